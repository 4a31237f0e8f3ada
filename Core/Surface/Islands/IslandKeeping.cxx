// SPDX-License-Identifier: BSD-3-Clause
#include "Surface/Islands/IslandKeeping.h"

#include "Surface/Islands/SurfaceRanges.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace isosurface
{
namespace
{

/// The points, cells and corners that are kept of a surface with indices of a type.
template <typename Index>
class KeptSurface
{
public:
  KeptSurface(Surface& surface, const SurfaceCells<Index>& cells, int threads)
    : Extracted(surface)
    , Cells(cells)
    , Threads(threads)
    , Numbers(surface.NumberOfPoints)
    , PointsBefore(CountRanges(surface.NumberOfPoints) + 1, 0)
    , CellsBefore(CountRanges(surface.NumberOfCells) + 1, 0)
    , CornersBefore(CellsBefore)
  {
  }

  /// isKept(point): also of the cells whose first point it is.
  template <typename Predicate>
  void Make(const Predicate& isKept, Buffer<Index>& connectivity, Buffer<Index>& offsets)
  {
    this->NumberPoints(isKept);
    this->CountCells();
    this->KeepParts();
    this->KeepCells(connectivity, offsets);
    this->KeepTuples(3, this->Extracted.Points);
    this->KeepTuples(3, this->Extracted.DoublePoints);
    this->KeepTuples(3, this->Extracted.Normals);
    this->KeepTuples(1, this->Extracted.GlobalIds);
    for (SurfaceAttribute& attribute : this->Extracted.Attributes)
    {
      this->KeepTuples(GetTupleSize(attribute.Layout), attribute.Bytes);
    }
    this->Extracted.NumberOfPoints = this->PointsBefore.back();
    this->Extracted.NumberOfCells = this->CellsBefore.back();
    this->Extracted.NumberOfTriangles =
      this->CornersBefore.back() - 2 * this->Extracted.NumberOfCells;
  }

private:
  bool HasPoint(std::size_t point) const { return this->Numbers[point] >= 0; }
  bool HasCell(std::size_t cell) const { return this->HasPoint(this->Cells.GetFirstPoint(cell)); }

  template <typename Predicate>
  void NumberPoints(const Predicate& isKept)
  {
    const std::size_t points = this->Extracted.NumberOfPoints;
    ForRanges(points, this->Threads,
      [&](std::size_t begin, std::size_t end, std::size_t range)
      {
        std::size_t count = 0;
        for (std::size_t point = begin; point < end; ++point)
        {
          this->Numbers[point] = isKept(point) ? 0 : -1;
          count += this->HasPoint(point) ? 1 : 0;
        }
        this->PointsBefore[range] = count;
      });
    SumRanges(this->PointsBefore);
    ForRanges(points, this->Threads,
      [&](std::size_t begin, std::size_t end, std::size_t range)
      {
        auto number = static_cast<Index>(this->PointsBefore[range]);
        for (std::size_t point = begin; point < end; ++point)
        {
          this->Numbers[point] = this->HasPoint(point) ? number++ : -1;
        }
      });
  }

  void CountCells()
  {
    ForRanges(this->Extracted.NumberOfCells, this->Threads,
      [&](std::size_t begin, std::size_t end, std::size_t range)
      {
        std::size_t cells = 0;
        std::size_t corners = 0;
        for (std::size_t cell = begin; cell < end; ++cell)
        {
          if (this->HasCell(cell))
          {
            ++cells;
            corners += this->Cells.End(cell) - this->Cells.Begin(cell);
          }
        }
        this->CellsBefore[range] = cells;
        this->CornersBefore[range] = corners;
      });
    SumRanges(this->CellsBefore);
    SumRanges(this->CornersBefore);
  }

  std::size_t CountPointsBefore(std::size_t point) const
  {
    const std::size_t range = point / SurfaceRangeSize;
    std::size_t count = this->PointsBefore[range];
    for (std::size_t n = range * SurfaceRangeSize; n < point; ++n)
    {
      count += this->HasPoint(n) ? 1 : 0;
    }
    return count;
  }

  std::size_t CountCellsBefore(std::size_t cell) const
  {
    const std::size_t range = cell / SurfaceRangeSize;
    std::size_t count = this->CellsBefore[range];
    for (std::size_t n = range * SurfaceRangeSize; n < cell; ++n)
    {
      count += this->HasCell(n) ? 1 : 0;
    }
    return count;
  }

  void KeepParts()
  {
    for (SurfacePart& part : this->Extracted.Parts)
    {
      const std::size_t endPoint = this->CountPointsBefore(part.FirstPoint + part.NumberOfPoints);
      const std::size_t endCell = this->CountCellsBefore(part.FirstCell + part.NumberOfCells);
      part.FirstPoint = this->CountPointsBefore(part.FirstPoint);
      part.FirstCell = this->CountCellsBefore(part.FirstCell);
      part.NumberOfPoints = endPoint - part.FirstPoint;
      part.NumberOfCells = endCell - part.FirstCell;
    }
  }

  void KeepCells(Buffer<Index>& connectivity, Buffer<Index>& offsets)
  {
    Buffer<Index> keptCorners(this->CornersBefore.back());
    Buffer<Index> keptOffsets(offsets.IsEmpty() ? 0 : this->CellsBefore.back() + 1);
    ForRanges(this->Extracted.NumberOfCells, this->Threads,
      [&](std::size_t begin, std::size_t end, std::size_t range)
      {
        std::size_t corner = this->CornersBefore[range];
        std::size_t number = this->CellsBefore[range];
        for (std::size_t cell = begin; cell < end; ++cell)
        {
          if (!this->HasCell(cell))
          {
            continue;
          }
          if (!keptOffsets.IsEmpty())
          {
            keptOffsets[number++] = static_cast<Index>(corner);
          }
          const std::size_t last = this->Cells.End(cell);
          for (std::size_t from = this->Cells.Begin(cell); from < last; ++from)
          {
            keptCorners[corner++] = this->Numbers[this->Cells[from]];
          }
        }
      });
    if (!keptOffsets.IsEmpty())
    {
      keptOffsets[this->CellsBefore.back()] = static_cast<Index>(this->CornersBefore.back());
    }
    connectivity = std::move(keptCorners);
    offsets = std::move(keptOffsets);
  }

  /// Keeps what the points have: so many values each.
  template <typename T>
  void KeepTuples(std::size_t width, Buffer<T>& values)
  {
    if (values.IsEmpty())
    {
      return;
    }
    Buffer<T> kept(this->PointsBefore.back() * width);
    ForRanges(this->Extracted.NumberOfPoints, this->Threads,
      [&](std::size_t begin, std::size_t end, std::size_t range)
      {
        T* to = kept.GetData() + width * this->PointsBefore[range];
        for (std::size_t point = begin; point < end; ++point)
        {
          if (this->HasPoint(point))
          {
            to = std::copy_n(values.GetData() + width * point, width, to);
          }
        }
      });
    values = std::move(kept);
  }

  Surface& Extracted;
  const SurfaceCells<Index>& Cells; ///< of the old arrays
  const int Threads;
  Buffer<Index> Numbers;                 ///< of the points; -1 for those that are dropped
  std::vector<std::size_t> PointsBefore; ///< kept, before each range, and all
  std::vector<std::size_t> CellsBefore;
  std::vector<std::size_t> CornersBefore;
};

template <typename Predicate>
void KeepPoints(const Predicate& isKept, int threads, Surface& surface)
{
  const auto keep = [&](const auto& cells, auto& connectivity, auto& offsets)
  { KeptSurface(surface, cells, threads).Make(isKept, connectivity, offsets); };
  IndexArray& corners = surface.Connectivity;
  if (corners.Is64Bit)
  {
    keep(SurfaceCells<std::int64_t>(surface), corners.Values64, surface.Offsets.Values64);
  }
  else
  {
    keep(SurfaceCells<std::int32_t>(surface), corners.Values32, surface.Offsets.Values32);
  }
}

// Marks the points of triangles that are finite. Turns the others so that a point that is not comes
// first, by which KeptSurface decides. Returns how many these are.
template <typename Index>
std::size_t MarkFiniteTriangles(
  const Surface& surface, Buffer<Index>& corners, std::vector<std::uint8_t>& areKept)
{
  std::size_t dropped = 0;
  for (std::size_t triangle = 0; triangle < corners.GetSize() / 3; ++triangle)
  {
    Index* own = corners.GetData() + 3 * triangle;
    Index* wrong = std::find_if(own, own + 3,
      [&surface](Index corner)
      {
        const Vector3 point = surface.GetPoint(static_cast<std::size_t>(corner));
        return !std::isfinite(point[0]) || !std::isfinite(point[1]) || !std::isfinite(point[2]);
      });
    if (wrong != own + 3)
    {
      std::rotate(own, wrong, own + 3);
      ++dropped;
      continue;
    }
    for (std::size_t corner = 0; corner < 3; ++corner)
    {
      areKept[static_cast<std::size_t>(own[corner])] = 1;
    }
  }
  return dropped;
}

} // namespace

void KeepIslands(const IslandLabels& labels, const std::vector<std::uint8_t>& areKept, int threads,
  Surface& surface)
{
  KeepPoints([&](std::size_t point) { return areKept[labels[point]] != 0; }, threads, surface);
}

std::size_t KeepFiniteTriangles(int threads, Surface& surface)
{
  std::vector<std::uint8_t> areKept(surface.NumberOfPoints, 0);
  IndexArray& corners = surface.Connectivity;
  const std::size_t dropped = corners.Is64Bit
    ? MarkFiniteTriangles(surface, corners.Values64, areKept)
    : MarkFiniteTriangles(surface, corners.Values32, areKept);
  if (std::find(areKept.begin(), areKept.end(), 0) != areKept.end())
  {
    KeepPoints([&](std::size_t point) { return areKept[point] != 0; }, threads, surface);
  }
  return dropped;
}

} // namespace isosurface
