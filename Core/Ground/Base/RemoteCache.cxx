// SPDX-License-Identifier: BSD-3-Clause
#include "Ground/Base/RemoteCache.h"

#include "Ground/Base/Checksum.h"
#include "Ground/Base/Coding.h"
#include "Ground/Base/FileSystem.h"

#include <algorithm>
#include <atomic>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <mutex>
#include <system_error>
#include <utility>

#include <unistd.h>

namespace isosurface
{
namespace
{

/// Magic, key, tag, size, time, begin, bytes and their checksum.
constexpr std::uint64_t PartMagic = 0x31747261706f7369; // "isopart1"
constexpr std::uint64_t UsualCacheBytes = std::uint64_t{ 4 } << 30;
/// A larger part would drive many others away.
constexpr std::uint64_t LargestShare = 8;
/// After so much of its own a process looks what others have written.
constexpr std::uint64_t LookShare = 16;

std::uint64_t GetCacheBytes()
{
  const char* const text =
    std::getenv("SCALABLE_ISOSURFACE_CACHE_BYTES"); // NOLINT(concurrency-mt-unsafe)
  return text && *text ? std::strtoull(text, nullptr, 10) : UsualCacheBytes;
}

std::filesystem::path FindParts()
{
  return std::filesystem::path(RemoteCache::FindFolder()) / "parts";
}

std::filesystem::path FindPart(const std::string& key)
{
  const std::string name = FormatChecksum(ComputeChecksum(key.data(), key.size()));
  return FindParts() / name.substr(0, 2) / name;
}

/// Removes what was used longest ago, until a tenth of the bytes is free.
void EvictParts(std::uint64_t most)
{
  using Time = std::filesystem::file_time_type;
  std::vector<std::pair<Time, std::filesystem::path>> parts;
  std::uint64_t bytes = 0;
  std::error_code error;
  for (std::filesystem::recursive_directory_iterator entry(FindParts(), error), end;
       !error && entry != end; entry.increment(error))
  {
    std::error_code gone; // by another process
    if (entry->is_regular_file(gone) && !gone)
    {
      const Time used = entry->last_write_time(gone);
      bytes += gone ? 0 : static_cast<std::uint64_t>(entry->file_size(gone));
      parts.emplace_back(used, entry->path());
    }
  }
  if (bytes <= most)
  {
    return;
  }
  std::sort(parts.begin(), parts.end());
  for (const auto& [used, path] : parts)
  {
    if (bytes <= most - most / 10)
    {
      return;
    }
    std::error_code gone;
    const auto size = static_cast<std::uint64_t>(std::filesystem::file_size(path, gone));
    if (!gone && std::filesystem::remove(path, gone))
    {
      bytes -= std::min(bytes, size);
    }
  }
}

/// Counts what is written, and makes room now and then.
void CountWritten(std::uint64_t bytes, std::uint64_t most)
{
  static std::mutex mutex;
  static std::uint64_t unseen = ~std::uint64_t{ 0 } / 2; // at first, others' parts
  const std::lock_guard<std::mutex> lock(mutex);
  unseen += bytes;
  if (unseen > most / LookShare)
  {
    unseen = 0;
    EvictParts(most);
  }
}

} // namespace

std::string RemoteCache::FindFolder()
{
  const std::pair<const char*, const char*> places[] = { { "SCALABLE_ISOSURFACE_CACHE", "" },
    { "XDG_CACHE_HOME", "/scalable-isosurface" }, { "HOME", "/.cache/scalable-isosurface" } };
  for (const auto& [variable, below] : places)
  {
    const char* const value = std::getenv(variable); // NOLINT(concurrency-mt-unsafe)
    if (value && *value)
    {
      return std::string(value) + below;
    }
  }
  return {};
}

std::optional<RemotePart> RemoteCache::Find(const std::string& key)
{
  if (GetCacheBytes() == 0 || FindFolder().empty())
  {
    return std::nullopt;
  }
  const std::string path = FindPart(key).string();
  const auto file = GetLocalFileSystem().OpenForReading(path);
  std::vector<std::uint8_t> bytes;
  if (file.IsOk() && (*file)->GetSize() <= GetCacheBytes())
  {
    bytes.resize(static_cast<std::size_t>((*file)->GetSize()));
  }
  constexpr std::size_t numbers = 8;
  constexpr std::size_t head = numbers * sizeof(std::uint64_t);
  if (bytes.size() < head || !(*file)->Read(0, bytes.size(), bytes.data()).IsOk())
  {
    return std::nullopt;
  }
  const auto number = [&bytes](std::size_t at)
  { return LoadLittleEndian<std::uint64_t>(bytes.data() + at * sizeof(std::uint64_t)); };
  const std::uint64_t most = bytes.size();
  const std::uint64_t sizes =
    std::min(number(2), most) + std::min(number(3), most) + std::min(number(7), most);
  const bool isWhole = number(0) == PartMagic &&
    number(1) ==
      ComputeChecksum(
        bytes.data() + 2 * sizeof(std::uint64_t), bytes.size() - 2 * sizeof(std::uint64_t)) &&
    sizes == bytes.size() - head;
  const auto* const text = reinterpret_cast<const char*>(bytes.data()) + head;
  if (!isWhole || key.compare(0, std::string::npos, text, static_cast<std::size_t>(number(2))) != 0)
  {
    return std::nullopt;
  }
  std::error_code error; // used now
  std::filesystem::last_write_time(path, std::filesystem::file_time_type::clock::now(), error);
  RemotePart part;
  part.Tag.assign(text + number(2), static_cast<std::size_t>(number(3)));
  part.Size = number(4);
  part.Modified = static_cast<std::int64_t>(number(5));
  part.Begin = number(6);
  part.Bytes.assign(bytes.end() - static_cast<std::ptrdiff_t>(number(7)), bytes.end());
  return part;
}

void RemoteCache::Keep(const std::string& key, const RemotePart& part)
{
  const std::uint64_t most = GetCacheBytes();
  if (part.Tag.empty() || part.Bytes.size() > most / LargestShare || FindFolder().empty())
  {
    return;
  }
  const std::uint64_t numbers[] = { PartMagic, 0, key.size(), part.Tag.size(), part.Size,
    static_cast<std::uint64_t>(part.Modified), part.Begin, part.Bytes.size() };
  std::vector<std::uint8_t> bytes(sizeof(numbers));
  for (std::size_t at = 0; at < std::size(numbers); ++at)
  {
    StoreLittleEndian(bytes.data() + at * sizeof(std::uint64_t), numbers[at]);
  }
  bytes.insert(bytes.end(), key.begin(), key.end());
  bytes.insert(bytes.end(), part.Tag.begin(), part.Tag.end());
  bytes.insert(bytes.end(), part.Bytes.begin(), part.Bytes.end());
  constexpr std::size_t checked = 2 * sizeof(std::uint64_t);
  StoreLittleEndian(bytes.data() + sizeof(std::uint64_t),
    ComputeChecksum(bytes.data() + checked, bytes.size() - checked));
  static std::atomic<std::uint64_t> written = 0;
  const std::filesystem::path path = FindPart(key);
  const std::string beside =
    path.string() + "." + std::to_string(::getpid()) + "." + std::to_string(++written);
  FileSystem& files = GetLocalFileSystem();
  bool isWritten = files.MakeDirectories(path.parent_path().string()).IsOk();
  std::error_code error; // what was fetched with keys is the user's alone
  std::filesystem::permissions(FindParts(), std::filesystem::perms::owner_all, error);
  if (isWritten)
  {
    const auto file = files.CreateForWriting(beside); // not synchronised: the checksum tells
    isWritten = file.IsOk() && (*file)->Append(bytes.data(), bytes.size()).IsOk();
  }
  isWritten = isWritten && files.Rename(beside, path.string()).IsOk();
  if (!isWritten)
  {
    static_cast<void>(files.RemoveAll(beside));
    return;
  }
  CountWritten(bytes.size(), most);
}

} // namespace isosurface
