// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/Hdf5/Hdf5ChunkCoding.h"

#include <zlib.h>

#include <algorithm>
#include <cstring>

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

std::optional<Hdf5ChunkCoding> Hdf5ChunkCoding::Find(const Hdf5Handle& dataset,
  const Hdf5Handle& plist, hid_t native, const StoredArray::Numbers& chunk)
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
    const H5Z_filter_t filter = ::H5Pget_filter2(
      plist.Get(), static_cast<unsigned int>(number), &flags, &values, &size, 0, nullptr, nullptr);
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

bool Hdf5ChunkCoding::IsChunk(const StoredArray::Numbers& low, const StoredArray::Numbers& size,
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

std::optional<std::size_t> Hdf5ChunkCoding::Inflate(
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

bool Hdf5ChunkCoding::IsOfAnotherSize(const std::vector<std::uint8_t>& stored)
{
  const std::uint8_t* bytes = nullptr;
  return this->Inflate(stored, bytes).value_or(this->ChunkBytes) != this->ChunkBytes;
}

bool Hdf5ChunkCoding::Decode(
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

void Hdf5ChunkCoding::CopyRows(
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
      row = row * static_cast<std::size_t>(this->Chunk[axis]) + static_cast<std::size_t>(at[axis]);
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

} // namespace isosurface
