// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/Indexing/GrowingIndex.h"

#include "Formats/Opener/ForeignVolume.h"
#include "Storage/Store/BlockedVolume.h"
#include "Storage/Store/FinishedLayers.h"

#include <algorithm>
#include <utility>

namespace isosurface
{
namespace
{

/// Before this share is written, its time says little about that of the rest.
constexpr double ShareToEstimate = 0.02;
/// A sample takes the place of one that is so many times smaller.
constexpr double EnoughLarger = 1.5;

} // namespace

GrowingIndex::GrowingIndex(Communicator& ranks, FileSystem& files, SourceIndex index,
  SourceSample sample, std::uint64_t memoryBytes)
  : Index(std::move(index))
  , Files(files)
  , Sample(std::move(sample))
  , Collector(ranks.GetSize() == 1 && this->Sample.Volume && this->Sample.Share < 1
        ? std::make_unique<SampleCollector>(this->Sample.WholeStep)
        : nullptr)
  , Finished(this->Sample.Volume
        ? std::make_shared<FinishedLayers>(files, OpenForeignVolume, this->Index.Path)
        : nullptr)
{
  if (ranks.GetSize() == 1 && !CanWriteIndex(files, this->Index))
  {
    this->Memory = std::make_shared<MemoryFileSystem>(files, this->Index.Path, memoryBytes);
  }
  FileSystem& place = this->Memory ? *this->Memory : files;
  this->Writing = std::make_unique<CollectiveTask>(ranks, this->Index.Source,
    [this, &place, memoryBytes](Communicator& all, const Progress& advance) -> Status
    {
      const Progress tell = [&](double done)
      {
        if (this->FirstProgress < 0)
        {
          this->FirstTime = std::chrono::steady_clock::now();
          this->FirstProgress = done;
        }
        return advance(done);
      };
      // However it ends.
      const std::unique_ptr<FinishedLayers, void (*)(FinishedLayers*)> end(
        this->Finished.get(), [](FinishedLayers* layers) { layers->End(); });
      const auto leftOut = WriteSourceIndex(
        all, place, this->Index, memoryBytes, tell, this->Collector.get(), this->Finished.get());
      ISOSURFACE_RETURN_IF_ERROR(leftOut.GetStatus());
      this->LeftOut = *leftOut;
      return Status::Ok();
    });
}

bool GrowingIndex::IsCurrent() const
{
  const auto state = FindIndexState(this->Memory ? *this->Memory : this->Files, this->Index);
  return state.IsOk() && *state == IndexState::Current;
}

Result<std::shared_ptr<BlockedVolume>> GrowingIndex::Open() const
{
  auto opened = BlockedVolume::Open(this->Index.Path, this->Memory ? *this->Memory : this->Files,
    BlockCache::GetProcessCache(), OpenForeignVolume);
  if (!opened.IsOk() || !this->Memory)
  {
    return opened;
  }
  const auto kept =
    std::make_shared<std::pair<std::shared_ptr<MemoryFileSystem>, std::shared_ptr<BlockedVolume>>>(
      this->Memory, *opened);
  return std::shared_ptr<BlockedVolume>(kept, kept->second.get());
}

bool GrowingIndex::HasLargerSample()
{
  if (this->Finished && this->Finished->AreShown())
  {
    return false;
  }
  const double share = this->Collector ? this->Collector->GetShare() : 0;
  const bool isWorth =
    share >= EnoughLarger * this->Sample.Share || (share == 1 && this->Sample.Share < 1);
  if (isWorth && !this->Enlarging)
  {
    this->Enlarging = std::make_unique<BackgroundTask>(this->Index.Source,
      [this](const Progress&) -> Status
      {
        auto larger = this->Collector->MakeSample(this->Files, this->Index);
        ISOSURFACE_RETURN_IF_ERROR(larger.GetStatus());
        this->Larger = std::move(*larger);
        return Status::Ok();
      });
  }
  return this->Enlarging && this->Enlarging->Wait(0);
}

Status GrowingIndex::EnlargeSample()
{
  const std::unique_ptr<BackgroundTask> made = std::move(this->Enlarging);
  ISOSURFACE_RETURN_IF_ERROR(made->GetStatus());
  this->Sample = std::move(this->Larger);
  return Status::Ok();
}

double GrowingIndex::EstimateSeconds() const
{
  const double first = this->FirstProgress;
  const double done = this->GetProgress() - first;
  if (first < 0 || done < ShareToEstimate)
  {
    return -1;
  }
  const double seconds =
    std::chrono::duration<double>(std::chrono::steady_clock::now() - this->FirstTime).count();
  return seconds * std::max(0.0, 1 - first - done) / done;
}

} // namespace isosurface
