// SPDX-License-Identifier: BSD-3-Clause
#include "Storage/Sampling/StoredBoxSource.h"

#include "Ground/Volume/SampleCopy.h"

#include <utility>

namespace isosurface
{

Result<std::unique_ptr<StoredBoxSource>> StoredBoxSource::Make(
  const std::shared_ptr<BlockedVolume>& volume, std::size_t timeStep,
  const std::vector<std::size_t>& arrays, int threads)
{
  ISOSURFACE_ASSIGN_OR_RETURN(auto samples, LevelSamples::Open(volume, timeStep, 0));
  std::unique_ptr<StoredBoxSource> source(new StoredBoxSource);
  for (const std::size_t array : arrays)
  {
    for (int component = 0; component < volume->GetVariables().GetComponents(array); ++component)
    {
      source->Variables.push_back(*volume->GetVariables().Find(array, component));
    }
  }
  source->Samples = std::move(samples);
  source->Box = source->Samples->GetBox();
  source->Threads = threads;
  return source;
}

std::uint64_t StoredBoxSource::GetReadBytes(const VertexBox& box) const
{
  std::uint64_t bytes = 0;
  for (const std::size_t variable : this->Variables)
  {
    bytes += GetValueSize(this->Samples->GetVolume().GetVariables()[variable].Type);
  }
  return bytes * static_cast<std::uint64_t>(box.GetNumberOfVertices());
}

std::uint64_t StoredBoxSource::GetHeldBytes() const
{
  return this->Samples->GetMemory();
}

Result<BoxSamples> StoredBoxSource::Read(const VertexBox& box)
{
  // Each array begins where values of any type may.
  constexpr std::size_t alignment = sizeof(double);
  auto samples = std::make_shared<std::vector<std::uint8_t>>(
    this->GetReadBytes(box) + alignment * this->Variables.size());
  BoxSamples result;
  std::uint8_t* first = samples->data();
  QueryStatistics statistics;
  for (const std::size_t variable : this->Variables)
  {
    const ValueType type = this->Samples->GetVolume().GetVariables()[variable].Type;
    const SampleView view = MakeSampleView(type, box, first);
    ISOSURFACE_RETURN_IF_ERROR(
      this->Samples->Read(variable, box, { 1, 1, 1 }, this->Threads, first, 1, statistics));
    const std::size_t bytes =
      GetValueSize(view.Type) * static_cast<std::size_t>(box.GetNumberOfVertices());
    first += (bytes + alignment - 1) / alignment * alignment;
    result.Arrays.push_back(view);
  }
  result.Owner = std::move(samples);
  return result;
}

} // namespace isosurface
