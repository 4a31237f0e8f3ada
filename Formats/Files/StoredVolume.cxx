// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/Files/StoredVolume.h"

#include "Formats/Opener/ForeignVolume.h"
#include "Storage/Sampling/StoredBoxSource.h"

#include <algorithm>
#include <numeric>

namespace isosurface
{
namespace
{

// The same samples at the coarsest level that has them: every second vertex is a vertex of the next
// level, if the first one is.
SampleRequest Coarsen(SampleRequest request, int levels)
{
  const Index3 size = request.Box.GetSize();
  const auto hasEven = [&](std::size_t axis)
  {
    const bool isOne = size[axis] <= request.Step[axis];
    return request.Box.Low[axis] % 2 == 0 && (isOne || request.Step[axis] % 2 == 0);
  };
  while (request.Level + 1 < levels && hasEven(0) && hasEven(1) && hasEven(2))
  {
    ++request.Level;
    for (std::size_t axis = 0; axis < 3; ++axis)
    {
      request.Box.Low[axis] /= 2;
      request.Box.High[axis] = (request.Box.High[axis] + 1) / 2;
      request.Step[axis] = (request.Step[axis] + 1) / 2;
    }
  }
  return request;
}

} // namespace

Result<std::shared_ptr<StoredVolume>> StoredVolume::Open(
  const std::string& path, const OpeningChoice& choice)
{
  ISOSURFACE_ASSIGN_OR_RETURN(auto volume,
    BlockedVolume::Open(
      path, GetLocalFileSystem(), BlockCache::GetProcessCache(), OpenForeignVolume, choice.Place));
  if (volume->GetHeader().TimeSteps.empty())
  {
    return Status(StatusCode::Corrupt, path + ": the volume has no time step");
  }
  return std::make_shared<StoredVolume>(std::move(volume), choice.HasLocalStores);
}

StoredVolume::StoredVolume(std::shared_ptr<BlockedVolume> volume, bool hasLocalStores)
  : Volume(std::move(volume))
{
  this->Volume->SetLocalStores(hasLocalStores);
  for (const TimeStepDescription& step : this->Volume->GetHeader().TimeSteps)
  {
    this->Times.push_back(step.Time);
  }
}

LevelDescription StoredVolume::Describe(int level) const
{
  LevelDescription description;
  description.Grid = this->Volume->GetHeader().Grid.Coarsen(level);
  if (const GridLines* lines = this->Volume->GetLines(level))
  {
    description.Lines = *lines;
  }
  const StoredLevel stored = this->Volume->FindLevel(level);
  // Blocks of a coarse level have few vertices: several of them then.
  const std::int64_t size = std::max(stored.Grid->GetBlockSize() >> stored.Level, 16);
  const Index3 dimensions = description.Grid.GetDimensions();
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    description.Chunk[axis] = std::min(size, dimensions[axis]);
  }
  return description;
}

Status StoredVolume::Read(const SampleRequest& given, void* samples, const Progress& progress)
{
  ISOSURFACE_RETURN_IF_ERROR(this->Volume->CheckSource(given.TimeStep));
  const SampleRequest request = Coarsen(given, this->GetNumberOfLevels());
  ISOSURFACE_ASSIGN_OR_RETURN(
    const auto level, this->Levels.Find(this->Volume, request.TimeStep, request.Level));
  const std::size_t first = this->Volume->GetVariables().GetFirst(request.Array);
  const ValueType type = this->GetArrays()[request.Array].Type;
  const auto stride = static_cast<std::ptrdiff_t>(request.Components.size());
  QueryStatistics unused;
  for (std::size_t number = 0; number < request.Components.size(); ++number)
  {
    const std::size_t variable = first + static_cast<std::size_t>(request.Components[number]);
    ISOSURFACE_RETURN_IF_ERROR(level->Read(variable, request.Box, request.Step, request.Threads,
      request.FindPlace(samples, number, type), stride, unused, progress));
  }
  return Status::Ok();
}

Result<std::unique_ptr<BoxSource>> StoredVolume::OpenSource(
  std::size_t timeStep, int threads, std::uint64_t)
{
  std::vector<std::size_t> arrays(this->GetArrays().size());
  std::iota(arrays.begin(), arrays.end(), std::size_t{ 0 });
  ISOSURFACE_ASSIGN_OR_RETURN(
    auto source, StoredBoxSource::Make(this->Volume, timeStep, arrays, threads));
  return std::unique_ptr<BoxSource>(std::move(source));
}

Result<std::shared_ptr<BlockedVolume>> StoredVolume::GetBlocks(
  std::size_t timeStep, const Progress&, std::size_t& stepThere)
{
  ISOSURFACE_RETURN_IF_ERROR(this->Volume->CheckSource(timeStep));
  stepThere = timeStep;
  return this->Volume;
}

} // namespace isosurface
