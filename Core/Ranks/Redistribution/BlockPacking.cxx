// SPDX-License-Identifier: BSD-3-Clause
#include "Ranks/Redistribution/BlockPacking.h"

#include "Coding/EdgeIndex/EdgeIndexDecoder.h"
#include "Coding/EdgeIndex/EdgeIndexEncoder.h"
#include "Coding/EdgeIndex/IsovalueJoin.h"

#include <memory>
#include <utility>
#include <vector>

namespace isosurface
{
namespace
{

// The arriving blocks that one isovalue crosses, as the source of an extraction.
class ArrivingRecords : public CodedBlockSource
{
public:
  ArrivingRecords(const EdgeIndexHeader& header, ArrivingBlocks& arriving, std::size_t isovalue)
    : CodedBlockSource(header)
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
  Result<BlockSamples> Acquire(std::size_t block) override
  {
    const std::uint8_t* bytes = this->Arriving.Wait(this->Blocks[block]);
    if (!bytes)
    {
      return Status(StatusCode::Aborted, "Not all blocks of the isosurface arrived.");
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

  ArrivingBlocks& Arriving;
  std::size_t Isovalue;
  std::vector<std::size_t> Blocks; ///< in Arriving
};

// Splits the records of several blocks by block; the records of one block follow each other.
class RecordSplitter
{
public:
  RecordSplitter(const EdgeIndexHeader& header, const TakeBlock& take)
    : Header(header)
    , Take(take)
  {
  }

  Status Split(const std::vector<std::uint8_t>& bytes)
  {
    std::size_t used = 0;
    for (std::size_t at = 0; at < bytes.size(); at += used)
    {
      ISOSURFACE_ASSIGN_OR_RETURN(const auto record,
        EdgeIndexRecord::Parse(this->Header, bytes.data() + at, bytes.size() - at, used));
      if (!(this->Block.Vertices == record.Block.Vertices))
      {
        ISOSURFACE_RETURN_IF_ERROR(this->Finish());
        this->Begin(record.Block);
      }
      this->Block.Points[record.Block.Isovalue] = record.Block.NumberOfPoints;
      this->Block.Bytes += used;
      this->Records.insert(this->Records.end(), bytes.data() + at, bytes.data() + at + used);
    }
    return this->Finish();
  }

private:
  void Begin(const EdgeIndexBlock& block)
  {
    this->Records = Message();
    this->Block = BlockDescription();
    this->Block.Vertices = block.Vertices;
    this->Block.Lattice = block.Lattice;
    this->Block.Points.resize(this->Header.Isovalues.size());
  }
  Status Finish()
  {
    return this->Records.empty() ? Status::Ok()
                                 : this->Take(std::move(this->Block), std::move(this->Records));
  }

  const EdgeIndexHeader& Header;
  const TakeBlock& Take;
  BlockDescription Block;
  Message Records;
};

} // namespace

Status PackBlocks(const EdgeIndexHeader& header, BlockSource& source, int threads,
  const TakeBlock& take, const Progress& progress)
{
  if (header.PreviewLevel != 0)
  {
    return { StatusCode::InvalidArgument, "An isosurface is redistributed without a preview." };
  }
  const auto takeRecords = [&](const std::vector<std::uint8_t>& bytes)
  { return RecordSplitter(header, take).Split(bytes); };
  return EncodeBlocks(header, source, threads, takeRecords, progress);
}

Result<Surface> UnpackBlocks(const EdgeIndexHeader& header, const ContourRequest& request,
  ArrivingBlocks& blocks, int threads, const Progress& progress)
{
  std::vector<IsovalueSource> sources;
  for (std::size_t isovalue = 0; isovalue < header.Isovalues.size(); ++isovalue)
  {
    sources.push_back({ isovalue, std::make_unique<ArrivingRecords>(header, blocks, isovalue) });
  }
  return JoinIsovalues(header, sources, request, threads, progress);
}

} // namespace isosurface
