// SPDX-License-Identifier: BSD-3-Clause
#include "Storage/Spectrum/BlockWorkload.h"

#include "Ground/Base/ProcessorClones.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <type_traits>
#include <utility>

namespace isosurface
{
namespace
{

/// A change of active cells and triangles in one number: cells times this, and triangles. The cells
/// around a vertex are 8, so that a change fits 32 bits.
constexpr int PackedCellBits = 27;
constexpr std::int32_t PackedCell = std::int32_t{ 1 } << PackedCellBits;
/// The triangles of so many changes are less than half of PackedCell: a vertex changes at most 48.
constexpr std::size_t MaximumPackedVertices = std::size_t{ 1 } << 20;

/// Counts the edges <= a value of at most 16 bits, in 32 bits and without a branch, so that loops
/// can be vectorised.
struct ShortEdgeCounter
{
  std::int16_t operator()(int value) const
  {
    return static_cast<std::int16_t>(
      std::clamp((value >> this->Exponent) - this->First + 1, 0, this->Count));
  }

  int First; ///< clamped to -2^20 .. 2^20, beyond all 16-bit values
  int Count;
  int Exponent;
};

/// The rows of a box of samples along x, whose distances are in samples.
struct SampleRows
{
  std::int64_t Length;
  std::int64_t Rows;
  std::int64_t Slices;
  std::ptrdiff_t RowStride;
  std::ptrdiff_t SliceStride;
};

template <typename T>
ISOSURFACE_CLONES void CountShortRows(const T* __restrict__ from, const SampleRows& rows,
  ShortEdgeCounter count, std::int16_t* __restrict__ to)
{
  const std::int64_t length = rows.Length;
  for (std::int64_t k = 0; k < rows.Slices; ++k)
  {
    for (std::int64_t j = 0; j < rows.Rows; ++j)
    {
      const T* __restrict__ row = from + k * rows.SliceStride + j * rows.RowStride;
      for (std::int64_t i = 0; i < length; ++i)
      {
        to[i] = count(row[i]);
      }
      to += length;
    }
  }
}

/// Finds the minimum and the maximum of some numbers.
ISOSURFACE_CLONES void FindLimits(
  const std::int16_t* values, std::size_t count, std::int16_t* minimum, std::int16_t* maximum)
{
  std::int16_t low = std::numeric_limits<std::int16_t>::max();
  std::int16_t high = std::numeric_limits<std::int16_t>::min();
  for (std::size_t index = 0; index < count; ++index)
  {
    low = values[index] < low ? values[index] : low;
    high = values[index] > high ? values[index] : high;
  }
  *minimum = low;
  *maximum = high;
}

/// Packs changes of vertices, in which a cell counts VertexChanges::ActiveCellUnit.
ISOSURFACE_CLONES void PackChanges(
  const std::int16_t* __restrict__ changes, std::size_t count, std::int32_t* __restrict__ packed)
{
  constexpr int unit = VertexChanges::ActiveCellUnit; // 2^8
  for (std::size_t index = 0; index < count; ++index)
  {
    // The triangles fill less than half a unit.
    const int cells = (changes[index] + unit / 2) >> 8;
    packed[index] = changes[index] + cells * (PackedCell - unit);
  }
}

/// Counts the edges <= a value. The edges are First, First + 1, ... First + Count - 1 times the
/// width.
template <typename T>
class EdgeCounter
{
public:
  explicit EdgeCounter(const SpectrumBins& bins)
    : First(bins.First)
    , Count(bins.Count)
    , Exponent(bins.Exponent)
    , Short{ static_cast<int>(std::clamp<std::int64_t>(bins.First, -ShortLimit, ShortLimit)),
      static_cast<int>(bins.Count), std::min(bins.Exponent, 31) }
    // In two steps, since 2^-Exponent may be too large for a double.
    , Scale{ std::ldexp(1.0, -(bins.Exponent / 2)),
      std::ldexp(1.0, -(bins.Exponent - bins.Exponent / 2)) }
  {
  }

  std::int16_t operator()(T value) const
  {
    if constexpr (std::is_floating_point_v<T>)
    {
      return this->CountBelow(static_cast<double>(value));
    }
    else if constexpr (sizeof(T) <= sizeof(std::int16_t))
    {
      return this->Short(value);
    }
    else
    {
      using Wide =
        std::conditional_t<std::is_same_v<T, std::uint64_t>, std::uint64_t, std::int64_t>;
      const Wide shifted = static_cast<Wide>(value) >> std::min(this->Exponent, 63);
      const auto quotient = static_cast<std::int64_t>(
        std::min<Wide>(shifted, std::numeric_limits<std::int64_t>::max()));
      if (quotient < this->First)
      {
        return 0;
      }
      const std::uint64_t steps =
        static_cast<std::uint64_t>(quotient) - static_cast<std::uint64_t>(this->First);
      return static_cast<std::int16_t>(steps >= this->Count ? this->Count : steps + 1);
    }
  }

  /// Counts the edges for each value of a row.
  void CountRow(const T* from, std::ptrdiff_t stride, std::int64_t size, std::int16_t* to) const
  {
    for (std::int64_t i = 0; i < size; ++i)
    {
      to[i] = (*this)(from[i * stride]);
    }
  }
  const ShortEdgeCounter& GetShort() const { return this->Short; }

private:
  std::int16_t CountBelow(double value) const
  {
    double quotient = value * this->Scale[0] * this->Scale[1];
    if (value < 0 && quotient == 0)
    {
      quotient = -0.5; // it has underflowed
    }
    if (!(quotient >= static_cast<double>(this->First))) // NaN as well
    {
      return 0;
    }
    if (quotient >= static_cast<double>(this->First + this->Count))
    {
      return static_cast<std::int16_t>(this->Count);
    }
    auto floor = static_cast<std::int64_t>(quotient);
    floor -= static_cast<double>(floor) > quotient ? 1 : 0;
    return static_cast<std::int16_t>(floor - this->First + 1);
  }

  /// Beyond all 16-bit values.
  static constexpr std::int64_t ShortLimit = 1 << 20;

  std::int64_t First;
  std::uint32_t Count;
  int Exponent;
  ShortEdgeCounter Short;
  double Scale[2];
};

template <typename T>
void CountEdges(const SpectrumBins& bins, const SampleView& samples, std::int16_t* to)
{
  const EdgeCounter<T> count(bins);
  const Index3 size = samples.Box.GetSize();
  const std::ptrdiff_t stride = samples.Stride[0];
  if constexpr (sizeof(T) <= sizeof(std::int16_t))
  {
    if (stride == 1)
    {
      CountShortRows(samples.At<T>(samples.Box.Low),
        { size[0], size[1], size[2], samples.Stride[1], samples.Stride[2] }, count.GetShort(), to);
      return;
    }
  }
  for (std::int64_t k = 0; k < size[2]; ++k)
  {
    for (std::int64_t j = 0; j < size[1]; ++j)
    {
      const T* from =
        samples.At<T>({ samples.Box.Low[0], samples.Box.Low[1] + j, samples.Box.Low[2] + k });
      count.CountRow(from, stride, size[0], to);
      to += size[0];
    }
  }
}

} // namespace

BlockWorkload::BlockWorkload(const SpectrumBins& bins)
{
  static_assert(SpectrumBins::MaximumCount < 32767, "numbers of edges are compared as int16");
  this->SetBins(bins);
}

void BlockWorkload::SetBins(const SpectrumBins& bins)
{
  this->Bins = bins;
  this->Changes.resize(std::max(this->Changes.size(), bins.Count + std::size_t{ 1 }));
  this->PackedChanges.resize(this->Changes.size() * PackedSums, 0);
  this->MinimumValue = bins.Count;
  this->MaximumValue = 0;
}

void BlockWorkload::Count(const SampleView& samples)
{
  const Index3 size = samples.Box.GetSize();
  if (this->Bins.Count == 0 || size[0] < 2 || size[1] < 2 || size[2] < 2)
  {
    return;
  }
  std::int16_t* values = this->Vertices.Resize(size);
  DispatchValueType(
    samples.Type, [&](auto zero) { CountEdges<decltype(zero)>(this->Bins, samples, values); });
  this->Vertices.Compute();
  const std::size_t vertices = this->Vertices.GetNumberOfVertices();
  std::int16_t minimum = 0;
  std::int16_t maximum = 0;
  FindLimits(values, vertices, &minimum, &maximum);
  this->MinimumValue = std::min(this->MinimumValue, static_cast<std::size_t>(minimum));
  this->MaximumValue = std::max(this->MaximumValue, static_cast<std::size_t>(maximum));
  for (std::size_t begin = 0; begin < vertices; begin += MaximumPackedVertices)
  {
    const std::size_t end = std::min(begin + MaximumPackedVertices, vertices);
    if (this->PackedVertices + (end - begin) > MaximumPackedVertices)
    {
      this->Unpack();
    }
    this->PackedVertices += end - begin;
    this->AddChanges(begin, end);
  }
  const VertexChanges::Diagonal* const diagonals = this->Vertices.GetDiagonals();
  for (std::size_t index = 0; index < this->Vertices.GetNumberOfDiagonals(); ++index)
  {
    this->Changes[static_cast<std::size_t>(diagonals[index].Second)].Triangles -= 4;
    this->Changes[static_cast<std::size_t>(diagonals[index].Third)].Triangles += 4;
  }
}

void BlockWorkload::AddChanges(std::size_t begin, std::size_t end)
{
  // Neighbours often have the same value: they use different sums, so that one addition need not
  // wait for the other.
  std::int64_t* const even = this->PackedChanges.data();
  std::int64_t* const odd = even + this->PackedChanges.size() / PackedSums;
  std::array<std::int32_t, 1024> packed; // in the processor's first cache
  for (; begin < end; begin += packed.size())
  {
    const std::int16_t* const values = this->Vertices.GetValues() + begin;
    const std::int16_t* const changes = this->Vertices.GetChanges() + begin;
    const std::size_t count = std::min(packed.size(), end - begin);
    PackChanges(changes, count, packed.data());
    // Skips zeros four at a time: most changes are 0 where values are smooth.
    std::size_t vertex = 0;
    for (; vertex + 4 <= count; vertex += 4)
    {
      std::uint64_t some = 0;
      std::memcpy(&some, changes + vertex, sizeof(some));
      if (some != 0)
      {
        even[values[vertex]] += packed[vertex];
        odd[values[vertex + 1]] += packed[vertex + 1];
        even[values[vertex + 2]] += packed[vertex + 2];
        odd[values[vertex + 3]] += packed[vertex + 3];
      }
    }
    for (; vertex < count; ++vertex)
    {
      even[values[vertex]] += packed[vertex];
    }
  }
}

void BlockWorkload::Unpack()
{
  std::int64_t* const even = this->PackedChanges.data();
  std::int64_t* const odd = even + this->PackedChanges.size() / PackedSums;
  for (std::size_t value = this->MinimumValue; value <= this->MaximumValue; ++value)
  {
    const std::int64_t packed = std::exchange(even[value], 0) + std::exchange(odd[value], 0);
    const std::int64_t cells = (packed + PackedCell / 2) >> PackedCellBits;
    this->Changes[value].Triangles += packed - cells * PackedCell;
    this->Changes[value].Cells += cells;
  }
  this->PackedVertices = 0;
}

void BlockWorkload::MoveTo(WorkloadSpectrum& spectrum)
{
  this->Unpack();
  std::int64_t triangles = 0;
  std::int64_t cells = 0;
  // The changes of a cell cancel out, so before the minimum and after the maximum all sums are 0.
  for (std::size_t value = this->MinimumValue; value <= this->MaximumValue; ++value)
  {
    const Change change = std::exchange(this->Changes[value], {});
    triangles += change.Triangles;
    cells += change.Cells;
    if (value < this->Bins.Count)
    {
      spectrum.Triangles[value] += static_cast<std::uint64_t>(triangles);
      spectrum.ActiveCells[value] += static_cast<std::uint64_t>(cells);
    }
  }
  this->MinimumValue = this->Bins.Count;
  this->MaximumValue = 0;
}

} // namespace isosurface
