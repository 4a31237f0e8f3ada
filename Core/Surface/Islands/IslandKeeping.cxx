// SPDX-License-Identifier: BSD-3-Clause
#include "Surface/Islands/IslandKeeping.h"

#include "Surface/Islands/SurfaceRanges.h"

#include <bitset>
#include <cstring>
#include <utility>

namespace isosurface
{
namespace
{

constexpr std::size_t WordBits = 64;

std::size_t CountBits(std::uint64_t word)
{
  return std::bitset<WordBits>(word).count();
}

/// Some of the items 0, 1, ... and their new numbers.
class Selection
{
public:
  template <typename Predicate>
  Selection(std::size_t items, int threads, const Predicate& isSelected)
    : Words(items / WordBits + 1, 0)
    , Firsts(items / WordBits + 2, 0)
  {
    ForRanges(items, threads,
      [&](std::size_t begin, std::size_t end, std::size_t)
      {
        for (std::size_t item = begin; item < end; ++item)
        {
          this->Words[item / WordBits] |= std::uint64_t{ isSelected(item) } << (item % WordBits);
        }
      });
    for (std::size_t word = 0; word < this->Words.size(); ++word)
    {
      this->Firsts[word + 1] = this->Firsts[word] + CountBits(this->Words[word]);
    }
  }

  std::size_t GetCount() const { return this->Firsts.back(); }
  bool Has(std::size_t item) const
  {
    return (this->Words[item / WordBits] >> (item % WordBits) & 1) != 0;
  }
  /// How many of the items before this one are selected: the new number of a selected one.
  std::size_t CountBefore(std::size_t item) const
  {
    const std::uint64_t before = (std::uint64_t{ 1 } << (item % WordBits)) - 1;
    return this->Firsts[item / WordBits] + CountBits(this->Words[item / WordBits] & before);
  }

private:
  std::vector<std::uint64_t> Words;
  std::vector<std::size_t> Firsts; ///< selected items before each word
};

/// Keeps the tuples of selected points, of so many values each.
template <typename T>
void KeepTuples(
  const Selection& points, std::size_t items, std::size_t width, int threads, Buffer<T>& values)
{
  if (values.IsEmpty())
  {
    return;
  }
  Buffer<T> kept(points.GetCount() * width);
  ForRanges(items, threads,
    [&](std::size_t begin, std::size_t end, std::size_t)
    {
      T* to = kept.GetData() + width * points.CountBefore(begin);
      for (std::size_t item = begin; item < end; ++item)
      {
        if (points.Has(item))
        {
          std::memcpy(to, values.GetData() + width * item, width * sizeof(T));
          to += width;
        }
      }
    });
  values = std::move(kept);
}

/// Where the corners of the selected cells of each range begin, and where the last one ends.
std::vector<std::size_t> FindFirstCorners(
  const Surface& surface, const Selection& cells, int threads)
{
  std::vector<std::size_t> firsts(CountRanges(surface.NumberOfCells) + 1, 0);
  ForRanges(surface.NumberOfCells, threads,
    [&](std::size_t begin, std::size_t end, std::size_t range)
    {
      std::size_t corners = 0;
      for (std::size_t cell = begin; cell < end; ++cell)
      {
        const CellCorners old(surface, cell);
        corners += cells.Has(cell) ? old.End - old.Begin : 0;
      }
      firsts[range + 1] = corners;
    });
  for (std::size_t range = 1; range < firsts.size(); ++range)
  {
    firsts[range] += firsts[range - 1];
  }
  return firsts;
}

template <typename Index>
void KeepCells(const Selection& points, const Selection& cells, int threads, Surface& surface,
  Buffer<Index>& connectivity, Buffer<Index>& offsets)
{
  const std::vector<std::size_t> firsts = FindFirstCorners(surface, cells, threads);
  Buffer<Index> keptCorners(firsts.back());
  Buffer<Index> keptOffsets(offsets.IsEmpty() ? 0 : cells.GetCount() + 1);
  ForRanges(surface.NumberOfCells, threads,
    [&](std::size_t begin, std::size_t end, std::size_t range)
    {
      std::size_t corner = firsts[range];
      std::size_t number = cells.CountBefore(begin);
      for (std::size_t cell = begin; cell < end; ++cell)
      {
        if (!cells.Has(cell))
        {
          continue;
        }
        if (!keptOffsets.IsEmpty())
        {
          keptOffsets[number++] = static_cast<Index>(corner);
        }
        const CellCorners old(surface, cell);
        for (std::size_t from = old.Begin; from < old.End; ++from)
        {
          keptCorners[corner++] =
            static_cast<Index>(points.CountBefore(static_cast<std::size_t>(connectivity[from])));
        }
      }
    });
  if (!keptOffsets.IsEmpty())
  {
    keptOffsets[cells.GetCount()] = static_cast<Index>(firsts.back());
  }
  connectivity = std::move(keptCorners);
  offsets = std::move(keptOffsets);
  surface.NumberOfTriangles = firsts.back() - 2 * cells.GetCount();
}

void KeepParts(const Selection& points, const Selection& cells, Surface& surface)
{
  for (SurfacePart& part : surface.Parts)
  {
    const std::size_t endPoint = points.CountBefore(part.FirstPoint + part.NumberOfPoints);
    const std::size_t endCell = cells.CountBefore(part.FirstCell + part.NumberOfCells);
    part.FirstPoint = points.CountBefore(part.FirstPoint);
    part.FirstCell = cells.CountBefore(part.FirstCell);
    part.NumberOfPoints = endPoint - part.FirstPoint;
    part.NumberOfCells = endCell - part.FirstCell;
  }
}

} // namespace

void KeepIslands(const IslandLabels& labels, const std::vector<std::uint8_t>& areKept, int threads,
  Surface& surface)
{
  const Selection points(surface.NumberOfPoints, threads,
    [&](std::size_t point) { return areKept[labels[point]] != 0; });
  const Selection cells(surface.NumberOfCells, threads,
    [&](std::size_t cell)
    {
      const auto corner = surface.Connectivity[CellCorners(surface, cell).Begin];
      return points.Has(static_cast<std::size_t>(corner));
    });
  if (surface.Connectivity.Is64Bit)
  {
    KeepCells(
      points, cells, threads, surface, surface.Connectivity.Values64, surface.Offsets.Values64);
  }
  else
  {
    KeepCells(
      points, cells, threads, surface, surface.Connectivity.Values32, surface.Offsets.Values32);
  }
  const std::size_t items = surface.NumberOfPoints;
  KeepTuples(points, items, 3, threads, surface.Points);
  KeepTuples(points, items, 3, threads, surface.Normals);
  KeepTuples(points, items, 1, threads, surface.GlobalIds);
  for (SurfaceAttribute& attribute : surface.Attributes)
  {
    KeepTuples(
      points, items, items == 0 ? 0 : attribute.Bytes.GetSize() / items, threads, attribute.Bytes);
  }
  KeepParts(points, cells, surface);
  surface.NumberOfPoints = points.GetCount();
  surface.NumberOfCells = cells.GetCount();
}

} // namespace isosurface
