// SPDX-License-Identifier: BSD-3-Clause
#include "Storage/Sampling/ImagePlan.h"

#include "Storage/Store/BlockedVolume.h"

#include <algorithm>
#include <limits>
#include <utility>

namespace isosurface
{
namespace
{

/// The vertices of a level around a box of vertices of full resolution.
VertexBox CoarsenAround(const VertexBox& finest, int level, const Index3& dimensions)
{
  VertexBox box;
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    const std::int64_t last = dimensions[axis] - 1;
    const std::int64_t step = std::int64_t{ 1 } << level;
    box.Low[axis] = std::min(last, finest.Low[axis] / step);
    box.High[axis] = std::min(last, (finest.High[axis] + step - 2) / step) + 1;
  }
  return box;
}

void FillTuples(ValueType type, const KeyRange* range, void* first, std::int64_t count, int stride)
{
  DispatchValueType(type,
    [&](auto zero)
    {
      using T = decltype(zero);
      const T nothing = std::numeric_limits<T>::quiet_NaN(); // 0 where there is none
      const T value = !range ? nothing
        : range->IsEmpty()   ? zero
                             : MakeValueOfKey<T>(range->Minimum);
      auto* const values = static_cast<T*>(first);
      for (std::int64_t point = 0; point < count; ++point)
      {
        values[point * stride] = value;
      }
    });
}

} // namespace

std::optional<ImagePlan> PlanSlice(const BlockedVolume& volume, const Plane& plane,
  Interpolation interpolation, double maximumPoints, int firstLevel)
{
  auto found = FindLatticeWithin(volume, plane, maximumPoints, firstLevel);
  if (!found)
  {
    return std::nullopt;
  }
  const auto lattice = std::make_shared<const PlaneLattice>(std::move(found->Lattice));
  ImagePlan plan;
  plan.Level = found->Level;
  plan.Grid = lattice->GetImage();
  plan.HasOutside = !lattice->IsAligned();
  const Index3 size = plan.Grid.GetDimensions();
  plan.Size = std::to_string(size[0]) + " x " + std::to_string(size[1]) + " points";
  plan.Fill = [lattice, interpolation](const LevelSamples& samples, std::size_t variable,
                const VertexBox& part, int threads, void* values, std::ptrdiff_t stride,
                std::uint8_t* isInside, QueryStatistics& statistics, const Progress& progress)
  {
    return lattice->Sample(samples, variable, interpolation, part, threads, values, stride,
      isInside, statistics, progress);
  };
  return plan;
}

std::optional<ImagePlan> PlanCoarseSlice(const BlockedVolume& volume, const Plane& plane,
  Interpolation interpolation, double maximumPoints)
{
  constexpr double coarsePoints = 3e5;
  constexpr int coarseLevel =
    2; // level 1 is stored in the blocks of full resolution, and would read as much
  auto plan = PlanSlice(volume, plane, interpolation, maximumPoints);
  if (plan && plan->CountPoints() > coarsePoints)
  {
    auto coarse =
      PlanSlice(volume, plane, interpolation, coarsePoints, std::max(plan->Level, coarseLevel));
    return coarse ? coarse : plan;
  }
  return plan;
}

std::optional<ImagePlan> PlanBox(
  const BlockedVolume& volume, const VertexBox& finest, double maximumPoints)
{
  for (int level = 0; level < volume.GetNumberOfLevels(); ++level)
  {
    ImagePlan plan;
    plan.Level = level;
    plan.Grid = volume.GetHeader().Grid.Coarsen(level);
    const VertexBox box = CoarsenAround(finest, level, plan.Grid.GetDimensions());
    if (static_cast<double>(box.GetNumberOfVertices()) > maximumPoints)
    {
      continue;
    }
    const Index3 size = box.GetSize();
    for (std::size_t axis = 0; axis < 3; ++axis)
    {
      plan.Grid.Extent[2 * axis] += box.Low[axis];
      plan.Grid.Extent[2 * axis + 1] = plan.Grid.Extent[2 * axis] + size[axis] - 1;
    }
    if (const GridLines* lines = volume.GetLines(level))
    {
      plan.Lines = lines->Cut(box);
    }
    plan.Fill = [low = box.Low](const LevelSamples& samples, std::size_t variable,
                  const VertexBox& part, int threads, void* values, std::ptrdiff_t stride,
                  std::uint8_t*, QueryStatistics& statistics, const Progress& progress)
    {
      return samples.Read(
        variable, part.Translate(low), { 1, 1, 1 }, threads, values, stride, statistics, progress);
    };
    return plan;
  }
  return std::nullopt;
}

Status SampledBox::Fill(LevelsOfVolume& levels, const Progress& progress)
{
  ISOSURFACE_ASSIGN_OR_RETURN(
    const auto samples, levels.Find(this->Volume, this->TimeStep, this->Plan.Level));
  this->Values.clear();
  this->IsInside.clear();
  if (this->Box.IsEmpty())
  {
    return Status::Ok();
  }
  const BlockedVolumeHeader& header = this->Volume->GetHeader();
  const ArrayVariables& variables = this->Volume->GetVariables();
  const std::int64_t points = this->Box.GetNumberOfVertices();
  this->IsInside.assign(this->Plan.HasOutside ? static_cast<std::size_t>(points) : 0, 1);
  std::vector<void*> begins;
  for (const std::size_t array : this->Arrays)
  {
    const ArrayDescription& description = header.Arrays[array];
    this->Values.emplace_back(
      static_cast<std::size_t>(points * description.Components) * GetValueSize(description.Type));
    begins.push_back(this->Values.back().GetData());
  }
  std::uint8_t* const isInside = this->IsInside.empty() ? nullptr : this->IsInside.data();
  QueryStatistics statistics;
  const auto sample = [&](std::size_t variable, void* first, int stride, const Progress& advance)
  {
    if (isInside)
    {
      const std::vector<KeyRange>& ranges = header.TimeSteps[this->TimeStep].Ranges;
      FillTuples(variables[variable].Type,
        this->Beyond == ValueBeyond::Minimum ? &ranges[variable] : nullptr, first, points, stride);
    }
    return this->Plan.Fill(
      *samples, variable, this->Box, this->Threads, first, stride, isInside, statistics, advance);
  };
  return SampleComponents(variables, this->Arrays, begins, progress, sample);
}

} // namespace isosurface
