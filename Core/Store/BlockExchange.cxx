// SPDX-License-Identifier: BSD-3-Clause
#include "Store/BlockExchange.h"

#include "Base/ByteOrder.h"
#include "Base/ParallelFor.h"
#include "Store/PieceOwnership.h"

#include <algorithm>
#include <cstring>
#include <string>

namespace isosurface
{
namespace
{

constexpr std::size_t PartHeaderSize = 64;

std::size_t FindSegmentIndex(const BlockGrid& grid, std::size_t array, int level)
{
  const auto levels = static_cast<std::size_t>(grid.GetNumberOfLevels());
  return array * levels + levels - 1 - static_cast<std::size_t>(level);
}

/// Copies the rows of a part of a segment out of samples at full resolution.
void CopyFromSamples(std::uint8_t* to, const SampleView& from, const SegmentRow& row, int level)
{
  DispatchValueType(from.Type,
    [&](auto zero)
    {
      using T = decltype(zero);
      const T* source = from.At<T>({ row.I << level, row.J << level, row.K << level });
      CopySamples(to, 1, source, from.Stride[0] * (row.Step << level), row.Count, sizeof(T));
    });
}

void StoreBox(std::uint8_t* bytes, const VertexBox& box)
{
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    StoreLittleEndian(bytes + 8 * axis, box.Low[axis]);
    StoreLittleEndian(bytes + 24 + 8 * axis, box.High[axis]);
  }
}

VertexBox LoadBox(const std::uint8_t* bytes)
{
  VertexBox box;
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    box.Low[axis] = LoadLittleEndian<std::int64_t>(bytes + 8 * axis);
    box.High[axis] = LoadLittleEndian<std::int64_t>(bytes + 24 + 8 * axis);
  }
  return box;
}

} // namespace

PendingBlock::PendingBlock(const BlockGrid& grid, std::int64_t block, std::uint32_t store,
  const std::vector<ValueType>& types)
  : Block(block)
  , Store(store)
  , Layout(grid, block, types)
  , Record(static_cast<std::size_t>(BlockRecord::AlignUp(Layout.Size)))
{
  std::memset(
    this->Record.GetData() + this->Layout.Size, 0, this->Record.GetSize() - this->Layout.Size);
}

BlockExchange::BlockExchange(Communicator& communicator, const BlockGrid& grid,
  const std::vector<ValueType>& types, const VolumePiece& piece,
  const std::vector<VertexBox>& pieces, const std::vector<VertexBox>& owned, int threads)
  : Grid(grid)
  , Types(types)
  , Piece(piece)
  , Threads(threads)
  , Rank(communicator.GetRank())
{
  for (const VertexBox& other : pieces)
  {
    this->ToSend.push_back(SubtractBox(owned, other));
  }
}

std::vector<Message> BlockExchange::Pack(const std::vector<Target>& round) const
{
  std::vector<Message> messages(this->ToSend.size());
  std::vector<std::vector<std::int64_t>> blocks(this->ToSend.size());
  for (const Target& target : round)
  {
    blocks[static_cast<std::size_t>(target.Rank)].push_back(target.Block);
  }
  ParallelFor(messages.size(), this->Threads,
    [&](std::size_t rank, int)
    {
      for (const std::int64_t block : blocks[rank])
      {
        this->PackBlock(block, this->ToSend[rank], messages[rank]);
      }
    });
  return messages;
}

void BlockExchange::PackBlock(
  std::int64_t block, const std::vector<VertexBox>& boxes, Message& message) const
{
  for (int level = 0; level < this->Grid.GetNumberOfLevels() && !boxes.empty(); ++level)
  {
    const BlockSegment segment(this->Grid, block, level);
    for (const VertexBox& box : boxes)
    {
      const VertexBox part = segment.GetBox().Intersect(CoarsenBox(box, level));
      if (part.IsEmpty())
      {
        continue;
      }
      std::int64_t samples = 0;
      segment.VisitRows(part, [&](const SegmentRow& row) { samples += row.Count; });
      if (samples == 0)
      {
        continue;
      }
      std::size_t size = PartHeaderSize;
      for (const ValueType type : this->Types)
      {
        size += static_cast<std::size_t>(samples) * GetValueSize(type);
      }
      message.resize(message.size() + size);
      std::uint8_t* to = message.data() + message.size() - size;
      StoreLittleEndian(to, static_cast<std::uint64_t>(block));
      StoreLittleEndian(to + 8, static_cast<std::uint64_t>(level));
      StoreBox(to + 16, part);
      to += PartHeaderSize;
      for (std::size_t array = 0; array < this->Types.size(); ++array)
      {
        segment.VisitRows(part,
          [&](const SegmentRow& row)
          {
            CopyFromSamples(to, this->Piece.Arrays[array], row, level);
            to += static_cast<std::size_t>(row.Count) * GetValueSize(this->Types[array]);
          });
      }
    }
  }
}

Status BlockExchange::Fill(
  std::vector<PendingBlock>& blocks, const std::vector<Message>& messages) const
{
  std::atomic<std::uint64_t> samples{ 0 };
  std::uint64_t expected = 0;
  for (const PendingBlock& block : blocks)
  {
    expected += block.Layout.Samples;
  }
  ParallelFor(blocks.size(), this->Threads,
    [&](std::size_t index, int) { this->FillFromPiece(blocks[index], samples); });
  std::vector<Status> outcomes(messages.size());
  ParallelFor(messages.size(), this->Threads,
    [&](std::size_t index, int)
    { outcomes[index] = this->FillFromMessage(blocks, messages[index], samples); });
  for (const Status& outcome : outcomes)
  {
    ISOSURFACE_RETURN_IF_ERROR(outcome);
  }
  if (samples != expected)
  {
    return Status(StatusCode::Corrupt,
      "the ranks supplied " + std::to_string(samples) + " samples of blocks that have " +
        std::to_string(expected));
  }
  return Status::Ok();
}

void BlockExchange::FillFromPiece(PendingBlock& block, std::atomic<std::uint64_t>& samples) const
{
  std::uint64_t count = 0;
  for (int level = 0; level < this->Grid.GetNumberOfLevels(); ++level)
  {
    const BlockSegment segment(this->Grid, block.Block, level);
    const VertexBox part = segment.GetBox().Intersect(CoarsenBox(this->Piece.Box, level));
    for (std::size_t array = 0; array < this->Types.size() && !part.IsEmpty(); ++array)
    {
      const std::size_t index = FindSegmentIndex(this->Grid, array, level);
      std::uint8_t* to =
        block.Record.GetData() + block.Layout.Offsets[index] + BlockRecord::SegmentHeaderSize;
      const std::size_t size = GetValueSize(this->Types[array]);
      segment.VisitRows(part,
        [&](const SegmentRow& row)
        {
          CopyFromSamples(to + row.Offset * size, this->Piece.Arrays[array], row, level);
          count += static_cast<std::uint64_t>(row.Count);
        });
    }
  }
  samples += count;
}

Status BlockExchange::FillFromMessage(std::vector<PendingBlock>& blocks, const Message& message,
  std::atomic<std::uint64_t>& samples) const
{
  Status damaged(StatusCode::Corrupt, "a message between ranks arrived damaged");
  const std::uint8_t* from = message.data();
  const std::uint8_t* end = from + message.size();
  std::uint64_t count = 0;
  while (from != end)
  {
    if (static_cast<std::size_t>(end - from) < PartHeaderSize)
    {
      return damaged;
    }
    const auto number = static_cast<std::int64_t>(LoadLittleEndian<std::uint64_t>(from));
    const auto level = LoadLittleEndian<std::uint64_t>(from + 8);
    const VertexBox part = LoadBox(from + 16);
    from += PartHeaderSize;
    const auto block = std::lower_bound(blocks.begin(), blocks.end(), number,
      [](const PendingBlock& a, std::int64_t b) { return a.Block < b; });
    if (block == blocks.end() || block->Block != number ||
      level >= static_cast<std::uint64_t>(this->Grid.GetNumberOfLevels()))
    {
      return damaged;
    }
    const BlockSegment segment(this->Grid, number, static_cast<int>(level));
    for (std::size_t array = 0; array < this->Types.size(); ++array)
    {
      const std::size_t index = FindSegmentIndex(this->Grid, array, static_cast<int>(level));
      std::uint8_t* to =
        block->Record.GetData() + block->Layout.Offsets[index] + BlockRecord::SegmentHeaderSize;
      const std::size_t size = GetValueSize(this->Types[array]);
      bool isComplete = true;
      segment.VisitRows(part,
        [&](const SegmentRow& row)
        {
          const std::size_t bytes = static_cast<std::size_t>(row.Count) * size;
          isComplete = isComplete && bytes <= static_cast<std::size_t>(end - from);
          if (isComplete)
          {
            std::memcpy(to + row.Offset * size, from, bytes);
            from += bytes;
            count += static_cast<std::uint64_t>(row.Count);
          }
        });
      if (!isComplete)
      {
        return damaged;
      }
    }
  }
  samples += count;
  return Status::Ok();
}

} // namespace isosurface
