// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_SurfaceExchange_h
#define isosurface_SurfaceExchange_h

#include "Coding/EdgeIndex/EdgeIndexHeader.h"
#include "Ground/Base/Communicator.h"
#include "Ground/Base/Progress.h"
#include "Ground/Base/Status.h"
#include "Ground/Volume/BlockSource.h"
#include "Ranks/Redistribution/ArrivingBlocks.h"
#include "Ranks/Redistribution/ExchangePlan.h"
#include "Surface/Contour/Surface.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace isosurface
{

class SurfaceUnpacking;

/**
 * Brings an isosurface from the ranks that have its blocks to the ranks that draw it. Each drawing
 * rank gets a compact piece of equal work (MakeCompactPartition) from any ranks:
 *
 * 1. Every rank encodes all its blocks (PackBlocks), including those that stay.
 * 2. All ranks gather the descriptions of all blocks and make the same ExchangePlan.
 * 3. Blocks travel in rounds of bounded size, while a thread contours those that have arrived.
 *
 * A piece is the same, bit for bit, for any number of extracting ranks and threads. Points on faces
 * where pieces meet have equal GlobalIds and are bitwise equal. Memory: the encoded blocks that the
 * rank had, freed as they are sent, and those that it receives.
 *
 * Source: X. Zhang and C. Bajaj, "Scalable isosurface visualization of massive datasets
 * on commodity off-the-shelf clusters", 2009, sections 2 and 4.2.
 */
class SurfaceExchange
{
public:
  struct Settings
  {
    int Threads = 1;
    /// Ranks 0 to DrawingRanks - 1 get a piece each; 0, or more than there are: all ranks.
    int DrawingRanks = 0;
    /// A rank's round ends with the block by which it has sent this many bytes.
    std::uint64_t RoundBytes = std::uint64_t{ 4 } << 20;
  };

  /// What this rank did.
  struct Cost
  {
    std::uint64_t EncodedBlocks = 0;
    std::uint64_t EncodedPoints = 0; ///< crossed edges, counted in each own block that has them
    std::uint64_t EncodedBytes = 0;  ///< of all own blocks
    std::uint64_t SentBytes = 0;     ///< to other ranks, including descriptions
    std::uint64_t ReceivedBlocks = 0;
    std::uint64_t ReceivedPoints = 0; ///< crossed edges, counted in each block that has them
    std::uint64_t Rounds = 0;
    double EncodeSeconds = 0;
    double ChooseSeconds = 0;   ///< for step 2, including waiting for slower ranks
    double ExchangeSeconds = 0; ///< for the rounds, including waiting for slower ranks
    double DecodeSeconds = 0;   ///< from the last round to the finished surface
  };

  /// The header is equal on all ranks and has no preview; request: see JoinIsovalues. All
  /// references must outlive the object.
  SurfaceExchange(Communicator& ranks, const EdgeIndexHeader& header, const ContourRequest& request,
    const Settings& settings);

  /**
   * Returns this rank's piece. Collective; call it once. source: this rank's blocks; no two ranks
   * have the same one. Errors of any rank: InvalidArgument (the header, samples that do not fit
   * it), what Acquire returns, Corrupt (a message arrived damaged), OutOfMemory, Aborted.
   */
  Result<Surface> Run(BlockSource& source, const Progress& progress = {});

  const Cost& GetCost() const { return this->Spent; }

private:
  Status Encode(BlockSource& source, const Progress& progress);
  Status MakePlan();
  /// Sends and receives all rounds, while `unpacking` goes on.
  Status SendRounds(SurfaceUnpacking& unpacking, const Progress& progress);
  void FillRound(std::size_t round, std::vector<Message>& outgoing, std::vector<Message>& incoming);
  /// False if the message is not what the plan expects.
  bool TakeMessage(std::size_t round, std::size_t source, Message message, ArrivingBlocks& blocks);

  Communicator& Ranks;
  const EdgeIndexHeader& Header;
  const ContourRequest& Request;
  Settings Wanted;
  std::vector<BlockDescription> Descriptions; ///< of the own blocks, until all know them
  std::vector<Message> Own;                   ///< their bytes
  ExchangePlan Plan;
  std::size_t NextBlock = 0;            ///< of Own, to be sent
  std::vector<std::size_t> NextArrival; ///< of Plan.BySource, of each rank
  std::vector<Message> Arrived;
  Cost Spent;
};

/// The bytes of a surface's points, GlobalIds, normals, attributes and cells: what sending it
/// without compression would cost. Of a cell its point numbers are sent; if not all cells are
/// triangles, its size as well.
std::uint64_t GetSurfaceBytes(const Surface& surface);

} // namespace isosurface

#endif
