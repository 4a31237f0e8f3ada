// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/Hdf5/Hdf5File.h"
#include "Formats/Hdf5/Hdf5Handle.h"
#include "Formats/Hdf5/Hdf5LinkedFiles.h"

#include <zlib.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <optional>
#include <utility>
#include <vector>

namespace isosurface
{
namespace
{

/// Chunks that are larger are left to the library.
constexpr double MaximumBytes = 2147483647;

/// 1 if the dataset's type is the native one, 2 if its bytes are in the other order; 0 otherwise.
int CompareTypes(hid_t stored, hid_t native)
{
  if (::H5Tequal(stored, native) > 0)
  {
    return 1;
  }
  const Hdf5Handle swapped(::H5Tcopy(native), ::H5Tclose);
  const H5T_order_t order = ::H5Tget_order(native) == H5T_ORDER_LE ? H5T_ORDER_BE : H5T_ORDER_LE;
  return ::H5Tset_order(swapped.Get(), order) >= 0 && ::H5Tequal(stored, swapped.Get()) > 0 ? 2 : 0;
}

template <std::size_t Size>
void SwapRow(const std::uint8_t* from, std::size_t count, std::uint8_t* to)
{
  for (std::size_t sample = 0; sample < count; ++sample, from += Size, to += Size)
  {
    std::reverse_copy(from, from + Size, to);
  }
}

template <std::size_t Size>
void UndoShuffle(const std::uint8_t* from, std::size_t count, std::uint8_t* to)
{
  for (std::size_t sample = 0; sample < count; ++sample)
  {
    for (std::size_t byte = 0; byte < Size; ++byte)
    {
      to[sample * Size + byte] = from[byte * count + sample];
    }
  }
}

} // namespace

/**
 * Decodes chunks of a dataset without the library, and so without its lock: those of plain integers
 * and floats that were shuffled, deflated, both or neither. Others are left to the library.
 */
class Hdf5ChunkCoding
{
public:
  /// Nothing if the dataset has other filters, or samples that need more than a swap of bytes to be
  /// those of the type `native`. The lock is held.
  static std::optional<Hdf5ChunkCoding> Find(const Hdf5Handle& dataset, const Hdf5Handle& plist,
    hid_t native, const StoredArray::Numbers& chunk)
  {
    const Hdf5Handle type(::H5Dget_type(dataset.Get()), ::H5Tclose);
    const int comparison = CompareTypes(type.Get(), native);
    Hdf5ChunkCoding coding;
    coding.Chunk = chunk;
    coding.ValueSize = ::H5Tget_size(native);
    coding.IsSwapped = comparison == 2 && coding.ValueSize > 1;
    auto bytes = static_cast<double>(coding.ValueSize);
    for (const std::int64_t size : chunk)
    {
      bytes *= static_cast<double>(size);
    }
    if (comparison == 0 || !(bytes >= 1 && bytes <= MaximumBytes))
    {
      return std::nullopt;
    }
    coding.ChunkBytes = static_cast<std::size_t>(bytes);
    // Chunks at the end may be stored without filters, which their masks do not tell.
    unsigned int options = 0;
    if (::H5Pget_chunk_opts(plist.Get(), &options) < 0 ||
      (options & H5D_CHUNK_DONT_FILTER_PARTIAL_CHUNKS) != 0)
    {
      return std::nullopt;
    }
    // A shuffle behind the deflation would have to be undone before it.
    const int filters = ::H5Pget_nfilters(plist.Get());
    for (int number = 0; number < filters; ++number)
    {
      unsigned int flags = 0;
      std::size_t values = 1;
      unsigned int size = 0;
      const H5Z_filter_t filter = ::H5Pget_filter2(plist.Get(), static_cast<unsigned int>(number),
        &flags, &values, &size, 0, nullptr, nullptr);
      if (filter == H5Z_FILTER_SHUFFLE && number == 0 && size == coding.ValueSize)
      {
        coding.IsShuffled = coding.ValueSize > 1;
      }
      else if (filter == H5Z_FILTER_DEFLATE && !coding.IsDeflated)
      {
        coding.IsDeflated = true;
      }
      else
      {
        return std::nullopt;
      }
    }
    return coding;
  }

  /// The bytes of a decoded chunk.
  std::size_t GetChunkBytes() const { return this->ChunkBytes; }
  /// Whether a box is a chunk, or what the last one on an axis has of the dataset.
  bool IsChunk(const StoredArray::Numbers& low, const StoredArray::Numbers& size,
    const StoredArray::Numbers& shape) const
  {
    for (std::size_t axis = 0; axis < low.size(); ++axis)
    {
      const std::int64_t end = std::min(low[axis] + this->Chunk[axis], shape[axis]);
      if (low[axis] % this->Chunk[axis] != 0 || low[axis] + size[axis] != end)
      {
        return false;
      }
    }
    return true;
  }

  /// Decodes `stored`, and writes the first `size` samples on each axis to `to`: the last axis
  /// fastest, without gaps. False if the bytes are not those of a chunk.
  bool Decode(
    const std::vector<std::uint8_t>& stored, const StoredArray::Numbers& size, std::uint8_t* to)
  {
    const std::uint8_t* samples = nullptr;
    if (this->Inflate(stored, samples) != this->ChunkBytes)
    {
      return false;
    }
    if (this->IsShuffled)
    {
      this->Ordered.resize(this->ChunkBytes);
      const std::size_t count = this->ChunkBytes / this->ValueSize;
      this->ValueSize == 2     ? UndoShuffle<2>(samples, count, this->Ordered.data())
        : this->ValueSize == 4 ? UndoShuffle<4>(samples, count, this->Ordered.data())
                               : UndoShuffle<8>(samples, count, this->Ordered.data());
      samples = this->Ordered.data();
    }
    this->CopyRows(samples, size, to);
    return true;
  }

  /// Whether `stored` is a code of more or fewer bytes than a chunk has. Of fewer, the library would
  /// read beyond them.
  bool IsOfAnotherSize(const std::vector<std::uint8_t>& stored)
  {
    const std::uint8_t* bytes = nullptr;
    return this->Inflate(stored, bytes).value_or(this->ChunkBytes) != this->ChunkBytes;
  }

private:
  /// Finds the bytes before the shuffle, which may be those of `stored`, and their number: one more
  /// than a chunk has for any that is larger; nothing if they are no code.
  std::optional<std::size_t> Inflate(
    const std::vector<std::uint8_t>& stored, const std::uint8_t*& bytes)
  {
    if (!this->IsDeflated)
    {
      bytes = stored.data();
      return stored.size();
    }
    this->Inflated.resize(this->ChunkBytes);
    bytes = this->Inflated.data();
    uLongf size = this->Inflated.size();
    const int outcome = ::uncompress(this->Inflated.data(), &size, stored.data(), stored.size());
    if (outcome == Z_BUF_ERROR) // there is no room for what follows
    {
      return this->ChunkBytes + 1;
    }
    return outcome == Z_OK ? std::optional<std::size_t>(size) : std::nullopt;
  }

  void CopyRows(
    const std::uint8_t* samples, const StoredArray::Numbers& size, std::uint8_t* to) const
  {
    const std::size_t rank = size.size();
    const auto count = static_cast<std::size_t>(size.back());
    StoredArray::Numbers at(rank, 0);
    bool isDone = false;
    while (!isDone)
    {
      std::size_t row = 0;
      for (std::size_t axis = 0; axis < rank; ++axis)
      {
        row =
          row * static_cast<std::size_t>(this->Chunk[axis]) + static_cast<std::size_t>(at[axis]);
      }
      const std::uint8_t* from = samples + row * this->ValueSize;
      if (!this->IsSwapped)
      {
        std::memcpy(to, from, count * this->ValueSize);
      }
      else
      {
        this->ValueSize == 2     ? SwapRow<2>(from, count, to)
          : this->ValueSize == 4 ? SwapRow<4>(from, count, to)
                                 : SwapRow<8>(from, count, to);
      }
      to += count * this->ValueSize;
      // The next row, the last axis but one fastest.
      std::size_t axis = rank - 1;
      isDone = true;
      while (isDone && axis-- > 0)
      {
        isDone = ++at[axis] >= size[axis];
        at[axis] = isDone ? 0 : at[axis];
      }
    }
  }

  StoredArray::Numbers Chunk;
  std::size_t ValueSize = 1;
  std::size_t ChunkBytes = 0;
  bool IsSwapped = false;
  bool IsShuffled = false;
  bool IsDeflated = false;
  std::vector<std::uint8_t> Inflated;
  std::vector<std::uint8_t> Ordered; ///< after the shuffle was undone
};

namespace
{

hid_t GetNativeType(ValueType type)
{
  switch (type)
  {
    case ValueType::Int8:
      return H5T_NATIVE_INT8;
    case ValueType::UInt8:
      return H5T_NATIVE_UINT8;
    case ValueType::Int16:
      return H5T_NATIVE_INT16;
    case ValueType::UInt16:
      return H5T_NATIVE_UINT16;
    case ValueType::Int32:
      return H5T_NATIVE_INT32;
    case ValueType::UInt32:
      return H5T_NATIVE_UINT32;
    case ValueType::Int64:
      return H5T_NATIVE_INT64;
    case ValueType::UInt64:
      return H5T_NATIVE_UINT64;
    case ValueType::Float32:
      return H5T_NATIVE_FLOAT;
    case ValueType::Float64:
      break;
  }
  return H5T_NATIVE_DOUBLE;
}

/// The first chunk is checked when a dataset is opened, unless that would take long.
constexpr std::size_t MostCheckedBytes = std::size_t{ 16 } << 20;

/// Whether chunks are no larger than the dataset may become. The library makes no others.
bool IsLayoutPossible(const Hdf5Handle& dataset, const StoredArray::Numbers& chunk)
{
  const Hdf5Handle space(::H5Dget_space(dataset.Get()), ::H5Sclose);
  std::vector<hsize_t> sizes(chunk.size());
  std::vector<hsize_t> most(chunk.size());
  if (::H5Sget_simple_extent_dims(space.Get(), sizes.data(), most.data()) !=
    static_cast<int>(chunk.size()))
  {
    return false;
  }
  for (std::size_t axis = 0; axis < chunk.size(); ++axis)
  {
    const auto size = static_cast<hsize_t>(chunk[axis]);
    if (sizes[axis] > 0 && most[axis] != H5S_UNLIMITED && size > most[axis])
    {
      return false;
    }
  }
  return true;
}

} // namespace

/// A dataset that is read by hyperslabs. Whole chunks of common codings are decoded beside the
/// library's lock, so that several open ones of several threads decode at the same time.
class Hdf5File::Array : public StoredArray
{
public:
  Array(const Hdf5File& file, std::string path, Hdf5Handle dataset, ValueType stored,
    const Numbers& shape, ValueType type)
    : File(file)
    , Name(file.Path + ":" + path)
    , ObjectPath(std::move(path))
    , Dataset(std::move(dataset))
    , Shape(shape)
    , StoredType(stored)
    , Type(type)
  {
  }

  const std::string& GetName() const override { return this->Name; }
  const Numbers& GetShape() const override { return this->Shape; }
  ValueType GetType() const override { return this->Type; }
  Numbers GetChunk() const override { return this->Chunk; }
  bool DecodesInParallel() const override { return this->HasCommonCoding; }
  std::uint64_t GetCacheBytes() const override { return this->CacheBytes; }
  std::uint64_t GetHeldBytes() const override { return this->HeldBytes; }

  /// Opens the dataset again, with a cache for a slab of chunks.
  Status SetCache(std::uint64_t cacheBytes)
  {
    const Hdf5Handle plist(::H5Dget_create_plist(this->Dataset.Get()), ::H5Pclose);
    this->Chunk = FindHdf5Chunk(plist, this->Shape.size());
    if (this->Chunk.empty())
    {
      return Status::Ok();
    }
    if (!IsLayoutPossible(this->Dataset, this->Chunk))
    {
      return this->MakeChunkError();
    }
    const ChunkCacheSize cache =
      FindChunkCacheSize(this->Shape, this->Chunk, GetValueSize(this->Type), cacheBytes);
    const Hdf5Handle access(::H5Pcopy(this->File.Links->GetAccess()), ::H5Pclose);
    // With a weight of 1, the library evicts no chunk of which a part was read, whatever their bytes.
    ::H5Pset_chunk_cache(access.Get(), cache.Slots, cache.Bytes, 0.75);
    // An open dataset would keep the cache that it has.
    this->Dataset = Hdf5Handle();
    Hdf5Handle dataset(
      ::H5Dopen2(this->File.File->Get(), this->ObjectPath.c_str(), access.Get()), ::H5Dclose);
    if (!dataset.IsOpen())
    {
      return this->File.MakeError(StatusCode::Corrupt, this->ObjectPath, FindHdf5Reason());
    }
    this->Dataset = std::move(dataset);
    this->Coding =
      Hdf5ChunkCoding::Find(this->Dataset, plist, GetNativeType(this->StoredType), this->Chunk);
    if (this->Coding && this->Coding->GetChunkBytes() <= MostCheckedBytes &&
      this->LoadChunk(Numbers(this->Shape.size(), 0)) &&
      this->Coding->IsOfAnotherSize(this->Stored))
    {
      return this->MakeChunkError();
    }
    this->HasCommonCoding = this->Coding.has_value();
    // The library decodes, unless somebody else keeps chunks, and reads whole ones.
    if (cacheBytes > 0 && !this->File.DecodesChunks)
    {
      this->Coding.reset();
      this->Stored = {};
    }
    this->HeldBytes += this->Coding ? 3 * this->Coding->GetChunkBytes() : 0;
    this->CacheBytes = cache.Bytes;
    this->HeldBytes += cache.HeldBytes;
    return Status::Ok();
  }

  Status Read(const Numbers& low, const Numbers& size, std::uint8_t* to) override
  {
    if (this->Coding && this->Coding->IsChunk(low, size, this->Shape) && this->LoadChunk(low))
    {
      if (this->Coding->Decode(this->Stored, size, to))
      {
        return Status::Ok();
      }
      if (this->Coding->IsOfAnotherSize(this->Stored))
      {
        return this->MakeChunkError();
      }
    }
    const Hdf5Scope scope;
    const std::vector<hsize_t> first(low.begin(), low.end());
    const std::vector<hsize_t> count(size.begin(), size.end());
    const Hdf5Handle inFile(::H5Dget_space(this->Dataset.Get()), ::H5Sclose);
    const Hdf5Handle inMemory(
      ::H5Screate_simple(static_cast<int>(count.size()), count.data(), nullptr), ::H5Sclose);
    if (!inFile.IsOpen() || !inMemory.IsOpen() ||
      ::H5Sselect_hyperslab(
        inFile.Get(), H5S_SELECT_SET, first.data(), nullptr, count.data(), nullptr) < 0 ||
      ::H5Dread(this->Dataset.Get(), GetNativeType(this->StoredType), inMemory.Get(), inFile.Get(),
        H5P_DEFAULT, to) < 0)
    {
      return this->File.MakeError(StatusCode::Corrupt, this->ObjectPath, FindHdf5Reason());
    }
    return Status::Ok();
  }

private:
  Status MakeChunkError() const
  {
    return this->File.MakeError(
      StatusCode::Corrupt, this->ObjectPath, "its chunks have another size than the file says");
  }
  /// Reads a chunk as it is stored. False if there is none, or if the library has to decode it, or
  /// to say what is wrong with it.
  bool LoadChunk(const Numbers& low)
  {
    const Hdf5Scope scope;
    const std::vector<hsize_t> offset(low.begin(), low.end());
    hsize_t bytes = 0;
    const std::size_t decoded = this->Coding->GetChunkBytes();
    if (::H5Dget_chunk_storage_size(this->Dataset.Get(), offset.data(), &bytes) < 0 || bytes == 0 ||
      bytes > decoded + decoded / 8 + 65536)
    {
      return false;
    }
    this->Stored.resize(static_cast<std::size_t>(bytes));
    std::uint32_t skippedFilters = 0;
    return ::H5Dread_chunk(this->Dataset.Get(), H5P_DEFAULT, offset.data(), &skippedFilters,
             this->Stored.data()) >= 0 &&
      skippedFilters == 0;
  }

  Hdf5File File;
  std::string Name;
  std::string ObjectPath;
  Hdf5Handle Dataset;
  Numbers Shape;
  ValueType StoredType; ///< of the file; its bits are those of Type
  ValueType Type;
  Numbers Chunk;
  std::optional<Hdf5ChunkCoding> Coding;
  bool HasCommonCoding = false;     ///< of chunks that are read as a whole
  std::vector<std::uint8_t> Stored; ///< a chunk, encoded
  std::uint64_t CacheBytes = 0;
  std::uint64_t HeldBytes = std::uint64_t{ 2 } << 20; // buffers of the conversion
};

/// A dataset, once everything was checked that its samples need.
Result<Hdf5Handle> Hdf5File::OpenDataset(const std::string& path) const
{
  Hdf5Handle dataset = this->Links->OpenDataset(this->File->Get(), path);
  if (dataset.IsOpen())
  {
    const Status status = this->Links->Check(dataset);
    return status.IsOk() ? Result<Hdf5Handle>(std::move(dataset))
                         : this->MakeError(status.GetCode(), path, status.GetMessage());
  }
  const std::string refusal = Hdf5LinkedFiles::GetRefusal();
  const std::string reason = FindHdf5Reason();
  if (!refusal.empty())
  {
    return this->MakeError(StatusCode::Unsupported, path, refusal);
  }
  return this->Has(path) ? this->MakeError(StatusCode::Unsupported, path,
                             this->IsDataset(path) ? reason : "it is a group, not a dataset")
                         : this->MakeError(StatusCode::NotFound, path, "there is no such dataset");
}

Result<StoredArray::Numbers> Hdf5File::FindShape(const std::string& path) const
{
  const Hdf5Scope scope;
  ISOSURFACE_ASSIGN_OR_RETURN(const auto dataset, this->OpenDataset(path));
  return FindHdf5Shape(dataset);
}

Result<std::shared_ptr<StoredArray>> Hdf5File::OpenArray(const std::string& path,
  std::uint64_t cacheBytes, const StoredArray::Numbers& shape, bool isUnsigned) const
{
  const Hdf5Scope scope;
  ISOSURFACE_ASSIGN_OR_RETURN(auto dataset, this->OpenDataset(path));
  const Hdf5Handle type(::H5Dget_type(dataset.Get()), ::H5Tclose);
  const auto found = FindHdf5ValueType(type.Get());
  if (!found)
  {
    return this->MakeError(StatusCode::Unsupported, path,
      "its type, " + DescribeHdf5Type(type.Get()) +
        ", is neither an integer of 8, 16, 32 or 64 bits nor a float of 16, 32 or 64");
  }
  const StoredArray::Numbers whole = FindHdf5Shape(dataset);
  bool isWithin = shape.empty() || shape.size() == whole.size();
  for (std::size_t axis = 0; isWithin && axis < shape.size(); ++axis)
  {
    isWithin = shape[axis] >= 1 && shape[axis] <= whole[axis];
  }
  if (!isWithin)
  {
    return this->MakeError(StatusCode::Corrupt, path,
      "it has " + JoinNumbers(whole) + " samples, of which " + JoinNumbers(shape) +
        " are said to be its own");
  }
  auto array =
    std::make_shared<Array>(*this, path, std::move(dataset), *found, shape.empty() ? whole : shape,
      isUnsigned && *found == ValueType::Int16 ? ValueType::UInt16 : *found);
  ISOSURFACE_RETURN_IF_ERROR(array->SetCache(cacheBytes));
  return std::shared_ptr<StoredArray>(std::move(array));
}

} // namespace isosurface
