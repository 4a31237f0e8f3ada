// SPDX-License-Identifier: BSD-3-Clause
#include "Ranks/Redistribution/ExchangePlan.h"

#include "Ground/Base/Coding.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <tuple>
#include <utility>

namespace isosurface
{
namespace
{

// See MakeCompactPartition. Order is sorted in place, range by range; a range of it is what is cut.
class Bisection
{
public:
  Bisection(const std::vector<WeighedBlock>& blocks, const std::array<double, 3>& spacing)
    : Blocks(blocks)
    , Spacing(spacing)
    , Order(blocks.size())
    , Pieces(blocks.size())
  {
    std::iota(this->Order.begin(), this->Order.end(), std::size_t{ 0 });
  }

  std::vector<std::uint32_t> Run(std::uint32_t pieces)
  {
    this->Divide(0, this->Order.size(), 0, pieces);
    return std::move(this->Pieces);
  }

private:
  // Assigns the blocks [begin, end) of Order to `pieces` pieces from `first` on.
  void Divide(std::size_t begin, std::size_t end, std::uint32_t first, std::uint32_t pieces)
  {
    if (pieces == 1)
    {
      for (std::size_t n = begin; n < end; ++n)
      {
        this->Pieces[this->Order[n]] = first;
      }
      return;
    }
    this->Sort(begin, end);
    const std::uint32_t lower = pieces / 2;
    const std::size_t cut = this->FindCut(begin, end, lower, pieces - lower);
    this->Divide(begin, cut, first, lower);
    this->Divide(cut, end, first + lower, pieces - lower);
  }

  void Sort(std::size_t begin, std::size_t end)
  {
    const std::size_t axis = this->FindLongestAxis(begin, end);
    const auto isBefore = [&](std::size_t a, std::size_t b)
    {
      const Index3& lowA = this->Blocks[a].Vertices.Low;
      const Index3& lowB = this->Blocks[b].Vertices.Low;
      for (std::size_t n = 0; n < 3; ++n)
      {
        const std::size_t next = (axis + n) % 3;
        if (lowA[next] != lowB[next])
        {
          return lowA[next] < lowB[next];
        }
      }
      return false;
    };
    std::sort(this->Order.begin() + static_cast<std::ptrdiff_t>(begin),
      this->Order.begin() + static_cast<std::ptrdiff_t>(end), isBefore);
  }

  std::size_t FindLongestAxis(std::size_t begin, std::size_t end) const
  {
    VertexBox bounds = begin < end ? this->Blocks[this->Order[begin]].Vertices : VertexBox();
    for (std::size_t n = begin; n < end; ++n)
    {
      bounds.Extend(this->Blocks[this->Order[n]].Vertices);
    }
    std::size_t longest = 0;
    double maximum = -1;
    for (std::size_t axis = 0; axis < 3; ++axis)
    {
      const double length =
        static_cast<double>(bounds.GetSize()[axis] - 1) * std::abs(this->Spacing[axis]);
      if (length > maximum)
      {
        maximum = length;
        longest = axis;
      }
    }
    return longest;
  }

  // The cut at which the maximum of the mean works on both sides is minimal. (A cut among n pieces
  // raises the mean by at most 1 / n of a block, hence the bound of 1.3 blocks.)
  std::size_t FindCut(
    std::size_t begin, std::size_t end, std::uint32_t lower, std::uint32_t upper) const
  {
    std::uint64_t before = 0;
    std::uint64_t behind = 0;
    for (std::size_t n = begin; n < end; ++n)
    {
      behind += this->Blocks[this->Order[n]].Workload;
    }
    std::size_t cut = begin;
    double minimum = static_cast<double>(behind) / upper;
    for (std::size_t n = begin; n < end; ++n)
    {
      before += this->Blocks[this->Order[n]].Workload;
      behind -= this->Blocks[this->Order[n]].Workload;
      const double mean =
        std::max(static_cast<double>(before) / lower, static_cast<double>(behind) / upper);
      if (mean < minimum)
      {
        minimum = mean;
        cut = n + 1;
      }
    }
    return cut;
  }

  const std::vector<WeighedBlock>& Blocks;
  const std::array<double, 3>& Spacing;
  std::vector<std::size_t> Order;
  std::vector<std::uint32_t> Pieces;
};

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

std::vector<std::uint32_t> MakeCompactPartition(const std::vector<WeighedBlock>& blocks,
  std::uint32_t pieces, const std::array<double, 3>& spacing)
{
  return Bisection(blocks, spacing).Run(pieces);
}

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
