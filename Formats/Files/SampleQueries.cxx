// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/Files/SampleQueries.h"

#include "Ground/Volume/VertexPlaces.h"
#include "Storage/Store/BlockedVolume.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

namespace isosurface
{
namespace
{

using Point = std::array<double, 3>;

/// The vertices around points.
VertexBox FindVerticesOf(const LevelDescription& level, const double* points, std::size_t count)
{
  constexpr double most = std::numeric_limits<double>::max();
  Point low{ most, most, most };
  Point high{ -most, -most, -most };
  for (std::size_t number = 0; number < 3 * count; ++number)
  {
    if (std::isfinite(points[number]))
    {
      low[number % 3] = std::min(low[number % 3], points[number]);
      high[number % 3] = std::max(high[number % 3], points[number]);
    }
  }
  const bool isAny = low[0] <= high[0] && low[1] <= high[1] && low[2] <= high[2];
  return isAny ? level.FindVerticesAround(low, high) : VertexBox{ {}, { 1, 1, 1 } };
}

/// The vertices around a plane that is along axes of the grid; all, if it is not.
VertexBox FindVerticesOf(const LevelDescription& level, const Plane& plane, double maximumPoints)
{
  const auto lattice = PlaneLattice::Make(level.Grid, level.Lines ? &*level.Lines : nullptr, plane);
  if (!lattice || !lattice->IsAligned() || lattice->CountPoints() > maximumPoints)
  {
    return { {}, level.Grid.GetDimensions() };
  }
  const GridGeometry& image = lattice->GetImage();
  const VertexPlaces places(image);
  const Index3 size = image.GetDimensions();
  return level.FindVerticesAround(places.FindPoint({ 0, 0, 0 }),
    places.FindPoint({ static_cast<double>(size[0] - 1), static_cast<double>(size[1] - 1),
      static_cast<double>(size[2] - 1) }));
}

} // namespace

Status ProbePoints(VolumeFile& file, const SampledArray& of, Interpolation interpolation,
  const double* points, std::size_t count, void* values, std::uint8_t* inside,
  const Progress& progress)
{
  std::size_t step = 0;
  Index3 corner{};
  const VertexBox box = FindVerticesOf(file.Describe(0), points, count);
  ISOSURFACE_ASSIGN_OR_RETURN(
    auto volume, file.GetBlocksOf(of.TimeStep, box, progress, step, corner));
  ISOSURFACE_ASSIGN_OR_RETURN(const auto level, LevelSamples::Open(volume, step, of.Level));
  const auto find = [points](std::int64_t point) {
    return Point{ points[3 * point], points[3 * point + 1], points[3 * point + 2] };
  };
  return SampleArrays(*level, { of.Array }, interpolation, static_cast<std::int64_t>(count), find,
    of.Threads, { values }, inside, progress);
}

Result<std::optional<SampledBox>> CutPlane(VolumeFile& file, const SampledArray& of,
  const Plane& plane, double maximumPoints, const Progress& progress)
{
  std::size_t step = 0;
  Index3 corner{};
  const VertexBox box = FindVerticesOf(file.Describe(0), plane, maximumPoints);
  ISOSURFACE_ASSIGN_OR_RETURN(
    auto volume, file.GetBlocksOf(of.TimeStep, box, progress, step, corner));
  auto plan = PlanSlice(*volume, plane, Interpolation::Linear, maximumPoints, of.Level);
  if (!plan)
  {
    return std::optional<SampledBox>();
  }
  plan->HasOutside = true; // also of an aligned plane, all of whose points are inside
  SampledBox cut;
  cut.Box.High = plan->Grid.GetDimensions();
  cut.Plan = std::move(*plan);
  cut.Volume = std::move(volume);
  cut.TimeStep = step;
  cut.Arrays = { of.Array };
  cut.Threads = of.Threads;
  LevelsOfVolume levels;
  ISOSURFACE_RETURN_IF_ERROR(cut.Fill(levels, progress));
  cut.Volume.reset(); // its samples need not stay
  return std::optional<SampledBox>(std::move(cut));
}

} // namespace isosurface
