// SPDX-License-Identifier: BSD-3-Clause
#include "Partition/BlockWorkload.h"

#include "Contour/MarchingCubesCases.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <type_traits>

namespace isosurface
{
namespace
{

/// What changes in a cell when a corner goes outside, by corner and by the corners that were inside
/// until then: ActiveCellUnit for a cell that becomes active, plus the number of new triangles.
using ChangeTable = std::array<std::array<std::int16_t, 256>, 8>;
constexpr int ActiveCellUnit = 256;

ChangeTable MakeChangeTable()
{
  const auto weigh = [](std::size_t inside)
  {
    const int active = inside != 0 && inside != 255 ? ActiveCellUnit : 0;
    return active + static_cast<int>(MarchingCubesCases[inside] >> 60);
  };
  ChangeTable table;
  for (std::size_t corner = 0; corner < 8; ++corner)
  {
    for (std::size_t inside = 0; inside < 256; ++inside)
    {
      const std::size_t after = inside & ~(std::size_t{ 1 } << corner);
      table[corner][inside] = static_cast<std::int16_t>(weigh(after) - weigh(inside));
    }
  }
  return table;
}

// The inner loops exist for several processors; the loader picks the best of them. Sanitizers do
// not work before the loader has finished.
#if defined(__x86_64__) && defined(__linux__) && defined(__GNUC__) && \
  !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__) && !defined(__clang__)
#  define ISOSURFACE_CLONES __attribute__((target_clones("arch=skylake-avx512", "avx2", "default")))
#else
#  define ISOSURFACE_CLONES
#endif

/// The offset of a corner of a cell in a row-major lattice of vertices.
std::int64_t FindCorner(int corner, std::int64_t rowStride, std::int64_t sliceStride)
{
  return (corner & 1) + ((corner >> 1) & 1) * rowStride + (corner >> 2) * sliceStride;
}

/// How many of the edges First, First + 1, ... (Count of them, in units of the width) are <= value.
template <typename T>
class EdgeCounter
{
public:
  explicit EdgeCounter(const SpectrumBins& bins)
    : First(bins.First)
    , Count(bins.Count)
    , Exponent(bins.Exponent)
    // In two steps, since 2^-Exponent alone may be beyond the doubles.
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
    else
    {
      using Largest =
        std::conditional_t<std::is_same_v<T, std::uint64_t>, std::uint64_t, std::int64_t>;
      const Largest shifted = static_cast<Largest>(value) >> std::min(this->Exponent, 63);
      const auto quotient = static_cast<std::int64_t>(
        std::min<Largest>(shifted, std::numeric_limits<std::int64_t>::max()));
      if (quotient < this->First)
      {
        return 0;
      }
      const std::uint64_t steps =
        static_cast<std::uint64_t>(quotient) - static_cast<std::uint64_t>(this->First);
      return static_cast<std::int16_t>(steps >= this->Count ? this->Count : steps + 1);
    }
  }

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

  std::int64_t First;
  std::uint32_t Count;
  int Exponent;
  double Scale[2];
};

/// Whether any value of four rows of `count` differs from the first one.
ISOSURFACE_CLONES bool HasDifference(
  const std::int16_t* base, std::int64_t count, std::int64_t rowStride, std::int64_t sliceStride)
{
  int different = 0;
  for (const std::int64_t offset :
    { std::int64_t{ 0 }, rowStride, sliceStride, rowStride + sliceStride })
  {
    const std::int16_t* row = base + offset;
    for (std::int64_t i = 0; i < count; ++i)
    {
      different |= row[i] ^ *base;
    }
  }
  return different != 0;
}

/// For cells in a row: per corner, the corners (one bit each) that are inside until it goes
/// outside. Of equal corners the one of lower number goes outside first.
ISOSURFACE_CLONES void FindInside(const std::array<const std::int16_t*, 8>& values,
  const std::array<std::int16_t*, 8>& masks, std::int64_t cells)
{
  const std::int16_t *v0 = values[0], *v1 = values[1], *v2 = values[2], *v3 = values[3],
                     *v4 = values[4], *v5 = values[5], *v6 = values[6], *v7 = values[7];
  std::int16_t *m0 = masks[0], *m1 = masks[1], *m2 = masks[2], *m3 = masks[3], *m4 = masks[4],
               *m5 = masks[5], *m6 = masks[6], *m7 = masks[7];
#pragma GCC ivdep
  for (std::int64_t i = 0; i < cells; ++i)
  {
    const std::int16_t value[8] = { v0[i], v1[i], v2[i], v3[i], v4[i], v5[i], v6[i], v7[i] };
    std::int16_t mask[8] = { 1, 2, 4, 8, 16, 32, 64, 128 };
#pragma GCC unroll 8
    for (int b = 1; b < 8; ++b)
    {
#pragma GCC unroll 8
      for (int a = 0; a < b; ++a)
      {
        const bool later = value[a] > value[b];
        mask[a] = static_cast<std::int16_t>(mask[a] | (later ? 0 : 1 << b));
        mask[b] = static_cast<std::int16_t>(mask[b] | (later ? 1 << a : 0));
      }
    }
    m0[i] = mask[0];
    m1[i] = mask[1];
    m2[i] = mask[2];
    m3[i] = mask[3];
    m4[i] = mask[4];
    m5[i] = mask[5];
    m6[i] = mask[6];
    m7[i] = mask[7];
  }
}

} // namespace

BlockWorkload::BlockWorkload(const SpectrumBins& bins)
  : Bins(bins)
  , Changes(bins.Count + 1)
{
  static_assert(SpectrumBins::MaximumCount <= 32767, "numbers of edges are compared as int16");
}

void BlockWorkload::Count(const SampleView& samples)
{
  const Index3 size = samples.Box.GetSize();
  if (this->Bins.Count == 0 || size[0] < 2 || size[1] < 2 || size[2] < 2)
  {
    return;
  }
  this->EdgeCounts.resize(static_cast<std::size_t>(samples.Box.GetNumberOfVertices()));
  this->VertexChanges.assign(this->EdgeCounts.size(), 0);
  DispatchValueType(samples.Type, [&](auto zero) { this->FindBins<decltype(zero)>(samples); });
  for (std::int64_t k = 0; k + 1 < size[2]; ++k)
  {
    this->CountSlice(size[0] * size[1] * k, size[0], size[1]);
  }
  for (std::size_t vertex = 0; vertex < this->EdgeCounts.size(); ++vertex)
  {
    // At most 8 cells of at most 5 triangles: the triangles fill less than half a unit.
    const int change = this->VertexChanges[vertex];
    const int cells = (change + ActiveCellUnit / 2) >> 8;
    Change& sum = this->Changes[static_cast<std::size_t>(this->EdgeCounts[vertex])];
    sum.Triangles += change - cells * ActiveCellUnit;
    sum.Cells += cells;
  }
}

template <typename T>
void BlockWorkload::FindBins(const SampleView& samples)
{
  const EdgeCounter<T> count(this->Bins);
  const Index3 size = samples.Box.GetSize();
  const std::ptrdiff_t stride = samples.Stride[0];
  std::int16_t* to = this->EdgeCounts.data();
  for (std::int64_t k = 0; k < size[2]; ++k)
  {
    for (std::int64_t j = 0; j < size[1]; ++j)
    {
      const T* from =
        samples.At<T>({ samples.Box.Low[0], samples.Box.Low[1] + j, samples.Box.Low[2] + k });
      for (std::int64_t i = 0; i < size[0]; ++i)
      {
        *to++ = count(from[i * stride]);
      }
    }
  }
}

/// The cells of a slice, as if it were one long row: so the inner loops are long in small blocks,
/// too. The cell from the end of a row to the begin of the next is none, and changes nothing.
void BlockWorkload::CountSlice(std::int64_t begin, std::int64_t columns, std::int64_t rows)
{
  const std::int64_t cells = columns * (rows - 1) - 1;
  for (std::int64_t first = 0; first < cells; first += CellsAtOnce)
  {
    const std::int64_t count = std::min(CellsAtOnce, cells - first);
    const std::int16_t* base = this->EdgeCounts.data() + begin + first;
    if (HasDifference(base, count + 1, columns, columns * rows))
    {
      CornerMasks masks;
      FindMasks(base, count, columns, columns * rows, masks);
      for (std::int64_t cell = columns - 1 - first % columns; cell < count; cell += columns)
      {
        for (std::array<std::int16_t, CellsAtOnce>& ofCorner : masks)
        {
          ofCorner[static_cast<std::size_t>(cell)] = 0; // no corner is inside
        }
      }
      this->AddChanges(masks, begin + first, count, columns, columns * rows);
    }
  }
}

void BlockWorkload::FindMasks(const std::int16_t* base, std::int64_t cells, std::int64_t rowStride,
  std::int64_t sliceStride, CornerMasks& masks)
{
  std::array<const std::int16_t*, 8> values;
  std::array<std::int16_t*, 8> to;
  for (int corner = 0; corner < 8; ++corner)
  {
    values[static_cast<std::size_t>(corner)] = base + FindCorner(corner, rowStride, sliceStride);
    to[static_cast<std::size_t>(corner)] = masks[static_cast<std::size_t>(corner)].data();
  }
  FindInside(values, to, cells);
}

void BlockWorkload::AddChanges(const CornerMasks& masks, std::int64_t row, std::int64_t cells,
  std::int64_t rowStride, std::int64_t sliceStride)
{
  static const ChangeTable table = MakeChangeTable();
  // A vertex of a row is the low corner of one cell and the high one of the cell before.
  for (std::size_t corner = 0; corner < 8; corner += 2)
  {
    const std::int16_t* lowChanges = table[corner].data();
    const std::int16_t* highChanges = table[corner + 1].data();
    const std::int16_t* low = masks[corner].data();
    const std::int16_t* high = masks[corner + 1].data();
    std::int16_t* to = this->VertexChanges.data() + row +
      FindCorner(static_cast<int>(corner), rowStride, sliceStride);
    int before = 0;
    for (std::int64_t i = 0; i < cells; ++i)
    {
      to[i] = static_cast<std::int16_t>(to[i] + before + lowChanges[low[i]]);
      before = highChanges[high[i]];
    }
    to[cells] = static_cast<std::int16_t>(to[cells] + before);
  }
}

void BlockWorkload::MoveTo(WorkloadSpectrum& spectrum)
{
  std::int64_t triangles = 0;
  std::int64_t cells = 0;
  for (std::size_t bin = 0; bin < this->Bins.Count; ++bin)
  {
    triangles += this->Changes[bin].Triangles;
    cells += this->Changes[bin].Cells;
    spectrum.Triangles[bin] += static_cast<std::uint64_t>(triangles);
    spectrum.ActiveCells[bin] += static_cast<std::uint64_t>(cells);
  }
  std::fill(this->Changes.begin(), this->Changes.end(), Change{});
}

} // namespace isosurface
