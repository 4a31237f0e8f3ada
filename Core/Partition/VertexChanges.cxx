// SPDX-License-Identifier: BSD-3-Clause
#include "Partition/VertexChanges.h"

#include "Partition/ProcessorClones.h"

#include <algorithm>
#include <limits>

namespace isosurface
{
namespace
{

/// 16-bit numbers of a slice, from its first vertex on.
using Input = const std::int16_t* __restrict__;
using Output = std::int16_t* __restrict__;

constexpr std::int16_t Narrow(int value)
{
  return static_cast<std::int16_t>(value);
}

/// `value` if the condition holds, else 0.
constexpr std::int16_t If(bool condition, std::int16_t value)
{
  return condition ? value : std::int16_t{ 0 };
}

constexpr std::int16_t Least(std::int16_t a, std::int16_t b)
{
  return a < b ? a : b;
}

constexpr std::int16_t Greatest(std::int16_t a, std::int16_t b)
{
  return a > b ? a : b;
}

/// Hands the weights of the cells between two slices, of the faces there and, as each of these
/// cells has one in either slice, of the faces in the slices. What the lower slice has got before
/// is added to; the upper one has got nothing.
ISOSURFACE_CLONES void HandLowsDown(Input low, Input high, Input cells, Input facesXZ,
  Input facesYZ, Output lowFace, Output lowEdgeX, Output lowEdgeY, Output highFace,
  Output highEdgeX, Output highEdgeY, std::ptrdiff_t row, std::ptrdiff_t count)
{
  constexpr std::int16_t unit = VertexChanges::ActiveCellUnit - 4;
  for (std::ptrdiff_t i = 0; i < count; ++i)
  {
    const std::int16_t a = Least(low[i], low[i + 1]);
    const std::int16_t b = Least(high[i], high[i + 1]);
    lowEdgeX[i] = Narrow(lowEdgeX[i] + If(a <= b, facesXZ[i]));
    highEdgeX[i] = If(a > b, facesXZ[i]);
    const std::int16_t aY = Least(low[i], low[i + row]);
    const std::int16_t bY = Least(high[i], high[i + row]);
    lowEdgeY[i] = Narrow(lowEdgeY[i] + If(aY <= bY, facesYZ[i]));
    highEdgeY[i] = If(aY > bY, facesYZ[i]);
    const std::int16_t aFace = Least(a, Least(low[i + row], low[i + row + 1]));
    const std::int16_t bFace = Least(b, Least(high[i + row], high[i + row + 1]));
    const auto face = static_cast<std::int16_t>(cells[i] & 2);
    const auto cell = static_cast<std::int16_t>(cells[i] & unit);
    lowFace[i] = Narrow(lowFace[i] + face + If(aFace <= bFace, cell));
    highFace[i] = Narrow(face + If(aFace > bFace, cell));
  }
}

/// The same for the maxima of the cells.
ISOSURFACE_CLONES void HandHighsDown(Input low, Input high, Input cells, Output lowFace,
  Output highFace, std::ptrdiff_t row, std::ptrdiff_t count)
{
  for (std::ptrdiff_t i = 0; i < count; ++i)
  {
    const std::int16_t a =
      Greatest(Greatest(low[i], low[i + 1]), Greatest(low[i + row], low[i + row + 1]));
    const std::int16_t b =
      Greatest(Greatest(high[i], high[i + 1]), Greatest(high[i + row], high[i + row + 1]));
    const auto cell = static_cast<std::int16_t>(cells[i] & -VertexChanges::ActiveCellUnit);
    lowFace[i] = Narrow(lowFace[i] + If(a >= b, cell));
    highFace[i] = If(a < b, cell);
  }
}

/// Which diagonal's ends (1 to 4, by the end in the lower slice; 0: none) are below all other
/// corners of a cell; false if that is so nowhere.
ISOSURFACE_CLONES bool FindDiagonals(
  Input low, Input high, Input cells, Output found, std::ptrdiff_t row, std::ptrdiff_t count)
{
  std::int16_t any = 0;
  for (std::ptrdiff_t i = 0; i < count; ++i)
  {
    const std::int16_t a[4] = { low[i], low[i + 1], low[i + row], low[i + row + 1] };
    const std::int16_t b[4] = { high[i + row + 1], high[i + row], high[i + 1], high[i] };
    const std::int16_t least01 = Least(Least(a[0], b[0]), Least(a[1], b[1]));
    const std::int16_t least23 = Least(Least(a[2], b[2]), Least(a[3], b[3]));
    // At most one of them holds.
    const std::int16_t which0 = If(Greatest(a[0], b[0]) < Least(Least(a[1], b[1]), least23), 1);
    const std::int16_t which1 = If(Greatest(a[1], b[1]) < Least(Least(a[0], b[0]), least23), 2);
    const std::int16_t which2 = If(Greatest(a[2], b[2]) < Least(Least(a[3], b[3]), least01), 3);
    const std::int16_t which3 = If(Greatest(a[3], b[3]) < Least(Least(a[2], b[2]), least01), 4);
    found[i] = static_cast<std::int16_t>(cells[i] & (which0 | which1 | which2 | which3));
    any = static_cast<std::int16_t>(any | found[i]);
  }
  return any != 0;
}

/// Hands the weights of a slice's faces to its edges along x. A face has the edge that starts where
/// it does, and the one a row behind.
ISOSURFACE_CLONES void HandFacesDown(Input values, Input lowFace, Input lowEdge, Input highFace,
  Output toLow, Output toHigh, std::ptrdiff_t row, std::ptrdiff_t count)
{
  for (std::ptrdiff_t i = 0; i < count; ++i)
  {
    const std::int16_t low = Least(values[i], values[i + 1]);
    const std::int16_t lowBefore = Least(values[i - row], values[i - row + 1]);
    const std::int16_t lowBehind = Least(values[i + row], values[i + row + 1]);
    toLow[i] =
      Narrow(lowEdge[i] + If(low <= lowBehind, lowFace[i]) + If(lowBefore > low, lowFace[i - row]));
    const std::int16_t high = Greatest(values[i], values[i + 1]);
    const std::int16_t highBefore = Greatest(values[i - row], values[i - row + 1]);
    const std::int16_t highBehind = Greatest(values[i + row], values[i + row + 1]);
    toHigh[i] =
      Narrow(If(high >= highBehind, highFace[i]) + If(highBefore < high, highFace[i - row]));
  }
}

/// Hands the weights of a slice's edges to its vertices.
ISOSURFACE_CLONES void HandEdgesDown(Input values, Input corners, std::int16_t sliceCount,
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
  this->Diagonals.clear();
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
  HandLowsDown(low, high, this->Cells.data(), this->FacesXZ.data(), this->FacesYZ.data(),
    begin(this->Lower.LowFace), begin(this->Lower.LowEdgeX), begin(this->Lower.LowEdgeY),
    begin(this->Upper.LowFace), begin(this->Upper.LowEdgeX), begin(this->Upper.LowEdgeY), row,
    count);
  HandHighsDown(low, high, this->Cells.data(), begin(this->Lower.HighFace),
    begin(this->Upper.HighFace), row, count);
  if (FindDiagonals(low, high, this->Cells.data(), this->Found.data(), row, count))
  {
    this->AddDiagonals(low, high);
  }
}

void VertexChanges::AddDiagonals(const std::int16_t* low, const std::int16_t* high)
{
  const std::size_t row = this->Columns;
  const auto end = this->Found.begin() + static_cast<std::ptrdiff_t>(this->SliceSize);
  const auto isFound = [](std::int16_t diagonal) { return diagonal != 0; };
  for (auto at = std::find_if(this->Found.begin(), end, isFound); at != end;
       at = std::find_if(at + 1, end, isFound))
  {
    const auto i = static_cast<std::size_t>(at - this->Found.begin());
    std::int16_t a[4] = { low[i], low[i + 1], low[i + row], low[i + row + 1] };
    std::int16_t b[4] = { high[i + row + 1], high[i + row], high[i + 1], high[i] };
    const auto which = static_cast<std::size_t>(this->Found[i] - 1);
    const std::int16_t second = Greatest(a[which], b[which]);
    a[which] = b[which] = std::numeric_limits<std::int16_t>::max();
    const std::int16_t third = Least(
      Least(Least(a[0], a[1]), Least(a[2], a[3])), Least(Least(b[0], b[1]), Least(b[2], b[3])));
    this->Diagonals.push_back({ second, third });
  }
}

void VertexChanges::FinishSlice(std::size_t slice)
{
  const std::int16_t* values = this->GetValues() + slice * this->SliceSize;
  const auto row = static_cast<std::ptrdiff_t>(this->Columns);
  const auto count = static_cast<std::ptrdiff_t>(this->SliceSize);
  const std::int16_t slices = slice == 0 || slice + 1 == this->Slices ? 1 : 2;
  const auto begin = [&](std::vector<std::int16_t>& weights)
  { return weights.data() + this->Margin; };
  HandFacesDown(values, begin(this->Lower.LowFace), begin(this->Lower.LowEdgeX),
    begin(this->Lower.HighFace), begin(this->LowEdge), begin(this->HighEdge), row, count);
  HandEdgesDown(values, this->Corners.data(), slices, begin(this->LowEdge), begin(this->HighEdge),
    begin(this->Lower.LowEdgeY), this->Changes.data() + slice * this->SliceSize, row, count);
}

} // namespace isosurface
