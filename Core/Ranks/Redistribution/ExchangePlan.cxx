// SPDX-License-Identifier: BSD-3-Clause
#include "Ranks/Redistribution/ExchangePlan.h"

#include "Ground/Base/Coding.h"
#include "Ranks/Redistribution/CompactPartition.h"

#include <algorithm>
#include <tuple>
#include <utility>

namespace isosurface
{
namespace
{

// More than any block of 65^3 vertices and a few isovalues takes.
constexpr std::uint64_t MaximumBytes = std::uint64_t{ 1 } << 40;
constexpr std::int64_t LatticeLimit = std::int64_t{ 1 } << 34;

Status ReadDescription(
  ByteReader& reader, const Index3& dimensions, std::size_t isovalues, BlockDescription& block)
{
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    const auto low = reader.ReadVarint<std::int64_t>();
    const auto vertices = reader.ReadVarint<std::int64_t>();
    const std::int64_t lattice = reader.ReadSignedVarint();
    if (vertices < 1 || vertices > dimensions[axis] || low > dimensions[axis] - vertices ||
      lattice < -LatticeLimit || lattice > LatticeLimit)
    {
      return MakeDamagedMessage();
    }
    block.Vertices.Low[axis] = low;
    block.Vertices.High[axis] = low + vertices;
    block.Lattice[axis] = lattice;
  }
  const auto maximumPoints = 3 * static_cast<std::uint64_t>(block.Vertices.GetNumberOfVertices());
  block.Points.resize(isovalues);
  for (std::uint64_t& points : block.Points)
  {
    points = reader.ReadVarint();
    if (points > maximumPoints)
    {
      return MakeDamagedMessage();
    }
  }
  block.Bytes = reader.ReadVarint();
  return reader.HasFailed() || block.Bytes > MaximumBytes ? MakeDamagedMessage() : Status::Ok();
}

// Reads the descriptions of all ranks' blocks.
Status ReadDescriptions(const std::vector<Message>& messages, const Index3& dimensions,
  std::size_t isovalues, std::uint64_t roundBytes, std::vector<ExchangePlan::IncomingBlock>& blocks)
{
  for (std::size_t source = 0; source < messages.size(); ++source)
  {
    ByteReader reader(messages[source]);
    std::size_t round = 0;
    std::uint64_t bytes = 0;
    while (reader.GetRemaining() > 0)
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
      AppendVarint(message, static_cast<std::uint64_t>(block.Vertices.Low[axis]));
      AppendVarint(message, static_cast<std::uint64_t>(block.Vertices.GetSize()[axis]));
      AppendSignedVarint(message, block.Lattice[axis]);
    }
    for (const std::uint64_t points : block.Points)
    {
      AppendVarint(message, points);
    }
    AppendVarint(message, block.Bytes);
  }
  return message;
}

Result<ExchangePlan> ExchangePlan::Make(const std::vector<Message>& messages, std::size_t rank,
  const GridGeometry& geometry, std::size_t isovalues, std::uint32_t pieces,
  std::uint64_t roundBytes)
{
  std::vector<IncomingBlock> blocks;
  const Status read =
    ReadDescriptions(messages, geometry.GetDimensions(), isovalues, roundBytes, blocks);
  ISOSURFACE_RETURN_IF_ERROR(read);
  std::vector<WeighedBlock> weighed;
  weighed.reserve(blocks.size());
  for (const IncomingBlock& block : blocks)
  {
    weighed.push_back({ block.Description.Vertices, block.Description.CountPoints() });
  }
  const std::vector<std::uint32_t> destinations =
    MakeCompactPartition(weighed, pieces, geometry.Spacing);

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
