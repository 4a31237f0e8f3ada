// SPDX-License-Identifier: BSD-3-Clause
// Parts of blocks are equal in work and compact in space.
#include "Ranks/Redistribution/ExchangePlan.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <numeric>
#include <random>
#include <string>
#include <vector>

using namespace isosurface;

namespace
{

const std::array<double, 3> Cubic = { 1, 1, 1 };

// Blocks of 16 cells, of those that are chosen by their coordinates.
std::vector<WeighedBlock> MakeBlocks(const Index3& size, std::mt19937& random,
  const std::function<bool(const Index3&)>& isThere, std::uint64_t heaviest)
{
  std::vector<WeighedBlock> blocks;
  VisitVertices(VertexBox{ {}, size },
    [&](const Index3& vertex)
    {
      const auto [i, j, k] = vertex;
      if (isThere(vertex))
      {
        blocks.push_back(
          { { { 16 * i, 16 * j, 16 * k }, { 16 * i + 17, 16 * j + 17, 16 * k + 17 } },
            random() % (heaviest + 1) });
      }
    });
  return blocks;
}

// Those that a sphere passes.
std::vector<WeighedBlock> MakeShell(std::mt19937& random)
{
  return MakeBlocks(
    { 16, 16, 16 }, random,
    [](const Index3& at)
    {
      double square = 0;
      for (const std::int64_t c : at)
      {
        square += (static_cast<double>(c) - 7.5) * (static_cast<double>(c) - 7.5);
      }
      return std::abs(std::sqrt(square) - 6) < 0.9;
    },
    5000);
}

std::vector<std::uint64_t> AddWork(const std::vector<WeighedBlock>& blocks,
  const std::vector<std::uint32_t>& parts, std::size_t size)
{
  std::vector<std::uint64_t> work(size);
  for (std::size_t n = 0; n < blocks.size(); ++n)
  {
    work.at(parts[n]) += blocks[n].Workload;
  }
  return work;
}

// The volumes of the parts' bounding boxes, summed.
double AddVolumes(const std::vector<WeighedBlock>& blocks, const std::vector<std::uint32_t>& parts,
  std::size_t size, const std::array<double, 3>& spacing = Cubic)
{
  double sum = 0;
  for (std::size_t part = 0; part < size; ++part)
  {
    double volume = 1;
    for (std::size_t axis = 0; axis < 3; ++axis)
    {
      std::int64_t low = std::numeric_limits<std::int64_t>::max();
      std::int64_t high = 0;
      for (std::size_t n = 0; n < blocks.size(); ++n)
      {
        if (parts[n] == part)
        {
          low = std::min(low, blocks[n].Vertices.Low[axis]);
          high = std::max(high, blocks[n].Vertices.High[axis]);
        }
      }
      volume *= high > low ? static_cast<double>(high - 1 - low) * spacing[axis] : 0;
    }
    sum += volume;
  }
  return sum;
}

// The least work that the fullest part can have, of all assignments.
std::uint64_t FindBestMaximum(
  const std::vector<WeighedBlock>& blocks, std::vector<std::uint64_t>& work, std::size_t next)
{
  if (next == blocks.size())
  {
    return *std::max_element(work.begin(), work.end());
  }
  std::uint64_t best = std::numeric_limits<std::uint64_t>::max();
  for (std::uint64_t& part : work)
  {
    part += blocks[next].Workload;
    best = std::min(best, FindBestMaximum(blocks, work, next + 1));
    part -= blocks[next].Workload;
  }
  return best;
}

std::uint64_t FindHeaviest(const std::vector<WeighedBlock>& blocks)
{
  std::uint64_t heaviest = 0;
  for (const WeighedBlock& block : blocks)
  {
    heaviest = std::max(heaviest, block.Workload);
  }
  return heaviest;
}

} // namespace

TEST(CompactPartition, NoPieceHasMoreThanTheMeanPlusOnePointThreeBlocks)
{
  std::mt19937 random(3);
  for (int trial = 0; trial < 300; ++trial)
  {
    const auto pick = [&](unsigned most)
    { return static_cast<std::uint32_t>(1 + random() % most); };
    const Index3 size = { pick(7), pick(7), pick(7) };
    const std::uint64_t heaviest = trial % 3 == 0 ? 1 : 10000;
    const auto blocks = MakeBlocks(
      size, random, [&](const Index3&) { return random() % 3 > 0; }, heaviest);
    const std::uint32_t parts = pick(40);
    const auto work = AddWork(blocks, MakeCompactPartition(blocks, parts, Cubic), parts);
    const double mean =
      static_cast<double>(std::accumulate(work.begin(), work.end(), std::uint64_t{ 0 })) / parts;
    EXPECT_LE(static_cast<double>(*std::max_element(work.begin(), work.end())),
      mean + 1.3 * static_cast<double>(FindHeaviest(blocks)))
      << "trial " << trial;
  }
}

TEST(CompactPartition, IsWithinOnePointThreeBlocksOfTheBestOfAllAssignments)
{
  std::mt19937 random(4);
  for (int trial = 0; trial < 40; ++trial)
  {
    const auto blocks = MakeBlocks(
      { 2, 2, 2 }, random, [](const Index3&) { return true; }, 1000);
    const auto parts = static_cast<std::uint32_t>(2 + random() % 3);
    const auto work = AddWork(blocks, MakeCompactPartition(blocks, parts, Cubic), parts);
    const std::uint64_t fullest = *std::max_element(work.begin(), work.end());
    std::vector<std::uint64_t> none(parts);
    const std::uint64_t best = FindBestMaximum(blocks, none, 0);
    EXPECT_GE(fullest, best);
    EXPECT_LE(static_cast<double>(fullest),
      static_cast<double>(best) + 1.3 * static_cast<double>(FindHeaviest(blocks)));
  }
}

TEST(CompactPartition, PiecesOfALineOfBlocksAreItsBestCuts)
{
  std::mt19937 random(5);
  for (int trial = 0; trial < 50; ++trial)
  {
    const auto blocks = MakeBlocks(
      { 1, 60, 1 }, random, [](const Index3&) { return true; }, 100);
    const auto parts = MakeCompactPartition(blocks, 2, Cubic);
    EXPECT_TRUE(std::is_sorted(parts.begin(), parts.end()));
    const auto work = AddWork(blocks, parts, 2);
    std::uint64_t best = work[0] + work[1];
    std::uint64_t before = 0;
    for (const WeighedBlock& block : blocks)
    {
      before += block.Workload;
      best = std::min(best, std::max(before, work[0] + work[1] - before));
    }
    EXPECT_EQ(*std::max_element(work.begin(), work.end()), best);
  }
}

TEST(CompactPartition, BoxesOfPiecesHaveLittleMoreVolumeThanTheWhole)
{
  std::mt19937 random(1);
  const auto blocks = MakeShell(random);
  const double whole = AddVolumes(blocks, MakeCompactPartition(blocks, 1, Cubic), 1);
  for (const std::uint32_t parts : { 4U, 7U, 8U, 16U })
  {
    std::vector<std::uint32_t> scattered(blocks.size());
    for (std::uint32_t& part : scattered)
    {
      part = static_cast<std::uint32_t>(random() % parts);
    }
    const double compact = AddVolumes(blocks, MakeCompactPartition(blocks, parts, Cubic), parts);
    const double dealt = AddVolumes(blocks, scattered, parts);
    EXPECT_LT(compact, 1.2 * whole) << parts << " parts";
    EXPECT_LT(compact, dealt / 3) << parts << " parts";
    RecordProperty("VolumeOf" + std::to_string(parts), std::to_string(compact / dealt));
  }
}

TEST(CompactPartition, EqualBlocksBecomeBoxesThatDoNotOverlap)
{
  std::mt19937 random(1);
  auto blocks = MakeBlocks(
    { 8, 8, 4 }, random, [](const Index3&) { return true; }, 0);
  for (WeighedBlock& block : blocks)
  {
    block.Workload = 7;
  }
  EXPECT_DOUBLE_EQ(AddVolumes(blocks, MakeCompactPartition(blocks, 8, Cubic), 8), 128.0 * 128 * 64);
}

TEST(CompactPartition, CutsTheSideThatIsLongestInTheWorld)
{
  std::mt19937 random(1);
  auto blocks = MakeBlocks(
    { 4, 2, 2 }, random, [](const Index3&) { return true; }, 0);
  for (WeighedBlock& block : blocks)
  {
    block.Workload = 1;
  }
  const auto parts = MakeCompactPartition(blocks, 2, { 1, 1, -5 });
  for (std::size_t n = 0; n < blocks.size(); ++n)
  {
    EXPECT_EQ(parts[n], blocks[n].Vertices.Low[2] > 0 ? 1U : 0U);
  }
}

TEST(CompactPartition, DoesNotDependOnTheOrderOfTheBlocks)
{
  std::mt19937 random(8);
  const auto blocks = MakeShell(random);
  const auto expected = MakeCompactPartition(blocks, 7, Cubic);
  std::vector<std::size_t> order(blocks.size());
  std::iota(order.begin(), order.end(), std::size_t{ 0 });
  std::shuffle(order.begin(), order.end(), random);
  std::vector<WeighedBlock> shuffled;
  for (const std::size_t block : order)
  {
    shuffled.push_back(blocks[block]);
  }
  const auto parts = MakeCompactPartition(shuffled, 7, Cubic);
  for (std::size_t n = 0; n < order.size(); ++n)
  {
    EXPECT_EQ(parts[n], expected[order[n]]);
  }
}

TEST(CompactPartition, AcceptsFewerBlocksThanPieces)
{
  std::mt19937 random(1);
  EXPECT_TRUE(MakeCompactPartition({}, 5, Cubic).empty());
  auto blocks = MakeBlocks(
    { 3, 1, 1 }, random, [](const Index3&) { return true; }, 0);
  for (WeighedBlock& block : blocks)
  {
    block.Workload = 9;
  }
  auto parts = MakeCompactPartition(blocks, 8, Cubic);
  EXPECT_EQ(std::unique(parts.begin(), parts.end()), parts.end());
  EXPECT_LT(*std::max_element(parts.begin(), parts.end()), 8U);
}
