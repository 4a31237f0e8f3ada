// SPDX-License-Identifier: BSD-3-Clause
#include "Storage/Store/FinishedLayers.h"

#include "Ground/Volume/SampleCopy.h"
#include "Ground/Volume/SampleRange.h"
#include "Storage/Record/BlockRecord.h"
#include "Storage/Store/StoreRecords.h"
#include "Storage/Store/StoredBlockSource.h"

#include <algorithm>
#include <chrono>
#include <iterator>
#include <thread>
#include <utility>

namespace isosurface
{
/// Some blocks.
class FinishedLayers::Blocks : public BlockSource
{
public:
  /// `box`: what they are cut to.
  Blocks(const BlockedVolumeHeader& header, std::size_t variable,
    std::vector<std::size_t> attributes, std::vector<std::int64_t> blocks, const VertexBox& box,
    ReadComponents read)
    : Grid(header.GetBlockGrid())
    , Variables(header.GetVariables())
    , VariableNumber(variable)
    , Attributes(std::move(attributes))
    , Numbers(std::move(blocks))
    , Box(box)
    , Read(std::move(read))
  {
  }

  std::size_t GetNumberOfBlocks() const override { return this->Numbers.size(); }
  Index3 GetLatticeCoordinates(std::size_t block) const override
  {
    return this->Grid.GetBlockCoordinates(this->Numbers[block]);
  }
  VertexBox GetVertices(std::size_t block) const override
  {
    return this->Grid.GetVertices(this->Numbers[block]).Intersect(this->Box);
  }
  ValueType GetValueType() const override { return this->Variables[this->VariableNumber].Type; }

  Result<BlockSamples> Acquire(std::size_t block) override
  {
    const std::int64_t number = this->Numbers[block];
    const Variable& contoured = this->Variables[this->VariableNumber];
    auto blocks = contoured.IsMagnitude() ? this->ReadArray(number, contoured.Array)
                                          : this->Read(number, this->VariableNumber, 1);
    ISOSURFACE_RETURN_IF_ERROR(blocks.GetStatus());
    if (contoured.IsMagnitude())
    {
      *blocks = { MakeMagnitudeBlock(*blocks) };
    }
    for (const std::size_t array : this->Attributes)
    {
      ISOSURFACE_ASSIGN_OR_RETURN(auto components, this->ReadArray(number, array));
      blocks->insert(blocks->end(), components.begin(), components.end());
    }
    return MakeBlockSamples(std::move(*blocks), this->Variables, this->Attributes);
  }

private:
  Result<DecodedBlocks> ReadArray(std::int64_t number, std::size_t array) const
  {
    return this->Read(number, this->Variables.GetFirst(array),
      static_cast<std::size_t>(this->Variables.GetComponents(array)));
  }

  const BlockGrid Grid;
  const ArrayVariables Variables;
  const std::size_t VariableNumber;
  const std::vector<std::size_t> Attributes; ///< arrays
  const std::vector<std::int64_t> Numbers;   ///< of blocks
  const VertexBox Box;
  const ReadComponents Read;
};

FinishedLayers::FinishedLayers(FileSystem& files, VolumeOpener opener, std::string path,
  const GridPlace& place, std::function<bool()> mayRead)
  : Files(files)
  , Opener(opener)
  , Path(std::move(path))
  , Place(place)
  , MayReadBoxes(std::move(mayRead))
{
}

void FinishedLayers::Begin(const BlockedVolumeHeader& planned)
{
  this->Header = planned;
  // The sample, which is shown before, has told of an impossible one.
  static_cast<void>(this->Place.Apply(this->Path, planned.Lines.has_value(), this->Header.Grid));
  this->Grid = planned.GetBlockGrid();
  this->HasBegun = true;
}

void FinishedLayers::LookAlong(const Sight& sight)
{
  const std::lock_guard<std::mutex> lock(this->Mutex);
  this->Sighted = sight;
}

std::optional<Sight> FinishedLayers::GetSight() const
{
  const std::lock_guard<std::mutex> lock(this->Mutex);
  return this->Sighted;
}

void FinishedLayers::Add(const BlockedVolumeHeader& volume, FinishedBlocks blocks)
{
  const std::lock_guard<std::mutex> lock(this->Mutex);
  if (this->Ranges.empty() && !this->HasBegun)
  {
    this->Begin(volume);
  }
  for (auto& [folder, entries] : blocks.Records)
  {
    std::vector<BlockDirectoryEntry>& all = this->Records[folder];
    std::move(entries.begin(), entries.end(), std::back_inserter(all));
  }
  this->Ranges.resize(blocks.Ranges.size());
  for (std::size_t variable = 0; variable < blocks.Ranges.size(); ++variable)
  {
    this->Ranges[variable].insert(
      this->Ranges[variable].end(), blocks.Ranges[variable].begin(), blocks.Ranges[variable].end());
  }
}

std::int64_t FinishedLayers::CountSlices() const
{
  const std::lock_guard<std::mutex> lock(this->Mutex);
  if (this->Ranges.empty())
  {
    return 0;
  }
  const Index3& blocks = this->Grid.GetNumberOfBlocksPerAxis();
  // Not all have as many if there was no memory for one.
  const auto least = std::min_element(this->Ranges.begin(), this->Ranges.end(),
    [](const auto& one, const auto& other) { return one.size() < other.size(); });
  const auto layers = static_cast<std::int64_t>(least->size()) / (blocks[0] * blocks[1]);
  return std::min(layers * this->Grid.GetBlockSize(), this->Grid.GetDimensions()[2] - 1);
}

Status FinishedLayers::OpenSamples()
{
  const std::lock_guard<std::mutex> lock(this->OpeningMutex);
  if (!this->Samples)
  {
    ISOSURFACE_ASSIGN_OR_RETURN(this->Samples,
      SourceSamples::Open(this->Files, this->Opener, this->Path,
        *this->Header.TimeSteps.back().Source, this->Header.Grid, this->Header.Arrays,
        BlockCache::GetProcessCache()));
  }
  return Status::Ok();
}

Result<DecodedBlocks> FinishedLayers::Gather(
  std::int64_t block, std::size_t first, std::size_t count, const VertexBox* part) const
{
  DecodedBlocks blocks;
  QueryStatistics statistics;
  for (std::size_t component = first; component < first + count; ++component)
  {
    ISOSURFACE_ASSIGN_OR_RETURN(
      auto read, this->Samples->ReadBlock(component, this->Grid, block, 0, statistics, part));
    blocks.push_back(std::move(read));
  }
  return blocks;
}

Result<FinishedLayers::ReadComponents> FinishedLayers::OpenRecords(
  std::vector<std::int64_t>& blocks) const
{
  struct Record
  {
    std::shared_ptr<StoreRecords> Store;
    BlockDirectoryEntry Entry;
  };
  std::map<std::string, std::vector<BlockDirectoryEntry>> wanted; // by the folders of stores
  {
    const std::lock_guard<std::mutex> lock(this->Mutex);
    for (const auto& [folder, all] : this->Records)
    {
      std::vector<BlockDirectoryEntry> found;
      std::copy_if(all.begin(), all.end(), std::back_inserter(found),
        [&](const BlockDirectoryEntry& entry)
        { return std::binary_search(blocks.begin(), blocks.end(), entry.Block); });
      if (!found.empty())
      {
        wanted[folder] = std::move(found);
      }
    }
  }
  const auto records = std::make_shared<std::map<std::int64_t, Record>>(); // by block
  for (auto& [folder, entries] : wanted)
  {
    ISOSURFACE_ASSIGN_OR_RETURN(auto store, StoreRecords::Open(this->Files, folder, this->Header));
    const std::shared_ptr<StoreRecords> shared = std::move(store);
    for (BlockDirectoryEntry& entry : entries)
    {
      const std::int64_t block = entry.Block;
      records->insert({ block, { shared, std::move(entry) } });
    }
  }
  blocks.clear();
  for (const auto& [block, record] : *records)
  {
    blocks.push_back(block);
  }
  return ReadComponents(
    [records](std::int64_t block, std::size_t first, std::size_t count)
    {
      const Record& record = records->at(block);
      QueryStatistics statistics;
      return record.Store->Read(record.Entry, first, count, 0, statistics);
    });
}

std::vector<std::int64_t> FinishedLayers::SelectBlocks(
  const BlockQuery& query, std::int64_t slices) const
{
  const std::lock_guard<std::mutex> lock(this->Mutex);
  const std::vector<ValueKey> thresholds =
    FindThresholdKeys(this->Header.GetVariables()[query.Variable].Type, query.Isovalues);
  BlockSelection selection = query.Selection;
  selection.Lines = this->Header.Lines ? &*this->Header.Lines : nullptr;
  const std::vector<KeyRange>& ranges = this->Ranges[query.Variable];
  std::vector<std::int64_t> blocks;
  for (std::size_t block = 0; block < ranges.size(); ++block)
  {
    const KeyRange& range = ranges[block];
    const auto number = static_cast<std::int64_t>(block);
    const bool isActive = std::any_of(thresholds.begin(), thresholds.end(),
      [&](ValueKey threshold) { return range.Straddles(threshold); });
    const bool isInside = !range.IsEmpty() &&
      std::any_of(thresholds.begin(), thresholds.end(),
        [&](ValueKey threshold) { return threshold <= range.Minimum; });
    const VertexBox vertices = this->Grid.GetVertices(number);
    if ((isActive || isInside) && vertices.Low[2] < slices &&
      selection.Selects(this->Header.Grid, vertices, isActive))
    {
      blocks.push_back(number);
    }
  }
  return blocks;
}

Result<std::unique_ptr<BlockSource>> FinishedLayers::FindBlocks(const BlockQuery& query,
  const std::vector<std::size_t>& attributes, std::int64_t slices, std::size_t part,
  std::size_t parts)
{
  std::vector<std::int64_t> blocks = this->SelectBlocks(query, slices);
  ReadComponents read;
  if (this->Header.IsInPlace())
  {
    ISOSURFACE_RETURN_IF_ERROR(this->OpenSamples());
    const auto find = [&](std::size_t place)
    { return blocks.begin() + static_cast<std::ptrdiff_t>(blocks.size() * place / parts); };
    blocks = std::vector<std::int64_t>(find(part), find(part + 1));
    read = [this](std::int64_t block, std::size_t first, std::size_t count)
    { return this->Gather(block, first, count); };
  }
  else
  {
    ISOSURFACE_ASSIGN_OR_RETURN(read, this->OpenRecords(blocks));
  }
  return std::unique_ptr<BlockSource>(
    std::make_unique<Blocks>(this->Header, query.Variable, attributes, std::move(blocks),
      VertexBox{ { 0, 0, 0 }, this->Grid.GetDimensions() }, std::move(read)));
}

std::vector<std::int64_t> FinishedLayers::SelectBlocksIn(
  const BlockQuery& query, const VertexBox& box) const
{
  const std::lock_guard<std::mutex> lock(this->Mutex);
  const std::vector<ValueKey> thresholds =
    FindThresholdKeys(this->Header.GetVariables()[query.Variable].Type, query.Isovalues);
  BlockSelection selection = query.Selection;
  selection.Lines = this->Header.Lines ? &*this->Header.Lines : nullptr;
  const std::size_t known = this->Ranges.empty() ? 0 : this->Ranges[query.Variable].size();
  const std::int64_t side = this->Grid.GetBlockSize();
  VertexBox wanted; // blocks, by their coordinates
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    wanted.Low[axis] = box.Low[axis] / side;
    wanted.High[axis] = (box.High[axis] - 2) / side + 1;
  }
  std::vector<std::int64_t> blocks;
  VisitVertices(wanted,
    [&](const Index3& coordinates)
    {
      const std::int64_t block = this->Grid.GetBlockIndex(coordinates);
      const auto number = static_cast<std::size_t>(block);
      const bool isActive = number >= known ||
        std::any_of(thresholds.begin(), thresholds.end(),
          [&](ValueKey threshold)
          { return this->Ranges[query.Variable][number].Straddles(threshold); });
      if (selection.Selects(this->Header.Grid, this->Grid.GetVertices(block), isActive))
      {
        blocks.push_back(block);
      }
    });
  return blocks;
}

void FinishedLayers::WaitForBoxes() const
{
  constexpr std::chrono::milliseconds pause{ 5 };
  while (this->ReadBoxes > 0)
  {
    std::this_thread::sleep_for(pause);
  }
}

Result<std::unique_ptr<BlockSource>> FinishedLayers::FindBox(const BlockQuery& query,
  const std::vector<std::size_t>& attributes, const VertexBox& box, std::size_t part,
  std::size_t parts, int threads)
{
  const std::vector<std::int64_t> all = this->SelectBlocksIn(query, box);
  ISOSURFACE_RETURN_IF_ERROR(this->OpenSamples());
  const auto find = [&](std::size_t place)
  { return all.begin() + static_cast<std::ptrdiff_t>(all.size() * place / parts); };
  std::vector<std::int64_t> blocks(find(part), find(part + 1));
  if (!blocks.empty())
  {
    const auto end = +[](std::atomic<int>* count) { --*count; };
    ++this->ReadBoxes;
    const std::unique_ptr<std::atomic<int>, decltype(end)> reading(&this->ReadBoxes, end);
    VertexBox mine = this->Grid.GetVertices(blocks.front());
    for (const std::int64_t block : blocks)
    {
      mine.Extend(this->Grid.GetVertices(block));
    }
    mine = mine.AddLayer(box).Intersect(box);
    const ArrayVariables variables = this->Header.GetVariables();
    std::vector<std::size_t> arrays = attributes;
    arrays.push_back(variables[query.Variable].Array);
    for (const std::size_t array : arrays)
    {
      ISOSURFACE_RETURN_IF_ERROR(this->Samples->Decode(variables.GetFirst(array), mine, threads));
    }
  }
  return std::unique_ptr<BlockSource>(
    std::make_unique<Blocks>(this->Header, query.Variable, attributes, std::move(blocks), box,
      [this, box](std::int64_t block, std::size_t first, std::size_t count)
      { return this->Gather(block, first, count, &box); }));
}

} // namespace isosurface
