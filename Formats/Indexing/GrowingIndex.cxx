// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/Indexing/GrowingIndex.h"

#include "Formats/Indexing/FetchBudget.h"
#include "Formats/Indexing/SourceSampler.h"
#include "Formats/Opener/ForeignVolume.h"
#include "Storage/Store/BlockedVolume.h"
#include "Storage/Store/FinishedLayers.h"

#include <algorithm>
#include <thread>
#include <utility>
#include <vector>

namespace isosurface
{
namespace
{

/// Before this share is written, its time says little about that of the rest.
constexpr double ShareToEstimate = 0.02;
/// A sample takes the place of one that is so many times smaller.
constexpr double EnoughLarger = 1.5;
/// Ranks tell each other what they have sampled after each of so many parts of the work.
constexpr double GatheringSteps = 20;
/// Of fetching a finer sample, as the coarse one tells; and the most vertices of it.
constexpr double FinerSeconds = 4;
constexpr std::int64_t MostVertices = std::int64_t{ 1 } << 24;

} // namespace

GrowingIndex::GrowingIndex(Communicator& ranks, FileSystem& files, SourceIndex index,
  SourceSample sample, std::uint64_t memoryBytes)
  : Index(std::move(index))
  , Files(files)
  , Sample(std::move(sample))
  , Collector(this->Sample.Volume && this->Sample.Share < 1
        ? std::make_unique<SampleCollector>(this->Sample.WholeStep)
        : nullptr)
{
  if (ranks.GetSize() == 1 && !CanWriteIndex(files, this->Index))
  {
    this->Memory = std::make_shared<MemoryFileSystem>(files, this->Index.Path, memoryBytes);
  }
  FileSystem& place = this->Memory ? *this->Memory : files;
  if (this->Sample.Volume)
  {
    this->Finished = std::shared_ptr<FinishedLayers>(
      new FinishedLayers(place, OpenForeignVolume, this->Index.Path, this->Index.Place,
        [budget = this->Index.Fetching, count = ranks.GetSize()]
        { return !budget || budget->IsWithin(count); }),
      [memory = this->Memory](FinishedLayers* layers) { delete layers; });
  }
  const bool isCoarse = this->Sample.Volume && this->Sample.Share == 1 &&
    (this->Sample.Level > 0 || this->Sample.IsUnfinished);
  this->FetchesFiner = isCoarse && this->Sample.Step == 0 && IsAddress(this->Index.Source);
  this->Writing = std::make_unique<CollectiveTask>(ranks, this->Index.Source,
    [this, &place, memoryBytes, finer = this->FetchesFiner, level = this->Sample.Level,
      vertices = this->Sample.Vertices,
      seconds = this->Sample.Seconds](Communicator& all, const Progress& advance) -> Status
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
      if (finer)
      {
        ISOSURFACE_RETURN_IF_ERROR(this->FetchFiner(all, level, vertices, seconds, advance));
      }
      ISOSURFACE_ASSIGN_OR_RETURN(this->LeftOut,
        WriteSourceIndex(all, place, this->Index, memoryBytes, tell, this->Collector.get(),
          this->Finished.get(), 0,
          [this](Communicator& relay, const Progress& go)
          { return this->WaitForBudget(relay, go); }));
      return Status::Ok();
    });
}

Status GrowingIndex::FetchFiner(
  Communicator& ranks, int level, std::int64_t vertices, double seconds, const Progress& progress)
{
  SampleLimits limits;
  limits.Seconds = level > 0 ? 2 * FinerSeconds : FinerSeconds;
  limits.CoarserThan = level;
  if (level > 0)
  {
    const double most =
      static_cast<double>(vertices) * FinerSeconds / std::max(seconds, FinerSeconds / 100);
    limits.Vertices =
      most < static_cast<double>(MostVertices) ? static_cast<std::int64_t>(most) : MostVertices;
  }
  const Progress look = [&progress](double) { return progress(0); };
  ISOSURFACE_ASSIGN_OR_RETURN(
    auto sample, ReadSourceSample(ranks, this->Files, this->Index, limits, look));
  const auto found = static_cast<double>(sample.Vertices);
  if (sample.Share == 1 && found >= EnoughLarger * static_cast<double>(vertices))
  {
    this->Larger = std::move(sample);
    this->HasFiner = true;
  }
  return Status::Ok();
}

Status GrowingIndex::WaitForBudget(Communicator& ranks, const Progress& advance)
{
  constexpr std::chrono::milliseconds pause{ 50 };
  for (;;)
  {
    const bool isFar =
      this->Finished && this->Index.Fetching && this->Index.Fetching->IsFarTooSmall();
    std::vector<std::uint64_t> all = { isFar && !this->IsAwaited ? 1U : 0U, advance(0) ? 1U : 0U };
    ranks.ReduceMinimum(all);
    this->Waits = all[0] != 0;
    if (all[0] == 0 || all[1] == 0)
    {
      return all[1] != 0
        ? Status::Ok()
        : Status(StatusCode::Aborted, this->Index.Source + ": indexing was stopped");
    }
    std::this_thread::sleep_for(pause);
  }
}

bool GrowingIndex::IsCurrent() const
{
  const auto state = FindIndexState(this->Memory ? *this->Memory : this->Files, this->Index);
  return state.IsOk() && *state == IndexState::Current;
}

Result<std::shared_ptr<BlockedVolume>> GrowingIndex::Open(const GridPlace& place) const
{
  auto opened = BlockedVolume::Open(this->Index.Path, this->Memory ? *this->Memory : this->Files,
    BlockCache::GetProcessCache(), OpenForeignVolume, place);
  if (!opened.IsOk() || !this->Memory)
  {
    return opened;
  }
  const auto kept =
    std::make_shared<std::pair<std::shared_ptr<MemoryFileSystem>, std::shared_ptr<BlockedVolume>>>(
      this->Memory, *opened);
  return std::shared_ptr<BlockedVolume>(kept, kept->second.get());
}

void GrowingIndex::SetSample(SourceSample sample)
{
  this->Enlarging.reset();
  this->Sample = std::move(sample);
}

bool GrowingIndex::HasLargerSample(Communicator& ranks)
{
  if ((!this->Collector && !this->FetchesFiner) || this->Sample.Step > 0)
  {
    return false;
  }
  const bool isThere = this->HasFiner || (this->Enlarging && this->Enlarging->Wait(0));
  std::vector<std::uint64_t> all = { this->Finished->AreShown() ? 0U : 1U, isThere ? 1U : 0U };
  ranks.ReduceMinimum(all);
  if (this->Collector && all[0] != 0 && !this->Enlarging && this->BeginStatus.IsOk())
  {
    this->BeginStatus =
      RunCollective(this->Index.Source, [&] { return this->BeginEnlarging(ranks); });
  }
  return all[0] != 0 && (all[1] != 0 || !this->BeginStatus.IsOk());
}

Status GrowingIndex::GatherSamples(Communicator& ranks)
{
  const double done = this->Writing->HasEnded() ? 1 : this->GetProgress();
  const std::uint64_t steps = ranks.Minimum(static_cast<std::uint64_t>(GatheringSteps * done));
  if (ranks.GetSize() == 1 || steps <= this->GatheredSteps)
  {
    return Status::Ok();
  }
  this->GatheredSteps = steps;
  ISOSURFACE_ASSIGN_OR_RETURN(const auto messages,
    GatherFromAll(ranks, this->Index.Source,
      [&](Message& mine)
      {
        mine = this->Collector->Pack(this->CommonSlices);
        return Status::Ok();
      }));
  return AttemptOnAll(ranks, this->Index.Source,
    [&]
    {
      const bool fits = std::all_of(messages.begin(), messages.end(),
        [&](const Message& message) { return this->Collector->Unpack(message); });
      return fits ? Status::Ok()
                  : Status(StatusCode::InvalidArgument,
                      this->Index.Source + ": the ranks see different volumes");
    });
}

Status GrowingIndex::BeginEnlarging(Communicator& ranks)
{
  ISOSURFACE_RETURN_IF_ERROR(this->GatherSamples(ranks));
  const std::uint64_t slices =
    ranks.Minimum(static_cast<std::uint64_t>(this->Collector->CountSlices()));
  this->CommonSlices = static_cast<std::int64_t>(slices);
  const double share = this->Collector->GetShare(this->CommonSlices);
  const bool isMore =
    share >= EnoughLarger * this->Sample.Share || (share == 1 && this->Sample.Share < 1);
  const bool isWorth = ranks.All(isMore); // a rank that has not opened the file yet knows no share
  if (!isWorth)
  {
    return Status::Ok();
  }
  return AttemptOnAll(ranks, this->Index.Source,
    [this]
    {
      this->Enlarging = std::make_unique<BackgroundTask>(this->Index.Source,
        [this, count = this->CommonSlices](const Progress&) -> Status
        {
          ISOSURFACE_ASSIGN_OR_RETURN(
            this->Larger, this->Collector->MakeSample(this->Files, this->Index, count));
          return Status::Ok();
        });
      return Status::Ok();
    });
}

Status GrowingIndex::EnlargeSample(Communicator& ranks)
{
  if (this->FetchesFiner) // then nothing is collected
  {
    this->FetchesFiner = false;
    this->Sample = std::move(this->Larger);
    return Status::Ok();
  }
  const std::unique_ptr<BackgroundTask> made = std::move(this->Enlarging);
  const Status begun = std::exchange(this->BeginStatus, Status::Ok());
  ISOSURFACE_RETURN_IF_ERROR(begun);
  ISOSURFACE_RETURN_IF_ERROR(ranks.Agree(made->GetStatus()));
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
