// SPDX-License-Identifier: BSD-3-Clause
#include "Storage/Record/SegmentPrediction.h"

#include "Storage/Record/OrderedSample.h"

#include <algorithm>
#include <cstddef>
#include <cstring>

namespace isosurface
{
namespace
{

/// Rows are computed in steps of this many samples, which compilers vectorise; the last step may
/// exceed the row.
constexpr std::size_t Step = 16;

std::size_t CountSteps(std::size_t size)
{
  return (size + Step - 1) / Step;
}

template <typename U>
U Mean(U a, U b)
{
  if constexpr (sizeof(U) <= 2)
  {
    // Compilers turn this form into one instruction.
    return static_cast<U>((std::uint32_t{ a } + b + 1) >> 1);
  }
  else
  {
    return (a | b) - ((a ^ b) >> 1);
  }
}

template <typename U>
void ComputeMeans(const U* __restrict a, const U* __restrict b, U* __restrict to, std::size_t steps)
{
  for (std::size_t index = 0; index < steps * Step; ++index)
  {
    to[index] = Mean(a[index], b[index]);
  }
}

/// a[0], b[0], a[1], b[1], ...
template <typename U>
void Interleave(const U* __restrict a, const U* __restrict b, U* __restrict to, std::size_t steps)
{
  for (std::size_t index = 0; index < steps * Step; ++index)
  {
    to[2 * index] = a[index];
    to[2 * index + 1] = b[index];
  }
}

/// A copy of the coarser level as ordered integers; the last sample of each row is repeated.
template <typename U>
struct CoarseRows
{
  VertexBox Box;
  std::size_t Pitch;
  U* First;

  template <typename T>
  void Fill(const SampleView& coarser)
  {
    const auto width = static_cast<std::size_t>(this->Box.GetSize()[0]);
    U* to = this->First;
    for (std::int64_t k = this->Box.Low[2]; k < this->Box.High[2]; ++k)
    {
      for (std::int64_t j = this->Box.Low[1]; j < this->Box.High[1]; ++j)
      {
        std::memcpy(to, coarser.At<T>({ this->Box.Low[0], j, k }), width * sizeof(U));
        for (std::size_t i = 0; i < width; ++i)
        {
          to[i] = OrderedSample<T>::FromBits(to[i]);
        }
        std::fill(to + width, to + this->Pitch, to[width - 1]);
        to += this->Pitch;
      }
    }
  }

  const U* Find(std::int64_t j, std::int64_t k) const
  {
    const Index3 size = this->Box.GetSize();
    const std::int64_t row = std::clamp<std::int64_t>(j - this->Box.Low[1], 0, size[1] - 1) +
      size[1] * std::clamp<std::int64_t>(k - this->Box.Low[2], 0, size[2] - 1);
    return this->First + static_cast<std::size_t>(row) * this->Pitch;
  }
};

/// The coarse row that predicts the fine row (j, k) at its even vertices; `memory` holds 3 pitches.
template <typename U>
const U* CombineRows(const CoarseRows<U>& coarse, std::int64_t j, std::int64_t k, U* memory)
{
  const std::size_t pitch = coarse.Pitch;
  const auto combineInPlane = [&](std::int64_t plane, U* to) -> const U*
  {
    const U* low = coarse.Find(j >> 1, plane);
    const U* high = coarse.Find((j + 1) >> 1, plane);
    if (low == high)
    {
      return low;
    }
    ComputeMeans(low, high, to, pitch / Step);
    return to;
  };
  const U* low = combineInPlane(k >> 1, memory);
  if ((k & 1) == 0)
  {
    return low;
  }
  const U* high = combineInPlane((k + 1) >> 1, memory + pitch);
  ComputeMeans(low, high, memory + 2 * pitch, pitch / Step);
  return memory + 2 * pitch;
}

} // namespace

const void* SegmentPrediction::Compute(const BlockSegment& segment, const SampleView& coarser)
{
  return DispatchValueType(coarser.Type,
    [&](auto zero) -> const void*
    {
      using T = decltype(zero);
      using U = OrderedOf<T>;
      CoarseRows<U> coarse;
      coarse.Box = coarser.Available;
      coarse.Pitch = CountSteps(static_cast<std::size_t>(coarse.Box.GetSize()[0]) + 1) * Step;
      // A row's last step may read one sample and write two steps beyond the row.
      const std::size_t margin = 4 * coarse.Pitch;
      const auto grow = [](std::vector<std::uint8_t>& bytes, std::size_t size)
      { bytes.resize(std::max(bytes.size(), size * sizeof(U))); };
      const Index3 size = coarse.Box.GetSize();
      grow(this->Coarse, static_cast<std::size_t>(size[1] * size[2]) * coarse.Pitch + margin);
      grow(this->Rows, 4 * coarse.Pitch + margin);
      grow(this->Predictions, static_cast<std::size_t>(segment.GetNumberOfSamples()) + 1 + margin);
      coarse.First = reinterpret_cast<U*>(this->Coarse.data());
      coarse.template Fill<T>(coarser);
      U* between = reinterpret_cast<U*>(this->Rows.data());
      U* combined = between + coarse.Pitch + Step;
      // One sample more in front: rows are computed from an even vertex on.
      U* predictions = reinterpret_cast<U*>(this->Predictions.data()) + 1;

      segment.VisitRows(segment.GetBox(),
        [&](const SegmentRow& row)
        {
          const U* means =
            CombineRows(coarse, row.J, row.K, combined) + (row.I >> 1) - coarse.Box.Low[0];
          U* to = predictions + row.Offset;
          const auto count = static_cast<std::size_t>(row.Count);
          if (row.Step == 2)
          {
            ComputeMeans(means, means + 1, to, CountSteps(count));
            return;
          }
          // If the first vertex is odd, the even one before it belongs to the previous row.
          U* even = to - (row.I & 1);
          const U before = *even;
          const std::size_t steps = CountSteps(count / 2 + 1);
          ComputeMeans(means, means + 1, between, steps);
          Interleave(means, between, even, steps);
          if ((row.I & 1) != 0)
          {
            *even = before;
          }
        });
      return predictions;
    });
}

} // namespace isosurface
