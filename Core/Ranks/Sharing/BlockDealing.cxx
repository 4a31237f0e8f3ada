// SPDX-License-Identifier: BSD-3-Clause
#include "Ranks/Sharing/BlockDealing.h"

#include "Ground/Volume/VertexBox.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdlib>
#include <numeric>
#include <tuple>

namespace isosurface
{
namespace
{

constexpr std::int64_t MaximumBits = std::int64_t{ 1 } << 28;

/// Thousandths of the mean work, by the number of axes with active neighbours on both sides and, of
/// the others, with one on one side.
constexpr std::array<std::array<std::int64_t, 4>, 4> WorkOfFaces = { {
  { 370, 300, 450, 610 },
  { 530, 710, 1120, 1120 },
  { 1480, 1580, 1580, 1580 },
  { 2050, 2050, 2050, 2050 },
} };
constexpr std::int64_t WorkOfEdge = 15;     ///< for each active neighbour across an edge
constexpr std::int64_t WorkOfCorner = -116; ///< across a corner
constexpr std::int64_t MinimumWork = 20;

/// Which blocks of a box are active, with a layer of others around them.
class ActiveMap
{
public:
  ActiveMap(const Index3& low, const Index3& high)
    : Low(low)
    , Size{ high[0] - low[0] + 3, high[1] - low[1] + 3, high[2] - low[2] + 3 }
  {
  }
  bool Fits() const
  {
    return static_cast<double>(this->Size[0]) * static_cast<double>(this->Size[1]) *
      static_cast<double>(this->Size[2]) <=
      static_cast<double>(MaximumBits);
  }
  void Allocate()
  {
    this->Bits.resize(static_cast<std::size_t>(this->Size[0] * this->Size[1] * this->Size[2]));
  }
  std::size_t Find(const Index3& block) const
  {
    return static_cast<std::size_t>(block[0] - this->Low[0] + 1 +
      this->Size[0] *
        (block[1] - this->Low[1] + 1 + this->Size[1] * (block[2] - this->Low[2] + 1)));
  }
  void Set(const Index3& block) { this->Bits[this->Find(block)] = true; }
  std::int64_t Has(std::size_t place, std::int64_t i, std::int64_t j, std::int64_t k) const
  {
    const auto step = i + this->Size[0] * (j + this->Size[1] * k);
    return this->Bits[static_cast<std::size_t>(static_cast<std::int64_t>(place) + step)] ? 1 : 0;
  }

private:
  Index3 Low;
  Index3 Size;
  std::vector<bool> Bits;
};

/// The work of a block of full size, in thousandths.
std::int64_t PredictWork(const ActiveMap& map, const Index3& block)
{
  const std::size_t place = map.Find(block);
  std::size_t both = 0;
  std::size_t one = 0;
  const std::int64_t sides[3] = { map.Has(place, -1, 0, 0) + map.Has(place, 1, 0, 0),
    map.Has(place, 0, -1, 0) + map.Has(place, 0, 1, 0),
    map.Has(place, 0, 0, -1) + map.Has(place, 0, 0, 1) };
  for (const std::int64_t active : sides)
  {
    both += active == 2 ? 1 : 0;
    one += active == 1 ? 1 : 0;
  }
  std::int64_t work = WorkOfFaces[both][one];
  for (std::int64_t k = -1; k <= 1; ++k)
  {
    for (std::int64_t j = -1; j <= 1; ++j)
    {
      for (std::int64_t i = -1; i <= 1; ++i)
      {
        const std::int64_t axes = std::abs(i) + std::abs(j) + std::abs(k);
        work += axes < 2 ? 0 : map.Has(place, i, j, k) * (axes == 2 ? WorkOfEdge : WorkOfCorner);
      }
    }
  }
  return std::max(work, MinimumWork);
}

/// The cells of a block, in thousandths of one of full size; at least 1.
std::int64_t FindSize(const BlockGrid& grid, std::int64_t block)
{
  std::int64_t size = 1000;
  for (const std::int64_t vertices : grid.GetVertices(block).GetSize())
  {
    size = size * std::max<std::int64_t>(1, vertices - 1) / grid.GetBlockSize();
  }
  return std::max<std::int64_t>(1, size);
}

constexpr std::int64_t MaximumStep = 24; // finds good lattices; more ranks differ little
constexpr std::int64_t Radius = 3;       // of neighbours that are looked at, in blocks

// How near the nearest blocks of one rank are, and how many such neighbours there are, negated: the
// greater, the better.
std::tuple<std::int64_t, std::int64_t> Judge(std::int64_t ranks, std::int64_t y, std::int64_t z)
{
  std::int64_t nearest = 3 * (Radius + 1) * (Radius + 1);
  std::int64_t count = 0;
  for (std::int64_t k = 0; k <= Radius; ++k)
  {
    for (std::int64_t j = -Radius; j <= Radius; ++j)
    {
      for (std::int64_t i = -Radius; i <= Radius; ++i)
      {
        const std::int64_t square = i * i + j * j + k * k;
        if (square == 0 || square > nearest || (i + y * j + z * k) % ranks != 0)
        {
          continue;
        }
        count = square < nearest ? 1 : count + 1;
        nearest = square;
      }
    }
  }
  return { nearest, -count };
}

/// Moves blocks from ranks with much work to ranks with little of it.
class WorkLeveler
{
public:
  WorkLeveler(
    const std::vector<std::int64_t>& work, std::vector<std::uint32_t>& owners, std::size_t ranks)
    : Work(work)
    , Owners(owners)
    , Loads(ranks)
    , Blocks(ranks)
  {
    for (std::size_t block = 0; block < work.size(); ++block)
    {
      this->Loads[owners[block]] += work[block];
      this->Blocks[owners[block]].push_back(block);
    }
  }

  /// Ends when all ranks have nearly the same work, or no move makes two of them more alike.
  void Run()
  {
    const std::int64_t sum =
      std::accumulate(this->Loads.begin(), this->Loads.end(), std::int64_t{ 0 });
    const std::int64_t mean = sum / static_cast<std::int64_t>(this->Loads.size());
    bool isBetter = true;
    for (std::size_t moves = this->Work.size() / MovedPart; isBetter && moves > 0; --moves)
    {
      const auto most = std::max_element(this->Loads.begin(), this->Loads.end());
      const auto least = std::min_element(this->Loads.begin(), this->Loads.end());
      isBetter = *most - *least > mean / 100 &&
        this->Move(static_cast<std::size_t>(most - this->Loads.begin()),
          static_cast<std::size_t>(least - this->Loads.begin()));
    }
  }

private:
  static constexpr std::size_t MovedPart = 8; ///< at most one block in so many is moved

  /// Moves the block whose work is next to half of the difference; false if that has no use.
  bool Move(std::size_t from, std::size_t to)
  {
    const std::int64_t gap = this->Loads[from] - this->Loads[to];
    std::vector<std::size_t>& mine = this->Blocks[from];
    const auto misses = [&](std::size_t block) { return std::abs(2 * this->Work[block] - gap); };
    const auto best = std::min_element(mine.begin(), mine.end(),
      [&](std::size_t a, std::size_t b) { return misses(a) < misses(b); });
    if (best == mine.end() || this->Work[*best] >= gap)
    {
      return false;
    }
    const std::size_t block = *best;
    mine.erase(best);
    this->Blocks[to].push_back(block);
    this->Loads[from] -= this->Work[block];
    this->Loads[to] += this->Work[block];
    this->Owners[block] = static_cast<std::uint32_t>(to);
    return true;
  }

  const std::vector<std::int64_t>& Work;
  std::vector<std::uint32_t>& Owners;
  std::vector<std::int64_t> Loads;              ///< per rank
  std::vector<std::vector<std::size_t>> Blocks; ///< per rank
};

} // namespace

std::vector<std::int64_t> PredictActiveBlockWork(
  const BlockGrid& grid, const std::vector<std::int64_t>& blocks)
{
  std::vector<std::int64_t> work(blocks.size(), 1);
  if (blocks.empty())
  {
    return work;
  }
  Index3 low = grid.GetBlockCoordinates(blocks.front());
  Index3 high = low;
  for (const std::int64_t block : blocks)
  {
    const Index3 place = grid.GetBlockCoordinates(block);
    for (std::size_t axis = 0; axis < 3; ++axis)
    {
      low[axis] = std::min(low[axis], place[axis]);
      high[axis] = std::max(high[axis], place[axis]);
    }
  }
  ActiveMap map(low, high);
  if (!map.Fits())
  {
    return work;
  }
  map.Allocate();
  for (const std::int64_t block : blocks)
  {
    map.Set(grid.GetBlockCoordinates(block));
  }
  for (std::size_t n = 0; n < blocks.size(); ++n)
  {
    const std::int64_t full = PredictWork(map, grid.GetBlockCoordinates(blocks[n]));
    work[n] = full * FindSize(grid, blocks[n]);
  }
  return work;
}

BlockDealing::BlockDealing(std::uint32_t ranks)
  : Ranks(ranks)
{
  std::tuple<std::int64_t, std::int64_t> best{ 0, 0 };
  const std::int64_t last = std::min(this->Ranks - 1, MaximumStep);
  for (std::int64_t y = 1; y <= last; ++y)
  {
    for (std::int64_t z = y; z <= last; ++z)
    {
      const auto judged = Judge(this->Ranks, y, z);
      if (judged > best)
      {
        best = judged;
        this->StepY = y;
        this->StepZ = z;
      }
    }
  }
}

std::vector<std::uint32_t> BlockDealing::Deal(
  const BlockGrid& grid, const std::vector<std::int64_t>& blocks) const
{
  std::vector<std::int64_t> ascending = blocks;
  std::sort(ascending.begin(), ascending.end());
  std::vector<std::uint32_t> owners;
  owners.reserve(blocks.size());
  for (const std::int64_t block : ascending)
  {
    owners.push_back(this->FindRank(grid.GetBlockCoordinates(block)));
  }
  const std::vector<std::int64_t> work = PredictActiveBlockWork(grid, ascending);
  WorkLeveler(work, owners, static_cast<std::size_t>(this->Ranks)).Run();
  std::vector<std::uint32_t> dealt;
  dealt.reserve(blocks.size());
  for (const std::int64_t block : blocks)
  {
    const auto place = std::lower_bound(ascending.begin(), ascending.end(), block);
    dealt.push_back(owners[static_cast<std::size_t>(place - ascending.begin())]);
  }
  return dealt;
}

} // namespace isosurface
