// SPDX-License-Identifier: BSD-3-Clause
#include "Storage/Spectrum/VertexChanges.h"

#include "Ground/Base/Coding.h"
#include "Ground/Base/ProcessorClones.h"

#include <algorithm>
#include <limits>

namespace isosurface
{
namespace
{

/// The 16-bit numbers of a slice, beginning with its first vertex.
using Input = const std::int16_t* __restrict__;
using Output = std::int16_t* __restrict__;

constexpr std::int16_t Narrow(int value)
{
  return static_cast<std::int16_t>(value);
}

/// `value` if the condition is true, otherwise 0.
constexpr std::int16_t If(bool condition, std::int16_t value)
{
  return condition ? value : std::int16_t{ 0 };
}

constexpr std::int16_t Minimum(std::int16_t a, std::int16_t b)
{
  return a < b ? a : b;
}

constexpr std::int16_t Maximum(std::int16_t a, std::int16_t b)
{
  return a > b ? a : b;
}

/// Finds the cells with a diagonal whose ends are below all other corners: the third value of their
/// corners, and how far below it the second one is, which is 0 for other cells. Returns false if
/// there are none.
ISOSURFACE_CLONES bool FindDiagonals(Input low, Input high, Input cells, Output third, Output fall,
  std::uint8_t* __restrict__ found, std::ptrdiff_t row, std::ptrdiff_t count)
{
  std::int16_t any = 0;
  for (std::ptrdiff_t i = 0; i < count; ++i)
  {
    // The lower and the upper ends of the four diagonals. If the minimum of the upper ends is below
    // all but one of the lower ends, both belong to one diagonal.
    const std::int16_t a[4] = { low[i], low[i + 1], low[i + row], low[i + row + 1] };
    const std::int16_t b[4] = { high[i + row + 1], high[i + row], high[i + 1], high[i] };
    const std::int16_t lower[4] = { Minimum(a[0], b[0]), Minimum(a[1], b[1]), Minimum(a[2], b[2]),
      Minimum(a[3], b[3]) };
    const std::int16_t upper = Minimum(Minimum(Maximum(a[0], b[0]), Maximum(a[1], b[1])),
      Minimum(Maximum(a[2], b[2]), Maximum(a[3], b[3])));
    const std::int16_t secondLower =
      Minimum(Maximum(Minimum(lower[0], lower[1]), Minimum(lower[2], lower[3])),
        Minimum(Maximum(lower[0], lower[1]), Maximum(lower[2], lower[3])));
    const std::int16_t falls = Narrow((secondLower - Minimum(upper, secondLower)) & cells[i]);
    third[i] = secondLower;
    fall[i] = falls;
    found[i] = falls != 0 ? 1 : 0;
    any = static_cast<std::int16_t>(any | falls);
  }
  return any != 0;
}

/// Packs 64 bytes that are 0 or 1 into bits.
std::uint64_t PackFlags(const std::uint8_t* flags)
{
  std::uint64_t bits = 0;
  for (int byte = 0; byte < 8; ++byte)
  {
    // The product brings each flag to a bit of its own in the last byte.
    const std::uint64_t product =
      LoadLittleEndian<std::uint64_t>(flags + 8 * byte) * 0x0102040810204080u;
    bits |= (product >> 56) << (8 * byte);
  }
  return bits;
}

/// What a vertex, edge or face of this value gets of two cells, faces or edges that it shares, one
/// with the next one of its kind and one with the one before. Of equal values the first one gets it.
constexpr std::int16_t GetShare(std::int16_t value, std::int16_t next, std::int16_t weight,
  std::int16_t before, std::int16_t weightBefore)
{
  return Narrow(If(value <= next, weight) + If(before > value, weightBefore));
}

/// Finds the extremes of the edges and faces of a slice.
ISOSURFACE_CLONES void FindSliceExtremes(Input values, Output lowEdgeX, Output lowEdgeY,
  Output lowFace, Output highEdgeX, Output highFace, std::ptrdiff_t row, std::ptrdiff_t count)
{
  for (std::ptrdiff_t i = 0; i < count; ++i)
  {
    const std::int16_t a = values[i];
    const std::int16_t b = values[i + 1];
    const std::int16_t c = values[i + row];
    const std::int16_t d = values[i + row + 1];
    lowEdgeX[i] = Minimum(a, b);
    lowEdgeY[i] = Minimum(a, c);
    lowFace[i] = Minimum(Minimum(a, b), Minimum(c, d));
    highEdgeX[i] = Narrow(~Maximum(a, b));
    highFace[i] = Narrow(~Maximum(Maximum(a, b), Maximum(c, d)));
  }
}

/// Passes on the weights of faces or cells between slices to the edges or faces of a slice.
ISOSURFACE_CLONES void PassOnBetweenSlices(
  Input below, Input own, Input above, Input weights, Output to, std::ptrdiff_t count)
{
  for (std::ptrdiff_t i = 0; i < count; ++i)
  {
    to[i] = GetShare(own[i], above[i], weights[i], below[i], weights[i]);
  }
}

/// Passes on the weights of cells to the minima and maxima of a slice's faces, and adds the weights
/// of the faces, which are in so many layers of cells.
ISOSURFACE_CLONES void PassOnCells(Input lowBelow, Input low, Input lowAbove, Input highBelow,
  Input high, Input highAbove, Input cells, std::int16_t layers, Output toLow, Output toHigh,
  std::ptrdiff_t count)
{
  // At its minimum a cell becomes active, and A falls to 0. At that of a face, - 2 F rises by 2. At
  // its maximum a cell is no longer active.
  constexpr std::int16_t lowUnit = VertexChanges::ActiveCellUnit - 4;
  const auto faceUnit = static_cast<std::int16_t>(2 * layers);
  for (std::ptrdiff_t i = 0; i < count; ++i)
  {
    const auto lowCell = static_cast<std::int16_t>(cells[i] & lowUnit);
    const auto highCell = static_cast<std::int16_t>(cells[i] & -VertexChanges::ActiveCellUnit);
    toLow[i] =
      Narrow(GetShare(low[i], lowAbove[i], lowCell, lowBelow[i], lowCell) + (cells[i] & faceUnit));
    toHigh[i] = GetShare(high[i], highAbove[i], highCell, highBelow[i], highCell);
  }
}

/// Passes on the weights of a slice's faces to its edges along x; adds them to those for minima.
ISOSURFACE_CLONES void PassOnFaces(Input low, Input lowFace, Input high, Input highFace,
  Output toLow, Output toHigh, std::ptrdiff_t row, std::ptrdiff_t count)
{
  for (std::ptrdiff_t i = 0; i < count; ++i)
  {
    toLow[i] =
      Narrow(toLow[i] + GetShare(low[i], low[i + row], lowFace[i], low[i - row], lowFace[i - row]));
    toHigh[i] = GetShare(high[i], high[i + row], highFace[i], high[i - row], highFace[i - row]);
  }
}

/// Passes on the weights of a slice's edges to its vertices.
ISOSURFACE_CLONES void PassOnEdges(Input values, Input corners, std::int16_t layers, Input lowEdgeX,
  Input highEdgeX, Input lowEdgeY, Output to, std::ptrdiff_t row, std::ptrdiff_t count)
{
  for (std::ptrdiff_t i = 0; i < count; ++i)
  {
    const std::int16_t value = values[i];
    const std::int16_t low =
      GetShare(value, values[i + 1], lowEdgeX[i], values[i - 1], lowEdgeX[i - 1]);
    const std::int16_t lowY =
      GetShare(value, values[i + row], lowEdgeY[i], values[i - row], lowEdgeY[i - row]);
    const std::int16_t high = Narrow(
      If(value >= values[i + 1], highEdgeX[i]) + If(values[i - 1] < value, highEdgeX[i - 1]));
    to[i] = Narrow(low + lowY + high - corners[i] * layers);
  }
}

} // namespace

void VertexChanges::Extremes::Assign(std::size_t size, std::int16_t value)
{
  for (Numbers* numbers :
    { &this->LowEdgeX, &this->LowEdgeY, &this->LowFace, &this->HighEdgeX, &this->HighFace })
  {
    numbers->assign(size, value);
  }
}

std::int16_t* VertexChanges::Resize(const Index3& size)
{
  const auto columns = static_cast<std::size_t>(size[0]);
  const auto rows = static_cast<std::size_t>(size[1]);
  this->Slices = static_cast<std::size_t>(size[2]);
  if (columns != this->Columns || columns * rows != this->SliceSize)
  {
    this->Columns = columns;
    this->SliceSize = columns * rows;
    this->Margin = columns + 1;
    this->FillUnits(rows);
    for (Extremes* extremes : { &this->Nearby[0], &this->Nearby[1], &this->Nearby[2] })
    {
      extremes->Assign(this->SliceSize + 2 * this->Margin, 0);
    }
    // Below all others, so that nothing is passed on from there.
    this->Outside.Assign(
      this->SliceSize + 2 * this->Margin, std::numeric_limits<std::int16_t>::min());
    for (Numbers* weights :
      { &this->LowFace, &this->HighFace, &this->LowEdgeX, &this->LowEdgeY, &this->HighEdgeX })
    {
      weights->assign(this->Margin + this->SliceSize, 0);
    }
    this->Third.resize(this->SliceSize);
    this->Fall.resize(this->SliceSize);
    this->Found.assign((this->SliceSize + 63) / 64 * 64, 0);
  }
  const std::size_t vertices = this->SliceSize * this->Slices;
  this->Values.resize(std::max(this->Values.size(), vertices + 2 * this->Margin));
  this->Changes.resize(std::max(this->Changes.size(), vertices));
  return this->Values.data() + this->Margin;
}

void VertexChanges::FillUnits(std::size_t rows)
{
  for (Numbers* units : { &this->Cells, &this->FacesXZ, &this->FacesYZ, &this->Corners })
  {
    units->assign(this->SliceSize, 0);
  }
  const auto countAround = [](std::size_t index, std::size_t count)
  { return index == 0 || index + 1 == count ? 1 : 2; };
  for (std::size_t j = 0; j < rows; ++j)
  {
    for (std::size_t i = 0; i < this->Columns; ++i)
    {
      const std::size_t vertex = i + j * this->Columns;
      const bool hasX = i + 1 < this->Columns;
      const bool hasY = j + 1 < rows;
      const int x = countAround(i, this->Columns);
      const int y = countAround(j, rows);
      this->Cells[vertex] = Narrow(hasX && hasY ? -1 : 0);
      this->FacesXZ[vertex] = Narrow(hasX ? 2 * y : 0);
      this->FacesYZ[vertex] = Narrow(hasY ? 2 * x : 0);
      this->Corners[vertex] = Narrow(x * y);
    }
  }
}

void VertexChanges::Compute()
{
  this->NumberOfDiagonals = 0;
  const Extremes* below = &this->Outside;
  Extremes* own = &this->Nearby[0];
  this->FindExtremes(0, *own);
  for (std::size_t slice = 0; slice < this->Slices; ++slice)
  {
    Extremes* above = &this->Outside;
    if (slice + 1 < this->Slices)
    {
      above = &this->Nearby[(slice + 1) % this->Nearby.size()];
      this->FindExtremes(slice + 1, *above);
      this->AddDiagonals(slice);
    }
    this->FinishSlice(slice, *below, *own, *above);
    below = own;
    own = above;
  }
}

void VertexChanges::FindExtremes(std::size_t slice, Extremes& extremes) const
{
  const auto begin = [&](Numbers& numbers) { return numbers.data() + this->Margin; };
  FindSliceExtremes(this->GetValues() + slice * this->SliceSize, begin(extremes.LowEdgeX),
    begin(extremes.LowEdgeY), begin(extremes.LowFace), begin(extremes.HighEdgeX),
    begin(extremes.HighFace), static_cast<std::ptrdiff_t>(this->Columns),
    static_cast<std::ptrdiff_t>(this->SliceSize));
}

/// Adds the diagonals of the cells between a slice and the next one.
void VertexChanges::AddDiagonals(std::size_t slice)
{
  const std::int16_t* low = this->GetValues() + slice * this->SliceSize;
  if (!FindDiagonals(low, low + this->SliceSize, this->Cells.data(), this->Third.data(),
        this->Fall.data(), this->Found.data(), static_cast<std::ptrdiff_t>(this->Columns),
        static_cast<std::ptrdiff_t>(this->SliceSize)))
  {
    return;
  }
  this->Diagonals.resize(std::max(this->Diagonals.size(), this->SliceSize * this->Slices));
  Diagonal* next = this->Diagonals.data() + this->NumberOfDiagonals;
  for (std::size_t first = 0; first < this->Found.size(); first += 64)
  {
    // One bit a cell, so that there are as many turns as diagonals.
    for (std::uint64_t bits = PackFlags(this->Found.data() + first); bits != 0; bits &= bits - 1)
    {
      const std::size_t cell = first + static_cast<std::size_t>(__builtin_ctzll(bits));
      *next++ = { Narrow(this->Third[cell] - this->Fall[cell]), this->Third[cell] };
    }
  }
  this->NumberOfDiagonals = static_cast<std::size_t>(next - this->Diagonals.data());
}

void VertexChanges::FinishSlice(
  std::size_t slice, const Extremes& below, const Extremes& own, const Extremes& above)
{
  const auto row = static_cast<std::ptrdiff_t>(this->Columns);
  const auto count = static_cast<std::ptrdiff_t>(this->SliceSize);
  const std::int16_t layers = slice == 0 || slice + 1 == this->Slices ? 1 : 2;
  const auto begin = [&](const Numbers& numbers) { return numbers.data() + this->Margin; };
  const auto to = [&](Numbers& numbers) { return numbers.data() + this->Margin; };
  PassOnBetweenSlices(begin(below.LowEdgeX), begin(own.LowEdgeX), begin(above.LowEdgeX),
    this->FacesXZ.data(), to(this->LowEdgeX), count);
  PassOnBetweenSlices(begin(below.LowEdgeY), begin(own.LowEdgeY), begin(above.LowEdgeY),
    this->FacesYZ.data(), to(this->LowEdgeY), count);
  PassOnCells(begin(below.LowFace), begin(own.LowFace), begin(above.LowFace), begin(below.HighFace),
    begin(own.HighFace), begin(above.HighFace), this->Cells.data(), layers, to(this->LowFace),
    to(this->HighFace), count);
  PassOnFaces(begin(own.LowEdgeX), begin(this->LowFace), begin(own.HighEdgeX),
    begin(this->HighFace), to(this->LowEdgeX), to(this->HighEdgeX), row, count);
  PassOnEdges(this->GetValues() + slice * this->SliceSize, this->Corners.data(), layers,
    begin(this->LowEdgeX), begin(this->HighEdgeX), begin(this->LowEdgeY),
    this->Changes.data() + slice * this->SliceSize, row, count);
}

} // namespace isosurface
