// SPDX-License-Identifier: BSD-3-Clause
#include "Storage/Store/StoreFaults.h"

#include "Ground/Base/Coding.h"

#include <algorithm>
#include <utility>

namespace isosurface
{
namespace
{

constexpr std::size_t MaximumReasonBytes = 1000;

void Append(Message& bytes, const StoreFault& fault)
{
  for (const std::uint32_t number :
    { fault.Where.TimeStep, fault.Where.Overview, fault.Where.Store, fault.Where.Replica })
  {
    AppendLittleEndian(bytes, number);
  }
  AppendLittleEndian(bytes, fault.Ordinal);
  const std::string reason = fault.Reason.substr(0, MaximumReasonBytes);
  AppendLittleEndian(bytes, static_cast<std::uint32_t>(reason.size()));
  bytes.insert(bytes.end(), reason.begin(), reason.end());
}

StoreFault Take(ByteReader& reader)
{
  StoreFault fault;
  fault.Where.TimeStep = reader.Read<std::uint32_t>();
  fault.Where.Overview = reader.Read<std::uint32_t>();
  fault.Where.Store = reader.Read<std::uint32_t>();
  fault.Where.Replica = reader.Read<std::uint32_t>();
  fault.Ordinal = reader.Read<std::int64_t>();
  const auto size = reader.Read<std::uint32_t>();
  if (const std::uint8_t* reason = reader.ReadBytes(size))
  {
    fault.Reason.assign(reason, reason + size);
  }
  return fault;
}

std::vector<StoreFault> TakeAll(const std::vector<Message>& messages)
{
  std::vector<StoreFault> faults;
  for (const Message& bytes : messages)
  {
    ByteReader reader(bytes);
    while (reader.GetRemaining() > 0)
    {
      StoreFault fault = Take(reader);
      if (reader.HasFailed())
      {
        break;
      }
      faults.push_back(std::move(fault));
    }
  }
  return faults;
}

} // namespace

void StoreFaults::Add(StoreFault fault)
{
  const std::lock_guard<std::mutex> lock(this->Mutex);
  if (this->Known.insert({ fault.Where, fault.Ordinal }).second)
  {
    this->Found.push_back(std::move(fault));
  }
}

ReplicaState StoreFaults::FindState(
  const Keys& known, const StoreReplica& replica, std::int64_t ordinal)
{
  const auto first = known.lower_bound({ replica, StoreFault::Whole });
  if (first == known.end() || !(first->first == replica))
  {
    return ReplicaState::Sound;
  }
  const bool isLost = first->second == StoreFault::Whole ||
    (ordinal != StoreFault::Whole && known.count({ replica, ordinal }) != 0);
  return isLost ? ReplicaState::Lost : ReplicaState::Damaged;
}

ReplicaState StoreFaults::GetState(
  const StoreReplica& replica, bool isCommon, std::int64_t ordinal) const
{
  const std::lock_guard<std::mutex> lock(this->Mutex);
  return FindState(isCommon ? this->Common : this->Known, replica, ordinal);
}

std::vector<std::uint32_t> StoreFaults::FindBest(StoreReplica store, std::uint32_t replicas) const
{
  std::vector<std::uint32_t> best;
  auto bestState = ReplicaState::Lost;
  for (store.Replica = 0; store.Replica < replicas; ++store.Replica)
  {
    const ReplicaState state = this->GetState(store, true);
    if (state < bestState)
    {
      best.clear();
      bestState = state;
    }
    if (state == bestState)
    {
      best.push_back(store.Replica);
    }
  }
  return best;
}

bool StoreFaults::IsEmpty() const
{
  const std::lock_guard<std::mutex> lock(this->Mutex);
  return this->Known.empty();
}

Message StoreFaults::Pack() const
{
  const std::lock_guard<std::mutex> lock(this->Mutex);
  const std::size_t count = std::min(MaximumOfMessage, this->Found.size());
  Message bytes;
  for (std::size_t index = 0; index < count; ++index)
  {
    Append(bytes, this->Found[index]);
  }
  return bytes;
}

std::vector<StoreFault> StoreFaults::Join(const std::vector<Message>& ofRanks)
{
  // All that takes much memory comes first: ranks that know different faults share blocks differently.
  const std::vector<StoreFault> told = TakeAll(ofRanks);
  std::vector<StoreFault> news;
  news.reserve(told.size());
  const std::lock_guard<std::mutex> lock(this->Mutex);
  for (const StoreFault& fault : told)
  {
    const Key key = { fault.Where, fault.Ordinal };
    this->Known.insert(key);
    if (this->Common.insert(key).second)
    {
      news.push_back(fault);
    }
  }
  const auto isTold = [this](const StoreFault& fault) {
    return this->Common.count({ fault.Where, fault.Ordinal }) != 0;
  };
  this->Found.erase(
    std::remove_if(this->Found.begin(), this->Found.end(), isTold), this->Found.end());
  return news;
}

} // namespace isosurface
