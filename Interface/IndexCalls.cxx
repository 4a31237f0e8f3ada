// SPDX-License-Identifier: BSD-3-Clause
#include "Interface/VolumeHandle.h"

#include "Formats/Files/StoredVolume.h"
#include "Formats/Indexing/FetchBudget.h"
#include "Formats/Indexing/GrowingIndex.h"
#include "Formats/Indexing/SourceSampler.h"

#include <memory>
#include <new>
#include <utility>

using namespace isosurface;

struct si_growing
{
  std::string Name;
  OpeningChoice Choice;
  std::unique_ptr<GrowingIndex> Growing; ///< null if there was a volume at once
  bool HasLarger = false;
  bool HasEnded = false;
  bool HasFailed = false;
  std::string Text;
};

struct si_fetching
{
  std::shared_ptr<FetchBudget> Budget; ///< of the last name
};

namespace isosurface
{
namespace
{

Result<SourceIndex> FindIndex(
  const std::string& name, const si_opening* opening, OpeningChoice& choice)
{
  ISOSURFACE_ASSIGN_OR_RETURN(choice, TakeOpening(opening));
  ISOSURFACE_ASSIGN_OR_RETURN(const auto taken, TakeStructure(opening, "si_opening"));
  ISOSURFACE_ASSIGN_OR_RETURN(auto index,
    SourceIndex::FindPartOf(GetLocalFileSystem(), name, "", choice.Axes, choice.IndexFolder,
      choice.Place, choice.Bounds));
  std::shared_ptr<FetchBudget> alone;
  std::shared_ptr<FetchBudget>& budget = taken.fetching ? taken.fetching->Budget : alone;
  if (!budget || budget->GetSource() != index.Source)
  {
    budget = std::make_shared<FetchBudget>(index.Source, taken.fetch_budget);
  }
  budget->SetLimit(taken.fetch_budget);
  index.Fetching = budget;
  return index;
}

std::uint64_t OrUsualMemory(std::uint64_t memory)
{
  return memory != 0 ? memory : std::uint64_t{ 1 } << 30;
}

/// Whether the index has to be written, on any rank. Collective.
Result<bool> IsWanted(Communicator& ranks, const SourceIndex& index)
{
  const auto state =
    Attempt(index.Path, [&] { return FindIndexState(GetLocalFileSystem(), index); });
  ISOSURFACE_RETURN_IF_ERROR(ranks.Agree(state.GetStatus()));
  return ranks.Any(*state != IndexState::Current);
}

/// Begins to write the index beside this thread, or, of a small file, writes it. Collective.
Status Grow(Call& call, si_growing& growing, SourceSample sample, const SourceIndex& index,
  std::uint64_t memory)
{
  Communicator& ranks = call.GetRanks();
  const bool isWhole = sample.IsWhole;
  auto begun = Attempt(growing.Name,
    [&]() -> Result<std::unique_ptr<GrowingIndex>>
    {
      return std::make_unique<GrowingIndex>(ranks, GetLocalFileSystem(), index,
        isWhole ? SourceSample() : std::move(sample), OrUsualMemory(memory));
    });
  ISOSURFACE_RETURN_IF_ERROR(ranks.Agree(begun.GetStatus()));
  growing.Growing = std::move(*begun);
  if (isWhole)
  {
    ISOSURFACE_RETURN_IF_ERROR(ranks.Agree(growing.Growing->Finish(ranks, call.GetProgress())));
    growing.HasEnded = true;
  }
  return Status::Ok();
}

Result<std::shared_ptr<VolumeFile>> OpenGrown(Communicator& ranks, si_growing& growing)
{
  if (!growing.Growing)
  {
    return VolumeFile::Open(growing.Name, growing.Choice);
  }
  std::shared_ptr<BlockedVolume> volume;
  if (growing.HasEnded && !growing.HasFailed)
  {
    ISOSURFACE_ASSIGN_OR_RETURN(volume, growing.Growing->Open(growing.Choice.Place));
  }
  else
  {
    if (std::exchange(growing.HasLarger, false))
    {
      ISOSURFACE_RETURN_IF_ERROR(growing.Growing->EnlargeSample(ranks));
    }
    volume = growing.Growing->GetSample().Volume;
  }
  return std::shared_ptr<VolumeFile>(
    std::make_shared<StoredVolume>(std::move(volume), growing.Choice.HasLocalStores));
}

} // namespace
} // namespace isosurface

si_fetching* si_fetching_new(void)
{
  return new (std::nothrow) si_fetching;
}

void si_fetching_free(si_fetching* fetching)
{
  delete fetching;
}

si_result si_write_index(
  const char* name, const si_opening* opening, uint64_t memory, const si_run* run)
{
  return RunCall(ToText(name), run,
    [&](Call& call) -> Status
    {
      OpeningChoice choice;
      const auto index = FindIndex(ToText(name), opening, choice);
      ISOSURFACE_RETURN_IF_ERROR(call.GetRanks().Agree(index.GetStatus()));
      ISOSURFACE_ASSIGN_OR_RETURN(const auto isWanted, IsWanted(call.GetRanks(), *index));
      if (isWanted)
      {
        ISOSURFACE_ASSIGN_OR_RETURN(const auto leftOut,
          WriteSourceIndex(call.GetRanks(), GetLocalFileSystem(), *index, OrUsualMemory(memory),
            call.GetProgress(), nullptr, nullptr, call.GetThreads()));
        call.Warn(leftOut);
      }
      return Status::Ok();
    });
}

si_result si_growing_begin(const char* name, const si_opening* opening, size_t step, double seconds,
  uint64_t memory, const si_run* run, si_growing** growing)
{
  return RunCall(ToText(name), run,
    [&](Call& call) -> Status
    {
      auto made = std::make_unique<si_growing>();
      made->Name = ToText(name);
      FileKind kind = {};
      const auto find = [&]() -> Result<SourceIndex>
      {
        ISOSURFACE_ASSIGN_OR_RETURN(kind, FindFileKind(made->Name));
        return FindIndex(made->Name, opening, made->Choice);
      };
      const auto found = find();
      ISOSURFACE_RETURN_IF_ERROR(call.GetRanks().Agree(found.GetStatus()));
      const SourceIndex& index = *found;
      bool isWanted = kind == FileKind::Source;
      if (isWanted)
      {
        ISOSURFACE_ASSIGN_OR_RETURN(isWanted, IsWanted(call.GetRanks(), index));
      }
      if (isWanted)
      {
        SampleLimits limits;
        limits.Step = step;
        limits.Seconds = seconds > 0 ? seconds : limits.Seconds;
        ISOSURFACE_ASSIGN_OR_RETURN(auto sample,
          ReadSourceSample(
            call.GetRanks(), GetLocalFileSystem(), index, limits, call.GetProgress()));
        ISOSURFACE_RETURN_IF_ERROR(Grow(call, *made, std::move(sample), index, memory));
      }
      return Give(std::move(made), growing);
    });
}

si_result si_growing_poll(
  si_growing* growing, double seconds, const si_run* run, si_growing_state* state)
{
  return RunCall(growing->Name, run,
    [&](Call& call) -> Status
    {
      if (state->size < sizeof(state->size))
      {
        return { StatusCode::InvalidArgument, "si_growing_state does not begin with its size" };
      }
      Communicator& ranks = call.GetRanks();
      GrowingIndex* const index = growing->Growing.get();
      if (growing->HasFailed)
      {
        return ranks.Agree(index->GetStatus());
      }
      if (index && !growing->HasEnded)
      {
        growing->HasEnded = index->Advance(ranks, seconds);
        if (growing->HasEnded)
        {
          const Status status = ranks.Agree(index->GetStatus());
          growing->HasFailed = !status.IsOk();
          ISOSURFACE_RETURN_IF_ERROR(status);
          call.Warn(index->GetLeftOut());
        }
        else
        {
          growing->HasLarger = growing->HasLarger || index->HasLargerSample(ranks);
          index->GetIndex().Fetching->Gather(ranks);
        }
      }
      const bool isReady = !index || growing->HasEnded;
      si_growing_state told{};
      told.size = state->size;
      told.stage = isReady   ? SI_GROWING_READY
        : growing->HasLarger ? SI_GROWING_LARGER
                             : SI_GROWING_WORKS;
      told.done = index ? index->GetProgress() : 1;
      told.seconds_left = index ? index->EstimateSeconds() : 0;
      told.share = index && index->GetSample().Volume ? index->GetSample().Share : 1;
      growing->Text = index ? index->GetSample().Text : "";
      const std::string fetched = index ? index->GetIndex().Fetching->Describe() : "";
      growing->Text += fetched.empty() ? "" : "; " + fetched;
      told.text = growing->Text.c_str();
      std::memcpy(state, &told, std::min(state->size, sizeof(told)));
      return Status::Ok();
    });
}

si_result si_growing_take(si_growing* growing, const si_run* run, si_volume** volume)
{
  return RunCall(growing->Name, run,
    [&](Call& call) -> Status
    {
      ISOSURFACE_ASSIGN_OR_RETURN(auto file, OpenGrown(call.GetRanks(), *growing));
      return Give(std::make_unique<si_volume>(std::move(file)), volume);
    });
}

void si_growing_stop(si_growing* growing)
{
  if (growing->Growing)
  {
    growing->Growing->Stop();
  }
}

void si_growing_free(si_growing* growing)
{
  delete growing;
}
