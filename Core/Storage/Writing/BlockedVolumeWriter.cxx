// SPDX-License-Identifier: BSD-3-Clause
#include "Storage/Writing/BlockedVolumeWriter.h"

#include "Ground/Base/Checksum.h"
#include "Ground/Base/Fingerprint.h"
#include "Ground/Base/ParallelFor.h"
#include "Storage/Writing/GenerationFolder.h"
#include "Storage/Writing/ResolutionWriter.h"
#include "Storage/Writing/VolumePlan.h"
#include "Storage/Writing/WriteContext.h"
#include "Storage/Writing/WriteJournal.h"

#include <algorithm>
#include <cstddef>
#include <utility>

namespace isosurface
{
namespace
{

/// One write of a time step: locks the volume, writes the stores of the volume and its overviews,
/// then makes them visible.
class BlockedVolumeWriteJob
{
public:
  BlockedVolumeWriteJob(Communicator& ranks, FileSystem& files, std::string path, BoxSource& source,
    const BlockedVolumeSettings& settings, Progress progress)
    : Context(ranks, files, std::move(path), settings)
    , Source(source)
    , Tell(std::move(progress))
  {
  }

  /// Collective. `pending`: the volume to append to, if it is not the one on disk.
  Result<WriteStatistics> Run(const GridGeometry& grid, const std::vector<ArrayDescription>& arrays,
    const std::optional<BlockedVolumeHeader>& pending);

  /// The lock of the volume's folder, on rank 0. Run() takes it unless it is held already.
  void HoldLock(std::unique_ptr<PathLock> lock) { this->Lock = std::move(lock); }
  std::unique_ptr<PathLock> TakeLock() { return std::move(this->Lock); }

  /// Whether a later write can go on with what is on disk. Known in Run().
  bool KeepsJournal() const { return this->Context.Settings.JournalSeconds.has_value(); }
  /// After Run(): what was written, with the time steps before.
  const BlockedVolumeHeader& GetHeader() const { return this->Volume->GetHeader(); }

private:
  Status LockVolume();
  void WarnOfLackOfRoom() const;
  void ReadJournal();
  Result<BlockedVolumeHeader> Plan(const GridGeometry& grid,
    const std::vector<ArrayDescription>& arrays,
    const std::optional<BlockedVolumeHeader>& existing);
  Status WriteVolume(const GridGeometry& grid, const std::vector<ArrayDescription>& arrays,
    const std::optional<BlockedVolumeHeader>& pending);
  Status Prepare(const GridGeometry& grid, const std::vector<ArrayDescription>& arrays,
    const std::optional<BlockedVolumeHeader>& pending);
  Status CheckBox(const GridGeometry& grid) const;
  /// A checksum of all that has to be the same on all ranks.
  std::uint64_t ComputeFingerprint(const BlockedVolumeHeader& header) const;
  /// InvalidArgument for this reason if the ranks have different numbers.
  Status CheckEqual(std::uint64_t mine, const char* reason) const;
  Status CheckSourceFiles() const;
  Status MakeGeneration();
  Status WriteOverviews();
  Result<std::unique_ptr<ResolutionWriter>> WriteOverview(
    std::size_t overview, ResolutionWriter& finer);
  Status Commit();
  /// Progress within [begin, end] of the whole work.
  Progress MakeProgress(double begin, double end) const;

  WriteContext Context;
  BoxSource& Source;
  Progress Tell;
  std::unique_ptr<ResolutionWriter> Volume;
  std::unique_ptr<PathLock> Lock; ///< of rank 0
  std::string NewFolder;          ///< of rank 0; empty until it is made
  WriteJournal Journal;           ///< of an earlier write, until this one makes its own
  bool HasJournal = false;        ///< whether an earlier write of the same has left one
  bool IsFinished = false;        ///< whether that write has finished the time step
  bool IsVisible = false;
  WriteStatistics Statistics;
};

/// The share of the work that is done when the volume's own stores are written.
constexpr double VolumeDone = 0.97;

Result<WriteStatistics> BlockedVolumeWriteJob::Run(const GridGeometry& grid,
  const std::vector<ArrayDescription>& arrays, const std::optional<BlockedVolumeHeader>& pending)
{
  // First of all, so that a second writer fails before it has done any work.
  ISOSURFACE_RETURN_IF_ERROR(
    this->Context.AgreeOn(this->Context.Rank == 0 ? this->LockVolume() : Status::Ok()));
  const Status status =
    RunCollective(this->Context.Path, [&] { return this->WriteVolume(grid, arrays, pending); });
  if (!status.IsOk())
  {
    this->Volume.reset();
    // All ranks have closed their files before the folder is removed.
    static_cast<void>(this->Context.Ranks.Agree(Status::Ok()));
    const bool isKept = this->KeepsJournal() && this->Journal.Blocks > 0;
    if (this->Context.Rank == 0 && !this->IsVisible && !isKept)
    {
      if (this->KeepsJournal() && !this->Journal.Finished)
      {
        static_cast<void>(this->Context.Files.RemoveAll(
          WriteJournal::GetPath(this->Context.Files, this->Context.Path)));
      }
      GenerationFolder::Discard(this->Context.Files, this->Context.Path, this->NewFolder);
    }
    return status;
  }
  return this->Statistics;
}

/// Keeps other writers out until this job ends.
Status BlockedVolumeWriteJob::LockVolume()
{
  if (this->Lock)
  {
    return Status::Ok();
  }
  ISOSURFACE_RETURN_IF_ERROR(this->Context.Files.CheckRegular(this->Context.Path, "write"));
  auto lock =
    this->Context.Files.LockFolder(GetStoresFolder(this->Context.Files, this->Context.Path));
  if (lock.IsOk())
  {
    this->Lock = std::move(*lock);
  }
  return lock.GetStatus();
}

Status BlockedVolumeWriteJob::WriteVolume(const GridGeometry& grid,
  const std::vector<ArrayDescription>& arrays, const std::optional<BlockedVolumeHeader>& pending)
{
  this->ReadJournal();
  ISOSURFACE_RETURN_IF_ERROR(this->Prepare(grid, arrays, pending));
  if (this->IsFinished)
  {
    return Status::Ok();
  }
  this->WarnOfLackOfRoom();
  ISOSURFACE_RETURN_IF_ERROR(this->Volume->Distribute());
  ISOSURFACE_RETURN_IF_ERROR(this->MakeGeneration());
  ISOSURFACE_RETURN_IF_ERROR(this->Volume->Write());
  this->Statistics = this->Volume->GetStatistics();
  ISOSURFACE_RETURN_IF_ERROR(this->WriteOverviews());
  ISOSURFACE_RETURN_IF_ERROR(
    this->Context.AgreeOn(this->Context.Attempt([&] { return this->CheckSourceFiles(); })));
  return this->Commit();
}

void BlockedVolumeWriteJob::WarnOfLackOfRoom() const
{
  if (this->Context.Rank != 0 || !this->Context.Settings.Warn)
  {
    return;
  }
  // The other ranks go on to a collective: if a warning cannot be made, there is none.
  static_cast<void>(this->Context.Attempt(
    [&]
    {
      const std::string warning = DescribeLackOfRoom(
        this->Context.Files, this->Context.Path, CountRecordBytes(this->Volume->GetHeader()));
      if (!warning.empty())
      {
        this->Context.Settings.Warn(warning);
      }
      return Status::Ok();
    }));
}

/// Finds what an earlier write has left, for all ranks. What cannot be read is nothing.
void BlockedVolumeWriteJob::ReadJournal()
{
  Message mine;
  // Where nobody keeps others out, another writer may be at work on it, so there is no journal.
  if (this->Context.Rank == 0 && this->Context.Settings.JournalSeconds && this->Lock->IsExclusive())
  {
    mine.push_back(1);
    static_cast<void>(this->Context.Attempt(
      [&]
      {
        const auto text = WriteJournal::ReadText(this->Context.Files, this->Context.Path);
        if (text.IsOk())
        {
          mine.insert(mine.end(), text->begin(), text->end());
        }
        return text.GetStatus();
      }));
  }
  const Message shared = this->Context.Ranks.AllGather(mine)[0];
  if (shared.empty())
  {
    this->Context.Settings.JournalSeconds.reset();
    return;
  }
  const auto journal =
    WriteJournal::Parse(std::string(shared.begin() + 1, shared.end()), this->Context.Path);
  this->HasJournal = journal.IsOk();
  this->Journal = journal.IsOk() ? *journal : WriteJournal{};
}

/// The header of what is written. If an earlier write of that has left a journal, that of the same
/// stores; else there is no journal any longer.
Result<BlockedVolumeHeader> BlockedVolumeWriteJob::Plan(const GridGeometry& grid,
  const std::vector<ArrayDescription>& arrays, const std::optional<BlockedVolumeHeader>& existing)
{
  const auto plan = [&](const BlockedVolumeSettings& settings)
  { return PlanVolume(this->Context.Path, grid, arrays, settings, existing, this->Context.Size); };
  if (this->HasJournal)
  {
    BlockedVolumeSettings same = this->Context.Settings;
    same.NumberOfStores =
      same.NumberOfStores == 0 && !existing ? this->Journal.NumberOfStores : same.NumberOfStores;
    const auto planned = plan(same);
    const auto finished = planned.IsOk() && !same.Publish ? this->Journal.FindFinished(*planned)
                                                          : std::optional<BlockedVolumeHeader>();
    this->IsFinished = finished.has_value();
    if (finished)
    {
      return *finished;
    }
    if (planned.IsOk() && this->Journal.IsInProgress(*planned))
    {
      return planned;
    }
  }
  this->HasJournal = false;
  this->Journal = WriteJournal{};
  return plan(this->Context.Settings);
}

Status BlockedVolumeWriteJob::Prepare(const GridGeometry& grid,
  const std::vector<ArrayDescription>& arrays, const std::optional<BlockedVolumeHeader>& pending)
{
  this->Context.Settings.Threads =
    this->Context.Ranks.ChooseThreads(this->Context.Settings.Threads);
  std::uint64_t fingerprint = 0;
  const auto plan = [&]() -> Status
  {
    ISOSURFACE_ASSIGN_OR_RETURN(const auto existing,
      FindVolumeToAppendTo(
        this->Context.Files, this->Context.Path, this->Context.Settings, pending));
    ISOSURFACE_ASSIGN_OR_RETURN(const auto header, this->Plan(grid, arrays, existing));
    this->Journal.Finished = pending;
    this->Journal.NumberOfStores = header.NumberOfStores;
    this->Journal.Plan = WriteJournal::ComputePlan(header);
    ISOSURFACE_RETURN_IF_ERROR(this->CheckBox(grid));
    fingerprint = this->ComputeFingerprint(header);
    this->Volume = std::make_unique<ResolutionWriter>(this->Context, this->Source, header,
      !header.Overviews.empty(), this->MakeProgress(0, VolumeDone));
    if (this->KeepsJournal())
    {
      this->Volume->KeepJournal(this->Journal);
    }
    this->Volume->TellCaller();
    return Status::Ok();
  };
  ISOSURFACE_RETURN_IF_ERROR(this->Context.AgreeOn(this->Context.Attempt(plan)));
  const FileState& source = this->Context.Settings.Files.State;
  Fingerprint files;
  files.AddNumber(source.Files);
  files.AddNumber(source.Bytes);
  files.AddNumber(static_cast<std::uint64_t>(source.Modified));
  ISOSURFACE_RETURN_IF_ERROR(
    this->CheckEqual(files.Get(), "the ranks see different files of the source"));
  ISOSURFACE_RETURN_IF_ERROR(
    this->CheckEqual(fingerprint, "the ranks disagree about grid, arrays or settings"));
  return this->Volume->Prepare();
}

Status BlockedVolumeWriteJob::CheckBox(const GridGeometry& grid) const
{
  const VertexBox& box = this->Source.GetBox();
  const VertexBox whole = { { 0, 0, 0 }, grid.GetDimensions() };
  return box.IsEmpty() || whole.Intersect(box) == box
    ? Status::Ok()
    : this->Context.MakeRefusal("a rank's piece does not fit the grid");
}

std::uint64_t BlockedVolumeWriteJob::ComputeFingerprint(const BlockedVolumeHeader& header) const
{
  // The header has everything else that matters.
  const BlockedVolumeSettings& settings = this->Context.Settings;
  const std::string text = this->Context.Path + "\n" + header.Format() + "\n" +
    std::to_string(settings.MemoryLimit) + (settings.Publish ? "" : "\n") +
    (settings.JournalSeconds ? "\n" : "") + (settings.WhenFinished ? "\nwhen finished" : "");
  return ComputeChecksum(text.data(), text.size());
}

Status BlockedVolumeWriteJob::CheckEqual(std::uint64_t mine, const char* reason) const
{
  // The complement of the maximum of complements is the minimum: one reduction for both.
  std::vector<std::uint64_t> extremes = { mine, ~mine };
  this->Context.Ranks.ReduceMaximum(extremes);
  return extremes[0] == ~extremes[1] ? Status::Ok() : this->Context.MakeRefusal(reason);
}

Status BlockedVolumeWriteJob::CheckSourceFiles() const
{
  const SourceFiles& source = this->Context.Settings.Files;
  ISOSURFACE_ASSIGN_OR_RETURN(const auto state, FindStateOfAll(this->Context.Files, source.Paths));
  return state == source.State ? Status::Ok()
                               : Status(StatusCode::Corrupt,
                                   source.Paths.front() + ": was changed while it was read for " +
                                     this->Context.Path + "; start again");
}

Status BlockedVolumeWriteJob::MakeGeneration()
{
  Status status;
  Message name;
  if (this->Context.Rank == 0)
  {
    BlockedVolumeHeader wanted = this->Volume->GetHeader();
    wanted.TimeSteps.back().Folder = this->Journal.Folder;
    if (this->Lock->IsExclusive())
    {
      // Of time steps before, the journal has to stay, too.
      GenerationFolder::RemoveUnnamed(this->Context.Files, this->Context.Path, wanted,
        this->HasJournal || (this->Journal.Finished && this->KeepsJournal()));
    }
    const auto folder = this->HasJournal
      ? Result<std::string>(this->Journal.Folder)
      : GenerationFolder::Create(this->Context.Files, this->Context.Path);
    status = folder.GetStatus();
    if (folder.IsOk())
    {
      this->NewFolder = *folder;
      name.assign(folder->begin(), folder->end());
    }
  }
  ISOSURFACE_RETURN_IF_ERROR(this->Context.AgreeOn(status));
  const Message shared = this->Context.Ranks.AllGather(name)[0];
  this->Volume->GetStep().Folder.assign(shared.begin(), shared.end());
  this->Journal.Folder = this->Volume->GetStep().Folder;
  return Status::Ok();
}

/// Writes each overview as the volume was, from the samples that the grid before it has left.
Status BlockedVolumeWriteJob::WriteOverviews()
{
  std::unique_ptr<ResolutionWriter> coarsest;
  const std::size_t overviews = this->Volume->GetHeader().Overviews.size();
  for (std::size_t overview = 0; overview < overviews; ++overview)
  {
    ISOSURFACE_ASSIGN_OR_RETURN(
      coarsest, this->WriteOverview(overview, coarsest ? *coarsest : *this->Volume));
    this->Volume->GetStep().Overviews[overview] = coarsest->GetStep().Stores;
    this->Statistics.OverviewBytes += coarsest->GetStatistics().Bytes;
    this->Statistics.MemoryBytes =
      std::max(this->Statistics.MemoryBytes, coarsest->GetStatistics().MemoryBytes);
  }
  // Until here a write that is killed could go on.
  return this->Volume->RemoveTemporaryFiles();
}

Result<std::unique_ptr<ResolutionWriter>> BlockedVolumeWriteJob::WriteOverview(
  std::size_t overview, ResolutionWriter& finer)
{
  std::unique_ptr<OverviewSource> source;
  std::unique_ptr<ResolutionWriter> writer;
  const BlockedVolumeHeader& volume = this->Volume->GetHeader();
  ISOSURFACE_RETURN_IF_ERROR(this->Context.AgreeOn(this->Context.Attempt(
    [&]
    {
      source = finer.MakeOverviewSource();
      writer =
        std::make_unique<ResolutionWriter>(this->Context, *source, volume.MakeOverview(overview),
          overview + 1 < volume.Overviews.size(), this->MakeProgress(VolumeDone, 1));
      return Status::Ok();
    })));
  ISOSURFACE_RETURN_IF_ERROR(writer->Prepare());
  ISOSURFACE_RETURN_IF_ERROR(writer->Distribute());
  const Status written = writer->Write();
  if (written.GetCode() == StatusCode::Corrupt)
  {
    this->Journal.Blocks = 0; // the next write does not go on with the temporary files
  }
  ISOSURFACE_RETURN_IF_ERROR(written);
  if (&finer != this->Volume.get())
  {
    ISOSURFACE_RETURN_IF_ERROR(finer.RemoveTemporaryFiles());
  }
  return writer;
}

Status BlockedVolumeWriteJob::Commit()
{
  return this->Context.AgreeOn(this->Context.Attempt(
    [&]() -> Status
    {
      if (this->Context.Rank != 0)
      {
        return Status::Ok();
      }
      FileSystem& files = this->Context.Files;
      const std::string& path = this->Context.Path;
      const BlockedVolumeHeader& header = this->Volume->GetHeader();
      const std::string& folder = header.TimeSteps.back().Folder;
      for (std::size_t overview = 0; overview < header.Overviews.size(); ++overview)
      {
        ISOSURFACE_RETURN_IF_ERROR(files.SyncDirectory(
          GetStoresFolder(files, path) + "/" + GetOverviewFolder(folder, overview)));
      }
      ISOSURFACE_RETURN_IF_ERROR(files.SyncDirectory(this->Volume->GetFolder()));
      if (!this->Context.Settings.Publish)
      {
        WriteJournal journal;
        journal.Finished = header;
        journal.NumberOfStores = header.NumberOfStores;
        return this->KeepsJournal() ? journal.Write(files, path) : Status::Ok();
      }
      ISOSURFACE_RETURN_IF_ERROR(GenerationFolder::Commit(files, path, header, this->IsVisible));
      if (this->KeepsJournal())
      {
        static_cast<void>(files.RemoveAll(WriteJournal::GetPath(files, path)));
      }
      GenerationFolder::RemoveOlder(files, path, folder, header);
      return Status::Ok();
    }));
}

Progress BlockedVolumeWriteJob::MakeProgress(double begin, double end) const
{
  return [this, begin, end](double share)
  { return !this->Tell || this->Tell(begin + (end - begin) * share); };
}

} // namespace

Result<WriteStatistics> BlockedVolumeWriter::Write(const std::string& path,
  const GridGeometry& grid, const std::vector<ArrayDescription>& arrays, BoxSource& source,
  const BlockedVolumeSettings& settings, const Progress& progress)
{
  if (!settings.Append || path != this->PendingPath)
  {
    this->DiscardPending();
  }
  BlockedVolumeWriteJob job(this->Ranks, this->Files, path, source, settings, progress);
  job.HoldLock(std::move(this->PendingLock));
  auto written = job.Run(grid, arrays, this->Pending);
  this->IsPendingKept = job.KeepsJournal();
  if (!written.IsOk())
  {
    this->PendingLock = job.TakeLock();
    this->DiscardPending();
  }
  else if (settings.Publish)
  {
    this->Pending.reset();
  }
  else
  {
    this->PendingPath = path;
    this->Pending = job.GetHeader();
    this->PendingLock = job.TakeLock();
  }
  return written;
}

BlockedVolumeWriter::~BlockedVolumeWriter()
{
  this->DiscardPending();
}

void BlockedVolumeWriter::DiscardPending()
{
  if (this->Pending && !this->IsPendingKept && this->Ranks.GetRank() == 0)
  {
    GenerationFolder::DiscardUnnamed(this->Files, this->PendingPath, *this->Pending);
  }
  this->Pending.reset();
  this->PendingLock.reset();
}

Result<WriteStatistics> BlockedVolumeWriter::Write(const std::string& path,
  const GridGeometry& grid, const std::vector<ArrayDescription>& arrays, const VolumePiece& piece,
  const BlockedVolumeSettings& settings, const Progress& progress)
{
  MemorySource source(piece);
  return this->Write(path, grid, arrays, source, settings, progress);
}

} // namespace isosurface
