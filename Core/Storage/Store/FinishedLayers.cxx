// SPDX-License-Identifier: BSD-3-Clause
#include "Storage/Store/FinishedLayers.h"

#include "Ground/Base/Fingerprint.h"
#include "Ground/Volume/SampleCopy.h"
#include "Ground/Volume/SampleRange.h"
#include "Storage/Record/BlockRecord.h"

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
    auto owned = std::make_shared<DecodedBlocks>();
    BlockSamples samples;
    const Variable& variable = this->Variables[this->VariableNumber];
    const std::size_t first = this->Variables.GetFirst(variable.Array);
    const bool isMagnitude = variable.IsMagnitude();
    const std::size_t begin = isMagnitude ? first : this->VariableNumber;
    const std::size_t end = isMagnitude
      ? first + static_cast<std::size_t>(this->Variables.GetComponents(variable.Array))
      : begin + 1;
    ISOSURFACE_RETURN_IF_ERROR(this->ReadComponents(this->Numbers[block], begin, end, *owned));
    if (isMagnitude)
    {
      owned->push_back(MakeMagnitudeBlock(*owned));
    }
    samples.Scalars = owned->back()->View;
    for (const std::size_t array : this->Attributes)
    {
      const std::size_t count = owned->size();
      const std::size_t from = this->Variables.GetFirst(array);
      ISOSURFACE_RETURN_IF_ERROR(this->ReadComponents(this->Numbers[block], from,
        from + static_cast<std::size_t>(this->Variables.GetComponents(array)), *owned));
      AttributeView& attribute = samples.Attributes.emplace_back();
      for (std::size_t component = count; component < owned->size(); ++component)
      {
        attribute.Components.push_back((*owned)[component]->View);
      }
    }
    samples.Owner = std::move(owned);
    return samples;
  }

private:
  /// Adds components [begin, end) of a block.
  Status ReadComponents(
    std::int64_t number, std::size_t begin, std::size_t end, DecodedBlocks& blocks) const
  {
    for (std::size_t component = begin; component < end; ++component)
    {
      auto block = std::make_shared<DecodedBlock>();
      block->Block = number;
      const VertexBox box = this->Layers.Grid.GetGhostedVertices(number, 0);
      const ValueType type = this->Layers.Samples->GetType(component);
      block->Bytes = Buffer<std::uint8_t>(
        static_cast<std::size_t>(box.GetNumberOfVertices()) * GetValueSize(type));
      block->View = MakeSampleView(type, box, block->Bytes.GetData());
      block->View.Box = this->Layers.Grid.GetVertices(number);
      QueryStatistics statistics;
      ISOSURFACE_RETURN_IF_ERROR(
        this->Layers.Samples->Read(component, box, block->Bytes.GetData(), statistics));
      blocks.push_back(std::move(block));
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

void FinishedLayers::Add(std::int64_t blocks, const std::vector<std::vector<KeyRange>>& ranges)
{
  const std::lock_guard<std::mutex> lock(this->Mutex);
  this->Ranges.resize(ranges.size());
  for (std::size_t variable = 0; variable < ranges.size(); ++variable)
  {
    std::vector<KeyRange>& mine = this->Ranges[variable];
    mine.insert(mine.end(), ranges[variable].begin() + static_cast<std::ptrdiff_t>(mine.size()),
      ranges[variable].begin() + blocks);
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
  const auto layers =
    static_cast<std::int64_t>(this->Ranges.front().size()) / (blocks[0] * blocks[1]);
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
  if (!this->Samples)
  {
    auto samples = SourceSamples::Open(
      this->Files, this->Opener, this->Path, this->Header, 0, this->Dataset, this->Cache);
    ISOSURFACE_RETURN_IF_ERROR(samples.GetStatus());
    this->Samples = std::move(*samples);
  }
  return Status::Ok();
}

Result<std::unique_ptr<BlockSource>> FinishedLayers::FindBlocks(
  const BlockQuery& query, const std::vector<std::size_t>& attributes, std::int64_t slices)
{
  const std::lock_guard<std::mutex> lock(this->Mutex);
  ISOSURFACE_RETURN_IF_ERROR(this->OpenSamples());
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
  return std::unique_ptr<BlockSource>(
    std::make_unique<Blocks>(*this, query.Variable, attributes, std::move(blocks)));
}

} // namespace isosurface
