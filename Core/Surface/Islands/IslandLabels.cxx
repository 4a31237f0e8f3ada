// SPDX-License-Identifier: BSD-3-Clause
#include "Surface/Islands/IslandLabels.h"

#include "Surface/Islands/SurfaceRanges.h"

#include <algorithm>

namespace isosurface
{
namespace
{

template <typename Index>
using Forest = std::vector<std::atomic<Index>>;

template <typename Index>
Index GetParent(const Forest<Index>& forest, Index point)
{
  return forest[static_cast<std::size_t>(point)].load(std::memory_order_relaxed);
}

template <typename Index>
Index FindRoot(Forest<Index>& forest, Index point)
{
  Index parent = GetParent(forest, point);
  while (parent != point)
  {
    const Index grandparent = GetParent(forest, parent);
    if (grandparent == parent)
    {
      return parent;
    }
    // Halves the path. What was an ancestor once stays one, so that it does not matter if another
    // thread has stored a higher one meanwhile. Only a root's parent needs more care.
    forest[static_cast<std::size_t>(point)].store(grandparent, std::memory_order_relaxed);
    point = grandparent;
    parent = GetParent(forest, point);
  }
  return point;
}

template <typename Index>
void Join(Forest<Index>& forest, Index a, Index b)
{
  if (GetParent(forest, a) == GetParent(forest, b))
  {
    return; // most triangles, since their neighbours have joined their points
  }
  while (true)
  {
    a = FindRoot(forest, a);
    b = FindRoot(forest, b);
    if (a == b)
    {
      return;
    }
    Index root = std::max(a, b);
    if (forest[static_cast<std::size_t>(root)].compare_exchange_strong(
          root, std::min(a, b), std::memory_order_relaxed))
    {
      return;
    }
  }
}

} // namespace

IslandLabels::IslandLabels(const Surface& surface, int threads)
  : Is64Bit(surface.Connectivity.Is64Bit)
{
  if (this->Is64Bit)
  {
    this->Label(surface, threads, this->Labels64);
  }
  else
  {
    this->Label(surface, threads, this->Labels32);
  }
}

template <typename Index>
void IslandLabels::Label(const Surface& surface, int threads, Forest<Index>& labels)
{
  const std::size_t points = surface.NumberOfPoints;
  labels = Forest<Index>(points);
  ForRanges(points, threads,
    [&](std::size_t begin, std::size_t end, std::size_t)
    {
      for (std::size_t point = begin; point < end; ++point)
      {
        labels[point].store(static_cast<Index>(point), std::memory_order_relaxed);
      }
    });
  WithCells(surface,
    [&](const auto& cells)
    {
      ForRanges(surface.NumberOfCells, threads,
        [&](std::size_t begin, std::size_t end, std::size_t)
        {
          for (std::size_t corner = cells.Begin(begin); begin < end; ++begin)
          {
            for (++corner; corner < cells.End(begin); ++corner)
            {
              Join(
                labels, static_cast<Index>(cells[corner - 1]), static_cast<Index>(cells[corner]));
            }
          }
        });
    });

  // Each point gets its root; roots are counted. Then a root gets ~number, which is negative, so
  // that other points can tell it from a root that has none yet; and in the end all get numbers.
  std::vector<std::size_t> firsts(CountRanges(points) + 1, 0);
  ForRanges(points, threads,
    [&](std::size_t begin, std::size_t end, std::size_t range)
    {
      std::size_t roots = 0;
      for (std::size_t point = begin; point < end; ++point)
      {
        const Index root = FindRoot(labels, static_cast<Index>(point));
        labels[point].store(root, std::memory_order_relaxed);
        roots += static_cast<std::size_t>(root) == point ? 1 : 0;
      }
      firsts[range] = roots;
    });
  SumRanges(firsts);
  this->NumberOfIslands = firsts.back();
  ForRanges(points, threads,
    [&](std::size_t begin, std::size_t end, std::size_t range)
    {
      std::size_t number = firsts[range];
      for (std::size_t point = begin; point < end; ++point)
      {
        if (labels[point].load(std::memory_order_relaxed) == static_cast<Index>(point))
        {
          labels[point].store(~static_cast<Index>(number++), std::memory_order_relaxed);
        }
      }
    });
  ForRanges(points, threads,
    [&](std::size_t begin, std::size_t end, std::size_t)
    {
      for (std::size_t point = begin; point < end; ++point)
      {
        const Index root = labels[point].load(std::memory_order_relaxed);
        if (root >= 0)
        {
          labels[point].store(
            labels[static_cast<std::size_t>(root)].load(std::memory_order_relaxed),
            std::memory_order_relaxed);
        }
      }
    });
  ForRanges(points, threads,
    [&](std::size_t begin, std::size_t end, std::size_t)
    {
      for (std::size_t point = begin; point < end; ++point)
      {
        labels[point].store(
          ~labels[point].load(std::memory_order_relaxed), std::memory_order_relaxed);
      }
    });
}

} // namespace isosurface
