// SPDX-License-Identifier: BSD-3-Clause
#include "Storage/Writing/BlockExchange.h"

#include "Ground/Base/Coding.h"
#include "Ground/Base/ParallelFor.h"
#include "Ground/Volume/PieceOwnership.h"

#include <algorithm>
#include <cstring>
#include <string>

namespace isosurface
{
namespace
{

constexpr std::size_t PartHeaderSize = 64;

/// So few that threads rarely wait for the last one.
constexpr std::size_t BlocksInTurn = 8;

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

/// Prefetches what the next block along x has of a row, since the processor does not predict that
/// it comes next.
void PrefetchNextBlock(const SampleView& layer, const SegmentRow& row, std::int64_t blockSize)
{
#if defined(__GNUC__)
  DispatchValueType(layer.Type,
    [&](auto zero)
    {
      using T = decltype(zero);
      constexpr std::ptrdiff_t line = 64;
      constexpr int secondCache = 2;
      const auto* last = reinterpret_cast<const char*>(
        layer.At<T>({ row.I + (row.Count - 1) * row.Step, row.J, row.K }));
      const std::ptrdiff_t bytes =
        static_cast<std::ptrdiff_t>(sizeof(T)) * layer.Stride[0] * blockSize;
      for (std::ptrdiff_t at = line; at < bytes + line; at += line)
      {
        __builtin_prefetch(last + at, 0, secondCache);
      }
    });
#endif
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
  const std::vector<ValueType>& types, Buffer<std::uint8_t> record)
  : Block(block)
  , Store(store)
  , Layout(grid, block, types)
  , Record(std::move(record))
{
}

BlockExchange::BlockExchange(const BlockGrid& grid, const std::vector<ValueType>& types,
  const std::vector<VertexBox>& boxes, std::size_t rank, int threads)
  : Grid(grid)
  , Types(types)
  , Box(boxes[rank])
  , Threads(threads)
  , Owned(FindOwnedBoxes(boxes, rank))
{
  for (const VertexBox& other : boxes)
  {
    this->ToSend.push_back(SubtractBox(this->Owned, other));
    this->HasParts = this->HasParts || !(other == boxes[0]);
  }
}

template <typename Visitor>
void BlockExchange::VisitParts(const BlockRun& run, std::size_t rank, Visitor&& visit) const
{
  for (std::int64_t block = run.Begin; block < run.End && !this->ToSend[rank].empty(); ++block)
  {
    for (int level = 0; level < this->Grid.GetNumberOfLevels(); ++level)
    {
      const BlockSegment segment(this->Grid, block, level);
      for (const VertexBox& box : this->ToSend[rank])
      {
        const VertexBox part = segment.GetBox().Intersect(CoarsenBox(box, level));
        if (!part.IsEmpty())
        {
          visit(segment, part, block, level);
        }
      }
    }
  }
}

std::vector<VertexBox> BlockExchange::FindBoxes(const BlockRun& run, std::size_t rank) const
{
  if (this->ToSend[rank].empty())
  {
    return {};
  }
  VertexBox bounds = this->ToSend[rank].front();
  for (const VertexBox& box : this->ToSend[rank])
  {
    for (std::size_t axis = 0; axis < 3; ++axis)
    {
      bounds.Low[axis] = std::min(bounds.Low[axis], box.Low[axis]);
      bounds.High[axis] = std::max(bounds.High[axis], box.High[axis]);
    }
  }
  return RunSamples::FindBoxes(this->Grid, run, bounds);
}

std::uint64_t BlockExchange::GetMessageBytes(const BlockRun& run, std::size_t rank) const
{
  std::uint64_t valueSize = 0;
  for (const ValueType type : this->Types)
  {
    valueSize += GetValueSize(type);
  }
  std::uint64_t bytes = 0;
  this->VisitParts(run, rank,
    [&](const BlockSegment&, const VertexBox& part, std::int64_t, int) {
      bytes += PartHeaderSize + static_cast<std::uint64_t>(part.GetNumberOfVertices()) * valueSize;
    });
  return bytes;
}

Message BlockExchange::Pack(const BlockRun& run, std::size_t rank, const RunSamples& samples) const
{
  Message message;
  // A growing vector would take twice the memory at times.
  message.reserve(static_cast<std::size_t>(this->GetMessageBytes(run, rank)));
  this->VisitParts(run, rank,
    [&](const BlockSegment& segment, const VertexBox& part, std::int64_t block, int level)
    { this->PackPart(segment, part, block, level, samples, message); });
  return message;
}

void BlockExchange::PackPart(const BlockSegment& segment, const VertexBox& part, std::int64_t block,
  int level, const RunSamples& samples, Message& message) const
{
  std::int64_t count = 0;
  segment.VisitRows(part, [&](const SegmentRow& row) { count += row.Count; });
  if (count == 0)
  {
    return;
  }
  std::size_t size = PartHeaderSize;
  for (const ValueType type : this->Types)
  {
    size += static_cast<std::size_t>(count) * GetValueSize(type);
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
        CopyFromSamples(to, samples.Find(array, row.K << level), row, level);
        to += static_cast<std::size_t>(row.Count) * GetValueSize(this->Types[array]);
      });
  }
}

Status BlockExchange::Fill(std::vector<PendingBlock>& blocks, const RunSamples& samples,
  const std::vector<Message>& messages, RecordBuffers& buffers,
  const std::function<void(std::size_t index, int thread)>& whenFilled) const
{
  std::atomic<std::uint64_t> count{ 0 };
  std::uint64_t expected = 0;
  for (const PendingBlock& block : blocks)
  {
    expected += block.Layout.Samples;
  }
  // A thread fills neighbours along x, whose rows share lines of the processor's caches.
  ParallelFor((blocks.size() + BlocksInTurn - 1) / BlocksInTurn, this->Threads,
    [&](std::size_t turn, int thread)
    {
      const std::size_t end = std::min(blocks.size(), (turn + 1) * BlocksInTurn);
      for (std::size_t index = turn * BlocksInTurn; index < end; ++index)
      {
        PendingBlock& block = blocks[index];
        block.Record = buffers.Take();
        const std::uint64_t filled = this->FillFromSource(block, samples);
        count += filled;
        if (filled == block.Layout.Samples)
        {
          whenFilled(index, thread);
        }
      }
    });
  std::vector<Status> outcomes(messages.size());
  ParallelFor(messages.size(), this->Threads,
    [&](std::size_t index, int)
    { outcomes[index] = this->FillFromMessage(blocks, messages[index], count); });
  for (const Status& outcome : outcomes)
  {
    ISOSURFACE_RETURN_IF_ERROR(outcome);
  }
  if (count != expected)
  {
    return Status(StatusCode::Corrupt,
      "the ranks supplied " + std::to_string(count) + " samples of blocks that have " +
        std::to_string(expected));
  }
  return Status::Ok();
}

std::uint64_t BlockExchange::FillFromSource(PendingBlock& block, const RunSamples& samples) const
{
  std::uint64_t filled = 0;
  for (int level = 0; level < this->Grid.GetNumberOfLevels(); ++level)
  {
    const BlockSegment segment(this->Grid, block.Block, level);
    const VertexBox part = segment.GetBox().Intersect(CoarsenBox(this->Box, level));
    for (std::size_t array = 0; array < this->Types.size() && !part.IsEmpty(); ++array)
    {
      const std::size_t index = FindSegmentIndex(this->Grid, array, level);
      std::uint8_t* to =
        block.Record.GetData() + block.Layout.Offsets[index] + BlockRecord::SegmentHeaderSize;
      const std::size_t size = GetValueSize(this->Types[array]);
      segment.VisitRows(part,
        [&](const SegmentRow& row)
        {
          const SampleView& view = samples.Find(array, row.K << level);
          if (level == 0)
          {
            PrefetchNextBlock(view, row, this->Grid.GetBlockSize());
          }
          CopyFromSamples(to + row.Offset * size, view, row, level);
          filled += static_cast<std::uint64_t>(row.Count);
        });
    }
  }
  return filled;
}

Status BlockExchange::FillFromMessage(std::vector<PendingBlock>& blocks, const Message& message,
  std::atomic<std::uint64_t>& count) const
{
  Status damaged(StatusCode::Corrupt, "a message between ranks arrived damaged");
  const std::uint8_t* from = message.data();
  const std::uint8_t* end = from + message.size();
  std::uint64_t filled = 0;
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
            filled += static_cast<std::uint64_t>(row.Count);
          }
        });
      if (!isComplete)
      {
        return damaged;
      }
    }
  }
  count += filled;
  return Status::Ok();
}

} // namespace isosurface
