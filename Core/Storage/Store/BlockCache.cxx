// SPDX-License-Identifier: BSD-3-Clause
#include "Storage/Store/BlockCache.h"

#include "Ground/Base/Checksum.h"

namespace isosurface
{

const std::shared_ptr<BlockCache>& BlockCache::GetProcessCache()
{
  static const auto cache = std::make_shared<BlockCache>(std::uint64_t{ 1 } << 30);
  return cache;
}

std::size_t BlockCache::KeyHash::operator()(const BlockCacheKey& key) const
{
  static_assert(sizeof(BlockCacheKey) == 24, "a key has no padding to hash");
  return static_cast<std::size_t>(ComputeChecksum(&key, sizeof(key)));
}

Result<std::shared_ptr<const DecodedBlock>> BlockCache::Get(
  const BlockCacheKey& key, const Loader& load, bool& hit)
{
  std::unique_lock<std::mutex> lock(this->Mutex);
  const auto found = this->Index.find(key);
  if (found != this->Index.end())
  {
    EntryList& entries = this->FindList(key);
    entries.splice(entries.begin(), entries, found->second);
    hit = true;
    return found->second->Block;
  }
  const auto inFlight = this->InFlight.find(key);
  if (inFlight != this->InFlight.end())
  {
    const std::shared_ptr<Loading> loading = inFlight->second;
    this->LoadingDone.wait(lock, [&] { return loading->Done; });
    hit = true;
    if (!loading->Error.IsOk())
    {
      return loading->Error;
    }
    return loading->Block;
  }

  hit = false;
  const auto loading = std::make_shared<Loading>();
  this->InFlight.emplace(key, loading);
  lock.unlock();
  return this->Load(key, load, *loading);
}

Result<std::shared_ptr<const DecodedBlock>> BlockCache::Load(
  const BlockCacheKey& key, const Loader& load, Loading& loading)
{
  std::unique_lock<std::mutex> lock(this->Mutex, std::defer_lock);
  const auto finish = [&]
  {
    loading.Done = true;
    this->InFlight.erase(key);
    this->LoadingDone.notify_all();
  };
  try
  {
    auto result = load();
    lock.lock();
    if (result.IsOk())
    {
      loading.Block = *result;
      this->Insert(key, *result);
    }
    else
    {
      loading.Error = result.GetStatus();
    }
    finish();
    return result;
  }
  catch (...)
  {
    // Short of memory. Those who wait must be told.
    if (!lock.owns_lock())
    {
      lock.lock();
    }
    loading.Error = Status(StatusCode::OutOfMemory, "there is not enough memory to load a block");
    finish();
    throw;
  }
}

bool BlockCache::Contains(const BlockCacheKey& key) const
{
  const std::lock_guard<std::mutex> lock(this->Mutex);
  return this->Index.count(key) != 0 || this->InFlight.count(key) != 0;
}

void BlockCache::Expect(const std::vector<BlockCacheKey>& keys)
{
  const std::lock_guard<std::mutex> lock(this->Mutex);
  this->OtherEntries.splice(this->OtherEntries.begin(), this->ExpectedEntries);
  this->Expected.clear();
  this->Expected.insert(keys.begin(), keys.end());
  for (const BlockCacheKey& key : this->Expected)
  {
    const auto found = this->Index.find(key);
    if (found != this->Index.end())
    {
      this->ExpectedEntries.splice(
        this->ExpectedEntries.begin(), this->OtherEntries, found->second);
    }
  }
}

BlockCache::EntryList& BlockCache::FindList(const BlockCacheKey& key)
{
  return this->Expected.count(key) != 0 ? this->ExpectedEntries : this->OtherEntries;
}

void BlockCache::Insert(const BlockCacheKey& key, const std::shared_ptr<const DecodedBlock>& block)
{
  const std::uint64_t bytes = sizeof(Entry) + sizeof(DecodedBlock) + block->Bytes.GetSize();
  if (bytes > this->Budget)
  {
    return;
  }
  EntryList& entries = this->FindList(key);
  while (this->Size > this->Budget - bytes)
  {
    if (this->OtherEntries.empty() && &entries == &this->ExpectedEntries)
    {
      return;
    }
    this->RemoveOne();
  }
  entries.push_front({ key, block, bytes });
  this->Index[key] = entries.begin();
  this->Size += bytes;
}

void BlockCache::Trim(std::uint64_t budget)
{
  while (this->Size > budget)
  {
    this->RemoveOne();
  }
}

void BlockCache::RemoveOne()
{
  EntryList& entries = this->OtherEntries.empty() ? this->ExpectedEntries : this->OtherEntries;
  this->Size -= entries.back().Bytes;
  this->Index.erase(entries.back().Key);
  entries.pop_back();
}

void BlockCache::RemoveDataset(std::uint64_t dataset, EntryList& entries)
{
  for (auto entry = entries.begin(); entry != entries.end();)
  {
    if (entry->Key.Dataset == dataset)
    {
      this->Size -= entry->Bytes;
      this->Index.erase(entry->Key);
      entry = entries.erase(entry);
    }
    else
    {
      ++entry;
    }
  }
}

void BlockCache::Retain(std::uint64_t dataset)
{
  const std::lock_guard<std::mutex> lock(this->Mutex);
  ++this->Users[dataset];
}

void BlockCache::Release(std::uint64_t dataset)
{
  const std::lock_guard<std::mutex> lock(this->Mutex);
  const auto users = this->Users.find(dataset);
  if (users != this->Users.end() && --users->second == 0)
  {
    this->Users.erase(users);
    this->RemoveDataset(dataset, this->ExpectedEntries);
    this->RemoveDataset(dataset, this->OtherEntries);
  }
}

void BlockCache::SetBudget(std::uint64_t budget)
{
  const std::lock_guard<std::mutex> lock(this->Mutex);
  this->Budget = budget;
  this->Trim(budget);
}

std::uint64_t BlockCache::GetBudget() const
{
  const std::lock_guard<std::mutex> lock(this->Mutex);
  return this->Budget;
}

std::uint64_t BlockCache::GetSize() const
{
  const std::lock_guard<std::mutex> lock(this->Mutex);
  return this->Size;
}

void BlockCache::Clear()
{
  const std::lock_guard<std::mutex> lock(this->Mutex);
  this->Trim(0);
}

} // namespace isosurface
