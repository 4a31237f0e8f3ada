// SPDX-License-Identifier: BSD-3-Clause
#include "Redistribution/SurfaceExchange.h"

#include "EdgeIndex/CodedNumbers.h"
#include "EdgeIndex/EdgeIndexDecoder.h"
#include "EdgeIndex/EdgeIndexEncoder.h"
#include "EdgeIndex/IsovalueJoin.h"
#include "Redistribution/CompactPartition.h"

#include <algorithm>
#include <chrono>
#include <memory>
#include <new>
#include <tuple>
#include <utility>

namespace isosurface
{
namespace
{

double GetSecondsSince(std::chrono::steady_clock::time_point begin)
{
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

Status MakeDamaged()
{
  return { StatusCode::Corrupt, "A message of isosurface blocks between ranks arrived damaged." };
}

// What `step` returns, or that there is not enough memory for it.
template <typename Step>
Status RunWithinMemory(Step&& step)
{
  try
  {
    return step();
  }
  catch (const std::bad_alloc&)
  {
    return { StatusCode::OutOfMemory,
      "There is not enough memory to redistribute the isosurface." };
  }
}

} // namespace

SurfaceExchange::SurfaceExchange(
  Communicator& ranks, const EdgeIndexHeader& header, const Settings& settings)
  : Ranks(ranks)
  , Header(header)
  , Wanted(settings)
{
  if (this->Wanted.DrawingRanks < 1 || this->Wanted.DrawingRanks > ranks.GetSize())
  {
    this->Wanted.DrawingRanks = ranks.GetSize();
  }
}

Status SurfaceExchange::Run(BlockSource& source, const Progress& progress)
{
  const auto begin = std::chrono::steady_clock::now();
  const Status encoded = RunWithinMemory([&] { return this->Encode(source, progress); });
  this->Spent.EncodeSeconds = GetSecondsSince(begin);
  ISOSURFACE_RETURN_IF_ERROR(this->Ranks.Agree(encoded));
  const auto exchange = std::chrono::steady_clock::now();
  ISOSURFACE_RETURN_IF_ERROR(this->ChooseDestinations());
  ISOSURFACE_RETURN_IF_ERROR(this->SendRounds());
  this->Spent.ExchangeSeconds = GetSecondsSince(exchange);
  return Status::Ok();
}

Status SurfaceExchange::Encode(BlockSource& source, const Progress& progress)
{
  if (this->Header.PreviewLevel != 0)
  {
    return { StatusCode::InvalidArgument, "An isosurface is redistributed without a preview." };
  }
  return EncodeBlocks(
    this->Header, source, this->Wanted.Threads,
    [this](const std::vector<std::uint8_t>& bytes) { return this->TakeEncoded(bytes); }, progress);
}

// Records of one block follow each other.
Status SurfaceExchange::TakeEncoded(const std::vector<std::uint8_t>& bytes)
{
  std::size_t used = 0;
  for (std::size_t at = 0; at < bytes.size(); at += used)
  {
    const auto record =
      EdgeIndexRecord::Parse(this->Header, bytes.data() + at, bytes.size() - at, used);
    ISOSURFACE_RETURN_IF_ERROR(record.GetStatus());
    const EdgeIndexBlock& block = record->Block;
    if (this->Own.empty() || !(this->Own.back().Vertices == block.Vertices))
    {
      this->Own.emplace_back().Vertices = block.Vertices;
    }
    EncodedBlock& own = this->Own.back();
    own.Points += block.NumberOfPoints;
    own.Bytes.insert(own.Bytes.end(), bytes.data() + at, bytes.data() + at + used);
    this->Spent.EncodedBytes += used;
  }
  this->Spent.EncodedBlocks = this->Own.size();
  return Status::Ok();
}

Status SurfaceExchange::ChooseDestinations()
{
  Message mine;
  const Status described = RunWithinMemory(
    [&]
    {
      mine = this->DescribeBlocks();
      return Status::Ok();
    });
  ISOSURFACE_RETURN_IF_ERROR(this->Ranks.Agree(described));
  const std::vector<Message> messages = this->Ranks.AllGather(mine);
  return this->Ranks.Agree(RunWithinMemory([&] { return this->Partition(messages); }));
}

Message SurfaceExchange::DescribeBlocks() const
{
  Message message;
  for (const EncodedBlock& block : this->Own)
  {
    for (std::size_t axis = 0; axis < 3; ++axis)
    {
      AppendNumber(message, static_cast<std::uint64_t>(block.Vertices.Low[axis]));
      AppendNumber(message, static_cast<std::uint64_t>(block.Vertices.GetSize()[axis]));
    }
    AppendNumber(message, block.Points);
  }
  return message;
}

Status SurfaceExchange::Partition(const std::vector<Message>& messages)
{
  const auto self = static_cast<std::size_t>(this->Ranks.GetRank());
  std::vector<WeighedBlock> blocks;
  std::size_t firstOwn = 0;
  const Index3 dimensions = this->Header.Geometry.GetDimensions();
  for (std::size_t rank = 0; rank < messages.size(); ++rank)
  {
    firstOwn = rank == self ? blocks.size() : firstOwn;
    NumberReader reader(messages[rank].data(), messages[rank].size());
    while (reader.GetLeft() > 0)
    {
      WeighedBlock& block = blocks.emplace_back();
      for (std::size_t axis = 0; axis < 3; ++axis)
      {
        const auto low = static_cast<std::int64_t>(reader.ReadNumber());
        const auto vertices = static_cast<std::int64_t>(reader.ReadNumber());
        if (vertices < 1 || vertices > dimensions[axis] || low > dimensions[axis] - vertices)
        {
          return MakeDamaged();
        }
        block.Vertices.Low[axis] = low;
        block.Vertices.High[axis] = low + vertices;
      }
      block.Workload = reader.ReadNumber();
    }
    if (reader.HasFailed())
    {
      return MakeDamaged();
    }
  }
  const std::vector<std::uint32_t> parts = MakeCompactPartition(
    blocks, static_cast<std::uint32_t>(this->Wanted.DrawingRanks), this->Header.Geometry.Spacing);
  if (firstOwn + this->Own.size() > parts.size())
  {
    return MakeDamaged();
  }
  for (std::size_t n = 0; n < this->Own.size(); ++n)
  {
    this->Own[n].Destination = parts[firstOwn + n];
  }
  for (std::size_t n = 0; n < blocks.size(); ++n)
  {
    this->ExpectedPoints += parts[n] == self ? blocks[n].Workload : 0;
  }
  return Status::Ok();
}

Status SurfaceExchange::SendRounds()
{
  Status status;
  bool isLeft = true;
  while (isLeft)
  {
    std::vector<Message> outgoing;
    if (status.IsOk())
    {
      status = RunWithinMemory(
        [&]
        {
          this->FillRound(outgoing);
          return Status::Ok();
        });
    }
    ISOSURFACE_RETURN_IF_ERROR(this->Ranks.Agree(status));
    std::vector<std::uint64_t> left = { this->Own.size() - this->NextBlock };
    this->Ranks.ReduceMaximum(left);
    isLeft = left.front() > 0;
    std::vector<Message> incoming = this->Ranks.Exchange(std::move(outgoing));
    status = RunWithinMemory([&] { return this->TakeRound(std::move(incoming)); });
    ++this->Spent.Rounds;
  }
  this->SortRecords();
  if (status.IsOk() && this->Spent.ReceivedPoints != this->ExpectedPoints)
  {
    status = MakeDamaged();
  }
  return this->Ranks.Agree(status);
}

void SurfaceExchange::FillRound(std::vector<Message>& outgoing)
{
  const auto self = static_cast<std::size_t>(this->Ranks.GetRank());
  outgoing.resize(static_cast<std::size_t>(this->Ranks.GetSize()));
  std::uint64_t sent = 0;
  for (; this->NextBlock < this->Own.size() && sent < this->Wanted.RoundBytes; ++this->NextBlock)
  {
    EncodedBlock& block = this->Own[this->NextBlock];
    Message& message = outgoing[block.Destination];
    message.insert(message.end(), block.Bytes.begin(), block.Bytes.end());
    sent += block.Bytes.size();
    this->Spent.SentBytes += block.Destination == self ? 0 : block.Bytes.size();
    std::vector<std::uint8_t>().swap(block.Bytes);
  }
}

Status SurfaceExchange::TakeRound(std::vector<Message> incoming)
{
  for (Message& message : incoming)
  {
    this->Arrived.push_back(std::move(message));
    const Message& bytes = this->Arrived.back();
    std::size_t used = 0;
    for (std::size_t at = 0; at < bytes.size(); at += used)
    {
      const auto record =
        EdgeIndexRecord::Parse(this->Header, bytes.data() + at, bytes.size() - at, used);
      if (!record.IsOk() || record->Block.IsPreview)
      {
        return MakeDamaged();
      }
      this->Records.push_back(*record);
      this->Spent.ReceivedPoints += record->Block.NumberOfPoints;
    }
  }
  return Status::Ok();
}

// By place, so that the surface does not tell which rank a block came from.
void SurfaceExchange::SortRecords()
{
  const auto getKey = [](const EdgeIndexRecord& record)
  {
    const Index3& low = record.Block.Vertices.Low;
    return std::make_tuple(low[2], low[1], low[0], record.Block.Isovalue);
  };
  std::sort(this->Records.begin(), this->Records.end(),
    [&](const EdgeIndexRecord& a, const EdgeIndexRecord& b) { return getKey(a) < getKey(b); });
  for (std::size_t n = 0; n < this->Records.size(); ++n)
  {
    const bool isNew =
      n == 0 || !(this->Records[n].Block.Vertices == this->Records[n - 1].Block.Vertices);
    this->Spent.ReceivedBlocks += isNew ? 1 : 0;
  }
}

Result<Surface> SurfaceExchange::MakeSurface(
  const ContourRequest& request, int threads, const Progress& progress) const
{
  Result<Surface> surface = Surface();
  const Status status = RunWithinMemory(
    [&]
    {
      std::vector<std::vector<EdgeIndexRecord>> records(this->Header.Isovalues.size());
      for (const EdgeIndexRecord& record : this->Records)
      {
        records[record.Block.Isovalue].push_back(record);
      }
      std::vector<std::unique_ptr<BlockSource>> sources;
      sources.reserve(records.size());
      for (std::vector<EdgeIndexRecord>& blocks : records)
      {
        sources.push_back(std::make_unique<EdgeIndexBlockSource>(this->Header, std::move(blocks)));
      }
      surface = JoinIsovalues(this->Header, sources, request, threads, progress);
      return surface.GetStatus();
    });
  if (!status.IsOk())
  {
    return status;
  }
  return surface;
}

std::uint64_t GetSurfaceBytes(const Surface& surface)
{
  const auto getIndexBytes = [](const IndexArray& array)
  { return array.GetSize() * (array.Is64Bit ? sizeof(std::int64_t) : sizeof(std::int32_t)); };
  std::uint64_t bytes = sizeof(float) * (surface.Points.GetSize() + surface.Normals.GetSize()) +
    sizeof(std::int64_t) * surface.GlobalIds.GetSize() + getIndexBytes(surface.Connectivity) +
    getIndexBytes(surface.Offsets);
  for (const SurfaceAttribute& attribute : surface.Attributes)
  {
    bytes += attribute.Bytes.GetSize();
  }
  return bytes;
}

} // namespace isosurface
