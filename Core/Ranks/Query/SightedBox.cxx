// SPDX-License-Identifier: BSD-3-Clause
#include "Ranks/Query/SightedBox.h"

#include "Ground/Volume/VertexPlaces.h"

#include <algorithm>
#include <cmath>

namespace isosurface
{
namespace
{

using Point = std::array<double, 3>;

/// A box that has too many vertices is made smaller by this factor, at most so many times.
constexpr double Shrinking = 0.8;
constexpr int MostShrinkings = 80;
/// Parts of a cell that are rounding errors.
constexpr double FaceTolerance = 1e-6;

/// A box of the world.
struct Bounds
{
  Point Low{};
  Point High{};
};

void CutByRegion(const Region& region, Bounds& bounds)
{
  for (const HalfSpace& half : region.GetHalfSpaces())
  {
    for (std::size_t axis = 0; axis < 3; ++axis)
    {
      const double normal = half.Normal[axis];
      const bool isAlong =
        normal != 0 && half.Normal[(axis + 1) % 3] == 0 && half.Normal[(axis + 2) % 3] == 0;
      if (isAlong)
      {
        double& side = normal > 0 ? bounds.High[axis] : bounds.Low[axis];
        side =
          normal > 0 ? std::min(side, half.Offset / normal) : std::max(side, half.Offset / normal);
      }
    }
  }
}

/// The smallest box of whole chunks that has these vertices.
VertexBox TakeWholeChunks(const VertexBox& box, const Index3& chunk, const Index3& dimensions)
{
  VertexBox whole;
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    whole.Low[axis] = box.Low[axis] / chunk[axis] * chunk[axis];
    whole.High[axis] =
      std::min(dimensions[axis], ((box.High[axis] - 1) / chunk[axis] + 1) * chunk[axis]);
  }
  return whole;
}

VertexBox FindChunks(const BlockedVolumeHeader& volume, const VertexPlaces& places,
  const Sight& sight, double distance, const Region& region, std::int64_t vertices)
{
  const Index3 dimensions = volume.Grid.GetDimensions();
  Point center;
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    center[axis] = sight.Eye[axis] + distance * sight.Direction[axis];
  }
  Point vertex = places.FindVertex(center);
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    vertex[axis] = std::clamp(vertex[axis], 0.0, static_cast<double>(dimensions[axis] - 1));
  }
  center = places.FindPoint(vertex);
  double radius = sight.FindRadius(distance);
  for (int shrinking = 0; shrinking < MostShrinkings; ++shrinking, radius *= Shrinking)
  {
    Bounds bounds;
    for (std::size_t axis = 0; axis < 3; ++axis)
    {
      bounds.Low[axis] = center[axis] - radius;
      bounds.High[axis] = center[axis] + radius;
    }
    CutByRegion(region, bounds);
    const bool isInside = std::equal(bounds.Low.begin(), bounds.Low.end(), bounds.High.begin(),
      [](double low, double high) { return low <= high; });
    const VertexBox box =
      isInside ? places.FindVerticesAround(bounds.Low, bounds.High) : VertexBox();
    if (box.IsEmpty())
    {
      break;
    }
    const VertexBox whole =
      TakeWholeChunks(box, *volume.TimeSteps.back().Source->Chunk, dimensions);
    if (whole.GetNumberOfVertices() <= vertices)
    {
      return whole;
    }
  }
  return {};
}

/// Moves the faces of a box inwards to those of cells of the sample; false if there is none between them.
bool MoveFaces(const VertexPlaces& places, const VertexPlaces& ofSample, const Index3& sampleSize,
  SightedBox& box)
{
  const auto find = [](const VertexPlaces& from, const VertexPlaces& to, const Index3& vertex)
  {
    return to.FindVertex(from.FindPoint({ static_cast<double>(vertex[0]),
      static_cast<double>(vertex[1]), static_cast<double>(vertex[2]) }));
  };
  const Index3 last = { box.Exact.High[0] - 1, box.Exact.High[1] - 1, box.Exact.High[2] - 1 };
  const Point low = find(places, ofSample, box.Exact.Low);
  const Point high = find(places, ofSample, last);
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    if (low[axis] >= static_cast<double>(sampleSize[axis] - 1) || high[axis] <= 0)
    {
      return true; // the sample ends before, or begins behind
    }
  }
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    box.Sampled.Low[axis] =
      std::max<std::int64_t>(0, std::llround(std::ceil(low[axis] - FaceTolerance)));
    box.Sampled.High[axis] = std::min<std::int64_t>(
      sampleSize[axis], std::llround(std::floor(high[axis] + FaceTolerance)) + 1);
  }
  const Index3 sampleLast = { box.Sampled.High[0] - 1, box.Sampled.High[1] - 1,
    box.Sampled.High[2] - 1 };
  const Point begin = find(ofSample, places, box.Sampled.Low);
  const Point end = find(ofSample, places, sampleLast);
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    if (box.Sampled.Low[axis] >= sampleLast[axis])
    {
      return false;
    }
    if (box.Sampled.Low[axis] > 0)
    {
      box.Exact.Low[axis] =
        std::clamp<std::int64_t>(std::llround(begin[axis]), box.Exact.Low[axis], last[axis]);
    }
    if (sampleLast[axis] < sampleSize[axis] - 1)
    {
      box.Exact.High[axis] =
        1 + std::clamp<std::int64_t>(std::llround(end[axis]), box.Exact.Low[axis], last[axis]);
    }
    if (box.Exact.High[axis] - box.Exact.Low[axis] < 2)
    {
      return false;
    }
  }
  return true;
}

} // namespace

SightedBox FindSightedBox(const BlockedVolumeHeader& volume, const Sight& sight, double distance,
  const Region& region, std::int64_t vertices, const GridGeometry& sample,
  const GridLines* sampleLines)
{
  const VertexPlaces places(volume.Grid, volume.Lines ? &*volume.Lines : nullptr);
  SightedBox box;
  box.Exact = FindChunks(volume, places, sight, distance, region, vertices);
  const bool isThere = !box.Exact.IsEmpty() &&
    MoveFaces(places, VertexPlaces(sample, sampleLines), sample.GetDimensions(), box);
  return isThere ? box : SightedBox();
}

} // namespace isosurface
