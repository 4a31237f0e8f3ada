// SPDX-License-Identifier: BSD-3-Clause
#include "Redistribution/ExchangePlan.h"

#include "EdgeIndex/CodedNumbers.h"
#include "Redistribution/CompactPartition.h"

#include <algorithm>
#include <tuple>
#include <utility>

namespace isosurface
{
namespace
{

// No block of 65^3 vertices and a few isovalues comes near it.
constexpr std::uint64_t MostBytes = std::uint64_t{ 1 } << 40;
constexpr std::int64_t LatticeLimit = std::int64_t{ 1 } << 34;

Status ReadDescription(
  NumberReader& reader, const Index3& dimensions, std::size_t isovalues, BlockDescription& block)
{
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    const auto low = static_cast<std::int64_t>(reader.ReadNumber());
    const auto vertices = static_cast<std::int64_t>(reader.ReadNumber());
    const std::int64_t lattice = reader.ReadSigned();
    if (vertices < 1 || vertices > dimensions[axis] || low > dimensions[axis] - vertices ||
      lattice < -LatticeLimit || lattice > LatticeLimit)
    {
      return MakeDamagedMessage();
    }
    block.Vertices.Low[axis] = low;
    block.Vertices.High[axis] = low + vertices;
    block.Lattice[axis] = lattice;
  }
  const auto mostPoints = 3 * static_cast<std::uint64_t>(block.Vertices.GetNumberOfVertices());
  block.Points.resize(isovalues);
  for (std::uint64_t& points : block.Points)
  {
    points = reader.ReadNumber();
    if (points > mostPoints)
    {
      return MakeDamagedMessage();
    }
  }
  block.Bytes = reader.ReadNumber();
  return reader.HasFailed() || block.Bytes > MostBytes ? MakeDamagedMessage() : Status::Ok();
}

// The blocks of all ranks, those of a rank in the order of its message.
Status ReadDescriptions(const std::vector<Message>& messages, const Index3& dimensions,
  std::size_t isovalues, std::uint64_t roundBytes, std::vector<ExchangePlan::IncomingBlock>& blocks)
{
  for (std::size_t source = 0; source < messages.size(); ++source)
  {
    NumberReader reader(messages[source].data(), messages[source].size());
    std::size_t round = 0;
    std::uint64_t bytes = 0;
    while (reader.GetLeft() > 0)
    {
      if (bytes >= roundBytes)
      {
        ++round;
        bytes = 0;
      }
      ExchangePlan::IncomingBlock& block = blocks.emplace_back();
      block.Source = source;
      block.Round = round;
      ISOSURFACE_RETURN_IF_ERROR(ReadDescription(reader, dimensions, isovalues, block.Description));
      bytes += block.Description.Bytes;
    }
  }
  return Status::Ok();
}

} // namespace

Message ExchangePlan::Describe(const std::vector<BlockDescription>& blocks)
{
  Message message;
  for (const BlockDescription& block : blocks)
  {
    for (std::size_t axis = 0; axis < 3; ++axis)
    {
      AppendNumber(message, static_cast<std::uint64_t>(block.Vertices.Low[axis]));
      AppendNumber(message, static_cast<std::uint64_t>(block.Vertices.GetSize()[axis]));
      AppendSigned(message, block.Lattice[axis]);
    }
    for (const std::uint64_t points : block.Points)
    {
      AppendNumber(message, points);
    }
    AppendNumber(message, block.Bytes);
  }
  return message;
}

Result<ExchangePlan> ExchangePlan::Make(const std::vector<Message>& messages, std::size_t rank,
  const GridGeometry& geometry, std::size_t isovalues, std::uint32_t parts,
  std::uint64_t roundBytes)
{
  std::vector<IncomingBlock> blocks;
  const Status read =
    ReadDescriptions(messages, geometry.GetDimensions(), isovalues, roundBytes, blocks);
  if (!read.IsOk())
  {
    return read;
  }
  std::vector<WeighedBlock> weighed;
  weighed.reserve(blocks.size());
  for (const IncomingBlock& block : blocks)
  {
    weighed.push_back({ block.Description.Vertices, block.Description.CountPoints() });
  }
  const std::vector<std::uint32_t> destinations =
    MakeCompactPartition(weighed, parts, geometry.Spacing);

  ExchangePlan plan;
  std::vector<std::size_t> places; // of those that come here, in all blocks
  for (std::size_t n = 0; n < blocks.size(); ++n)
  {
    plan.Rounds = std::max(plan.Rounds, blocks[n].Round + 1);
    if (blocks[n].Source == rank)
    {
      plan.Own.push_back({ destinations[n], blocks[n].Round });
    }
    if (destinations[n] == rank)
    {
      places.push_back(n);
    }
  }
  std::sort(places.begin(), places.end(),
    [&blocks](std::size_t a, std::size_t b)
    {
      const Index3& lowA = blocks[a].Description.Vertices.Low;
      const Index3& lowB = blocks[b].Description.Vertices.Low;
      return std::tie(lowA[2], lowA[1], lowA[0]) < std::tie(lowB[2], lowB[1], lowB[0]);
    });
  std::vector<std::vector<std::pair<std::size_t, std::size_t>>> sequences(messages.size());
  for (std::size_t n = 0; n < places.size(); ++n)
  {
    sequences[blocks[places[n]].Source].emplace_back(places[n], n);
    plan.Incoming.push_back(std::move(blocks[places[n]]));
  }
  plan.BySource.resize(messages.size());
  for (std::size_t source = 0; source < sequences.size(); ++source)
  {
    std::sort(sequences[source].begin(), sequences[source].end());
    for (const auto& entry : sequences[source])
    {
      plan.BySource[source].push_back(entry.second);
    }
  }
  return plan;
}

} // namespace isosurface
