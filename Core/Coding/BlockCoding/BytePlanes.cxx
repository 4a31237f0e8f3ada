// SPDX-License-Identifier: BSD-3-Clause
#include "Coding/BlockCoding/BytePlanes.h"

#include "Ground/Base/Coding.h"

#include <zstd.h>

#include <algorithm>
#include <memory>
#include <new>

namespace isosurface
{
namespace
{

// Higher levels save a hundredth of the bytes.
constexpr int PlaneLevel = 1;

struct PlaneContextDeleter
{
  void operator()(ZSTD_CCtx* context) const { ZSTD_freeCCtx(context); }
  void operator()(ZSTD_DCtx* context) const { ZSTD_freeDCtx(context); }
};

template <typename Context>
Context* DemandContext(const std::unique_ptr<Context, PlaneContextDeleter>& context)
{
  if (!context)
  {
    throw std::bad_alloc();
  }
  return context.get();
}

// Appends a plane: its size, then zstd's frame, or the plane itself if that is not smaller.
void AppendPlane(const std::uint8_t* plane, std::size_t size, std::vector<std::uint8_t>& bytes)
{
  thread_local const std::unique_ptr<ZSTD_CCtx, PlaneContextDeleter> context(ZSTD_createCCtx());
  thread_local std::vector<std::uint8_t> frame;
  frame.resize(ZSTD_compressBound(size));
  const std::size_t stored =
    ZSTD_compressCCtx(DemandContext(context), frame.data(), frame.size(), plane, size, PlaneLevel);
  const bool isSmaller = ZSTD_isError(stored) == 0 && stored < size;
  AppendVarint(bytes, isSmaller ? stored : size);
  const std::uint8_t* first = isSmaller ? frame.data() : plane;
  bytes.insert(bytes.end(), first, first + (isSmaller ? stored : size));
}

bool ReadPlane(ByteReader& reader, std::uint8_t* plane, std::size_t size)
{
  thread_local const std::unique_ptr<ZSTD_DCtx, PlaneContextDeleter> context(ZSTD_createDCtx());
  const std::uint64_t stored = reader.ReadVarint();
  if (reader.HasFailed() || stored > size || stored > reader.GetRemaining())
  {
    return false;
  }
  const std::uint8_t* first = reader.ReadBytes(static_cast<std::size_t>(stored));
  if (stored == size)
  {
    std::copy_n(first, size, plane);
    return true;
  }
  return ZSTD_decompressDCtx(
           DemandContext(context), plane, size, first, static_cast<std::size_t>(stored)) == size;
}

} // namespace

void BytePlanes::SetSize(const std::array<int, 3>& size)
{
  this->SizeX = size[0];
  this->BytesOfRow = (static_cast<std::size_t>(size[0]) + 7) / 8;
  this->NumberOfRows = static_cast<std::size_t>(size[1]) * static_cast<std::size_t>(size[2]);
  this->Rows.resize(this->BytesOfRow * this->NumberOfRows);
  this->Row = 0;
  this->Numbers.clear();
  this->Taken = 0;
  this->IsBroken = false;
}

void BytePlanes::Begin(const std::array<int, 3>& size)
{
  this->SetSize(size);
}

void BytePlanes::Append(std::vector<std::uint8_t>& bytes) const
{
  AppendPlane(this->Rows.data(), this->Rows.size(), bytes);
  std::uint64_t any = 0;
  for (const std::uint64_t number : this->Numbers)
  {
    any |= number;
  }
  unsigned planes = 0;
  for (; any != 0; any >>= 8)
  {
    ++planes;
  }
  AppendVarint(bytes, this->Numbers.size());
  bytes.push_back(static_cast<std::uint8_t>(planes));
  std::vector<std::uint8_t> plane(this->Numbers.size());
  for (unsigned n = 0; n < planes; ++n)
  {
    std::transform(this->Numbers.begin(), this->Numbers.end(), plane.begin(),
      [n](std::uint64_t number) { return static_cast<std::uint8_t>(number >> (8 * n)); });
    AppendPlane(plane.data(), plane.size(), bytes);
  }
}

std::size_t BytePlanes::Begin(
  const std::array<int, 3>& size, const std::uint8_t* bytes, std::size_t numberOfBytes)
{
  this->SetSize(size);
  ByteReader reader(bytes, numberOfBytes);
  if (!ReadPlane(reader, this->Rows.data(), this->Rows.size()))
  {
    return 0;
  }
  const std::uint64_t numbers = reader.ReadVarint();
  const auto planes = reader.Read<std::uint8_t>();
  // At most a number for each edge.
  if (reader.HasFailed() || planes > 8 ||
    numbers > 3 * this->NumberOfRows * static_cast<std::size_t>(this->SizeX))
  {
    return 0;
  }
  this->NumberOfNumbers = static_cast<std::size_t>(numbers);
  this->NumberOfPlanes = planes;
  this->Planes.resize(this->NumberOfNumbers * planes);
  for (unsigned n = 0; n < planes; ++n)
  {
    if (!ReadPlane(reader, this->Planes.data() + n * this->NumberOfNumbers, this->NumberOfNumbers))
    {
      return 0;
    }
  }
  return numberOfBytes - reader.GetRemaining();
}

} // namespace isosurface
