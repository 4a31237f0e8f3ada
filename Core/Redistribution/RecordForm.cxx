// SPDX-License-Identifier: BSD-3-Clause
#include "Redistribution/RecordForm.h"

#include "EdgeIndex/EdgeIndexDecoder.h"
#include "EdgeIndex/EdgeIndexEncoder.h"
#include "EdgeIndex/IsovalueJoin.h"

#include <memory>
#include <utility>
#include <vector>

namespace isosurface
{
namespace
{

// The blocks that one isovalue crosses.
class ArrivingRecords : public BlockSource
{
public:
  ArrivingRecords(const EdgeIndexHeader& header, ArrivingBlocks& arriving, std::size_t isovalue)
    : Header(header)
    , Decoder(header)
    , Arriving(arriving)
    , Isovalue(isovalue)
  {
    const std::vector<BlockDescription>& blocks = arriving.GetBlocks();
    for (std::size_t n = 0; n < blocks.size(); ++n)
    {
      if (blocks[n].Points[isovalue] > 0)
      {
        this->Blocks.push_back(n);
      }
    }
  }

  std::size_t GetNumberOfBlocks() const override { return this->Blocks.size(); }
  Index3 GetLatticeCoordinates(std::size_t block) const override
  {
    return this->Describe(block).Lattice;
  }
  VertexBox GetVertices(std::size_t block) const override { return this->Describe(block).Vertices; }
  ValueType GetValueType() const override { return this->Header.GetDecodedType(); }
  Result<BlockSamples> Acquire(std::size_t block) override
  {
    const std::uint8_t* bytes = this->Arriving.Wait(this->Blocks[block]);
    if (!bytes)
    {
      return Status(StatusCode::Aborted, "Not all blocks of the isosurface came.");
    }
    const BlockDescription& description = this->Describe(block);
    std::size_t used = 0;
    for (std::size_t at = 0; at < description.Bytes; at += used)
    {
      const auto record =
        EdgeIndexRecord::Parse(this->Header, bytes + at, description.Bytes - at, used);
      if (!record.IsOk())
      {
        return MakeDamagedMessage();
      }
      if (record->Block.Isovalue == this->Isovalue)
      {
        return this->IsAsDescribed(record->Block, description) ? this->Decoder.Decode(*record)
                                                               : MakeDamagedMessage();
      }
    }
    return MakeDamagedMessage();
  }

private:
  const BlockDescription& Describe(std::size_t block) const
  {
    return this->Arriving.GetBlocks()[this->Blocks[block]];
  }
  bool IsAsDescribed(const EdgeIndexBlock& block, const BlockDescription& description) const
  {
    return !block.IsPreview && block.Vertices == description.Vertices &&
      block.Lattice == description.Lattice &&
      block.NumberOfPoints == description.Points[this->Isovalue];
  }

  const EdgeIndexHeader& Header;
  EdgeIndexBlockDecoder Decoder;
  ArrivingBlocks& Arriving;
  std::size_t Isovalue;
  std::vector<std::size_t> Blocks; ///< in Arriving
};

} // namespace

// Records of one block follow each other.
Status RecordForm::Pack(
  BlockSource& source, int threads, const Take& take, const Progress& progress) const
{
  if (this->Header.PreviewLevel != 0)
  {
    return { StatusCode::InvalidArgument, "An isosurface is redistributed without a preview." };
  }
  const auto takeRecords = [&](const std::vector<std::uint8_t>& bytes)
  {
    BlockDescription block;
    Message records;
    std::size_t used = 0;
    for (std::size_t at = 0; at < bytes.size(); at += used)
    {
      const auto record =
        EdgeIndexRecord::Parse(this->Header, bytes.data() + at, bytes.size() - at, used);
      ISOSURFACE_RETURN_IF_ERROR(record.GetStatus());
      if (!records.empty() && !(block.Vertices == record->Block.Vertices))
      {
        ISOSURFACE_RETURN_IF_ERROR(take(std::move(block), std::move(records)));
        records = Message();
      }
      if (records.empty())
      {
        block = BlockDescription();
        block.Vertices = record->Block.Vertices;
        block.Lattice = record->Block.Lattice;
        block.Points.resize(this->Header.Isovalues.size());
      }
      block.Points[record->Block.Isovalue] = record->Block.NumberOfPoints;
      block.Bytes += used;
      records.insert(records.end(), bytes.data() + at, bytes.data() + at + used);
    }
    return records.empty() ? Status::Ok() : take(std::move(block), std::move(records));
  };
  return EncodeBlocks(this->Header, source, threads, takeRecords, progress);
}

Result<Surface> RecordForm::Unpack(
  ArrivingBlocks& blocks, int threads, const Progress& progress) const
{
  std::vector<std::unique_ptr<BlockSource>> sources;
  for (std::size_t isovalue = 0; isovalue < this->Header.Isovalues.size(); ++isovalue)
  {
    sources.push_back(std::make_unique<ArrivingRecords>(this->Header, blocks, isovalue));
  }
  return JoinIsovalues(this->Header, sources, this->Request, threads, progress);
}

} // namespace isosurface
