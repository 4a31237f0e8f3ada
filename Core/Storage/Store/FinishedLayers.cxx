// SPDX-License-Identifier: BSD-3-Clause
#include "Storage/Store/FinishedLayers.h"

#include "Ground/Base/Fingerprint.h"
#include "Ground/Volume/SampleCopy.h"
#include "Ground/Volume/SampleRange.h"
#include "Storage/Record/BlockRecord.h"
#include "Storage/Store/StoredBlockSource.h"

#include <algorithm>
#include <utility>

namespace isosurface
{
namespace
{

/// A dataset of the block cache that nobody else has.
std::uint64_t MakeDataset(const std::string& path)
{
  static std::atomic<std::uint64_t> count = 0;
  Fingerprint fingerprint;
  fingerprint.AddText(path + ", unfinished");
  fingerprint.AddNumber(++count);
  return fingerprint.Get();
}

} // namespace

/// Some blocks, gathered from the source.
class FinishedLayers::Blocks : public BlockSource
{
public:
  Blocks(FinishedLayers& layers, std::size_t variable, std::vector<std::size_t> attributes,
    std::vector<std::int64_t> blocks)
    : Layers(layers)
    , Variables(layers.Header.GetVariables())
    , VariableNumber(variable)
    , Attributes(std::move(attributes))
    , Numbers(std::move(blocks))
  {
  }

  std::size_t GetNumberOfBlocks() const override { return this->Numbers.size(); }
  Index3 GetLatticeCoordinates(std::size_t block) const override
  {
    return this->Layers.Grid.GetBlockCoordinates(this->Numbers[block]);
  }
  VertexBox GetVertices(std::size_t block) const override
  {
    return this->Layers.Grid.GetVertices(this->Numbers[block]);
  }
  ValueType GetValueType() const override { return this->Variables[this->VariableNumber].Type; }

  Result<BlockSamples> Acquire(std::size_t block) override
  {
    DecodedBlocks blocks;
    ISOSURFACE_RETURN_IF_ERROR(this->Read(this->Numbers[block], this->VariableNumber, blocks));
    for (const std::size_t array : this->Attributes)
    {
      ISOSURFACE_RETURN_IF_ERROR(this->ReadArray(this->Numbers[block], array, blocks));
    }
    return MakeBlockSamples(std::move(blocks), this->Variables, this->Attributes);
  }

private:
  /// Adds a variable of a block.
  Status Read(std::int64_t number, std::size_t variable, DecodedBlocks& blocks) const
  {
    if (this->Variables[variable].IsMagnitude())
    {
      DecodedBlocks components;
      ISOSURFACE_RETURN_IF_ERROR(
        this->ReadArray(number, this->Variables[variable].Array, components));
      blocks.push_back(MakeMagnitudeBlock(components));
      return Status::Ok();
    }
    const ValueType type = this->Variables[variable].Type;
    const VertexBox box = this->Layers.Grid.GetGhostedVertices(number, 0);
    auto block = std::make_shared<DecodedBlock>();
    block->Block = number;
    block->Bytes = Buffer<std::uint8_t>(
      static_cast<std::size_t>(box.GetNumberOfVertices()) * GetValueSize(type));
    block->View = MakeSampleView(type, box, block->Bytes.GetData());
    block->View.Box = this->Layers.Grid.GetVertices(number);
    QueryStatistics statistics;
    ISOSURFACE_RETURN_IF_ERROR(
      this->Layers.Samples->Read(variable, box, block->Bytes.GetData(), statistics));
    blocks.push_back(std::move(block));
    return Status::Ok();
  }

  /// Adds the components of an array.
  Status ReadArray(std::int64_t number, std::size_t array, DecodedBlocks& blocks) const
  {
    const std::size_t first = this->Variables.GetFirst(array);
    const auto count = static_cast<std::size_t>(this->Variables.GetComponents(array));
    for (std::size_t component = first; component < first + count; ++component)
    {
      ISOSURFACE_RETURN_IF_ERROR(this->Read(number, component, blocks));
    }
    return Status::Ok();
  }

  FinishedLayers& Layers;
  const ArrayVariables Variables;
  const std::size_t VariableNumber;
  const std::vector<std::size_t> Attributes; ///< arrays
  const std::vector<std::int64_t> Numbers;   ///< of blocks
};

FinishedLayers::FinishedLayers(FileSystem& files, VolumeOpener opener, std::string path)
  : Files(files)
  , Opener(opener)
  , Path(std::move(path))
  , Cache(BlockCache::GetProcessCache())
  , Dataset(MakeDataset(this->Path))
{
  this->Cache->Retain(this->Dataset);
}

FinishedLayers::~FinishedLayers()
{
  this->Cache->Release(this->Dataset);
}

void FinishedLayers::Begin(BlockedVolumeHeader header)
{
  this->Header = std::move(header);
  this->Grid = this->Header.GetBlockGrid();
}

void FinishedLayers::Add(const std::vector<std::vector<KeyRange>>& ranges)
{
  const std::lock_guard<std::mutex> lock(this->Mutex);
  this->Ranges.resize(ranges.size());
  for (std::size_t variable = 0; variable < ranges.size(); ++variable)
  {
    this->Ranges[variable].insert(
      this->Ranges[variable].end(), ranges[variable].begin(), ranges[variable].end());
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

std::shared_ptr<const void> FinishedLayers::Show()
{
  const std::lock_guard<std::mutex> lock(this->Mutex);
  std::shared_ptr<const void> shown = this->Shown.lock();
  if (!shown)
  {
    shown = std::make_shared<const bool>(true);
    this->Shown = shown;
  }
  return shown;
}

bool FinishedLayers::AreShown() const
{
  const std::lock_guard<std::mutex> lock(this->Mutex);
  return !this->Shown.expired();
}

Status FinishedLayers::OpenSamples()
{
  const std::lock_guard<std::mutex> lock(this->OpeningMutex);
  if (!this->Samples)
  {
    auto samples = SourceSamples::Open(
      this->Files, this->Opener, this->Path, this->Header, 0, this->Dataset, this->Cache);
    ISOSURFACE_RETURN_IF_ERROR(samples.GetStatus());
    this->Samples = std::move(*samples);
  }
  return Status::Ok();
}

Result<std::unique_ptr<BlockSource>> FinishedLayers::FindBlocks(const BlockQuery& query,
  const std::vector<std::size_t>& attributes, std::int64_t slices, std::size_t part,
  std::size_t parts)
{
  ISOSURFACE_RETURN_IF_ERROR(this->OpenSamples());
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
  const auto find = [&](std::size_t first)
  { return blocks.begin() + static_cast<std::ptrdiff_t>(blocks.size() * first / parts); };
  return std::unique_ptr<BlockSource>(std::make_unique<Blocks>(
    *this, query.Variable, attributes, std::vector<std::int64_t>(find(part), find(part + 1))));
}

} // namespace isosurface
