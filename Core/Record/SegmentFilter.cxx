// SPDX-License-Identifier: BSD-3-Clause
#include "Record/SegmentFilter.h"

#include "Base/Coding.h"
#include "Record/OrderedSample.h"

#include <algorithm>
#include <cstring>

namespace isosurface
{
namespace
{

/// Samples are filtered in pieces that stay in the first cache; a multiple of 8.
constexpr std::size_t PieceSize = 1024;

/// Transposes 8 x 8 bits: bit c of byte r goes to bit r of byte c. Source: H. S. Warren, "Hacker's
/// Delight", 2nd ed., 2013, section 7-3.
std::uint64_t TransposeBits(std::uint64_t x)
{
  std::uint64_t t = (x ^ (x >> 7)) & 0x00AA00AA00AA00AAu;
  x ^= t ^ (t << 7);
  t = (x ^ (x >> 14)) & 0x0000CCCC0000CCCCu;
  x ^= t ^ (t << 14);
  t = (x ^ (x >> 28)) & 0x00000000F0F0F0F0u;
  return x ^ t ^ (t << 28);
}

template <typename U>
U Zigzag(U residual)
{
  constexpr int highest = 8 * static_cast<int>(sizeof(U)) - 1;
  return static_cast<U>(
    static_cast<U>(residual << 1) ^ static_cast<U>(0 - static_cast<U>(residual >> highest)));
}

template <typename U>
U Unzigzag(U code)
{
  return static_cast<U>(
    static_cast<U>(code >> 1) ^ static_cast<U>(0 - static_cast<U>(code & U{ 1 })));
}

/// Where a piece of a layout is: codes [First, First + Count) of Total.
struct Piece
{
  std::size_t First;
  std::size_t Count;
  std::size_t Total;
};

template <typename U>
void StoreBytePlanes(const U* codes, const Piece& piece, std::uint8_t* to)
{
  for (std::size_t byte = 0; byte < sizeof(U); ++byte)
  {
    std::uint8_t* plane = to + byte * piece.Total + piece.First;
    for (std::size_t index = 0; index < piece.Count; ++index)
    {
      plane[index] = static_cast<std::uint8_t>(codes[index] >> (8 * byte));
    }
  }
}

template <typename U>
void LoadBytePlanes(const std::uint8_t* from, const Piece& piece, U* __restrict codes)
{
  const std::uint8_t* __restrict plane = from + piece.First;
  const std::size_t pitch = piece.Total;
  // Plane after plane: loops that compilers turn into vectors, on codes in the first cache.
  for (std::size_t index = 0; index < piece.Count; ++index)
  {
    codes[index] = plane[index];
  }
  for (std::size_t byte = 1; byte < sizeof(U); ++byte)
  {
    const std::uint8_t* __restrict next = plane + byte * pitch;
    for (std::size_t index = 0; index < piece.Count; ++index)
    {
      codes[index] = static_cast<U>(codes[index] | static_cast<U>(U{ next[index] } << (8 * byte)));
    }
  }
}

template <typename U>
void StoreBitPlanes(const U* codes, const Piece& piece, std::uint8_t* to)
{
  const std::size_t groups = piece.Total / 8;
  const std::size_t first = piece.First / 8;
  const std::size_t whole = std::min(piece.Count / 8, groups - first);
  for (std::size_t byte = 0; byte < sizeof(U); ++byte)
  {
    for (std::size_t group = 0; group < whole; ++group)
    {
      std::uint64_t rows = 0;
      for (std::size_t row = 0; row < 8; ++row)
      {
        rows |= static_cast<std::uint64_t>(
                  static_cast<std::uint8_t>(codes[8 * group + row] >> (8 * byte)))
          << (8 * row);
      }
      const std::uint64_t planes = TransposeBits(rows);
      for (std::size_t bit = 0; bit < 8; ++bit)
      {
        to[(8 * byte + bit) * groups + first + group] =
          static_cast<std::uint8_t>(planes >> (8 * bit));
      }
    }
  }
  std::memcpy(to + sizeof(U) * (piece.First + 8 * whole), codes + 8 * whole,
    sizeof(U) * (piece.Count - 8 * whole));
}

template <typename U>
void LoadBitPlanes(const std::uint8_t* from, const Piece& piece, U* codes)
{
  const std::size_t groups = piece.Total / 8;
  const std::size_t first = piece.First / 8;
  const std::size_t whole = std::min(piece.Count / 8, groups - first);
  std::memset(codes, 0, sizeof(U) * piece.Count);
  for (std::size_t byte = 0; byte < sizeof(U); ++byte)
  {
    const std::uint8_t* planes = from + 8 * byte * groups + first;
    for (std::size_t group = 0; group < whole; ++group)
    {
      std::uint64_t columns = 0;
      for (std::size_t bit = 0; bit < 8; ++bit)
      {
        columns |= static_cast<std::uint64_t>(planes[bit * groups + group]) << (8 * bit);
      }
      const std::uint64_t rows = TransposeBits(columns);
      for (std::size_t row = 0; row < 8; ++row)
      {
        U& code = codes[8 * group + row];
        const auto part = static_cast<std::uint8_t>(rows >> (8 * row));
        code = static_cast<U>(code | static_cast<U>(U{ part } << (8 * byte)));
      }
    }
  }
  std::memcpy(codes + 8 * whole, from + sizeof(U) * (piece.First + 8 * whole),
    sizeof(U) * (piece.Count - 8 * whole));
}

template <typename U>
void StoreCodes(SampleLayout layout, const U* codes, const Piece& piece, std::uint8_t* to)
{
  // One byte plane is what it was.
  switch (sizeof(U) == 1 && layout == SampleLayout::BytePlanes ? SampleLayout::Samples : layout)
  {
    case SampleLayout::BytePlanes:
      return StoreBytePlanes(codes, piece, to);
    case SampleLayout::BitPlanes:
      return StoreBitPlanes(codes, piece, to);
    case SampleLayout::Samples:
      std::memcpy(to + sizeof(U) * piece.First, codes, sizeof(U) * piece.Count);
  }
}

template <typename U>
void LoadCodes(SampleLayout layout, const std::uint8_t* from, const Piece& piece, U* codes)
{
  switch (sizeof(U) == 1 && layout == SampleLayout::BytePlanes ? SampleLayout::Samples : layout)
  {
    case SampleLayout::BytePlanes:
      return LoadBytePlanes(from, piece, codes);
    case SampleLayout::BitPlanes:
      return LoadBitPlanes(from, piece, codes);
    case SampleLayout::Samples:
      std::memcpy(codes, from + sizeof(U) * piece.First, sizeof(U) * piece.Count);
  }
}

/// Codes of a piece of the samples, in place; `previous` goes from piece to piece.
template <typename T, typename U>
void EncodePiece(
  SamplePredictor predictor, U* values, std::size_t count, const U* predictions, U& previous)
{
  switch (predictor)
  {
    case SamplePredictor::None:
      return;
    case SamplePredictor::Previous:
      for (std::size_t index = 0; index < count; ++index)
      {
        const U value = OrderedSample<T>::FromBits(values[index]);
        values[index] = Zigzag(static_cast<U>(value - previous));
        previous = value;
      }
      return;
    case SamplePredictor::Coarser:
      for (std::size_t index = 0; index < count; ++index)
      {
        values[index] =
          Zigzag(static_cast<U>(OrderedSample<T>::FromBits(values[index]) - predictions[index]));
      }
  }
}

template <typename T, typename U>
void DecodePiece(
  SamplePredictor predictor, U* values, std::size_t count, const U* predictions, U& previous)
{
  switch (predictor)
  {
    case SamplePredictor::None:
      return;
    case SamplePredictor::Previous:
      for (std::size_t index = 0; index < count; ++index)
      {
        previous = static_cast<U>(previous + Unzigzag(values[index]));
        values[index] = OrderedSample<T>::ToBits(previous);
      }
      return;
    case SamplePredictor::Coarser:
      for (std::size_t index = 0; index < count; ++index)
      {
        values[index] =
          OrderedSample<T>::ToBits(static_cast<U>(predictions[index] + Unzigzag(values[index])));
      }
  }
}

} // namespace

void ApplyFilter(SegmentFilter filter, ValueType type, const std::uint8_t* samples,
  std::size_t count, const void* predictions, std::uint8_t* to)
{
  DispatchValueType(type,
    [&](auto zero)
    {
      using T = decltype(zero);
      using U = OrderedOf<T>;
      const U* predicted =
        filter.Predictor == SamplePredictor::Coarser ? static_cast<const U*>(predictions) : nullptr;
      U previous = OrderedSample<T>::Sign;
      U values[PieceSize];
      for (Piece piece{ 0, 0, count }; piece.First < count; piece.First += piece.Count)
      {
        piece.Count = std::min(PieceSize, count - piece.First);
        std::memcpy(values, samples + sizeof(U) * piece.First, sizeof(U) * piece.Count);
        EncodePiece<T>(filter.Predictor, values, piece.Count,
          predicted ? predicted + piece.First : nullptr, previous);
        StoreCodes(filter.Layout, values, piece, to);
      }
    });
}

void RevertFilter(SegmentFilter filter, ValueType type, const std::uint8_t* from, std::size_t count,
  const void* predictions, std::uint8_t* samples)
{
  DispatchValueType(type,
    [&](auto zero)
    {
      using T = decltype(zero);
      using U = OrderedOf<T>;
      const U* predicted =
        filter.Predictor == SamplePredictor::Coarser ? static_cast<const U*>(predictions) : nullptr;
      U previous = OrderedSample<T>::Sign;
      U values[PieceSize];
      for (Piece piece{ 0, 0, count }; piece.First < count; piece.First += piece.Count)
      {
        piece.Count = std::min(PieceSize, count - piece.First);
        LoadCodes(filter.Layout, from, piece, values);
        DecodePiece<T>(filter.Predictor, values, piece.Count,
          predicted ? predicted + piece.First : nullptr, previous);
        std::memcpy(samples + sizeof(U) * piece.First, values, sizeof(U) * piece.Count);
      }
    });
}

} // namespace isosurface
