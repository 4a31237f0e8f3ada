// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_BlockExchange_h
#define isosurface_BlockExchange_h

#include "Ground/Base/Buffer.h"
#include "Ground/Base/Communicator.h"
#include "Ground/Base/Status.h"
#include "Ground/Volume/BlockGrid.h"
#include "Storage/Record/BlockRecord.h"
#include "Storage/Record/BlockSegment.h"
#include "Storage/Writing/RecordBuffers.h"
#include "Storage/Writing/SpanSamples.h"

#include <atomic>
#include <cstdint>
#include <functional>
#include <vector>

namespace isosurface
{

/// A block whose record is being made.
struct PendingBlock
{
  /// `record`: at least as large as the record will be, padded; or nothing yet.
  PendingBlock(const BlockGrid& grid, std::int64_t block, std::uint32_t store,
    const std::vector<ValueType>& types, Buffer<std::uint8_t> record = {});

  /// The memory of a block whose record has `record` bytes.
  static std::uint64_t GetBytes(std::uint64_t record)
  {
    return BlockRecord::AlignUp(record) + record / 32 + 1024;
  }

  std::int64_t Block;
  std::uint32_t Store;
  BlockRecordLayout Layout;
  Buffer<std::uint8_t> Record; ///< padded; segments have no headers until they are sealed
  std::vector<std::uint8_t> OverviewSamples; ///< of PickOverviewSamples, for the next overview
  bool IsFinished = false;                   ///< whether the record is encoded and sealed
};

/**
 * Brings the samples of blocks from the ranks that have them to the ranks that make their records.
 * A rank takes samples from its own source where that has them, and the rest from the vertices'
 * owners (PieceOwnership.h), with one message for each pair of ranks and round:
 *
 *     message: parts of segments, one after another
 *     +----+----------------------------------------------------------------------+
 *     |  0 | block index                                                 (uint64) |
 *     |  8 | level                                                       (uint32) |
 *     | 12 | 0                                                           (uint32) |
 *     | 16 | box in the level's coordinates: low x, y, z, high x, y, z    (int64) |
 *     | 64 | the segment's samples in the box, in its order, array after array    |
 *     +----+----------------------------------------------------------------------+
 */
class BlockExchange
{
public:
  /// `boxes`: those of the ranks' sources. The references must outlive this object.
  BlockExchange(const BlockGrid& grid, const std::vector<ValueType>& types,
    const std::vector<VertexBox>& boxes, std::size_t rank, int threads);

  /// The vertices that this rank supplies.
  const std::vector<VertexBox>& GetOwned() const { return this->Owned; }
  /// Whether any rank needs samples of another one.
  bool IsNeeded() const { return this->HasParts; }

  /// The boxes that this rank reads to supply another rank's span.
  std::vector<VertexBox> FindBoxes(const BlockSpan& span, std::size_t rank) const;
  /// A bound of the bytes of Pack()'s message.
  std::uint64_t GetMessageBytes(const BlockSpan& span, std::size_t rank) const;
  /// The samples of FindBoxes() for that rank's span.
  Message Pack(const BlockSpan& span, std::size_t rank, const SpanSamples& samples) const;

  /// Fills the records of this rank's span from its own samples and from the messages of all ranks.
  /// Takes their memory from `buffers`. Fails if samples are missing. For each block that needs no
  /// messages, `whenFilled` is called with its index in `blocks`, by several threads at once, while
  /// its samples are in the processor's cache. Then its record may be taken away.
  Status Fill(std::vector<PendingBlock>& blocks, const SpanSamples& samples,
    const std::vector<Message>& messages, RecordBuffers& buffers,
    const std::function<void(std::size_t index, int thread)>& whenFilled) const;

private:
  template <typename Visitor>
  void VisitParts(const BlockSpan& span, std::size_t rank, Visitor&& visit) const;
  void PackPart(const BlockSegment& segment, const VertexBox& part, std::int64_t block, int level,
    const SpanSamples& samples, Message& message) const;
  /// Returns the number of samples taken from the source.
  std::uint64_t FillFromSource(PendingBlock& block, const SpanSamples& samples) const;
  Status FillFromMessage(std::vector<PendingBlock>& blocks, const Message& message,
    std::atomic<std::uint64_t>& count) const;

  const BlockGrid& Grid;
  const std::vector<ValueType>& Types;
  const VertexBox Box;
  int Threads;
  std::vector<VertexBox> Owned;
  /// Per rank: the boxes that this rank sends to it.
  std::vector<std::vector<VertexBox>> ToSend;
  bool HasParts = false;
};

} // namespace isosurface

#endif
