// SPDX-License-Identifier: BSD-3-Clause
#include "Surface/Spectrum/VertexChanges.h"

#include "Ground/Base/ProcessorClones.h"

#include <algorithm>

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

/// Passes on the weights for minima of the cells between two slices and of the faces between them,
/// and adds the weights of the cells' faces in the slices. Adds to the weights of the lower slice;
/// sets those of the upper slice.
ISOSURFACE_CLONES void PassOnMinima(Input low, Input high, Input cells, Input facesXZ,
  Input facesYZ, Output lowFace, Output lowEdgeX, Output lowEdgeY, Output highFace,
  Output highEdgeX, Output highEdgeY, std::ptrdiff_t row, std::ptrdiff_t count)
{
  // At its minimum a cell becomes active, and A falls to 0. At that of a face, - 2 F rises by 2.
  constexpr std::int16_t unit = VertexChanges::ActiveCellUnit - 4;
  for (std::ptrdiff_t i = 0; i < count; ++i)
  {
    const std::int16_t a = Minimum(low[i], low[i + 1]);
    const std::int16_t b = Minimum(high[i], high[i + 1]);
    lowEdgeX[i] = Narrow(lowEdgeX[i] + If(a <= b, facesXZ[i]));
    highEdgeX[i] = If(a > b, facesXZ[i]);
    const std::int16_t aY = Minimum(low[i], low[i + row]);
    const std::int16_t bY = Minimum(high[i], high[i + row]);
    lowEdgeY[i] = Narrow(lowEdgeY[i] + If(aY <= bY, facesYZ[i]));
    highEdgeY[i] = If(aY > bY, facesYZ[i]);
    const std::int16_t aFace = Minimum(a, Minimum(low[i + row], low[i + row + 1]));
    const std::int16_t bFace = Minimum(b, Minimum(high[i + row], high[i + row + 1]));
    const auto face = static_cast<std::int16_t>(cells[i] & 2);
    const auto cell = static_cast<std::int16_t>(cells[i] & unit);
    lowFace[i] = Narrow(lowFace[i] + face + If(aFace <= bFace, cell));
    highFace[i] = Narrow(face + If(aFace > bFace, cell));
  }
}

/// Passes on the weights for maxima of the cells: there they are no longer active.
ISOSURFACE_CLONES void PassOnMaxima(Input low, Input high, Input cells, Output lowFace,
  Output highFace, std::ptrdiff_t row, std::ptrdiff_t count)
{
  for (std::ptrdiff_t i = 0; i < count; ++i)
  {
    const std::int16_t a =
      Maximum(Maximum(low[i], low[i + 1]), Maximum(low[i + row], low[i + row + 1]));
    const std::int16_t b =
      Maximum(Maximum(high[i], high[i + 1]), Maximum(high[i + row], high[i + row + 1]));
    const auto cell = static_cast<std::int16_t>(cells[i] & -VertexChanges::ActiveCellUnit);
    lowFace[i] = Narrow(lowFace[i] + If(a >= b, cell));
    highFace[i] = If(a < b, cell);
  }
}

/// Finds the cells with a diagonal whose ends are below all other corners, and the second and third
/// values of their corners; the two are equal for other cells. Returns false if there are none.
ISOSURFACE_CLONES bool FindDiagonals(Input low, Input high, Input cells,
  VertexChanges::Diagonal* __restrict__ found, std::ptrdiff_t row, std::ptrdiff_t count)
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
    const std::int16_t fall = Narrow((secondLower - Minimum(upper, secondLower)) & cells[i]);
    found[i].Second = Narrow(secondLower - fall);
    found[i].Third = secondLower;
    any = static_cast<std::int16_t>(any | fall);
  }
  return any != 0;
}

/// Passes on the weights of a slice's faces to its edges along x: a face has the edge of its low
/// corner and the edge of the next row.
ISOSURFACE_CLONES void PassOnFaces(Input values, Input lowFace, Input lowEdge, Input highFace,
  Output toLow, Output toHigh, std::ptrdiff_t row, std::ptrdiff_t count)
{
  for (std::ptrdiff_t i = 0; i < count; ++i)
  {
    const std::int16_t low = Minimum(values[i], values[i + 1]);
    const std::int16_t lowBefore = Minimum(values[i - row], values[i - row + 1]);
    const std::int16_t lowBehind = Minimum(values[i + row], values[i + row + 1]);
    toLow[i] =
      Narrow(lowEdge[i] + If(low <= lowBehind, lowFace[i]) + If(lowBefore > low, lowFace[i - row]));
    const std::int16_t high = Maximum(values[i], values[i + 1]);
    const std::int16_t highBefore = Maximum(values[i - row], values[i - row + 1]);
    const std::int16_t highBehind = Maximum(values[i + row], values[i + row + 1]);
    toHigh[i] =
      Narrow(If(high >= highBehind, highFace[i]) + If(highBefore < high, highFace[i - row]));
  }
}

/// Passes on the weights of a slice's edges to its vertices.
ISOSURFACE_CLONES void PassOnEdges(Input values, Input corners, std::int16_t sliceCount,
  Input lowEdgeX, Input highEdgeX, Input lowEdgeY, Output to, std::ptrdiff_t row,
  std::ptrdiff_t count)
{
  for (std::ptrdiff_t i = 0; i < count; ++i)
  {
    const std::int16_t value = values[i];
    const std::int16_t low =
      Narrow(If(value <= values[i + 1], lowEdgeX[i]) + If(values[i - 1] > value, lowEdgeX[i - 1]));
    const std::int16_t lowY = Narrow(
      If(value <= values[i + row], lowEdgeY[i]) + If(values[i - row] > value, lowEdgeY[i - row]));
    const std::int16_t high = Narrow(
      If(value >= values[i + 1], highEdgeX[i]) + If(values[i - 1] < value, highEdgeX[i - 1]));
    to[i] = Narrow(low + lowY + high - corners[i] * sliceCount);
  }
}

} // namespace

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
    for (SliceWeights* weights : { &this->Lower, &this->Upper })
    {
      for (std::vector<std::int16_t>* part :
        { &weights->LowFace, &weights->LowEdgeX, &weights->LowEdgeY, &weights->HighFace })
      {
        part->assign(this->Margin + this->SliceSize, 0);
      }
    }
    this->LowEdge.assign(this->Margin + this->SliceSize, 0);
    this->HighEdge.assign(this->Margin + this->SliceSize, 0);
    this->Found.resize(this->SliceSize);
  }
  const std::size_t vertices = this->SliceSize * this->Slices;
  this->Values.resize(std::max(this->Values.size(), vertices + 2 * this->Margin));
  this->Changes.resize(std::max(this->Changes.size(), vertices));
  return this->Values.data() + this->Margin;
}

void VertexChanges::FillUnits(std::size_t rows)
{
  for (std::vector<std::int16_t>* units :
    { &this->Cells, &this->FacesXZ, &this->FacesYZ, &this->Corners })
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
  for (std::vector<std::int16_t>* part :
    { &this->Lower.LowFace, &this->Lower.LowEdgeX, &this->Lower.LowEdgeY, &this->Lower.HighFace })
  {
    std::fill(part->begin(), part->end(), std::int16_t{ 0 });
  }
  for (std::size_t slice = 0; slice + 1 < this->Slices; ++slice)
  {
    this->VisitCells(slice);
    this->FinishSlice(slice);
    std::swap(this->Lower, this->Upper);
  }
  this->FinishSlice(this->Slices - 1);
}

void VertexChanges::VisitCells(std::size_t slice)
{
  const std::int16_t* low = this->GetValues() + slice * this->SliceSize;
  const std::int16_t* high = low + this->SliceSize;
  const auto row = static_cast<std::ptrdiff_t>(this->Columns);
  const auto count = static_cast<std::ptrdiff_t>(this->SliceSize);
  const auto begin = [&](std::vector<std::int16_t>& weights)
  { return weights.data() + this->Margin; };
  PassOnMinima(low, high, this->Cells.data(), this->FacesXZ.data(), this->FacesYZ.data(),
    begin(this->Lower.LowFace), begin(this->Lower.LowEdgeX), begin(this->Lower.LowEdgeY),
    begin(this->Upper.LowFace), begin(this->Upper.LowEdgeX), begin(this->Upper.LowEdgeY), row,
    count);
  PassOnMaxima(low, high, this->Cells.data(), begin(this->Lower.HighFace),
    begin(this->Upper.HighFace), row, count);
  if (FindDiagonals(low, high, this->Cells.data(), this->Found.data(), row, count))
  {
    this->AddDiagonals();
  }
}

void VertexChanges::AddDiagonals()
{
  this->Diagonals.resize(std::max(this->Diagonals.size(), this->SliceSize * this->Slices));
  Diagonal* next = this->Diagonals.data() + this->NumberOfDiagonals;
  for (const Diagonal& found : this->Found)
  {
    // Without a branch, which would often be mispredicted.
    *next = found;
    next += found.Second != found.Third ? 1 : 0;
  }
  this->NumberOfDiagonals = static_cast<std::size_t>(next - this->Diagonals.data());
}

void VertexChanges::FinishSlice(std::size_t slice)
{
  const std::int16_t* values = this->GetValues() + slice * this->SliceSize;
  const auto row = static_cast<std::ptrdiff_t>(this->Columns);
  const auto count = static_cast<std::ptrdiff_t>(this->SliceSize);
  const std::int16_t slices = slice == 0 || slice + 1 == this->Slices ? 1 : 2;
  const auto begin = [&](std::vector<std::int16_t>& weights)
  { return weights.data() + this->Margin; };
  PassOnFaces(values, begin(this->Lower.LowFace), begin(this->Lower.LowEdgeX),
    begin(this->Lower.HighFace), begin(this->LowEdge), begin(this->HighEdge), row, count);
  PassOnEdges(values, this->Corners.data(), slices, begin(this->LowEdge), begin(this->HighEdge),
    begin(this->Lower.LowEdgeY), this->Changes.data() + slice * this->SliceSize, row, count);
}

} // namespace isosurface
