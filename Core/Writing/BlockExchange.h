// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_BlockExchange_h
#define isosurface_BlockExchange_h

#include "Base/Buffer.h"
#include "Base/Communicator.h"
#include "Base/Status.h"
#include "Record/BlockRecord.h"
#include "Record/BlockSegment.h"
#include "Volume/BlockGrid.h"
#include "Writing/RunSamples.h"

#include <atomic>
#include <cstdint>
#include <functional>
#include <vector>

namespace isosurface
{

/// A block whose record is being made, on its way to the rank that writes it.
struct PendingBlock
{
  /// `record`: at least as large as the record will be, padded.
  PendingBlock(const BlockGrid& grid, std::int64_t block, std::uint32_t store,
    const std::vector<ValueType>& types, Buffer<std::uint8_t> record);

  /// The memory of a block whose record has so many bytes.
  static std::uint64_t GetBytes(std::uint64_t record)
  {
    return BlockRecord::AlignUp(record) + record / 32 + 1024;
  }

  std::int64_t Block;
  std::uint32_t Store;
  BlockRecordLayout Layout;
  Buffer<std::uint8_t> Record; ///< padded; segments without their headers until they are sealed
  std::vector<std::uint8_t> OverviewSamples; ///< what the next overview takes of it; see there
  bool IsFinished = false;                   ///< whether the record is what the file will have
};

/**
 * Brings the samples of blocks from the ranks that have them to the ranks that make their records.
 *
 * What a rank's own source has it takes from there. The rest comes from the vertices' owners
 * (PieceOwnership.h), one message a pair of ranks and round:
 *
 *     message: parts, one after another
 *     +----+------------------------------------------------+
 *     |  0 | block index                          (uint64)   |
 *     |  8 | level                                (uint32)   |
 *     | 12 | 0                                    (uint32)   |
 *     | 16 | part: low x, y, z, high x, y, z      (int64)    |   in the level's coordinates
 *     | 64 | the samples of the segment in the part, in its order, array after array
 *     +----+------------------------------------------------+
 */
class BlockExchange
{
public:
  /// `boxes`: what the source of each rank has. The references must outlive this object.
  BlockExchange(const BlockGrid& grid, const std::vector<ValueType>& types,
    const std::vector<VertexBox>& boxes, std::size_t rank, int threads);

  /// What this rank is to supply.
  const std::vector<VertexBox>& GetOwned() const { return this->Owned; }
  /// Whether any rank lacks anything that another one has.
  bool IsNeeded() const { return this->HasParts; }

  /// What this rank reads to supply another rank's run.
  std::vector<VertexBox> FindBoxes(const BlockRun& run, std::size_t rank) const;
  /// A bound of the bytes of Pack()'s message.
  std::uint64_t GetMessageBytes(const BlockRun& run, std::size_t rank) const;
  /// The samples of FindBoxes() for that rank's run.
  Message Pack(const BlockRun& run, std::size_t rank, const RunSamples& samples) const;

  /// Fills the records of this rank's run from its own samples and from the messages of all ranks.
  /// Fails if the samples do not add up. `whenFilled` is called, by several threads at once, for
  /// each block that takes nothing from messages, while its samples are still near.
  Status Fill(std::vector<PendingBlock>& blocks, const RunSamples& samples,
    const std::vector<Message>& messages,
    const std::function<void(PendingBlock&, int thread)>& whenFilled) const;

private:
  template <typename Visitor>
  void VisitParts(const BlockRun& run, std::size_t rank, Visitor&& visit) const;
  void PackPart(const BlockSegment& segment, const VertexBox& part, std::int64_t block, int level,
    const RunSamples& samples, Message& message) const;
  /// Returns the number of samples that the source had.
  std::uint64_t FillFromSource(PendingBlock& block, const RunSamples& samples) const;
  Status FillFromMessage(std::vector<PendingBlock>& blocks, const Message& message,
    std::atomic<std::uint64_t>& count) const;

  const BlockGrid& Grid;
  const std::vector<ValueType>& Types;
  const VertexBox Box;
  int Threads;
  std::vector<VertexBox> Owned;
  /// Per rank: what it has to be sent from here.
  std::vector<std::vector<VertexBox>> ToSend;
  bool HasParts = false;
};

} // namespace isosurface

#endif
