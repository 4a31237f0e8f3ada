// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_SurfaceExchange_h
#define isosurface_SurfaceExchange_h

#include "Base/Communicator.h"
#include "Base/Progress.h"
#include "Base/Status.h"
#include "Contour/Surface.h"
#include "EdgeIndex/EdgeIndexHeader.h"
#include "Redistribution/BlockDescription.h"
#include "Redistribution/ExchangePlan.h"
#include "Redistribution/SurfaceForm.h"
#include "Volume/BlockSource.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

namespace isosurface
{

class SurfaceUnpacking;

/**
 * Brings an isosurface from the ranks that have its blocks to the ranks that draw it: each drawing
 * rank gets a compact part of equal work (MakeCompactPartition), whoever had its blocks.
 *
 * 1. Every rank encodes its own blocks, as edge-index records (RecordForm) or, for comparison, as
 *    the arrays of their surfaces (RawForm). All of them: a block that stays where it is must meet
 *    its neighbours in the points that the codec made of theirs.
 * 2. All ranks tell each other the box, the points and the bytes of their crossed blocks: the exact
 *    work, known only now, in some fifteen bytes a block. Each makes the same plan of it
 *    (ExchangePlan), so nobody needs to be told what comes when.
 * 3. Blocks go to their ranks in rounds of bounded size. Meanwhile a thread makes the surface of
 *    those that are there, in the order of their places.
 *
 * So a part's surface is, bit for bit, the same for any number of extracting ranks and threads, and
 * its points are shared within the rank. Points on faces where parts meet have equal GlobalIds and
 * are bitwise equal.
 *
 * Memory: the encoded blocks that the rank had, let go as they are sent, and those that it gets.
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
    /// A rank sends no more bytes in a round, but for the last block's.
    std::uint64_t RoundBytes = std::uint64_t{ 4 } << 20;
    /// RawForm instead of RecordForm; of the header only the grid matters then.
    bool Raw = false;
  };

  /// What this rank did.
  struct Cost
  {
    std::uint64_t EncodedBlocks = 0;
    std::uint64_t EncodedPoints = 0; ///< crossed edges of the own blocks, shared ones once a block
    std::uint64_t EncodedBytes = 0;  ///< of all own blocks
    std::uint64_t SentBytes = 0;     ///< of those that went to other ranks, and descriptions
    std::uint64_t ReceivedBlocks = 0;
    std::uint64_t ReceivedPoints = 0; ///< crossed edges of the blocks, shared ones once a block
    std::uint64_t Rounds = 0;
    double EncodeSeconds = 0;
    double ChooseSeconds = 0;   ///< of step 2, waiting for slower ranks included
    double ExchangeSeconds = 0; ///< of the rounds, waiting for slower ranks included
    double DecodeSeconds = 0;   ///< from the last round to the finished surface
  };

  /// The header, without a preview, is equal on all ranks; see JoinIsovalues for the request. Raw:
  /// the request's isovalues are the header's, its attributes those that the source gives, and it
  /// has GlobalIds and Offsets. All references must outlive the object.
  SurfaceExchange(Communicator& ranks, const EdgeIndexHeader& header, const ContourRequest& request,
    const Settings& settings);
  ~SurfaceExchange();

  /**
   * This rank's part. Collective, once for each object. source: this rank's blocks; no two ranks
   * have the same one. Errors, of any rank: InvalidArgument (the header, samples that do not fit
   * it), what Acquire returns, Corrupt (a message arrived damaged), OutOfMemory, Aborted.
   */
  Result<Surface> Run(BlockSource& source, const Progress& progress = {});

  const Cost& GetCost() const { return this->Spent; }

private:
  Status Encode(BlockSource& source, const Progress& progress);
  Status MakePlan();
  /// Rounds, while `unpacking` goes on.
  Status SendRounds(SurfaceUnpacking& unpacking, const Progress& progress);
  void FillRound(std::size_t round, std::vector<Message>& outgoing, std::vector<Message>& incoming);
  /// False if it is not what was to come.
  bool TakeMessage(std::size_t round, std::size_t source, Message message, ArrivingBlocks& blocks);

  Communicator& Ranks;
  const EdgeIndexHeader& Header;
  Settings Wanted;
  std::unique_ptr<SurfaceForm> Form;
  std::vector<BlockDescription> Descriptions; ///< of the own blocks, until all know them
  std::vector<Message> Own;                   ///< their bytes
  ExchangePlan Plan;
  std::size_t NextBlock = 0;            ///< of Own, to be sent
  std::vector<std::size_t> NextArrival; ///< of Plan.BySource, of each rank
  std::vector<Message> Arrived;
  Cost Spent;
};

/// The bytes of a surface's points, GlobalIds, normals, attributes and corners of cells (of
/// polygons, also how many each has): what sending it as it is would cost.
std::uint64_t GetSurfaceBytes(const Surface& surface);

} // namespace isosurface

#endif
