// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/Files/SampleQueries.h"

#include "Storage/Store/BlockedVolume.h"

#include <array>
#include <utility>

namespace isosurface
{

Status ProbePoints(VolumeFile& file, const SampledArray& of, Interpolation interpolation,
  const double* points, std::size_t count, void* values, std::uint8_t* inside,
  const Progress& progress)
{
  std::size_t step = 0;
  ISOSURFACE_ASSIGN_OR_RETURN(auto volume, file.GetBlocks(of.TimeStep, progress, step));
  ISOSURFACE_ASSIGN_OR_RETURN(const auto level, LevelSamples::Open(volume, step, of.Level));
  const LevelDescription description = file.Describe(of.Level);
  const VertexPlaces places(description.Grid, description.Lines ? &*description.Lines : nullptr);
  const PointPortions portions = MakePointPortions(static_cast<std::int64_t>(count), places,
    [points](std::int64_t point)
    {
      return std::array<double, 3>{ points[3 * point], points[3 * point + 1],
        points[3 * point + 2] };
    });
  QueryStatistics unused;
  return SampleComponents(volume->GetVariables(), { of.Array }, { values }, progress,
    [&](std::size_t variable, void* first, int stride, const Progress& advance)
    {
      return SamplePoints(*level, variable, interpolation, portions, of.Threads, first, stride,
        inside, unused, advance);
    });
}

Result<std::optional<SampledBox>> CutPlane(VolumeFile& file, const SampledArray& of,
  const Plane& plane, double maximumPoints, const Progress& progress)
{
  std::size_t step = 0;
  ISOSURFACE_ASSIGN_OR_RETURN(auto volume, file.GetBlocks(of.TimeStep, progress, step));
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
