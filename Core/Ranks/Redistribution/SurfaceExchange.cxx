// SPDX-License-Identifier: BSD-3-Clause
#include "Ranks/Redistribution/SurfaceExchange.h"

#include "Coding/EdgeIndex/EdgeIndexDecoder.h"
#include "Coding/EdgeIndex/EdgeIndexEncoder.h"
#include "Coding/EdgeIndex/IsovalueJoin.h"
#include "Ground/Base/Checksum.h"
#include "Ground/Base/WithinMemory.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <system_error>
#include <thread>
#include <utility>

namespace isosurface
{
namespace
{

/// Takes the edge-index records of one block, one for each isovalue that crosses it.
using TakeBlock = std::function<Status(BlockDescription block, Message bytes)>;

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

/**
 * Encodes the blocks of a source and calls `take` for each, from the calling thread, in the order
 * of the source. Blocks without a surface are left out.
 *
 * Errors: InvalidArgument (the header has a preview, the samples do not fit it), what Acquire or
 * `take` returns, Aborted, OutOfMemory.
 */
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

/**
 * The surface of blocks that arrive as PackBlocks made them. Each block is decoded when marching
 * cubes visits it, and waited for if it is not there yet; points that blocks share are made once.
 * request: see JoinIsovalues.
 *
 * Errors: Corrupt, OutOfMemory, Aborted (also if a block never comes); throws std::bad_alloc.
 */
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

} // namespace
/// Makes the surface of arriving blocks in a thread of its own, so that the calling thread can go
/// on exchanging messages with other ranks.
class SurfaceUnpacking
{
public:
  /// Starts the thread. Header and request must outlive the object. Throws std::system_error if the
  /// thread cannot be started.
  SurfaceUnpacking(const EdgeIndexHeader& header, const ContourRequest& request,
    std::vector<BlockDescription> blocks, int threads)
    : Blocks(std::move(blocks))
    , Thread(
        [this, &header, &request, threads]
        {
          Result<Surface> surface = this->Unpack(header, request, threads);
          const std::lock_guard<std::mutex> lock(this->Mutex);
          this->Outcome = std::move(surface);
          this->Done.notify_all();
        })
  {
  }

  /// Stops the thread, whether it has finished or not.
  ~SurfaceUnpacking()
  {
    this->Stopped = true;
    this->Blocks.GiveUp();
    this->Thread.join();
  }

  SurfaceUnpacking(const SurfaceUnpacking&) = delete;
  SurfaceUnpacking& operator=(const SurfaceUnpacking&) = delete;

  ArrivingBlocks& GetBlocks() { return this->Blocks; }
  /// The fraction that is done, 0 to 1.
  double GetShare() const { return this->Share; }
  /// The surface, once all blocks have arrived; calls `progress` while it waits.
  Result<Surface> Finish(const Progress& progress)
  {
    std::unique_lock<std::mutex> lock(this->Mutex);
    while (!this->Done.wait_for(
      lock, std::chrono::milliseconds(20), [this] { return this->Outcome.has_value(); }))
    {
      if (progress && !progress(this->Share))
      {
        this->Stopped = true;
        return Status(StatusCode::Aborted, "The redistribution was aborted.");
      }
    }
    return std::move(*this->Outcome);
  }

private:
  Result<Surface> Unpack(const EdgeIndexHeader& header, const ContourRequest& request, int threads)
  {
    const auto progress = [this](double share)
    {
      this->Share = share;
      return !this->Stopped;
    };
    return RunWithinMemory("", "There is not enough memory to redistribute the isosurface.",
      [&] { return UnpackBlocks(header, request, this->Blocks, threads, progress); });
  }

  ArrivingBlocks Blocks;
  std::atomic<double> Share{ 0 };
  std::atomic<bool> Stopped{ false };
  std::mutex Mutex;
  std::condition_variable Done;
  std::optional<Result<Surface>> Outcome;
  std::thread Thread; ///< last, since it uses all the others
};

namespace
{

// The fraction of the progress at which all own blocks are encoded.
constexpr double EncodingShare = 0.5;

using Clock = std::chrono::steady_clock;

double GetSecondsSince(Clock::time_point begin)
{
  return std::chrono::duration<double>(Clock::now() - begin).count();
}

// Returns what `step` returns, or an error if memory or threads run out.
template <typename Step>
Status RunWithThreads(Step&& step)
{
  try
  {
    return RunWithinMemory("", "There is not enough memory to redistribute the isosurface.", step);
  }
  catch (const std::system_error& error)
  {
    return { StatusCode::OutOfMemory,
      std::string("There is no thread to redistribute the isosurface: ") + error.what() };
  }
}

// Whether all ranks received the same messages. Collective.
bool IsSameOnAllRanks(Communicator& ranks, const std::vector<Message>& messages)
{
  std::uint64_t sum = 0;
  for (const Message& message : messages)
  {
    sum = ComputeChecksum(message.data(), message.size(), sum);
  }
  // The complement of the maximum of complements is the minimum: one reduction for both.
  std::vector<std::uint64_t> extremes = { sum, ~sum };
  ranks.ReduceMaximum(extremes);
  return extremes[0] == ~extremes[1];
}

} // namespace

SurfaceExchange::SurfaceExchange(Communicator& ranks, const EdgeIndexHeader& header,
  const ContourRequest& request, const Settings& settings)
  : Ranks(ranks)
  , Header(header)
  , Request(request)
  , Wanted(settings)
{
  if (this->Wanted.DrawingRanks < 1 || this->Wanted.DrawingRanks > ranks.GetSize())
  {
    this->Wanted.DrawingRanks = ranks.GetSize();
  }
}

Result<Surface> SurfaceExchange::Run(BlockSource& source, const Progress& progress)
{
  Clock::time_point begin = Clock::now();
  Status status = this->Ranks.Agree(RunWithThreads(
    [&] { return this->Encode(source, MakePartOfProgress(progress, 0, EncodingShare)); }));
  this->Spent.EncodeSeconds = GetSecondsSince(begin);
  ISOSURFACE_RETURN_IF_ERROR(status);
  begin = Clock::now();
  status = this->MakePlan();
  this->Spent.ChooseSeconds = GetSecondsSince(begin);
  ISOSURFACE_RETURN_IF_ERROR(status);
  begin = Clock::now();
  std::optional<SurfaceUnpacking> unpacking;
  status = this->Ranks.Agree(RunWithThreads(
    [&]
    {
      std::vector<BlockDescription> blocks;
      for (ExchangePlan::IncomingBlock& block : this->Plan.Incoming)
      {
        blocks.push_back(block.Description);
      }
      unpacking.emplace(this->Header, this->Request, std::move(blocks), this->Wanted.Threads);
      return Status::Ok();
    }));
  ISOSURFACE_RETURN_IF_ERROR(status);
  const Progress rest = MakePartOfProgress(progress, EncodingShare, 1);
  status = this->SendRounds(*unpacking, rest);
  this->Spent.ExchangeSeconds = GetSecondsSince(begin);
  ISOSURFACE_RETURN_IF_ERROR(status);
  begin = Clock::now();
  Result<Surface> surface = unpacking->Finish(rest);
  status = this->Ranks.Agree(surface.GetStatus());
  this->Spent.DecodeSeconds = GetSecondsSince(begin);
  ISOSURFACE_RETURN_IF_ERROR(status);
  return surface;
}

Status SurfaceExchange::Encode(BlockSource& source, const Progress& progress)
{
  const auto take = [this](BlockDescription block, Message bytes)
  {
    this->Spent.EncodedPoints += block.CountPoints();
    this->Spent.EncodedBytes += block.Bytes;
    ++this->Spent.EncodedBlocks;
    this->Descriptions.push_back(std::move(block));
    this->Own.push_back(std::move(bytes));
    return Status::Ok();
  };
  return PackBlocks(this->Header, source, this->Wanted.Threads, take, progress);
}

Status SurfaceExchange::MakePlan()
{
  Message mine;
  const Status described = RunWithThreads(
    [&]
    {
      mine = ExchangePlan::Describe(this->Descriptions);
      this->Descriptions = {};
      return Status::Ok();
    });
  ISOSURFACE_RETURN_IF_ERROR(this->Ranks.Agree(described));
  this->Spent.SentBytes += mine.size() * static_cast<std::uint64_t>(this->Ranks.GetSize() - 1);
  const std::vector<Message> messages = this->Ranks.AllGather(mine);
  // With different plans, ranks would wait for each other forever.
  ISOSURFACE_RETURN_IF_ERROR(this->Ranks.Agree(
    IsSameOnAllRanks(this->Ranks, messages) ? Status::Ok() : MakeDamagedMessage()));
  return this->Ranks.Agree(RunWithThreads(
    [&]
    {
      ISOSURFACE_ASSIGN_OR_RETURN(this->Plan,
        ExchangePlan::Make(messages, static_cast<std::size_t>(this->Ranks.GetRank()),
          this->Header.Geometry, this->Header.Isovalues.size(),
          static_cast<std::uint32_t>(this->Wanted.DrawingRanks), this->Wanted.RoundBytes));
      this->NextArrival.assign(messages.size(), 0);
      this->Spent.Rounds = this->Plan.Rounds;
      this->Spent.ReceivedBlocks = this->Plan.Incoming.size();
      for (const ExchangePlan::IncomingBlock& block : this->Plan.Incoming)
      {
        this->Spent.ReceivedPoints += block.Description.CountPoints();
      }
      return this->Plan.Own.size() == this->Own.size() ? Status::Ok() : MakeDamagedMessage();
    }));
}

Status SurfaceExchange::SendRounds(SurfaceUnpacking& unpacking, const Progress& progress)
{
  Status status;
  for (std::size_t round = 0; round < this->Plan.Rounds; ++round)
  {
    if (status.IsOk() && progress && !progress(unpacking.GetShare()))
    {
      status = Status(StatusCode::Aborted, "The redistribution was aborted.");
    }
    std::vector<Message> outgoing;
    std::vector<Message> incoming;
    if (status.IsOk())
    {
      status = RunWithThreads(
        [&]
        {
          this->FillRound(round, outgoing, incoming);
          return Status::Ok();
        });
    }
    ISOSURFACE_RETURN_IF_ERROR(this->Ranks.Agree(status));
    this->Ranks.Deliver(std::move(outgoing), incoming,
      [&](int source)
      {
        const auto from = static_cast<std::size_t>(source);
        if (!this->TakeMessage(round, from, std::move(incoming[from]), unpacking.GetBlocks()))
        {
          status = MakeDamagedMessage();
        }
      });
  }
  for (std::size_t source = 0; source < this->NextArrival.size(); ++source)
  {
    if (status.IsOk() && this->NextArrival[source] < this->Plan.BySource[source].size())
    {
      status = MakeDamagedMessage();
    }
  }
  return this->Ranks.Agree(status);
}

// Allocates all that delivering needs, so that it cannot fail on one rank alone.
void SurfaceExchange::FillRound(
  std::size_t round, std::vector<Message>& outgoing, std::vector<Message>& incoming)
{
  const auto self = static_cast<std::size_t>(this->Ranks.GetRank());
  const auto size = static_cast<std::size_t>(this->Ranks.GetSize());
  outgoing.resize(size);
  incoming.resize(size);
  for (; this->NextBlock < this->Own.size() && this->Plan.Own[this->NextBlock].Round == round;
       ++this->NextBlock)
  {
    const std::size_t destination = this->Plan.Own[this->NextBlock].Destination;
    Message& block = this->Own[this->NextBlock];
    outgoing[destination].insert(outgoing[destination].end(), block.begin(), block.end());
    this->Spent.SentBytes += destination == self ? 0 : block.size();
    Message().swap(block);
  }
  for (std::size_t source = 0; source < size; ++source)
  {
    std::size_t bytes = 0;
    const std::vector<std::size_t>& blocks = this->Plan.BySource[source];
    for (std::size_t n = this->NextArrival[source]; n < blocks.size(); ++n)
    {
      const ExchangePlan::IncomingBlock& block = this->Plan.Incoming[blocks[n]];
      if (block.Round != round)
      {
        break;
      }
      bytes += block.Description.Bytes;
    }
    incoming[source].resize(source == self ? 0 : bytes);
  }
  this->Arrived.reserve(this->Arrived.size() + size);
}

bool SurfaceExchange::TakeMessage(
  std::size_t round, std::size_t source, Message message, ArrivingBlocks& blocks)
{
  this->Arrived.push_back(std::move(message));
  const Message& bytes = this->Arrived.back();
  std::size_t at = 0;
  std::size_t& next = this->NextArrival[source];
  for (; next < this->Plan.BySource[source].size(); ++next)
  {
    const std::size_t place = this->Plan.BySource[source][next];
    const ExchangePlan::IncomingBlock& block = this->Plan.Incoming[place];
    if (block.Round != round)
    {
      break;
    }
    if (block.Description.Bytes > bytes.size() - at)
    {
      return false;
    }
    blocks.Arrive(place, bytes.data() + at);
    at += block.Description.Bytes;
  }
  return at == bytes.size();
}

std::uint64_t GetSurfaceBytes(const Surface& surface)
{
  const std::uint64_t index =
    surface.Connectivity.Is64Bit ? sizeof(std::int64_t) : sizeof(std::int32_t);
  std::uint64_t bytes = sizeof(float) * (surface.Points.GetSize() + surface.Normals.GetSize()) +
    sizeof(double) * surface.DoublePoints.GetSize() +
    sizeof(std::int64_t) * surface.GlobalIds.GetSize() + index * surface.Connectivity.GetSize();
  for (const SurfaceAttribute& attribute : surface.Attributes)
  {
    bytes += attribute.Bytes.GetSize();
  }
  // The ends of triangles follow from their number.
  const bool triangles = surface.Connectivity.GetSize() == 3 * surface.NumberOfCells;
  return triangles ? bytes : bytes + index * surface.NumberOfCells;
}

} // namespace isosurface
