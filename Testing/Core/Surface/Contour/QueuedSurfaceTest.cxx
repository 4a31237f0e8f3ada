// SPDX-License-Identifier: BSD-3-Clause
// Surfaces of blocks that become known during the extraction: those of a source that has them from
// the start, bit for bit.
#include "Fixtures/AttributedSource.h"
#include "Fixtures/LongTests.h"
#include "Fixtures/PlainContour.h"
#include "Ground/Volume/BlockQueue.h"
#include "Surface/Contour/SurfaceExtractor.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <utility>
#include <vector>

using namespace isosurface;

namespace
{

/// Hands out some blocks of a source, a few at a time.
class TestQueue : public BlockQueue
{
public:
  explicit TestQueue(std::vector<std::size_t> blocks)
    : Blocks(std::move(blocks))
  {
  }
  Result<std::vector<std::size_t>> Take() override
  {
    if (this->FailsAt && this->Taken >= *this->FailsAt)
    {
      return Status(StatusCode::IoError, "no counter");
    }
    std::vector<std::size_t> batch;
    for (std::size_t n = 1 + this->Taken % 3; n > 0 && this->Taken < this->Blocks.size(); --n)
    {
      batch.push_back(this->Blocks[this->Taken++]);
    }
    return batch;
  }
  std::size_t GetExpectedBlocks() const override { return this->Blocks.size(); }
  void LetOthersIn() override { ++this->Calls; }

  std::optional<std::size_t> FailsAt;
  int Calls = 0;

private:
  std::vector<std::size_t> Blocks;
  std::size_t Taken = 0;
};

std::vector<std::size_t> ListAll(const BlockSource& source)
{
  std::vector<std::size_t> blocks(source.GetNumberOfBlocks());
  std::iota(blocks.begin(), blocks.end(), std::size_t{ 0 });
  return blocks;
}

ContourRequest MakeRequest()
{
  ContourRequest request = MakePlainRequest({ 60, 40.5 });
  request.Offsets = true;
  request.Attributes = { { ValueType::Int16, 1 },
    { ValueType::Float32, AttributedSource::VectorSize }, { ValueType::Float64, 1 } };
  return request;
}

/// Some blocks of a random volume, in random order, by a queue; the same in ascending order, by a
/// source of these alone.
void CheckSubset(const ContourRequest& request, std::mt19937& random)
{
  std::uniform_int_distribution<int> size(2, 20);
  const Index3 dimensions{ size(random), size(random), size(random) };
  const auto volume = MakeRandomVolume<std::uint8_t>(random, dimensions, 100);
  const int blockSize = 1 + static_cast<int>(random() % 6);
  AttributedSource all(volume, blockSize, false);
  AttributedSource some(volume, blockSize, false);
  some.Blocks.clear();
  std::vector<std::size_t> chosen;
  for (std::size_t block = 0; block < all.Blocks.size(); ++block)
  {
    if (random() % 4 != 0)
    {
      chosen.push_back(block);
      some.Blocks.push_back(all.Blocks[block]);
    }
  }
  const auto whole = Require(ExtractSurface(volume.Geometry, some, request, 1));
  for (const int threads : { 1, 3 })
  {
    std::shuffle(chosen.begin(), chosen.end(), random);
    TestQueue queue(chosen);
    all.Acquired = 0;
    const auto queued =
      Require(ExtractQueuedSurface(volume.Geometry, all, request, queue, threads));
    EXPECT_EQ(all.Acquired, static_cast<int>(chosen.size()));
    ExpectSameSurface(queued, whole);
  }
}

} // namespace

TEST(QueuedSurface, IsThatOfASourceOfTheSameBlocks)
{
  std::mt19937 random(50);
  for (int trial = 0; trial < ChooseTrials(60); ++trial)
  {
    CheckSubset(MakeRequest(), random);
  }
}

TEST(QueuedSurface, IsTheSameWithPolygonsClosedSidesAndWithoutDegenerateTriangles)
{
  std::mt19937 random(51);
  for (int trial = 0; trial < ChooseTrials(60); ++trial)
  {
    ContourRequest request = MakeRequest();
    request.Polygons = trial % 5 == 0;
    request.DropDegenerateTriangles = trial % 2 == 0;
    request.ClosedSides = trial % 3 == 0 ? GridSides::All() : GridSides();
    CheckSubset(request, random);
  }
}

TEST(QueuedSurface, OfBlocksOfSeveralBricksIsThatOfASourceOfTheSameBlocks)
{
  std::mt19937 random(52);
  const auto volume = MakeRandomVolume<float>(random, { 130, 35, 66 }, 1000);
  TestBlockSource<float> source(volume, 64);
  ContourRequest request = MakeRequest();
  request.Attributes.clear();
  request.Isovalues = { 480 };
  const auto whole = Require(ExtractSurface(volume.Geometry, source, request, 2));
  std::vector<std::size_t> blocks(source.GetNumberOfBlocks());
  for (std::size_t block = 0; block < blocks.size(); ++block)
  {
    blocks[block] = blocks.size() - 1 - block;
  }
  TestQueue queue(blocks);
  const auto queued = Require(ExtractQueuedSurface(volume.Geometry, source, request, queue, 2));
  ExpectSameSurface(queued, whole);
}

TEST(QueuedSurface, OfNoBlocksIsEmpty)
{
  std::mt19937 random(53);
  const auto volume = MakeRandomVolume<std::uint8_t>(random, { 9, 9, 9 }, 100);
  TestBlockSource<std::uint8_t> source(volume, 4);
  const ContourRequest request = MakePlainRequest({ 60 });
  TestQueue queue({});
  const auto queued = Require(ExtractQueuedSurface(volume.Geometry, source, request, queue, 2));
  EXPECT_EQ(queued.NumberOfTriangles, 0u);
  EXPECT_EQ(queued.NumberOfBlocks, 0u);
}

TEST(QueuedSurface, TellsTheErrorsOfTheQueueAndOfABlock)
{
  std::mt19937 random(54);
  const auto volume = MakeRandomVolume<std::uint8_t>(random, { 19, 19, 19 }, 100);
  TestBlockSource<std::uint8_t> source(volume, 4);
  const std::vector<std::size_t> blocks = ListAll(source);
  const ContourRequest request = MakePlainRequest({ 60 });
  for (const int threads : { 1, 3 })
  {
    TestQueue broken(blocks);
    broken.FailsAt = 10;
    EXPECT_EQ(ExtractQueuedSurface(volume.Geometry, source, request, broken, threads)
                .GetStatus()
                .GetMessage(),
      "no counter");
    source.Failing = 50;
    TestQueue sound(blocks);
    EXPECT_EQ(ExtractQueuedSurface(volume.Geometry, source, request, sound, threads)
                .GetStatus()
                .GetMessage(),
      "block.store: no medium");
    source.Failing.reset();
  }
}

TEST(QueuedSurface, LetsOthersInAndEndsWhenProgressSaysSo)
{
  std::mt19937 random(55);
  const auto volume = MakeRandomVolume<std::uint8_t>(random, { 19, 19, 19 }, 100);
  TestBlockSource<std::uint8_t> source(volume, 4);
  const std::vector<std::size_t> blocks = ListAll(source);
  const ContourRequest request = MakePlainRequest({ 60 });
  TestQueue queue(blocks);
  EXPECT_TRUE(ExtractQueuedSurface(volume.Geometry, source, request, queue, 1).IsOk());
  EXPECT_GT(queue.Calls, 1) << "in both phases";
  TestQueue stopped(blocks);
  const auto surface = ExtractQueuedSurface(
    volume.Geometry, source, request, stopped, 1, [](double) { return false; });
  EXPECT_EQ(surface.GetStatus().GetCode(), StatusCode::Aborted);
}
