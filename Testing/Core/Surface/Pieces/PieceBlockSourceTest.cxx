// SPDX-License-Identifier: BSD-3-Clause
// Blocks of pieces on several ranks are those of the whole grid, sample by sample.
#include "Fixtures/TestBlockSource.h"
#include "Fixtures/ThreadCommunicator.h"

#include "Surface/Contour/BlockRanges.h"
#include "Surface/Pieces/PieceBlockSource.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <mutex>
#include <random>
#include <vector>

using namespace isosurface;

namespace
{

using Volume = SampleVolume<std::int16_t>;

const std::vector<double> Isovalues = { 3, 250 };

// Level but for a few places, so that some blocks are active and others are not.
Volume MakeVolume()
{
  Volume volume({ 70, 37, 53 });
  std::mt19937 random(3);
  for (std::int16_t& sample : volume.Samples)
  {
    sample = random() % 3000 == 0 ? 7 : 1;
  }
  return volume;
}

// The piece of a volume that a rank has in memory, a copy of exactly its size.
struct Part
{
  Part(const Volume& volume, const VertexBox& box)
    : Memory(Index3(box.GetSize()))
  {
    VisitVertices(box,
      [&](const Index3& vertex)
      {
        const auto [i, j, k] = vertex;
        this->Memory.At(i - box.Low[0], j - box.Low[1], k - box.Low[2]) = volume.At(i, j, k);
      });
    this->View = this->Memory.GetView();
    this->View.Available = box;
    this->View.Box = box;
  }
  GridPiece GetPiece() const
  {
    // The array itself serves as an attribute of two components, too.
    return { this->View, { { { this->View, this->View } } } };
  }

  Volume Memory;
  SampleView View;
};

// The boxes of the pieces of each rank.
using Cut = std::vector<std::vector<VertexBox>>;

VertexBox MakeBox(const Index3& low, const Index3& high)
{
  return { low, high };
}

std::vector<Cut> MakeCuts()
{
  const VertexBox whole = MakeBox({ 0, 0, 0 }, { 70, 37, 53 });
  return {
    { { whole } },
    { { whole }, {} },
    { {}, { whole }, { whole } },
    // Slabs that share a face, that overlap, and that do not even meet.
    { { MakeBox({ 0, 0, 0 }, { 70, 37, 21 }) }, { MakeBox({ 0, 0, 20 }, { 70, 37, 53 }) } },
    { { MakeBox({ 0, 0, 0 }, { 40, 37, 53 }) }, { MakeBox({ 30, 0, 0 }, { 50, 37, 53 }) },
      { MakeBox({ 35, 0, 0 }, { 70, 37, 53 }) } },
    { { MakeBox({ 0, 0, 0 }, { 70, 19, 53 }) }, { MakeBox({ 0, 19, 0 }, { 70, 37, 53 }) } },
    // Several pieces a rank.
    { { MakeBox({ 0, 0, 0 }, { 33, 37, 53 }), MakeBox({ 32, 0, 30 }, { 70, 37, 53 }) },
      { MakeBox({ 32, 0, 0 }, { 70, 37, 31 }) } },
  };
}

struct Block
{
  VertexBox Vertices;
  VertexBox Available;
  Index3 Lattice;
};

// The active blocks of all ranks by number; their samples are looked at here.
std::map<std::int64_t, Block> CollectBlocks(
  const Volume& volume, const Cut& cut, const PieceBlockSelection& selection)
{
  std::map<std::int64_t, Block> blocks;
  std::mutex mutex;
  ThreadCommunicator::Run(static_cast<int>(cut.size()),
    [&](Communicator& ranks)
    {
      std::vector<Part> parts;
      for (const VertexBox& box : cut[static_cast<std::size_t>(ranks.GetRank())])
      {
        parts.emplace_back(volume, box);
      }
      std::vector<GridPiece> pieces;
      for (Part& part : parts)
      {
        part.View.First = part.Memory.Samples.data();
        pieces.push_back(part.GetPiece());
      }
      const auto source = PieceBlockSource::Make(ranks, { volume.Geometry, pieces, selection }, 2);
      const std::lock_guard<std::mutex> lock(mutex);
      ASSERT_TRUE(source.IsOk()) << source.GetStatus().GetMessage();
      EXPECT_EQ((*source)->GetFiniteRange().Minimum, MakeValueKey<std::int16_t>(1));
      EXPECT_EQ((*source)->GetFiniteRange().Maximum, MakeValueKey<std::int16_t>(7));
      std::int64_t last = -1;
      for (std::size_t n = 0; n < (*source)->GetNumberOfBlocks(); ++n)
      {
        const std::int64_t number = (*source)->GetNumbers()[n];
        EXPECT_GT(number, last);
        last = number;
        const auto samples = (*source)->Acquire(n);
        ASSERT_TRUE(samples.IsOk());
        EXPECT_EQ(samples->Scalars.Box, (*source)->GetVertices(n));
        ExpectSamples(samples->Scalars, samples->Scalars.Available, volume);
        ASSERT_EQ(samples->Attributes.size(), 1u);
        ASSERT_EQ(samples->Attributes[0].Components.size(), 2u);
        ExpectSamples(samples->Attributes[0].Components[1],
          samples->Attributes[0].Components[1].Available, volume);
        const Block block = { samples->Scalars.Box, samples->Scalars.Available,
          (*source)->GetLatticeCoordinates(n) };
        EXPECT_TRUE(blocks.emplace(number, block).second) << "two ranks have block " << number;
      }
    });
  return blocks;
}

} // namespace

TEST(PieceBlockSource, BlocksDoNotDependOnHowTheGridIsCut)
{
  const Volume volume = MakeVolume();
  for (const int blockSize : { 16, 32, 64 })
  {
    PieceBlockSelection selection;
    selection.Isovalues = Isovalues;
    selection.BlockSize = blockSize;
    const BlockGrid grid(volume.GetDimensions(), blockSize);
    std::vector<std::int64_t> expected;
    for (std::int64_t number = 0; number < grid.GetNumberOfBlocks(); ++number)
    {
      const VertexBox box = grid.GetVertices(number);
      const Part part(volume, box);
      const auto isHigh = [](std::int16_t sample) { return sample >= 3; };
      if (std::any_of(part.Memory.Samples.begin(), part.Memory.Samples.end(), isHigh))
      {
        expected.push_back(number);
      }
    }
    for (const Cut& cut : MakeCuts())
    {
      for (const bool withLayer : { false, true })
      {
        selection.WithLayer = withLayer;
        std::vector<std::int64_t> found;
        for (const auto& [number, block] : CollectBlocks(volume, cut, selection))
        {
          found.push_back(number);
          EXPECT_EQ(block.Vertices, grid.GetVertices(number));
          EXPECT_EQ(block.Lattice, grid.GetBlockCoordinates(number));
          const VertexBox needed =
            withLayer ? grid.GetGhostedVertices(number, 0) : grid.GetVertices(number);
          EXPECT_EQ(block.Available.Intersect(needed), needed);
        }
        EXPECT_EQ(found, expected);
      }
    }
  }
}

TEST(PieceBlockSource, ARegionLeavesBlocksOut)
{
  const Volume volume = MakeVolume();
  PieceBlockSelection selection;
  selection.Isovalues = Isovalues;
  selection.BlockSize = 16;
  selection.Region = Region::FromBounds({ 0, 20, 0, 100, 0, 100 });
  for (const Cut& cut : MakeCuts())
  {
    for (const auto& [number, block] : CollectBlocks(volume, cut, selection))
    {
      EXPECT_LE(block.Vertices.Low[0], 20) << "block " << number;
    }
  }
}

TEST(PieceBlockSource, AGapThatTheSurfaceCrossesIsAnError)
{
  Volume volume({ 40, 40, 40 });
  const Cut cut = { { MakeBox({ 0, 0, 0 }, { 40, 40, 18 }) },
    { MakeBox({ 0, 0, 22 }, { 40, 40, 40 }) } };
  const auto collect = [&]
  {
    std::vector<Status> outcomes(2);
    ThreadCommunicator::Run(2,
      [&](Communicator& ranks)
      {
        const auto rank = static_cast<std::size_t>(ranks.GetRank());
        const Part part(volume, cut[rank][0]);
        PieceBlockSelection selection;
        selection.Isovalues = { 3 };
        selection.BlockSize = 16;
        outcomes[rank] =
          PieceBlockSource::Make(ranks, { volume.Geometry, { part.GetPiece() }, selection }, 1)
            .GetStatus();
      });
    return outcomes;
  };
  volume.At(3, 3, 3) = 9;
  for (const Status& status : collect())
  {
    EXPECT_TRUE(status.IsOk()) << status.GetMessage();
  }
  volume.At(3, 3, 24) = 9;
  for (const Status& status : collect())
  {
    ExpectError(status, StatusCode::InvalidArgument, "gaps");
  }
}

TEST(PieceBlockSource, NoPiecesAreAnErrorOnAllRanks)
{
  ThreadCommunicator::Run(2,
    [](Communicator& ranks)
    {
      const Volume volume({ 4, 4, 4 });
      const auto source = PieceBlockSource::Make(ranks, { volume.Geometry, {}, {} }, 1);
      EXPECT_EQ(source.GetStatus().GetCode(), StatusCode::InvalidArgument);
    });
}
