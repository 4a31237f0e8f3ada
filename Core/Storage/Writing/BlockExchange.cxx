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
void BlockExchange::VisitParts(const BlockSpan& span, std::size_t rank, Visitor&& visit) const
{
  for (std::int64_t block = span.Begin; block < span.End && !this->ToSend[rank].empty(); ++block)
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

std::vector<VertexBox> BlockExchange::FindBoxes(const BlockSpan& span, std::size_t rank) const
{
  if (this->ToSend[rank].empty())
  {
    return {};
  }
  VertexBox bounds = this->ToSend[rank].front();
  for (const VertexBox& box : this->ToSend[rank])
  {
    bounds.Extend(box);
  }
  return SpanSamples::FindBoxes(this->Grid, span, bounds);
}

std::uint64_t BlockExchange::GetMessageBytes(const BlockSpan& span, std::size_t rank) const
{
  const std::uint64_t valueSize = SumValueSizes(this->Types);
  std::uint64_t bytes = 0;
  this->VisitParts(span, rank,
    [&](const BlockSegment&, const VertexBox& part, std::int64_t, int) {
      bytes += PartHeaderSize + static_cast<std::uint64_t>(part.GetNumberOfVertices()) * valueSize;
    });
  return bytes;
}

Message BlockExchange::Pack(
  const BlockSpan& span, std::size_t rank, const SpanSamples& samples) const
{
  Message message;
  // A growing vector would take twice the memory at times.
  message.reserve(static_cast<std::size_t>(this->GetMessageBytes(span, rank)));
  this->VisitParts(span, rank,
    [&](const BlockSegment& segment, const VertexBox& part, std::int64_t block, int level)
    { this->PackPart(segment, part, block, level, samples, message); });
  return message;
}

void BlockExchange::PackPart(const BlockSegment& segment, const VertexBox& part, std::int64_t block,
  int level, const SpanSamples& samples, Message& message) const
{
  std::int64_t count = 0;
  segment.VisitRows(part, [&](const SegmentRow& row) { count += row.Count; });
  if (count == 0)
  {
    return;
  }
  AppendLittleEndian(message, static_cast<std::uint64_t>(block));
  AppendLittleEndian(message, static_cast<std::uint64_t>(level));
  AppendBox(message, part);
  const std::size_t begin = message.size();
  message.resize(begin + static_cast<std::size_t>(count) * SumValueSizes(this->Types));
  std::uint8_t* to = message.data() + begin;
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

Status BlockExchange::Fill(std::vector<PendingBlock>& blocks, const SpanSamples& samples,
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

std::uint64_t BlockExchange::FillFromSource(PendingBlock& block, const SpanSamples& samples) const
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
  ByteReader reader(message);
  std::uint64_t filled = 0;
  while (reader.GetRemaining() > 0)
  {
    const auto number = static_cast<std::int64_t>(reader.Read<std::uint64_t>());
    const auto level = reader.Read<std::uint64_t>();
    const VertexBox part = ReadBox(reader);
    const auto block = std::lower_bound(blocks.begin(), blocks.end(), number,
      [](const PendingBlock& a, std::int64_t b) { return a.Block < b; });
    if (reader.HasFailed() || block == blocks.end() || block->Block != number ||
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
      segment.VisitRows(part,
        [&](const SegmentRow& row)
        {
          const std::size_t bytes = static_cast<std::size_t>(row.Count) * size;
          if (const std::uint8_t* from = reader.ReadBytes(bytes))
          {
            std::memcpy(to + row.Offset * size, from, bytes);
            filled += static_cast<std::uint64_t>(row.Count);
          }
        });
    }
    if (reader.HasFailed())
    {
      return damaged;
    }
  }
  count += filled;
  return Status::Ok();
}

} // namespace isosurface
