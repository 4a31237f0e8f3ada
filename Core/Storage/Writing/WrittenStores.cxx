// SPDX-License-Identifier: BSD-3-Clause
#include "Storage/Writing/WrittenStores.h"

#include "Storage/Store/BlockStore.h"
#include "Storage/Writing/OverviewSamples.h"

#include <algorithm>
#include <utility>

namespace isosurface
{

Status ReplicateStore(FileSystem& files, const std::string& path, const BlockedVolumeHeader& header,
  std::uint32_t store)
{
  const ArrayVariables variables = header.GetVariables();
  const std::string& generation = header.TimeSteps.back().Folder;
  const std::uint32_t stores = header.NumberOfStores;
  const std::vector<std::string> originals =
    BlockStore::ListPaths(GetStoreFolder(files, path, generation, store), variables);
  for (std::uint32_t replica = 1; replica < header.NumberOfReplicas; ++replica)
  {
    const std::string folder = GetReplicaFolder(files, path, generation, store, replica, stores);
    ISOSURFACE_RETURN_IF_ERROR(files.MakeDirectories(folder));
    const std::vector<std::string> copies = BlockStore::ListPaths(folder, variables);
    for (std::size_t file = 0; file < copies.size(); ++file)
    {
      ISOSURFACE_RETURN_IF_ERROR(CopyFile(files, originals[file], files, copies[file]));
    }
    ISOSURFACE_RETURN_IF_ERROR(files.SyncDirectory(folder));
    ISOSURFACE_RETURN_IF_ERROR(files.SyncDirectory(
      GetStoreFolder(files, path, generation, FindHost(store, replica, stores))));
  }
  return Status::Ok();
}

std::size_t WrittenStores::CountSegments(const BlockedVolumeHeader& header)
{
  return header.GetVariables().GetStoredTypes().size() *
    static_cast<std::size_t>(header.GetBlockGrid().GetNumberOfLevels());
}

WrittenStores::WrittenStores(const WriteContext& context, const BlockedVolumeHeader& header,
  const std::vector<std::uint32_t>& blockStores, bool hasCoarser, bool hasJournal)
  : Context(context)
  , Header(header)
  , BlockStores(blockStores)
  , HasCoarser(hasCoarser)
  , HasJournal(hasJournal)
  , Grid(header.GetBlockGrid())
  , Variables(header.GetVariables())
  , Segments(CountSegments(header))
{
}

std::vector<std::size_t> WrittenStores::CountBlocks(std::int64_t end) const
{
  std::vector<std::size_t> blocks(this->Header.NumberOfStores, 0);
  for (std::int64_t block = 0; block < end; ++block)
  {
    ++blocks[this->BlockStores[static_cast<std::size_t>(block)]];
  }
  return blocks;
}

Status WrittenStores::Create()
{
  const std::vector<std::size_t> blocks = this->CountBlocks(this->Grid.GetNumberOfBlocks());
  for (std::uint32_t store = 0; store < this->Header.NumberOfStores; ++store)
  {
    if (!this->Context.IsMine(store))
    {
      continue;
    }
    OpenStore& open = this->Stores[store];
    ISOSURFACE_ASSIGN_OR_RETURN(open.Writer,
      BlockStoreWriter::Create(this->Context.Files, this->GetStorePath(store), this->Segments,
        blocks[store], this->GetSamplePlace()));
    if (this->HasCoarser)
    {
      ISOSURFACE_ASSIGN_OR_RETURN(open.OverviewSamples,
        this->Context.Files.CreateForWriting(OverviewSource::GetPath(this->GetFolder(), store)));
    }
    if (this->HasJournal)
    {
      open.Journal = std::make_unique<StoreJournal>(this->Context.Files, this->GetStorePath(store));
    }
  }
  return Status::Ok();
}

Status WrittenStores::Take(const WriteJournal& journal, BlockCounts& counts)
{
  if (journal.Blocks > this->Grid.GetNumberOfBlocks())
  {
    return Status(StatusCode::Corrupt, "the journal has too many blocks");
  }
  const std::vector<std::size_t> blocks = this->CountBlocks(journal.Blocks);
  for (std::uint32_t store = 0; store < this->Header.NumberOfStores; ++store)
  {
    if (this->Context.IsMine(store))
    {
      ISOSURFACE_RETURN_IF_ERROR(this->TakeOne(store, blocks[store], journal.Checkpoint, counts));
    }
  }
  return Status::Ok();
}

Status WrittenStores::TakeOne(
  std::uint32_t store, std::size_t blocks, std::int64_t checkpoint, BlockCounts& counts)
{
  OpenStore& open = this->Stores[store];
  FileSystem& files = this->Context.Files;
  open.Journal = std::make_unique<StoreJournal>(files, this->GetStorePath(store));
  std::vector<BlockDirectoryEntry> entries;
  ISOSURFACE_ASSIGN_OR_RETURN(
    const auto taken, open.Journal->Take(checkpoint, this->Segments, entries, counts.GetRanges()));
  const bool isMine = std::all_of(entries.begin(), entries.end(),
    [&](const BlockDirectoryEntry& entry)
    { return this->BlockStores[static_cast<std::size_t>(entry.Block)] == store; });
  if (!isMine || entries.size() != blocks || !counts.GetSpectra().UnpackSums(store, taken.Spectra))
  {
    return Status(StatusCode::Corrupt, this->GetStorePath(store) + ": its journal is of others");
  }
  counts.AddFiniteRanges(taken.FiniteRanges);
  if (this->HasCoarser)
  {
    ISOSURFACE_RETURN_IF_ERROR(this->TakeOverviewSamples(store, entries, taken));
  }
  ISOSURFACE_ASSIGN_OR_RETURN(open.Writer,
    BlockStoreWriter::Open(files, this->GetStorePath(store), this->Segments,
      this->CountBlocks(this->Grid.GetNumberOfBlocks())[store], this->GetSamplePlace(),
      std::move(entries), taken));
  return Status::Ok();
}

Status WrittenStores::TakeOverviewSamples(std::uint32_t store,
  const std::vector<BlockDirectoryEntry>& entries, const StoreCheckpoint& checkpoint)
{
  const std::size_t vertexBytes = SumValueSizes(this->Variables.GetStoredTypes());
  std::vector<std::uint64_t> ends;
  for (const BlockDirectoryEntry& entry : entries)
  {
    const VertexBox part = FindOverviewPart(this->Grid, entry.Block);
    ends.push_back((ends.empty() ? 0 : ends.back()) +
      static_cast<std::uint64_t>(part.GetNumberOfVertices()) * vertexBytes);
  }
  const std::string path = OverviewSource::GetPath(this->GetFolder(), store);
  OpenStore& open = this->Stores[store];
  open.OverviewSum = AppendedSum(checkpoint.OverviewSum);
  ISOSURFACE_RETURN_IF_ERROR(open.OverviewSum.Check(this->Context.Files, path, ends));
  ISOSURFACE_ASSIGN_OR_RETURN(
    open.OverviewSamples, this->Context.Files.OpenForAppending(path, checkpoint.OverviewBytes));
  return Status::Ok();
}

Status WrittenStores::Append(const PendingBlock& block)
{
  OpenStore& store = this->Stores.at(block.Store);
  if (store.OverviewSamples)
  {
    store.OverviewSum.Add(block.OverviewSamples.data(), block.OverviewSamples.size());
    ISOSURFACE_RETURN_IF_ERROR(
      store.OverviewSamples->Append(block.OverviewSamples.data(), block.OverviewSamples.size()));
  }
  return store.Writer->Append(block);
}

void WrittenStores::FindRecords(std::int64_t begin, std::int64_t end,
  std::map<std::string, std::vector<BlockDirectoryEntry>>& records) const
{
  const auto isBefore = [](const BlockDirectoryEntry& entry, std::int64_t block)
  { return entry.Block < block; };
  for (const auto& [store, open] : this->Stores)
  {
    const std::vector<BlockDirectoryEntry>& all = open.Writer->GetEntries();
    const auto first = std::lower_bound(all.begin(), all.end(), begin, isBefore);
    const auto last = std::lower_bound(first, all.end(), end, isBefore);
    if (first != last)
    {
      std::vector<BlockDirectoryEntry>& found = records[this->GetStorePath(store)];
      found.insert(found.end(), first, last);
    }
  }
}

Status WrittenStores::AddCheckpoints(std::int64_t number, const BlockCounts& counts) const
{
  StoreCheckpoint checkpoint;
  checkpoint.FiniteRanges = counts.JoinFiniteRanges();
  for (const auto& [store, open] : this->Stores)
  {
    ISOSURFACE_RETURN_IF_ERROR(open.Writer->Sync());
    checkpoint.BlocksBytes = open.Writer->GetBytes();
    checkpoint.BlocksChecksum = open.Writer->GetChecksum();
    checkpoint.BlocksSum = open.Writer->GetSum().Get();
    if (open.OverviewSamples)
    {
      ISOSURFACE_RETURN_IF_ERROR(open.OverviewSamples->Sync());
      checkpoint.OverviewBytes = open.OverviewSamples->GetSize();
      checkpoint.OverviewSum = open.OverviewSum.Get();
    }
    checkpoint.Spectra = counts.GetSpectra().PackSums(store);
    ISOSURFACE_RETURN_IF_ERROR(
      open.Journal->Add(number, checkpoint, open.Writer->GetEntries(), counts.GetRanges()));
  }
  return Status::Ok();
}

std::vector<std::uint32_t> WrittenStores::GetNumbers() const
{
  std::vector<std::uint32_t> numbers;
  for (const auto& store : this->Stores)
  {
    numbers.push_back(store.first);
  }
  return numbers;
}

Result<StoreDescription> WrittenStores::Finish(
  std::uint32_t number, BlockCounts& counts, std::size_t memoryBytes)
{
  OpenStore& store = this->Stores.at(number);
  if (!counts.GetSpectra().FinishStore(number, store.Writer->GetEntries(), counts.GetRanges()))
  {
    // Samples of coarser levels and checkpoints come from the disk.
    return Status(StatusCode::Corrupt, this->GetFolder() + ": its temporary files are damaged");
  }
  ISOSURFACE_ASSIGN_OR_RETURN(
    auto description, store.Writer->Finish(this->Variables, counts.GetRanges(), memoryBytes));
  if (store.OverviewSamples)
  {
    ISOSURFACE_RETURN_IF_ERROR(store.OverviewSamples->SyncAndClose());
  }
  store = OpenStore{};
  return description;
}

Status WrittenStores::RemoveTemporaryFiles() const
{
  for (const auto& store : this->Stores)
  {
    ISOSURFACE_RETURN_IF_ERROR(
      this->Context.Files.RemoveAll(OverviewSource::GetPath(this->GetFolder(), store.first)));
    if (this->HasJournal)
    {
      ISOSURFACE_RETURN_IF_ERROR(
        StoreJournal::Remove(this->Context.Files, this->GetStorePath(store.first)));
    }
  }
  return Status::Ok();
}

} // namespace isosurface
