// SPDX-License-Identifier: BSD-3-Clause
#include "Storage/Writing/OverviewSamples.h"

#include "Storage/Record/BlockRecord.h"
#include "Storage/Record/BlockSegment.h"

#include <algorithm>
#include <utility>

namespace isosurface
{

VertexBox FindOverviewPart(const BlockGrid& finer, std::int64_t block)
{
  const Index3 coordinates = finer.GetBlockCoordinates(block);
  VertexBox part = finer.GetVertices(block, finer.GetNumberOfLevels());
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    // The shared face belongs to the next block.
    part.High[axis] -= coordinates[axis] + 1 < finer.GetNumberOfBlocksPerAxis()[axis] ? 1 : 0;
  }
  return part;
}

std::vector<std::uint8_t> PickOverviewSamples(
  const BlockGrid& finer, const std::vector<ValueType>& types, const PendingBlock& block)
{
  // The record's coarsest level is stored as a whole; the overview has every second vertex of it.
  const int levels = finer.GetNumberOfLevels();
  const VertexBox box = BlockSegment(finer, block.Block, levels - 1).GetBox();
  const VertexBox part = FindOverviewPart(finer, block.Block);
  std::vector<std::uint8_t> samples(
    static_cast<std::size_t>(part.GetNumberOfVertices()) * SumValueSizes(types));
  std::uint8_t* to = samples.data();
  for (std::size_t array = 0; array < types.size(); ++array)
  {
    // Every second vertex, so the view is in the overview's coordinates.
    SampleView from = MakeSampleView(types[array], box,
      block.Record.GetData() + block.Layout.Offsets[array * static_cast<std::size_t>(levels)] +
        BlockRecord::SegmentHeaderSize);
    from.First = from.AtBytes({ 2 * part.Low[0], 2 * part.Low[1], 2 * part.Low[2] });
    from.Available = part;
    for (std::ptrdiff_t& stride : from.Stride)
    {
      stride *= 2;
    }
    CopyBox(from, part, part, to);
    to += static_cast<std::size_t>(part.GetNumberOfVertices()) * GetValueSize(types[array]);
  }
  return samples;
}

std::string OverviewSource::GetPath(const std::string& folder, std::size_t store)
{
  return folder + "/overview-samples-" + std::to_string(store) + ".tmp";
}

OverviewSource::OverviewSource(FileSystem& files, std::string folder, const BlockGrid& finer,
  std::vector<ValueType> types, std::vector<std::uint32_t> blockStores, std::size_t stores)
  : Files(files)
  , Folder(std::move(folder))
  , Finer(finer)
  , Types(std::move(types))
  , VertexBytes(SumValueSizes(this->Types))
  , BlockStores(std::move(blockStores))
  , Stores(stores)
  , Pool(std::make_shared<PageBufferPool>())
{
  const Index3& blocks = finer.GetNumberOfBlocksPerAxis();
  this->Box.High = FindOverviewPart(finer, finer.GetNumberOfBlocks() - 1).High;
  this->LayerOffsets.reserve(static_cast<std::size_t>(blocks[2]) * stores);
  std::vector<std::uint64_t> offsets(stores, 0);
  for (std::int64_t block = 0; block < finer.GetNumberOfBlocks(); ++block)
  {
    if (block % (blocks[0] * blocks[1]) == 0)
    {
      this->LayerOffsets.insert(this->LayerOffsets.end(), offsets.begin(), offsets.end());
    }
    offsets[this->FindStore(block)] += this->GetBlockBytes(block);
  }
}

std::uint64_t OverviewSource::GetBlockBytes(std::int64_t block) const
{
  return static_cast<std::uint64_t>(FindOverviewPart(this->Finer, block).GetNumberOfVertices()) *
    this->VertexBytes;
}

std::int64_t OverviewSource::FindBlock(std::int64_t vertex, std::size_t axis) const
{
  // The last block also has its far face.
  return std::min((vertex << this->Finer.GetNumberOfLevels()) / this->Finer.GetBlockSize(),
    this->Finer.GetNumberOfBlocksPerAxis()[axis] - 1);
}

std::uint64_t OverviewSource::GetHeldBytes() const
{
  return this->BlockStores.size() * sizeof(std::uint32_t) +
    this->LayerOffsets.size() * sizeof(std::uint64_t);
}

std::uint64_t OverviewSource::GetReadBytes(const VertexBox& box) const
{
  // The box, and the parts of one layer in the rows of blocks that it intersects.
  const std::int64_t blockVertices =
    (this->Finer.GetBlockSize() >> this->Finer.GetNumberOfLevels()) + 1;
  const Index3 size = this->Box.GetSize();
  const std::int64_t rows =
    this->FindBlock(box.High[1] - 1, 1) - this->FindBlock(box.Low[1], 1) + 1;
  const std::int64_t vertices =
    size[0] * std::min(size[1], rows * blockVertices) * std::min(size[2], blockVertices);
  return static_cast<std::uint64_t>(box.GetNumberOfVertices() + vertices) * this->VertexBytes +
    8 * this->Types.size() +
    static_cast<std::uint64_t>(rows * this->Finer.GetNumberOfBlocksPerAxis()[0]) *
    (2 * sizeof(std::int64_t)) +
    this->Stores * sizeof(BlockRun);
}

std::vector<OverviewSource::BlockRun> OverviewSource::FindRuns(
  std::int64_t layer, std::int64_t beginRow, std::int64_t endRow) const
{
  const Index3& blocks = this->Finer.GetNumberOfBlocksPerAxis();
  std::vector<BlockRun> parts(this->Stores);
  for (std::size_t store = 0; store < this->Stores; ++store)
  {
    parts[store].Offset =
      this->LayerOffsets[static_cast<std::size_t>(layer) * this->Stores + store];
  }
  for (std::int64_t row = 0; row < endRow; ++row)
  {
    for (std::int64_t column = 0; column < blocks[0]; ++column)
    {
      const std::int64_t block = this->Finer.GetBlockIndex({ column, row, layer });
      BlockRun& part = parts[this->FindStore(block)];
      if (row < beginRow)
      {
        part.Offset += this->GetBlockBytes(block);
        continue;
      }
      part.Size += this->GetBlockBytes(block);
      part.Blocks.push_back(block);
    }
  }
  return parts;
}

Status OverviewSource::ReadRun(const BlockRun& part, std::size_t store, const VertexBox& box,
  const std::vector<std::uint8_t*>& samples)
{
  ISOSURFACE_ASSIGN_OR_RETURN(
    const auto file, this->Files.OpenForReading(GetPath(this->Folder, store)));
  const auto size = static_cast<std::size_t>(part.Size);
  if (this->PartBytes.GetSize() < size)
  {
    this->PartBytes = Buffer<std::uint8_t>();
    this->PartBytes = Buffer<std::uint8_t>(size);
  }
  ISOSURFACE_RETURN_IF_ERROR(file->Read(part.Offset, size, this->PartBytes.GetData()));
  const std::uint8_t* from = this->PartBytes.GetData();
  for (const std::int64_t block : part.Blocks)
  {
    const VertexBox has = FindOverviewPart(this->Finer, block);
    for (std::size_t array = 0; array < this->Types.size(); ++array)
    {
      CopyBox(
        MakeSampleView(this->Types[array], has, from), has.Intersect(box), box, samples[array]);
      from +=
        static_cast<std::size_t>(has.GetNumberOfVertices()) * GetValueSize(this->Types[array]);
    }
  }
  return Status::Ok();
}

Result<BoxSamples> OverviewSource::Read(const VertexBox& box)
{
  const auto vertices = static_cast<std::size_t>(box.GetNumberOfVertices());
  // Every array at an address that suits all types.
  const auto align = [](std::size_t size) { return (size + 7) / 8 * 8; };
  std::size_t bytes = 0;
  for (const ValueType type : this->Types)
  {
    bytes += align(vertices * GetValueSize(type));
  }
  ISOSURFACE_ASSIGN_OR_RETURN(const auto buffer, this->Pool->Take(bytes));
  std::vector<std::uint8_t*> samples;
  BoxSamples result;
  result.Owner = buffer;
  std::uint8_t* next = buffer->GetData();
  for (const ValueType type : this->Types)
  {
    samples.push_back(next);
    result.Arrays.push_back(MakeSampleView(type, box, next));
    next += align(vertices * GetValueSize(type));
  }
  const std::int64_t beginRow = this->FindBlock(box.Low[1], 1);
  const std::int64_t endRow = this->FindBlock(box.High[1] - 1, 1) + 1;
  for (std::int64_t layer = this->FindBlock(box.Low[2], 2);
       layer <= this->FindBlock(box.High[2] - 1, 2); ++layer)
  {
    const std::vector<BlockRun> parts = this->FindRuns(layer, beginRow, endRow);
    for (std::size_t store = 0; store < this->Stores; ++store)
    {
      if (parts[store].Size > 0)
      {
        ISOSURFACE_RETURN_IF_ERROR(this->ReadRun(parts[store], store, box, samples));
      }
    }
  }
  return result;
}

} // namespace isosurface
