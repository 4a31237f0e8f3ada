// SPDX-License-Identifier: BSD-3-Clause
#include "Storage/Record/SegmentFilter.h"

#include "Ground/Base/Coding.h"
#include "Ground/Base/ProcessorClones.h"
#include "Storage/Record/OrderedSample.h"

#include <algorithm>
#include <cstring>

namespace isosurface
{
namespace
{

/// Samples are filtered in runs that stay in the processor's first cache.
constexpr std::size_t RunSize = 1024;

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

/// Samples [First, First + Count) of a segment of Total samples.
struct SampleRun
{
  std::size_t First;
  std::size_t Count;
  std::size_t Total;
};

template <typename U>
void StoreBytePlanes(const U* codes, const SampleRun& run, std::uint8_t* to)
{
  for (std::size_t byte = 0; byte < sizeof(U); ++byte)
  {
    std::uint8_t* plane = to + byte * run.Total + run.First;
    for (std::size_t index = 0; index < run.Count; ++index)
    {
      plane[index] = static_cast<std::uint8_t>(codes[index] >> (8 * byte));
    }
  }
}

template <typename U>
void LoadBytePlanes(const std::uint8_t* from, const SampleRun& run, U* __restrict codes)
{
  const std::uint8_t* __restrict plane = from + run.First;
  const std::size_t pitch = run.Total;
  // One loop for each plane, which compilers vectorise, on codes that stay in the first cache.
  for (std::size_t index = 0; index < run.Count; ++index)
  {
    codes[index] = plane[index];
  }
  for (std::size_t byte = 1; byte < sizeof(U); ++byte)
  {
    const std::uint8_t* __restrict next = plane + byte * pitch;
    for (std::size_t index = 0; index < run.Count; ++index)
    {
      codes[index] = static_cast<U>(codes[index] | static_cast<U>(U{ next[index] } << (8 * byte)));
    }
  }
}

/// Splits a run of samples, which may be unaligned, into byte planes that are `pitch` apart.
template <typename U>
ISOSURFACE_CLONES void SplitBytes(const std::uint8_t* __restrict samples, std::size_t count,
  std::size_t pitch, std::uint8_t* __restrict to)
{
  for (std::size_t byte = 0; byte < sizeof(U); ++byte)
  {
    for (std::size_t index = 0; index < count; ++index)
    {
      U sample;
      std::memcpy(&sample, samples + sizeof(U) * index, sizeof(U));
      to[byte * pitch + index] = static_cast<std::uint8_t>(sample >> (8 * byte));
    }
  }
}

/// Replaces the samples of a run by their codes z; `previous` is carried from run to run.
template <typename T, typename U>
void EncodeRun(
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
void DecodeRun(
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
      U values[RunSize];
      for (SampleRun run{ 0, 0, count }; run.First < count; run.First += run.Count)
      {
        run.Count = std::min(RunSize, count - run.First);
        if (predictor == SamplePredictor::None)
        {
          SplitBytes<U>(samples + sizeof(U) * run.First, run.Count, count, to + run.First);
          continue;
        }
        std::memcpy(values, samples + sizeof(U) * run.First, sizeof(U) * run.Count);
        EncodeRun<T>(
          predictor, values, run.Count, predicted ? predicted + run.First : nullptr, previous);
        StoreBytePlanes(values, run, to);
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
      U values[RunSize];
      for (SampleRun run{ 0, 0, count }; run.First < count; run.First += run.Count)
      {
        run.Count = std::min(RunSize, count - run.First);
        LoadBytePlanes(from, run, values);
        DecodeRun<T>(
          predictor, values, run.Count, predicted ? predicted + run.First : nullptr, previous);
        std::memcpy(samples + sizeof(U) * run.First, values, sizeof(U) * run.Count);
      }
    });
}

} // namespace isosurface
