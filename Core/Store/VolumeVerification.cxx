// SPDX-License-Identifier: BSD-3-Clause
#include "Store/VolumeVerification.h"

#include "Base/Buffer.h"
#include "Base/Checksum.h"
#include "Base/Coding.h"
#include "Base/ParallelFor.h"
#include "Index/ExternalIntervalTree.h"
#include "Record/BlockRecord.h"
#include "Record/BlockSegment.h"
#include "Record/RecordCodec.h"
#include "Store/BlockDirectory.h"
#include "Store/BlockStore.h"
#include "Store/BlockedVolumeHeader.h"
#include "Store/JsonDocument.h"
#include "Store/VolumeSpectra.h"
#include "Volume/SampleRange.h"

#include <algorithm>
#include <limits>
#include <memory>
#include <utility>

namespace isosurface
{
namespace
{

/// Blocks that a thread takes at a time.
constexpr std::uint64_t RunLength = 32;

/// One store of one time step, of the volume or an overview. Threads work on different blocks of
/// it, each with its own results.
class StoreCheck
{
public:
  StoreCheck(FileSystem& files, const ArrayVariables& variables, const BlockGrid& grid,
    const StoreDescription& description, std::string folder)
    : Files(files)
    , Variables(variables)
    , Grid(grid)
    , Description(description)
    , Folder(std::move(folder))
    , Segments(variables.GetNumberOfStored() * static_cast<std::size_t>(grid.GetNumberOfLevels()))
  {
  }

  /// Opens the files, checks the directory's pages and the trees.
  void Open();
  bool IsOpen() const { return this->Directory != nullptr; }
  std::uint64_t GetNumberOfRuns() const
  {
    return this->Directory ? (this->Directory->GetCount() + RunLength - 1) / RunLength : 0;
  }
  void CheckRun(std::uint64_t run);
  /// What all blocks together must be; marks the blocks that the store has.
  void Finish(std::vector<std::uint8_t>& seen);

  std::vector<Status> TakeFaults();
  std::uint64_t GetFiles() const { return 2 + this->Variables.GetCount(); }
  std::uint64_t GetBytes() const { return this->Blocks ? this->Blocks->GetSize() : 0; }

private:
  std::string GetTreePath(std::size_t variable) const
  {
    return BlockStore::GetTreePath(this->Folder, this->Variables, variable);
  }
  void OpenTree(std::size_t variable);
  Status CheckRecord(std::uint64_t ordinal, std::vector<Status>& faults);
  std::shared_ptr<const DecodedBlock> CheckComponent(const BlockDirectoryEntry& entry,
    std::uint64_t ordinal, std::size_t component, const std::uint8_t* record,
    std::vector<Status>& faults);
  std::shared_ptr<const DecodedBlock> Find(
    const DecodedBlocks& components, std::size_t variable) const;
  void CheckRange(const DecodedBlock& block, std::uint64_t ordinal, std::size_t variable,
    std::vector<Status>& faults) const;
  Status MakeFault(const std::string& reason) const
  {
    return Status(StatusCode::Corrupt, BlockStore::GetBlocksPath(this->Folder) + ": " + reason);
  }

  FileSystem& Files;
  const ArrayVariables& Variables;
  const BlockGrid& Grid;
  const StoreDescription& Description;
  std::string Folder;
  std::size_t Segments;

  std::unique_ptr<RandomAccessFile> Blocks;
  std::unique_ptr<BlockDirectory> Directory;
  std::vector<std::vector<KeyRange>> Ranges; ///< per variable and ordinal, as the tree has it
  std::vector<std::int64_t> Numbers;         ///< per ordinal: the block, or -1
  std::vector<std::uint64_t> Sizes;          ///< per ordinal: bytes of the record and what pads it
  std::vector<std::uint64_t> Checksums;      ///< per ordinal and segment
  std::vector<Status> OpenFaults;
  std::vector<std::vector<Status>> RunFaults;
};

void StoreCheck::Open()
{
  if (!this->Files.Exists(this->Folder))
  {
    this->OpenFaults.emplace_back(
      StatusCode::NotFound, this->Folder + ": this store of the blocked volume is missing");
    return;
  }
  this->Ranges.resize(this->Variables.GetCount());
  for (std::size_t variable = 0; variable < this->Variables.GetCount(); ++variable)
  {
    this->OpenTree(variable);
  }
  auto blocks = this->Files.OpenForReading(BlockStore::GetBlocksPath(this->Folder));
  if (!blocks.IsOk())
  {
    this->OpenFaults.push_back(blocks.GetStatus());
    return;
  }
  this->Blocks = std::move(*blocks);
  if (this->Blocks->GetSize() != this->Description.Bytes)
  {
    this->OpenFaults.push_back(
      this->MakeFault("has " + std::to_string(this->Blocks->GetSize()) + " bytes instead of the " +
        std::to_string(this->Description.Bytes) + " that the header says"));
  }
  auto directory = BlockDirectory::Open(this->Files, BlockStore::GetDirectoryPath(this->Folder),
    this->Description.Blocks, this->Segments, BlockStore::PageCacheBytes);
  if (!directory.IsOk())
  {
    this->OpenFaults.push_back(directory.GetStatus());
    return;
  }
  this->Directory = std::move(*directory);
  const auto count = static_cast<std::size_t>(this->Directory->GetCount());
  this->Numbers.assign(count, -1);
  this->Sizes.assign(count, 0);
  this->Checksums.assign(count * this->Segments, 0);
  this->RunFaults.resize(static_cast<std::size_t>(this->GetNumberOfRuns()));
}

void StoreCheck::OpenTree(std::size_t variable)
{
  const std::string path = this->GetTreePath(variable);
  auto tree = ExternalIntervalTree::Open(this->Files, path, BlockStore::PageCacheBytes);
  PageStatistics pages;
  Status status = tree.IsOk() ? (*tree)->Verify(pages) : tree.GetStatus();
  if (status.IsOk() && (*tree)->GetCount() != this->Description.Blocks)
  {
    status = Status(
      StatusCode::Corrupt, path + ": has another number of intervals than the store has blocks");
  }
  bool isKnown = true;
  std::vector<KeyRange> ranges;
  if (status.IsOk())
  {
    ranges.resize(static_cast<std::size_t>(this->Description.Blocks));
    status = (*tree)->FindOverlapping(
      0, std::numeric_limits<ValueKey>::max(),
      [&](const KeyInterval& interval)
      {
        isKnown = isKnown && interval.Payload < ranges.size() && ranges[interval.Payload].IsEmpty();
        if (isKnown)
        {
          ranges[interval.Payload] = { interval.Minimum, interval.Maximum };
        }
      },
      pages);
  }
  if (status.IsOk() && !isKnown)
  {
    status = Status(StatusCode::Corrupt, path + ": does not have each block of the store once");
  }
  if (!status.IsOk())
  {
    this->OpenFaults.push_back(status);
    return;
  }
  this->Ranges[variable] = std::move(ranges);
}

void StoreCheck::CheckRun(std::uint64_t run)
{
  const std::uint64_t end = std::min((run + 1) * RunLength, this->Directory->GetCount());
  std::vector<Status>& faults = this->RunFaults[static_cast<std::size_t>(run)];
  for (std::uint64_t ordinal = run * RunLength; ordinal < end; ++ordinal)
  {
    const Status status = this->CheckRecord(ordinal, faults);
    if (!status.IsOk())
    {
      // A directory's page that is damaged is one fault, not one of each of its blocks.
      if (faults.empty() || faults.back().GetMessage() != status.GetMessage())
      {
        faults.push_back(status);
      }
    }
  }
}

Status StoreCheck::CheckRecord(std::uint64_t ordinal, std::vector<Status>& faults)
{
  QueryStatistics statistics;
  const auto entry = this->Directory->Read(
    ordinal, this->Grid.GetNumberOfBlocks(), this->Blocks->GetSize(), statistics);
  if (!entry.IsOk())
  {
    return entry.GetStatus();
  }
  const auto index = static_cast<std::size_t>(ordinal);
  const int levels = this->Grid.GetNumberOfLevels();
  const std::uint64_t size = entry->FindSegment(this->Segments);
  this->Numbers[index] = entry->Block;
  this->Sizes[index] = BlockRecord::AlignUp(size);
  for (std::size_t segment = 0; segment < this->Segments; ++segment)
  {
    const int level = levels - 1 - static_cast<int>(segment % static_cast<std::size_t>(levels));
    const std::size_t component = segment / static_cast<std::size_t>(levels);
    const BlockSegment samples(this->Grid, entry->Block, level);
    if (entry->Lengths[segment] >
      samples.GetNumberOfSamples() * GetValueSize(this->Variables[component].Type))
    {
      return this->MakeFault(
        "block " + std::to_string(entry->Block) + " has an impossible length in the directory");
    }
  }
  const std::uint64_t padded =
    std::min(this->Sizes[index], this->Blocks->GetSize() - entry->Offset);
  Buffer<std::uint8_t> record(static_cast<std::size_t>(padded));
  ISOSURFACE_RETURN_IF_ERROR(this->Blocks->Read(entry->Offset, record.GetSize(), record.GetData()));
  DecodedBlocks components;
  for (std::size_t component = 0; component < this->Variables.GetNumberOfStored(); ++component)
  {
    components.push_back(
      this->CheckComponent(*entry, ordinal, component, record.GetData(), faults));
  }
  for (std::size_t variable = 0; variable < this->Variables.GetCount(); ++variable)
  {
    const std::shared_ptr<const DecodedBlock> block = this->Find(components, variable);
    if (block)
    {
      this->CheckRange(*block, ordinal, variable, faults);
    }
  }
  const bool isPadded = std::all_of(record.GetData() + size, record.GetData() + padded,
    [](std::uint8_t byte) { return byte == 0; });
  return isPadded ? Status::Ok()
                  : this->MakeFault("block " + std::to_string(entry->Block) +
                      ": the bytes behind its record are not zero");
}

/// The samples of a component; null, and a fault, if they are damaged.
std::shared_ptr<const DecodedBlock> StoreCheck::CheckComponent(const BlockDirectoryEntry& entry,
  std::uint64_t ordinal, std::size_t component, const std::uint8_t* record,
  std::vector<Status>& faults)
{
  const auto levels = static_cast<std::size_t>(this->Grid.GetNumberOfLevels());
  const std::size_t first = component * levels;
  std::vector<const std::uint8_t*> segments;
  std::vector<std::uint32_t> lengths;
  bool isIntact = true;
  for (std::size_t index = 0; index < levels; ++index)
  {
    const std::uint8_t* segment = record + entry.FindSegment(first + index);
    const std::uint32_t stored = entry.Lengths[first + index];
    const Status status = CheckSegment(segment, stored,
      { entry.Block, static_cast<std::uint32_t>(component),
        static_cast<std::uint32_t>(levels - 1 - index) });
    if (!status.IsOk())
    {
      faults.push_back(this->MakeFault(status.GetMessage()));
      isIntact = false;
    }
    this->Checksums[static_cast<std::size_t>(ordinal) * this->Segments + first + index] =
      LoadLittleEndian<std::uint64_t>(segment);
    segments.push_back(segment);
    lengths.push_back(stored);
  }
  if (!isIntact)
  {
    return nullptr;
  }
  const auto block = DecodeLevel(this->Grid, entry.Block, static_cast<std::uint32_t>(component), 0,
    this->Variables[component].Type, segments, lengths);
  if (!block.IsOk())
  {
    faults.push_back(this->MakeFault(block.GetStatus().GetMessage()));
    return nullptr;
  }
  return *block;
}

/// The samples of a variable, of a magnitude if all components are there; else null.
std::shared_ptr<const DecodedBlock> StoreCheck::Find(
  const DecodedBlocks& components, std::size_t variable) const
{
  const Variable& wanted = this->Variables[variable];
  if (!wanted.IsMagnitude())
  {
    return components[variable];
  }
  const auto first =
    components.begin() + static_cast<std::ptrdiff_t>(this->Variables.GetFirst(wanted.Array));
  const DecodedBlocks tuple(first, first + this->Variables.GetComponents(wanted.Array));
  const bool areThere =
    std::all_of(tuple.begin(), tuple.end(), [](const auto& block) { return block != nullptr; });
  return areThere ? MakeMagnitudeBlock(tuple) : nullptr;
}

/// Whether the tree says of a block what its samples are.
void StoreCheck::CheckRange(const DecodedBlock& block, std::uint64_t ordinal, std::size_t variable,
  std::vector<Status>& faults) const
{
  if (this->Ranges[variable].empty())
  {
    return;
  }
  const KeyRange& stated = this->Ranges[variable][static_cast<std::size_t>(ordinal)];
  const KeyRange found = FindSampleRange(block.View, block.View.Box).All;
  if (stated.Minimum != found.Minimum || stated.Maximum != found.Maximum)
  {
    faults.emplace_back(StatusCode::Corrupt,
      this->GetTreePath(variable) + ": the interval of block " + std::to_string(block.Block) +
        " is not the range of its values");
  }
}

void StoreCheck::Finish(std::vector<std::uint8_t>& seen)
{
  if (!this->Directory)
  {
    return;
  }
  std::uint64_t size = 0;
  std::uint64_t checksum = 0;
  bool isComplete = true;
  for (std::size_t ordinal = 0; ordinal < this->Numbers.size(); ++ordinal)
  {
    isComplete = isComplete && this->Numbers[ordinal] >= 0;
    if (this->Numbers[ordinal] >= 0 && !seen.empty())
    {
      std::uint8_t& count = seen[static_cast<std::size_t>(this->Numbers[ordinal])];
      count = static_cast<std::uint8_t>(std::min(2, count + 1));
    }
    size += this->Sizes[ordinal];
    // As BlockStoreWriter chains them.
    std::vector<std::uint64_t> chain = { checksum };
    const auto begin =
      this->Checksums.begin() + static_cast<std::ptrdiff_t>(ordinal * this->Segments);
    chain.insert(chain.end(), begin, begin + static_cast<std::ptrdiff_t>(this->Segments));
    checksum = ComputeChecksum(chain.data(), chain.size() * sizeof(chain[0]));
  }
  if (isComplete && size != this->Blocks->GetSize())
  {
    this->OpenFaults.push_back(this->MakeFault("its records take " + std::to_string(size) +
      " of its " + std::to_string(this->Blocks->GetSize()) + " bytes"));
  }
  if (isComplete && checksum != this->Description.Checksum)
  {
    this->OpenFaults.push_back(
      this->MakeFault("is another store than the header speaks of: its checksum is " +
        FormatChecksum(checksum) + ", not " + FormatChecksum(this->Description.Checksum)));
  }
}

std::vector<Status> StoreCheck::TakeFaults()
{
  std::vector<Status> faults = std::move(this->OpenFaults);
  for (std::vector<Status>& of : this->RunFaults)
  {
    for (Status& fault : of)
    {
      // Runs may share a damaged page of the directory.
      if (faults.empty() || faults.back().GetMessage() != fault.GetMessage())
      {
        faults.push_back(std::move(fault));
      }
    }
  }
  return faults;
}

bool HaveEqualCounts(const WorkloadSpectrum& a, const WorkloadSpectrum& b)
{
  const auto ofA = a.GetQuantities();
  const auto ofB = b.GetQuantities();
  return std::equal(ofA.begin(), ofA.end(), ofB.begin(),
    [](const auto* countsOfA, const auto* countsOfB) { return *countsOfA == *countsOfB; });
}

/// The whole volume with its overviews, a time step after the other.
class VolumeCheck
{
public:
  VolumeCheck(const std::string& path, FileSystem& files, int threads, const Progress& progress)
    : Path(path)
    , Files(files)
    , Threads(threads)
    , Tell(progress)
  {
  }

  Result<VolumeVerification> Run()
  {
    this->Found.Files = 1;
    const auto header = BlockedVolumeHeader::Read(this->Files, this->Path);
    if (!header.IsOk())
    {
      this->AddFault(header.GetStatus());
      return std::move(this->Found);
    }
    std::vector<BlockedVolumeHeader> parts = { *header };
    std::uint64_t blocks = this->CountBlocks(*header);
    for (std::size_t overview = 0; overview < header->Overviews.size(); ++overview)
    {
      parts.push_back(header->MakeOverview(overview));
      blocks += this->CountBlocks(parts.back());
    }
    const double shares =
      static_cast<double>(blocks) * static_cast<double>(header->TimeSteps.size());
    for (std::size_t step = 0; step < header->TimeSteps.size(); ++step)
    {
      for (const BlockedVolumeHeader& part : parts)
      {
        this->PartShare = static_cast<double>(this->CountBlocks(part)) / shares;
        if (!this->CheckTimeStep(part, part.TimeSteps[step]))
        {
          return Status(StatusCode::Aborted, this->Path + ": the check was stopped");
        }
        this->PartBegin += this->PartShare;
      }
    }
    return std::move(this->Found);
  }

private:
  void AddFault(const Status& fault)
  {
    ++this->Found.FaultCount;
    if (this->Found.Faults.size() < VolumeVerification::MostFaults)
    {
      this->Found.Faults.push_back(fault);
    }
  }

  static std::uint64_t CountBlocks(const BlockedVolumeHeader& header)
  {
    return static_cast<std::uint64_t>(header.GetBlockGrid().GetNumberOfBlocks());
  }

  /// Reads all spectra; those of the stores must add up to that of the volume.
  Status CheckSpectra(const BlockedVolumeHeader& header, const TimeStepDescription& step)
  {
    const std::size_t variables = header.GetVariables().GetCount();
    const auto spectra =
      VolumeSpectra::Read(this->Files, this->Path, step.Folder, variables, header.NumberOfStores);
    if (!spectra.IsOk())
    {
      return spectra.GetStatus();
    }
    for (std::size_t variable = 0; variable < variables; ++variable)
    {
      const WorkloadSpectrum& total = *(*spectra)->GetTotal(variable);
      WorkloadSpectrum sum(total.Bins);
      bool hasSum = true;
      for (std::uint32_t store = 0; store < header.NumberOfStores; ++store)
      {
        const auto spectrum = (*spectra)->GetStore(variable, store);
        if (!spectrum.IsOk())
        {
          return spectrum.GetStatus();
        }
        hasSum = sum.Add(**spectrum) && hasSum;
      }
      if (!hasSum || !HaveEqualCounts(sum, total))
      {
        return Status(StatusCode::Corrupt,
          VolumeSpectra::GetPath(this->Path, step.Folder) +
            ": the stores' spectra do not add up to the volume's");
      }
    }
    return Status::Ok();
  }

  /// Of the volume itself, or of an overview. False if it was asked to stop.
  bool CheckTimeStep(const BlockedVolumeHeader& header, const TimeStepDescription& step)
  {
    const BlockGrid grid = header.GetBlockGrid();
    const ArrayVariables variables = header.GetVariables();
    const Status spectra = this->CheckSpectra(header, step);
    this->Found.Files += 1;
    if (!spectra.IsOk())
    {
      this->AddFault(spectra);
    }
    std::vector<std::unique_ptr<StoreCheck>> stores;
    for (std::uint32_t store = 0; store < header.NumberOfStores; ++store)
    {
      stores.push_back(std::make_unique<StoreCheck>(this->Files, variables, grid,
        step.Stores[store], GetStoreFolder(this->Path, step.Folder, store)));
    }
    if (!ParallelFor(
          stores.size(), this->Threads, [&](std::size_t store, int) { stores[store]->Open(); },
          this->MakeProgress(0, 0.05)))
    {
      return false;
    }
    std::vector<std::pair<std::uint32_t, std::uint64_t>> runs;
    for (std::uint32_t store = 0; store < header.NumberOfStores; ++store)
    {
      for (std::uint64_t run = 0; run < stores[store]->GetNumberOfRuns(); ++run)
      {
        runs.emplace_back(store, run);
      }
    }
    if (!ParallelFor(
          runs.size(), this->Threads,
          [&](std::size_t index, int) { stores[runs[index].first]->CheckRun(runs[index].second); },
          this->MakeProgress(0.05, 1)))
    {
      return false;
    }
    this->Join(grid, step, stores);
    return true;
  }

  void Join(const BlockGrid& grid, const TimeStepDescription& step,
    const std::vector<std::unique_ptr<StoreCheck>>& stores)
  {
    std::uint64_t promised = 0;
    for (const StoreDescription& store : step.Stores)
    {
      promised += store.Blocks;
    }
    // Nothing is allocated by what the header says unless the stores have as many blocks.
    const bool areOpen =
      std::all_of(stores.begin(), stores.end(), [](const auto& store) { return store->IsOpen(); });
    const std::size_t count = areOpen ? static_cast<std::size_t>(grid.GetNumberOfBlocks()) : 0;
    const std::uint64_t before = this->Found.FaultCount;
    std::vector<std::uint8_t> seen(count, 0);
    for (const auto& store : stores)
    {
      store->Finish(seen);
      for (const Status& fault : store->TakeFaults())
      {
        this->AddFault(fault);
      }
      this->Found.Files += store->GetFiles();
      this->Found.Bytes += store->GetBytes();
    }
    this->Found.Blocks += promised;
    const bool hasEachOnce =
      std::all_of(seen.begin(), seen.end(), [](std::uint8_t times) { return times == 1; });
    if (this->Found.FaultCount == before && !hasEachOnce)
    {
      this->AddFault(Status(StatusCode::Corrupt,
        this->Path + ": the stores of time step " + step.Folder + " do not have each block once"));
    }
  }

  Progress MakeProgress(double begin, double end) const
  {
    return [this, begin, end](double share)
    {
      return !this->Tell ||
        this->Tell(this->PartBegin + this->PartShare * (begin + (end - begin) * share));
    };
  }

  std::string Path;
  FileSystem& Files;
  int Threads;
  const Progress& Tell;
  double PartBegin = 0;
  double PartShare = 1;
  VolumeVerification Found;
};

} // namespace

Result<VolumeVerification> VerifyBlockedVolume(
  const std::string& path, FileSystem& files, int threads, const Progress& progress)
{
  return VolumeCheck(path, files, threads, progress).Run();
}

} // namespace isosurface
