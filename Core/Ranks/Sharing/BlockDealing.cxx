// SPDX-License-Identifier: BSD-3-Clause
#include "Ranks/Sharing/BlockDealing.h"

#include "Ranks/Sharing/ActiveBlockWork.h"

#include <algorithm>
#include <cstddef>
#include <cstdlib>
#include <numeric>
#include <tuple>

namespace isosurface
{
namespace
{

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
