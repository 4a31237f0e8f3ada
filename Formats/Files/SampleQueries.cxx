// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/Files/SampleQueries.h"

#include "Ground/Volume/VertexPlaces.h"
#include "Storage/Sampling/LevelSamples.h"
#include "Storage/Store/BlockedVolume.h"

#include <algorithm>
#include <limits>

namespace isosurface
{
namespace
{

Result<std::shared_ptr<const LevelSamples>> OpenLevel(
  VolumeFile& file, const SampledArray& of, int level, const Progress& progress)
{
  std::size_t step = 0;
  ISOSURFACE_ASSIGN_OR_RETURN(auto volume, file.GetBlocks(of.TimeStep, progress, step));
  return LevelSamples::Open(std::move(volume), step, level);
}

/// The points in their order, as vertex coordinates of a grid.
PointPortions PortionPoints(const double* points, std::size_t count, const VertexPlaces& places)
{
  constexpr std::size_t portionSize = 4096;
  PointPortions portions;
  portions.Count = (count + portionSize - 1) / portionSize;
  portions.Give = [=, &places](std::size_t portion, std::vector<SamplePoint>& given)
  {
    given.clear();
    const std::size_t first = portion * portionSize;
    const std::size_t end = std::min(count, first + portionSize);
    for (std::size_t point = first; point < end; ++point)
    {
      const double* const place = points + 3 * point;
      given.push_back(
        { places.FindVertex({ place[0], place[1], place[2] }), static_cast<std::int64_t>(point) });
    }
  };
  return portions;
}

/// Calls sample(variable, first value) for each component of an array.
template <typename Sample>
Status SampleComponents(
  const VolumeFile& file, const SampledArray& of, void* values, const Sample& sample)
{
  const ArrayDescription& array = file.GetArrays()[of.Array];
  const std::size_t first = ArrayVariables(file.GetArrays()).GetFirst(of.Array);
  for (int component = 0; component < array.Components; ++component)
  {
    const auto number = static_cast<std::size_t>(component);
    ISOSURFACE_RETURN_IF_ERROR(sample(first + number,
      static_cast<char*>(values) + number * GetValueSize(array.Type), array.Components));
  }
  return Status::Ok();
}

/// NaN, or 0 of integers.
void FillWithNothing(ValueType type, std::vector<std::uint8_t>& values)
{
  DispatchValueType(type,
    [&](auto zero)
    {
      using T = decltype(zero);
      const T nothing = std::numeric_limits<T>::quiet_NaN(); // 0 where there is none
      T* const begin = reinterpret_cast<T*>(values.data());
      std::fill(begin, begin + values.size() / sizeof(T), nothing);
    });
}

} // namespace

Status ProbePoints(VolumeFile& file, const SampledArray& of, Interpolation interpolation,
  const double* points, std::size_t count, void* values, std::uint8_t* inside,
  const Progress& progress)
{
  ISOSURFACE_ASSIGN_OR_RETURN(const auto level, OpenLevel(file, of, of.Level, progress));
  const LevelDescription description = file.Describe(of.Level);
  const VertexPlaces places(description.Grid, description.Lines ? &*description.Lines : nullptr);
  const PointPortions portions = PortionPoints(points, count, places);
  QueryStatistics unused;
  return SampleComponents(file, of, values,
    [&](std::size_t variable, void* first, int stride)
    {
      return SamplePoints(*level, variable, interpolation, portions, of.Threads, first, stride,
        inside, unused, progress);
    });
}

Result<std::optional<PlaneSamples>> CutPlane(VolumeFile& file, const SampledArray& of,
  const Plane& plane, double maximumPoints, const Progress& progress)
{
  std::size_t step = 0;
  ISOSURFACE_ASSIGN_OR_RETURN(const auto volume, file.GetBlocks(of.TimeStep, progress, step));
  const auto found = FindLatticeWithin(*volume, plane, maximumPoints, of.Level);
  if (!found)
  {
    return std::optional<PlaneSamples>();
  }
  ISOSURFACE_ASSIGN_OR_RETURN(const auto level, OpenLevel(file, of, found->Level, progress));
  const ArrayDescription& array = file.GetArrays()[of.Array];
  PlaneSamples cut;
  cut.Image = found->Lattice.GetImage();
  cut.Level = found->Level;
  const auto count = static_cast<std::size_t>(cut.Image.GetNumberOfVertices());
  cut.Inside.assign(count, 1);
  cut.Values.resize(count * static_cast<std::size_t>(array.Components) * GetValueSize(array.Type));
  FillWithNothing(array.Type, cut.Values);
  const VertexBox all{ { 0, 0, 0 }, cut.Image.GetDimensions() };
  QueryStatistics unused;
  ISOSURFACE_RETURN_IF_ERROR(SampleComponents(file, of, cut.Values.data(),
    [&](std::size_t variable, void* first, int stride)
    {
      return found->Lattice.Sample(*level, variable, Interpolation::Linear, all, of.Threads, first,
        stride, cut.Inside.data(), unused, progress);
    }));
  return std::optional<PlaneSamples>(std::move(cut));
}

} // namespace isosurface
