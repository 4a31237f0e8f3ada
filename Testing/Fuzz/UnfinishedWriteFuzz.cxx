// SPDX-License-Identifier: BSD-3-Clause
// Input: the text of a journal up to a zero byte, as it is or, behind a space, with the right checksum; then
// changes of what an unfinished write left: the number of a file (1 byte; from 128 on it ends there), a place
// (3 bytes), a number of bytes (1 byte), the bytes. The checksums of checkpoints are put right. An empty
// text: the journal that was left.
#include "FuzzTarget.h"
#include "SealedBytes.h"

#include "Fixtures/SampleVolume.h"
#include "Ground/Base/Checksum.h"
#include "Ground/Base/Coding.h"
#include "Storage/Verification/VolumeVerification.h"
#include "Storage/Writing/BlockedVolumeWriter.h"
#include "Storage/Writing/WriteJournal.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <string>

using namespace isosurface;

namespace
{

const std::string UnfinishedPath = "/data/volume.bvol";

/// A disk whose folders can be locked: only there a journal is kept.
class LockedDisk : public MemoryDisk
{
public:
  Result<std::unique_ptr<PathLock>> LockFolder(const std::string& path) override
  {
    struct Lock : public PathLock
    {
      bool IsExclusive() const override { return true; }
    };
    ISOSURFACE_RETURN_IF_ERROR(this->MakeDirectories(path));
    return std::unique_ptr<PathLock>(new Lock);
  }
};

/// Writes a volume of 2 x 1 x 9 blocks in rounds, with a checkpoint after each.
Status WriteVolume(MemoryDisk& disk, const Progress& progress)
{
  static const SampleVolume<std::uint8_t> volume({ 18, 17, 138 },
    [](auto i, auto j, auto k) {
      return 60 + 40 * std::sin(0.4 * static_cast<double>(i) + 0.01 * static_cast<double>(j * k));
    });
  const Index3& size = volume.GetDimensions();
  GridGeometry grid;
  grid.Extent = { 0, size[0] - 1, 0, size[1] - 1, 0, size[2] - 1 };
  SourceRecord record;
  record.Path = "run.nii.gz";
  record.AbsolutePath = "/data/run.nii.gz";
  record.Arrays = { "data" };
  record.State = { 1, 29000, 1 };
  BlockedVolumeSettings settings;
  settings.BlockSize = 16;
  settings.Distribution = DistributionMethod::Slab;
  settings.NumberOfStores = 1;
  settings.CopyOf = record;
  settings.JournalSeconds = 0;
  settings.MemoryLimit = 800000;
  settings.Threads = 1;
  SerialCommunicator alone;
  return BlockedVolumeWriter(alone, disk)
    .Write(UnfinishedPath, grid, { { "density", ValueType::UInt8 } },
      VolumePiece{ { { 0, 0, 0 }, size }, { volume.GetView() } }, settings, progress)
    .GetStatus();
}

/// What a write leaves that is stopped.
std::map<std::string, SealedBytes> LeaveUnfinished()
{
  LockedDisk disk;
  const Status status = WriteVolume(disk, [](double share) { return share < 0.5; });
  Require(status.GetCode() == StatusCode::Aborted, "the write is stopped");
  Require(disk.Exists(WriteJournal::GetPath(disk, UnfinishedPath)), "it leaves a journal");
  return disk.Copy();
}

void ChangeFiles(
  std::map<std::string, SealedBytes>& files, const std::uint8_t* begin, const std::uint8_t* end)
{
  while (end - begin >= 5)
  {
    const std::size_t number = begin[0] % 128;
    auto file = files.begin();
    std::advance(file, static_cast<std::ptrdiff_t>(number % files.size()));
    const std::size_t place = std::min<std::size_t>(
      file->second.size(), begin[1] | begin[2] << 8 | static_cast<std::size_t>(begin[3]) << 16);
    const bool isEnd = begin[0] >= 128;
    const auto count =
      static_cast<std::size_t>(std::min<std::ptrdiff_t>(begin[4], end - begin - 5));
    file->second.resize(isEnd ? place + count : std::max(file->second.size(), place + count));
    std::copy(
      begin + 5, begin + 5 + count, file->second.begin() + static_cast<std::ptrdiff_t>(place));
    begin += 5 + count;
  }
}

/// Puts the checksums of checkpoints right, after the drawing in StoreJournal.cxx.
void SealCheckpoints(std::map<std::string, SealedBytes>& files, const WriteJournal& journal)
{
  MemoryDisk empty;
  const std::string folder =
    GetStoresFolder(empty, UnfinishedPath) + "/" + journal.Folder + "/store-00000/";
  SealedBytes& entries = files[folder + "entries.tmp"];
  // The number of a block, its offset, the lengths of its segments, one a level, and its range.
  constexpr std::size_t entryBytes = 8 + 8 + 2 * 4 + 16;
  std::uint64_t chained = 0;
  for (std::size_t at = 0; at + entryBytes <= entries.size(); at += entryBytes)
  {
    chained = ComputeChecksum(entries.data() + at, entryBytes, chained);
  }
  SealedBytes& checkpoint =
    files[folder + "checkpoint-" + std::to_string(journal.Checkpoint % 2) + ".tmp"];
  if (checkpoint.size() >= 64)
  {
    StoreLittleEndian<std::uint64_t>(
      checkpoint.data() + 48, entries.size() / entryBytes * entryBytes);
    StoreLittleEndian(checkpoint.data() + 56, chained);
    StoreLittleEndian(checkpoint.data(),
      ComputeChecksum(checkpoint.data() + 8, checkpoint.size() - 8,
        static_cast<std::uint64_t>(journal.Checkpoint)));
  }
}

} // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size)
{
  static const std::map<std::string, SealedBytes> left = LeaveUnfinished();
  MemoryDisk empty;
  const std::string journalPath = WriteJournal::GetPath(empty, UnfinishedPath);
  const std::uint8_t* const zero = std::find(bytes, bytes + size, std::uint8_t{ 0 });
  std::string text(bytes, zero);
  if (text.empty())
  {
    const SealedBytes& journal = left.at(journalPath);
    text.assign(journal.begin(), journal.end());
  }
  else if (text[0] == ' ')
  {
    text = SealJson(text.substr(1));
  }
  auto files = left;
  if (zero != bytes + size)
  {
    ChangeFiles(files, zero + 1, bytes + size);
  }
  files[journalPath].assign(text.begin(), text.end());
  const auto journal = WriteJournal::Parse(text, journalPath);
  if (journal.IsOk())
  {
    SealCheckpoints(files, *journal);
    Require(size > 1 || files == left, "what was left has the right checksums");
  }
  else
  {
    Require(journal.GetStatus().GetMessage().find(journalPath) == 0, "an error names the file");
  }
  LockedDisk disk;
  for (auto& [path, content] : files)
  {
    PutFile(disk, path, std::move(content));
  }
  const MemoryLimit limit(std::size_t{ 64 } << 20);
  const Status written = WriteVolume(disk, {});
  Require(written.IsOk() || written.GetMessage().find("/data/") == 0, "an error names the file");
  if (written.IsOk())
  {
    // Journals are trusted as far as their checksums: what comes of them may be wrong, and is looked at.
    static_cast<void>(VerifyBlockedVolume(UnfinishedPath, disk, 1));
  }
  return 0;
}
