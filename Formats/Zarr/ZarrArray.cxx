// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/Zarr/ZarrArray.h"

#include "Formats/Source/ConvertedSource.h"

#include <algorithm>
#include <cstring>
#include <limits>
#include <tuple>

namespace isosurface
{
namespace
{

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
}

std::uint64_t ZarrArray::GetHeldBytes() const
{
  std::uint64_t inShard = this->Metadata.HasShards ? 1 : 0;
  for (std::size_t axis = 0; axis < this->Metadata.Shape.size(); ++axis)
  {
    inShard *= static_cast<std::uint64_t>(this->Metadata.Shard[axis] / this->Metadata.Chunk[axis]);
  }
  // The index of a shard is read into a buffer first.
  return this->CacheBytes + this->ChunkBytes + FindMaximumEncoded(this->ChunkBytes) + 33 * inShard;
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
  this->Encoded.resize(static_cast<std::size_t>(size));
  ISOSURFACE_RETURN_IF_ERROR(file.Read(offset, this->Encoded.size(), this->Encoded.data()));
  if (!DecodeZarr(this->Metadata.Encoding.Codecs, this->Encoded.data(), this->Encoded.size(),
        samples, decoded))
  {
    return this->MakeError(file.GetPath(), "a chunk is damaged or truncated: it cannot be decoded");
  }
  return allocated;
}

Status ZarrArray::FindInShard(const RandomAccessFile& file, const Numbers& shard,
  const Numbers& chunk, std::uint64_t& offset, std::uint64_t& size)
{
  std::size_t count = 1;
  std::size_t number = 0;
  for (std::size_t axis = 0; axis < chunk.size(); ++axis)
  {
    const std::int64_t inShard = this->Metadata.Shard[axis] / this->Metadata.Chunk[axis];
    count *= static_cast<std::size_t>(inShard);
    number =
      number * static_cast<std::size_t>(inShard) + static_cast<std::size_t>(chunk[axis] % inShard);
  }
  if (this->IndexShard != shard || this->Index.size() != count)
  {
    this->IndexShard.clear();
    const std::size_t checksums = 4 * this->Metadata.IndexCodecs.size();
    if (file.GetSize() < 16 * count + checksums)
    {
      return this->MakeError(file.GetPath(), "truncated: the shard has no whole index");
    }
    Bytes stored(16 * count + checksums);
    Bytes index(16 * count);
    const std::uint64_t begin = this->Metadata.IsIndexAtStart ? 0 : file.GetSize() - stored.size();
    ISOSURFACE_RETURN_IF_ERROR(file.Read(begin, stored.size(), stored.data()));
    if (!DecodeZarr(
          this->Metadata.IndexCodecs, stored.data(), stored.size(), index.data(), index.size()))
    {
      return this->MakeError(
        file.GetPath(), "truncated or damaged: the checksum of the shard's index is wrong");
    }
    this->Index.resize(count);
    for (std::size_t entry = 0; entry < count; ++entry)
    {
      const std::uint8_t* at = index.data() + 16 * entry;
      this->Index[entry] = { GetNumber(at, 8, this->Metadata.IsIndexBigEndian),
        GetNumber(at + 8, 8, this->Metadata.IsIndexBigEndian) };
    }
    this->IndexShard = shard;
  }
  std::tie(offset, size) = this->Index[number];
  if (offset == Missing && size == Missing)
  {
    offset = 0;
    size = 0;
    return Status::Ok();
  }
  return offset <= file.GetSize() && size <= file.GetSize() - offset && size > 0
    ? Status::Ok()
    : this->MakeError(file.GetPath(), "the shard's index is damaged");
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
  const std::string path = this->MakeKey(shard);
  const auto file = this->Files.OpenForReading(path);
  if (!file.IsOk())
  {
    return file.GetStatus().GetCode() == StatusCode::NotFound ? Result<Samples>(Samples())
                                                              : Result<Samples>(file.GetStatus());
  }
  if (this->Metadata.IsN5)
  {
    return this->LoadFromN5(**file);
  }
  std::uint64_t offset = 0;
  std::uint64_t size = (*file)->GetSize();
  if (this->Metadata.HasShards)
  {
    ISOSURFACE_RETURN_IF_ERROR(this->FindInShard(**file, shard, chunk, offset, size));
    if (size == 0)
    {
      return Samples();
    }
  }
  return this->Decode(**file, offset, size, this->ChunkBytes);
}

Result<ZarrArray::Samples> ZarrArray::TakeChunk(const Numbers& chunk, bool isKept)
{
  const auto found = this->Cached.find(chunk);
  if (found != this->Cached.end())
  {
    this->Cache.splice(this->Cache.begin(), this->Cache, found->second);
    return this->Cache.front().Decoded;
  }
  auto samples = this->LoadChunk(chunk);
  if (samples.IsOk() && *samples && isKept && this->ChunkBytes <= this->CacheBytes)
  {
    while ((this->Cache.size() + 1) * this->ChunkBytes > this->CacheBytes)
    {
      this->Cached.erase(this->Cache.back().Chunk);
      this->Cache.pop_back();
    }
    this->Cache.push_front({ chunk, *samples });
    this->Cached[chunk] = this->Cache.begin();
  }
  return samples;
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
  Numbers chunk = first;
  do
  {
    // A part is kept if the rest is there, but not asked for.
    bool isPart = false;
    for (std::size_t axis = 0; axis < rank; ++axis)
    {
      const std::int64_t begin = chunk[axis] * this->Metadata.Chunk[axis];
      const std::int64_t stop =
        std::min(begin + this->Metadata.Chunk[axis], this->Metadata.Shape[axis]);
      isPart = isPart || begin < low[axis] || stop > low[axis] + size[axis];
    }
    ISOSURFACE_ASSIGN_OR_RETURN(const auto samples, this->TakeChunk(chunk, isPart));
    this->CopyChunk(samples.get(), chunk, low, size, to);
  } while (Advance(chunk, first, end));
  return Status::Ok();
}

} // namespace isosurface
