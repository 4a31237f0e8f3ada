// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_SurfaceExchange_h
#define isosurface_SurfaceExchange_h

#include "Base/Communicator.h"
#include "Base/Progress.h"
#include "Base/Status.h"
#include "Contour/BlockSource.h"
#include "Contour/Surface.h"
#include "EdgeIndex/BlockRecordFormat.h"
#include "EdgeIndex/EdgeIndexHeader.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace isosurface
{

/**
 * Brings an isosurface from the ranks that have its blocks to the ranks that draw it, in the form
 * of edge-index records: each drawing rank gets a compact part of equal work
 * (MakeCompactPartition), whoever had its blocks.
 *
 * 1. Every rank encodes its own blocks. All of them: a block that stays where it is must meet its
 *    neighbours in the points that the codec made of theirs.
 * 2. All ranks tell each other the box and the number of points of their crossed blocks: the exact
 *    work, known only now, in some ten bytes a block. Each makes the same partition of it.
 * 3. Records go to their ranks in rounds of bounded size.
 * 4. A rank contours the records that it has (MakeSurface), in the order of their places.
 *
 * So a part's surface is, bit for bit, the same for any number of extracting ranks and threads, and
 * its points are shared within the rank without a search by GlobalIds. Points on faces where parts
 * meet have equal GlobalIds and are bitwise equal.
 *
 * Message of step 2: of each block, axis by axis, the low vertex and the number of vertices, then
 * the points: 7 numbers as in CodedNumbers.h. Of step 3: records, one after another.
 *
 * Memory: the compressed blocks that the rank had, let go as they are sent, and those that it gets.
 *
 * Source: X. Zhang, C. Bajaj and W. Blanke, "Scalable isosurface visualization of massive datasets
 * on commodity off-the-shelf clusters", 2009, sections 2 and 4.2.
 */
class SurfaceExchange
{
public:
  struct Settings
  {
    int Threads = 1;
    /// Ranks 0 to DrawingRanks - 1 get a part each; 0, or more than there are: all ranks.
    int DrawingRanks = 0;
    /// A rank sends no more records in a round, but for the last block's.
    std::uint64_t RoundBytes = std::uint64_t{ 64 } << 20;
  };

  /// What this rank did.
  struct Cost
  {
    std::uint64_t EncodedBlocks = 0;
    std::uint64_t EncodedBytes = 0; ///< of all own records
    std::uint64_t SentBytes = 0;    ///< of those that went to other ranks
    std::uint64_t ReceivedBlocks = 0;
    std::uint64_t ReceivedPoints = 0; ///< crossed edges of the blocks, shared ones once a block
    std::uint64_t Rounds = 0;
    double EncodeSeconds = 0;
    double ExchangeSeconds = 0; ///< of steps 2 and 3, waiting for slower ranks included
  };

  /// The header, without a preview, is equal on all ranks; both references must outlive the object.
  SurfaceExchange(Communicator& ranks, const EdgeIndexHeader& header, const Settings& settings);

  /**
   * Steps 1 to 3. Collective. source: this rank's blocks; no two ranks have the same one.
   * Once for each object. Errors, of any rank: InvalidArgument (the header, samples that do not fit
   * it), what Acquire returns, Corrupt (a message arrived damaged), OutOfMemory, Aborted.
   */
  Status Run(BlockSource& source, const Progress& progress = {});

  /// Step 4, of what Run brought, as often as wanted. Not collective. See JoinIsovalues for the
  /// request and errors.
  Result<Surface> MakeSurface(
    const ContourRequest& request, int threads, const Progress& progress = {}) const;

  const Cost& GetCost() const { return this->Spent; }

private:
  /// The records of a block of this rank's.
  struct EncodedBlock
  {
    VertexBox Vertices;
    std::uint64_t Points = 0;
    std::vector<std::uint8_t> Bytes;
    std::size_t Destination = 0;
  };

  Status Encode(BlockSource& source, const Progress& progress);
  Status TakeEncoded(const std::vector<std::uint8_t>& bytes);
  Status ChooseDestinations();
  Message DescribeBlocks() const;
  Status Partition(const std::vector<Message>& messages);
  Status SendRounds();
  void FillRound(std::vector<Message>& outgoing);
  Status TakeRound(std::vector<Message> incoming);
  void SortRecords();

  Communicator& Ranks;
  const EdgeIndexHeader& Header;
  Settings Wanted;
  std::vector<EncodedBlock> Own;
  std::size_t NextBlock = 0;        ///< of Own, to be sent
  std::uint64_t ExpectedPoints = 0; ///< of all that this rank is to get
  std::vector<Message> Arrived;
  std::vector<EdgeIndexRecord> Records; ///< in Arrived
  Cost Spent;
};

/// The bytes of a surface's arrays as they are in memory: what sending it as it is would cost.
std::uint64_t GetSurfaceBytes(const Surface& surface);

} // namespace isosurface

#endif
