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

/// Samples are filtered in pieces that stay in the first cache.
constexpr std::size_t PieceSize = 1024;

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

/// A piece of a segment: samples [First, First + Count) of Total.
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
  // One loop a plane, which compilers vectorise, on codes that stay in the first cache.
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

/// Replaces the samples of a piece by their codes z; `previous` is carried from piece to piece.
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

bool IsPredictor(std::uint8_t number)
{
  return number <= static_cast<std::uint8_t>(SamplePredictor::Coarser);
}

void ApplyFilter(SamplePredictor predictor, ValueType type, const std::uint8_t* samples,
  std::size_t count, const void* predictions, std::uint8_t* to)
{
  DispatchValueType(type,
    [&](auto zero)
    {
      using T = decltype(zero);
      using U = OrderedOf<T>;
      const U* predicted =
        predictor == SamplePredictor::Coarser ? static_cast<const U*>(predictions) : nullptr;
      U previous = OrderedSample<T>::Sign;
      U values[PieceSize];
      for (Piece piece{ 0, 0, count }; piece.First < count; piece.First += piece.Count)
      {
        piece.Count = std::min(PieceSize, count - piece.First);
        std::memcpy(values, samples + sizeof(U) * piece.First, sizeof(U) * piece.Count);
        EncodePiece<T>(
          predictor, values, piece.Count, predicted ? predicted + piece.First : nullptr, previous);
        StoreBytePlanes(values, piece, to);
      }
    });
}

void RevertFilter(SamplePredictor predictor, ValueType type, const std::uint8_t* from,
  std::size_t count, const void* predictions, std::uint8_t* samples)
{
  DispatchValueType(type,
    [&](auto zero)
    {
      using T = decltype(zero);
      using U = OrderedOf<T>;
      const U* predicted =
        predictor == SamplePredictor::Coarser ? static_cast<const U*>(predictions) : nullptr;
      U previous = OrderedSample<T>::Sign;
      U values[PieceSize];
      for (Piece piece{ 0, 0, count }; piece.First < count; piece.First += piece.Count)
      {
        piece.Count = std::min(PieceSize, count - piece.First);
        LoadBytePlanes(from, piece, values);
        DecodePiece<T>(
          predictor, values, piece.Count, predicted ? predicted + piece.First : nullptr, previous);
        std::memcpy(samples + sizeof(U) * piece.First, values, sizeof(U) * piece.Count);
      }
    });
}

} // namespace isosurface
