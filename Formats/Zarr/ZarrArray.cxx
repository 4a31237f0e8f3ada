// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/Zarr/ZarrArray.h"

#include "Formats/Source/ConvertedSource.h"
#include "Ground/Base/FirstFailure.h"
#include "Ground/Base/ParallelFor.h"

#include <algorithm>
#include <cstring>
#include <limits>

namespace isosurface
{
namespace
{

/// Chunks of an address that are fetched at once, and their bytes.
constexpr std::uint64_t MostAtOnce = 16;
constexpr std::uint64_t BytesAtOnce = std::uint64_t{ 128 } << 20;
/// Shards of an address whose indices are kept.
constexpr std::size_t KeptShards = 64;
constexpr std::uint64_t Missing = std::numeric_limits<std::uint64_t>::max();

/// Encoded chunks are hardly larger than decoded ones.
std::uint64_t FindMaximumEncoded(std::uint64_t decoded)
{
  return decoded + decoded / 8 + 65536;
}

std::uint64_t GetNumber(const std::uint8_t* bytes, std::size_t size, bool isBigEndian)
{
  std::uint64_t number = 0;
  for (std::size_t byte = 0; byte < size; ++byte)
  {
    number = number << 8 | bytes[isBigEndian ? byte : size - 1 - byte];
  }
  return number;
}

/// The next one of the boxes [first, end), the last axis fastest. False after the last one.
bool Advance(
  StoredArray::Numbers& at, const StoredArray::Numbers& first, const StoredArray::Numbers& end)
{
  for (std::size_t axis = at.size(); axis-- > 0;)
  {
    if (++at[axis] < end[axis])
    {
      return true;
    }
    at[axis] = first[axis];
  }
  return false;
}

/// Copies samples that lie `stride` bytes apart.
template <std::size_t Size>
void CopyRow(const std::uint8_t* from, std::int64_t stride, std::int64_t count, bool isSwapped,
  std::uint8_t* to)
{
  for (std::int64_t sample = 0; sample < count; ++sample, from += stride, to += Size)
  {
    if (isSwapped)
    {
      std::reverse_copy(from, from + Size, to);
    }
    else
    {
      std::memcpy(to, from, Size);
    }
  }
}

void WidenRow(const std::uint8_t* from, std::int64_t stride, std::int64_t count, bool isSwapped,
  std::uint8_t* to)
{
  for (std::int64_t sample = 0; sample < count; ++sample, from += stride, to += sizeof(float))
  {
    const float value = WidenHalf(static_cast<std::uint16_t>(GetNumber(from, 2, isSwapped)));
    std::memcpy(to, &value, sizeof(value));
  }
}

} // namespace

ZarrArray::ZarrArray(
  FileSystem& files, std::string folder, ZarrMetadata metadata, std::uint64_t cacheBytes)
  : Files(files)
  , Folder(std::move(folder))
  , Metadata(std::move(metadata))
  , StoredSize(this->Metadata.IsHalf ? 2 : GetValueSize(this->Metadata.Type))
  , Pool(std::make_shared<PageBufferPool>())
{
  const ChunkCacheSize cache =
    FindChunkCacheSize(this->Metadata.Shape, this->Metadata.Chunk, this->StoredSize, cacheBytes);
  this->ChunkBytes = static_cast<std::size_t>(cache.ChunkBytes);
  this->CacheBytes = cache.Bytes;
  if (IsAddress(this->Folder) && cacheBytes > 0) // or one chunk at a time is asked for
  {
    this->AtOnce = static_cast<std::size_t>(std::clamp<std::uint64_t>(
      BytesAtOnce / std::max<std::uint64_t>(1, this->ChunkBytes), 1, MostAtOnce));
  }
}

std::uint64_t ZarrArray::GetHeldBytes() const
{
  // The index of a shard is read into a buffer first.
  const std::uint64_t shards = this->AtOnce > 1 ? KeptShards : 1;
  const std::uint64_t index = this->Metadata.HasShards ? 33 * shards * this->CountInShard() : 0;
  return this->CacheBytes +
    this->AtOnce * (this->ChunkBytes + FindMaximumEncoded(this->ChunkBytes)) + index;
}

std::size_t ZarrArray::CountInShard() const
{
  std::size_t count = 1;
  for (std::size_t axis = 0; axis < this->Metadata.Shape.size(); ++axis)
  {
    count *= static_cast<std::size_t>(this->Metadata.Shard[axis] / this->Metadata.Chunk[axis]);
  }
  return count;
}

std::size_t ZarrArray::CountIndexBytes() const
{
  return 16 * this->CountInShard() + 4 * this->Metadata.IndexCodecs.size();
}

std::int64_t ZarrArray::FindFirstPart() const
{
  const auto bytes = static_cast<std::int64_t>(
    this->Metadata.HasShards ? this->CountIndexBytes() : FindMaximumEncoded(this->ChunkBytes));
  return this->Metadata.HasShards && !this->Metadata.IsIndexAtStart ? -bytes : bytes;
}

std::string ZarrArray::MakeKey(const Numbers& file) const
{
  std::string key = this->Folder + "/" + this->Metadata.KeyPrefix;
  for (std::size_t axis = 0; axis < file.size(); ++axis)
  {
    const std::int64_t number = file[this->Metadata.IsN5 ? file.size() - 1 - axis : axis];
    key += (axis == 0 ? "" : this->Metadata.Separator) + std::to_string(number);
  }
  return key;
}

Status ZarrArray::MakeError(const std::string& path, const std::string& reason) const
{
  return Status(StatusCode::Corrupt, path + ": cannot be read: " + reason);
}

Result<ZarrArray::Samples> ZarrArray::Allocate(std::size_t bytes)
{
  constexpr std::size_t large = std::size_t{ 1 } << 18;
  if (bytes < large)
  {
    return Samples(new std::uint8_t[bytes], std::default_delete<std::uint8_t[]>());
  }
  const auto buffer = this->Pool->Take(bytes);
  if (!buffer.IsOk())
  {
    return Status(buffer.GetStatus().GetCode(),
      this->Folder + ": cannot be read: " + buffer.GetStatus().GetMessage());
  }
  return Samples(*buffer, (*buffer)->GetData());
}

Result<ZarrArray::Samples> ZarrArray::Decode(
  const RandomAccessFile& file, std::uint64_t offset, std::uint64_t size, std::size_t decoded)
{
  if (size > FindMaximumEncoded(decoded))
  {
    return this->MakeError(file.GetPath(),
      "a chunk has " + std::to_string(size) + " bytes for " + std::to_string(decoded) +
        " of samples");
  }
  ISOSURFACE_ASSIGN_OR_RETURN(auto allocated, this->Allocate(decoded));
  std::uint8_t* const samples = allocated.get();
  if (this->Metadata.Encoding.Codecs.empty())
  {
    if (size != decoded)
    {
      return this->MakeError(file.GetPath(),
        std::string(size < decoded ? "truncated" : "damaged") + ": a chunk has " +
          std::to_string(size) + " bytes instead of " + std::to_string(decoded));
    }
    ISOSURFACE_RETURN_IF_ERROR(file.Read(offset, decoded, samples));
    return allocated;
  }
  Bytes encoded(static_cast<std::size_t>(size));
  ISOSURFACE_RETURN_IF_ERROR(file.Read(offset, encoded.size(), encoded.data()));
  if (!DecodeZarr(this->Metadata.Encoding.Codecs, encoded.data(), encoded.size(), samples, decoded))
  {
    return this->MakeError(file.GetPath(), "a chunk is damaged or truncated: it cannot be decoded");
  }
  return allocated;
}

Status ZarrArray::ReadIndex(Shard& shard) const
{
  const RandomAccessFile& file = *shard.File;
  const std::size_t count = this->CountInShard();
  Bytes stored(this->CountIndexBytes());
  Bytes index(16 * count);
  if (file.GetSize() < stored.size())
  {
    return this->MakeError(file.GetPath(), "truncated: the shard has no whole index");
  }
  const std::uint64_t begin = this->Metadata.IsIndexAtStart ? 0 : file.GetSize() - stored.size();
  ISOSURFACE_RETURN_IF_ERROR(file.Read(begin, stored.size(), stored.data()));
  if (!DecodeZarr(
        this->Metadata.IndexCodecs, stored.data(), stored.size(), index.data(), index.size()))
  {
    return this->MakeError(
      file.GetPath(), "truncated or damaged: the checksum of the shard's index is wrong");
  }
  shard.Index.resize(count);
  for (std::size_t entry = 0; entry < count; ++entry)
  {
    const std::uint8_t* at = index.data() + 16 * entry;
    shard.Index[entry] = { GetNumber(at, 8, this->Metadata.IsIndexBigEndian),
      GetNumber(at + 8, 8, this->Metadata.IsIndexBigEndian) };
  }
  return Status::Ok();
}

Result<std::shared_ptr<ZarrArray::Shard>> ZarrArray::OpenShard(const Numbers& number)
{
  std::shared_ptr<Shard> shard;
  {
    const std::lock_guard<std::mutex> lock(this->Mutex);
    if (this->Shards.size() >= (this->AtOnce > 1 ? KeptShards : 1) &&
      this->Shards.count(number) == 0)
    {
      this->Shards.clear();
    }
    std::shared_ptr<Shard>& kept = this->Shards[number];
    kept = kept ? kept : std::make_shared<Shard>();
    shard = kept;
  }
  const std::lock_guard<std::mutex> lock(shard->Mutex);
  if (!shard->IsOpened)
  {
    auto file = this->Files.OpenPart(this->MakeKey(number), this->FindFirstPart());
    if (file.IsOk())
    {
      shard->File = std::move(*file);
      ISOSURFACE_RETURN_IF_ERROR(this->ReadIndex(*shard));
    }
    else if (file.GetStatus().GetCode() != StatusCode::NotFound)
    {
      return file.GetStatus();
    }
    shard->IsOpened = true;
  }
  return shard;
}

Result<ZarrArray::Samples> ZarrArray::LoadFromShard(const Numbers& number, const Numbers& chunk)
{
  ISOSURFACE_ASSIGN_OR_RETURN(const auto shard, this->OpenShard(number));
  if (!shard->File)
  {
    return Samples();
  }
  std::size_t entry = 0;
  for (std::size_t axis = 0; axis < chunk.size(); ++axis)
  {
    const std::int64_t inShard = this->Metadata.Shard[axis] / this->Metadata.Chunk[axis];
    entry =
      entry * static_cast<std::size_t>(inShard) + static_cast<std::size_t>(chunk[axis] % inShard);
  }
  const auto [offset, size] = shard->Index[entry];
  if (offset == Missing && size == Missing)
  {
    return Samples();
  }
  const std::uint64_t end = shard->File->GetSize();
  return offset <= end && size <= end - offset && size > 0
    ? this->Decode(*shard->File, offset, size, this->ChunkBytes)
    : this->MakeError(shard->File->GetPath(), "the shard's index is damaged");
}

Result<ZarrArray::Samples> ZarrArray::LoadFromN5(const RandomAccessFile& file)
{
  // Big-endian: the mode, the number of axes, the samples on each axis, the fastest one first.
  const std::size_t rank = this->Metadata.Shape.size();
  Bytes header(4 + 4 * rank);
  if (file.GetSize() < header.size())
  {
    return this->MakeError(file.GetPath(), "truncated: the block has no whole header");
  }
  ISOSURFACE_RETURN_IF_ERROR(file.Read(0, header.size(), header.data()));
  if (GetNumber(header.data(), 2, true) != 0 || GetNumber(header.data() + 2, 2, true) != rank)
  {
    return this->MakeError(file.GetPath(),
      "the header of the block is damaged, or of a mode that is "
      "not the default one");
  }
  Numbers size(rank);
  std::size_t samples = 1;
  for (std::size_t axis = 0; axis < rank; ++axis)
  {
    const std::uint64_t stored = GetNumber(header.data() + 4 + 4 * (rank - 1 - axis), 4, true);
    if (stored < 1 || stored > static_cast<std::uint64_t>(this->Metadata.Chunk[axis]))
    {
      return this->MakeError(file.GetPath(), "the block has an impossible size");
    }
    size[axis] = static_cast<std::int64_t>(stored);
    samples *= static_cast<std::size_t>(stored);
  }
  auto block =
    this->Decode(file, header.size(), file.GetSize() - header.size(), samples * this->StoredSize);
  if (!block.IsOk() || size == this->Metadata.Chunk)
  {
    return block;
  }
  // Blocks at the end of the array may be smaller: each row goes where a whole block has it.
  ISOSURFACE_ASSIGN_OR_RETURN(auto whole, this->Allocate(this->ChunkBytes));
  std::fill_n(whole.get(), this->ChunkBytes, std::uint8_t{ 0 });
  const Numbers first(rank, 0);
  Numbers rows = size;
  rows.back() = 1;
  Numbers at = first;
  const auto rowBytes =
    static_cast<std::ptrdiff_t>(size.back()) * static_cast<std::ptrdiff_t>(this->StoredSize);
  const std::uint8_t* from = block->get();
  do
  {
    std::ptrdiff_t row = 0;
    for (std::size_t axis = 0; axis < rank; ++axis)
    {
      row = row * static_cast<std::ptrdiff_t>(this->Metadata.Chunk[axis]) +
        static_cast<std::ptrdiff_t>(at[axis]);
    }
    std::copy_n(from, rowBytes, whole.get() + row * static_cast<std::ptrdiff_t>(this->StoredSize));
    from += rowBytes;
  } while (Advance(at, first, rows));
  return whole;
}

Result<ZarrArray::Samples> ZarrArray::LoadChunk(const Numbers& chunk)
{
  Numbers shard = chunk;
  for (std::size_t axis = 0; axis < chunk.size(); ++axis)
  {
    shard[axis] = chunk[axis] / (this->Metadata.Shard[axis] / this->Metadata.Chunk[axis]);
  }
  if (this->Metadata.HasShards)
  {
    return this->LoadFromShard(shard, chunk);
  }
  const auto file = this->Files.OpenPart(this->MakeKey(chunk), this->FindFirstPart());
  if (!file.IsOk())
  {
    return file.GetStatus().GetCode() == StatusCode::NotFound ? Result<Samples>(Samples())
                                                              : Result<Samples>(file.GetStatus());
  }
  return this->Metadata.IsN5 ? this->LoadFromN5(**file)
                             : this->Decode(**file, 0, (*file)->GetSize(), this->ChunkBytes);
}

void ZarrArray::KeepChunk(const Numbers& chunk, const Samples& samples)
{
  if (!samples || this->ChunkBytes > this->CacheBytes)
  {
    return;
  }
  while ((this->Cache.size() + 1) * this->ChunkBytes > this->CacheBytes)
  {
    this->Cached.erase(this->Cache.back().Chunk);
    this->Cache.pop_back();
  }
  this->Cache.push_front({ chunk, samples });
  this->Cached[chunk] = this->Cache.begin();
}

Status ZarrArray::TakeChunk(
  const Wanted& wanted, const Numbers& low, const Numbers& size, std::uint8_t* to)
{
  const Numbers& chunk = wanted.Chunk;
  Samples samples;
  bool isCached = false;
  {
    const std::lock_guard<std::mutex> lock(this->Mutex);
    const auto found = this->Cached.find(chunk);
    isCached = found != this->Cached.end();
    if (isCached)
    {
      this->Cache.splice(this->Cache.begin(), this->Cache, found->second);
      samples = this->Cache.front().Decoded;
    }
  }
  if (!isCached)
  {
    ISOSURFACE_ASSIGN_OR_RETURN(samples, this->LoadChunk(chunk));
  }
  this->CopyChunk(samples.get(), chunk, low, size, to);
  if (!isCached && wanted.IsPart)
  {
    const std::lock_guard<std::mutex> lock(this->Mutex);
    this->KeepChunk(chunk, samples);
  }
  return Status::Ok();
}

void ZarrArray::CopyChunk(const std::uint8_t* samples, const Numbers& chunk, const Numbers& low,
  const Numbers& size, std::uint8_t* to) const
{
  const std::size_t rank = chunk.size();
  const std::size_t valueSize = GetValueSize(this->Metadata.Type);
  // Strides in bytes: of the chunk as it is stored, and of the box.
  Numbers fromStride(rank);
  Numbers toStride(rank);
  auto bytes = static_cast<std::int64_t>(this->StoredSize);
  for (std::size_t place = rank; place-- > 0;)
  {
    const std::size_t axis = this->Metadata.Encoding.Order[place];
    fromStride[axis] = bytes;
    bytes *= this->Metadata.Chunk[axis];
  }
  bytes = static_cast<std::int64_t>(valueSize);
  Numbers first(rank);
  Numbers end(rank);
  for (std::size_t axis = rank; axis-- > 0;)
  {
    toStride[axis] = bytes;
    bytes *= size[axis];
    const std::int64_t begin = chunk[axis] * this->Metadata.Chunk[axis];
    first[axis] = std::max(begin, low[axis]);
    end[axis] = std::min(begin + this->Metadata.Chunk[axis], low[axis] + size[axis]);
  }
  const std::int64_t count = end.back() - first.back();
  Numbers rows = end;
  rows.back() = first.back() + 1;
  Numbers at = first;
  do
  {
    std::int64_t from = 0;
    std::int64_t row = 0;
    for (std::size_t axis = 0; axis < rank; ++axis)
    {
      from += (at[axis] - chunk[axis] * this->Metadata.Chunk[axis]) * fromStride[axis];
      row += (at[axis] - low[axis]) * toStride[axis];
    }
    const std::uint8_t* source = samples ? samples + from : this->Metadata.Fill.data();
    const std::int64_t stride = samples ? fromStride.back() : 0;
    const bool isSwapped = samples && this->Metadata.Encoding.IsBigEndian;
    if (this->Metadata.IsHalf && samples)
    {
      WidenRow(source, stride, count, isSwapped, to + row);
    }
    else if (valueSize == 1)
    {
      CopyRow<1>(source, stride, count, false, to + row);
    }
    else if (valueSize == 2)
    {
      CopyRow<2>(source, stride, count, isSwapped, to + row);
    }
    else if (valueSize == 4)
    {
      CopyRow<4>(source, stride, count, isSwapped, to + row);
    }
    else
    {
      CopyRow<8>(source, stride, count, isSwapped, to + row);
    }
  } while (Advance(at, first, rows));
}

Status ZarrArray::Read(const Numbers& low, const Numbers& size, std::uint8_t* to)
{
  const std::size_t rank = low.size();
  Numbers first(rank);
  Numbers end(rank);
  for (std::size_t axis = 0; axis < rank; ++axis)
  {
    first[axis] = low[axis] / this->Metadata.Chunk[axis];
    end[axis] = (low[axis] + size[axis] - 1) / this->Metadata.Chunk[axis] + 1;
  }
  std::vector<Wanted> wanted;
  Numbers chunk = first;
  bool isMore = true;
  while (isMore)
  {
    bool isPart = false;
    for (std::size_t axis = 0; axis < rank; ++axis)
    {
      const std::int64_t begin = chunk[axis] * this->Metadata.Chunk[axis];
      const std::int64_t stop =
        std::min(begin + this->Metadata.Chunk[axis], this->Metadata.Shape[axis]);
      isPart = isPart || begin < low[axis] || stop > low[axis] + size[axis];
    }
    wanted.push_back({ chunk, isPart });
    isMore = Advance(chunk, first, end);
  }
  FirstFailure failure;
  ParallelFor(wanted.size(), static_cast<int>(this->AtOnce),
    [&](std::size_t number, int)
    { failure.Run([&] { return this->TakeChunk(wanted[number], low, size, to); }); });
  return failure.Get();
}

} // namespace isosurface
