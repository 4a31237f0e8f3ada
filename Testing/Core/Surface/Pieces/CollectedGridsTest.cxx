// SPDX-License-Identifier: BSD-3-Clause
// The images of all ranks become pieces of grids, the same grids on all ranks.
#include "Surface/Pieces/CollectedGrids.h"

#include "Fixtures/Require.h"
#include "Fixtures/ThreadCommunicator.h"

#include "Ground/Volume/SampleCopy.h"

#include <gtest/gtest.h>

#include <array>
#include <memory>
#include <utility>
#include <vector>

using namespace isosurface;

namespace
{

using GridExtent = std::array<std::int64_t, 6>;

/// The samples of an extent: x + 10 y + 100 z, plus `offset`.
MemoryImage MakeMemoryImage(
  const GridExtent& extent, std::vector<std::int64_t> block, float offset = 0)
{
  MemoryImage image;
  image.Grid.Extent = extent;
  image.Block = std::move(block);
  const auto samples = std::make_shared<std::vector<float>>();
  VisitVertices(
    { { extent[0], extent[2], extent[4] }, { extent[1] + 1, extent[3] + 1, extent[5] + 1 } },
    [&](const Index3& at)
    { samples->push_back(static_cast<float>(at[0] + 10 * at[1] + 100 * at[2]) + offset); });
  image.MakePiece = [extent, samples](const GridGeometry& grid) -> Result<MemoryPiece>
  {
    VertexBox box;
    for (std::size_t axis = 0; axis < 3; ++axis)
    {
      box.Low[axis] = extent[2 * axis] - grid.Extent[2 * axis];
      box.High[axis] = extent[2 * axis + 1] - grid.Extent[2 * axis] + 1;
    }
    MemoryPiece piece;
    piece.Components = { MakeSampleView(ValueType::Float32, box, samples->data()) };
    piece.Owner = samples;
    return piece;
  };
  return image;
}

/// What each rank collects of images that are dealt to the ranks in turn.
std::vector<CollectedGrids> CollectOn(int size, const std::vector<MemoryImage>& images)
{
  return ThreadCommunicator::Collect(size,
    [&](Communicator& ranks)
    {
      MemoryImages mine;
      for (std::size_t n = 0; n < images.size(); ++n)
      {
        if (n % static_cast<std::size_t>(size) == static_cast<std::size_t>(ranks.GetRank()))
        {
          mine.Images.push_back(images[n]);
        }
      }
      mine.AreThere = !mine.Images.empty();
      return Require(CollectedGrids::Collect(
        ranks, [&] { return mine; }, 1));
    });
}

/// Expects the piece of image `number` to have that image's samples where its grid says.
void ExpectPieceSamples(const CollectedGrids& grids, std::size_t piece, float offset)
{
  const MemoryPiece& found = grids.Pieces[piece];
  const GridExtent& extent = grids.Grids[found.Grid].Extent;
  const SampleView& view = found.Components.front();
  VisitVertices(view.Box,
    [&](const Index3& at)
    {
      const std::int64_t value =
        extent[0] + at[0] + 10 * (extent[2] + at[1]) + 100 * (extent[4] + at[2]);
      EXPECT_EQ(*view.At<float>(at), static_cast<float>(value) + offset);
    });
}

constexpr GridExtent West = { -2, 2, 5, 8, 0, 3 };
constexpr GridExtent East = { 2, 6, 5, 8, 0, 3 };

} // namespace

TEST(CollectedGrids, PiecesThatMeetAreOneGridWhicheverRanksHaveThem)
{
  const std::vector<MemoryImage> images = { MakeMemoryImage(West, { 0 }),
    MakeMemoryImage(East, { 1 }) };
  for (const int size : { 1, 2, 3 })
  {
    const std::vector<CollectedGrids> all = CollectOn(size, images);
    std::size_t pieces = 0;
    for (const CollectedGrids& grids : all)
    {
      ASSERT_EQ(grids.Grids.size(), 1u) << size << " ranks";
      EXPECT_EQ(grids.Grids[0].Extent, (GridExtent{ -2, 6, 5, 8, 0, 3 }));
      EXPECT_FALSE(grids.Lines.at(0));
      EXPECT_EQ(grids.Paths, (std::vector<std::vector<std::int64_t>>{ { 0 } }));
      EXPECT_EQ(grids.Blocks, std::vector<std::size_t>{ 0 });
      for (std::size_t piece = 0; piece < grids.Pieces.size(); ++piece)
      {
        ExpectPieceSamples(grids, piece, 0);
      }
      pieces += grids.Pieces.size();
    }
    EXPECT_EQ(pieces, 2u);
  }
}

TEST(CollectedGrids, ImagesWithOtherSamplesAtTheSamePlaceHaveGridsOfTheirOwn)
{
  const std::vector<MemoryImage> images = { MakeMemoryImage(West, { 4 }, 0.5F),
    MakeMemoryImage(West, { 1 }) };
  for (const int size : { 1, 2 })
  {
    for (const CollectedGrids& grids : CollectOn(size, images))
    {
      ASSERT_EQ(grids.Grids.size(), 2u) << size << " ranks";
      EXPECT_EQ(grids.Grids[0], grids.Grids[1]);
      EXPECT_EQ(grids.Paths, (std::vector<std::vector<std::int64_t>>{ { 1 }, { 4 } }));
      EXPECT_EQ(grids.Blocks, (std::vector<std::size_t>{ 0, 1 })) << "in the order of the blocks";
      for (std::size_t piece = 0; piece < grids.Pieces.size(); ++piece)
      {
        ExpectPieceSamples(grids, piece, grids.Blocks[grids.Pieces[piece].Grid] == 1 ? 0.5F : 0);
      }
    }
  }
}

TEST(CollectedGrids, GridsApartHaveExtentsOfTheirOwnInOneNumbering)
{
  const GridExtent far = { 20, 22, 5, 8, 0, 3 };
  for (const CollectedGrids& grids :
    CollectOn(2, { MakeMemoryImage(West, { 0 }), MakeMemoryImage(far, { 1 }) }))
  {
    ASSERT_EQ(grids.Grids.size(), 2u);
    EXPECT_EQ(grids.Grids[0].Extent, West);
    EXPECT_EQ(grids.Grids[1].Extent, far);
    ASSERT_EQ(grids.Pieces.size(), 1u);
    ExpectPieceSamples(grids, 0, 0);
  }
}

TEST(CollectedGrids, RectilinearGridsFollowTheRegularOnes)
{
  const auto makeLined = [](std::vector<double> x, std::vector<std::int64_t> block)
  {
    const auto last = static_cast<std::int64_t>(x.size()) - 1;
    MemoryImage image = MakeMemoryImage({ 0, last, 0, 1, 0, 1 }, std::move(block));
    image.Lines = GridLines{ { std::move(x), { 0, 1 }, { 0, 1 } } };
    return image;
  };
  for (const int size : { 1, 2, 3 })
  {
    for (const CollectedGrids& grids :
      CollectOn(size, { makeLined({ 0, 1, 4 }, { 0 }), MakeMemoryImage(West, { 1 }) }))
    {
      ASSERT_EQ(grids.Grids.size(), 2u) << size << " ranks";
      EXPECT_FALSE(grids.Lines[0]);
      ASSERT_TRUE(grids.Lines[1]);
      EXPECT_EQ(grids.Lines[1]->Coordinates[0], (std::vector<double>{ 0, 1, 4 }));
      EXPECT_EQ(grids.Blocks, (std::vector<std::size_t>{ 1, 0 }));
      for (const MemoryPiece& piece : grids.Pieces)
      {
        EXPECT_EQ(piece.Components.front().Box.GetSize(), grids.Grids[piece.Grid].GetDimensions());
      }
    }
  }
}

TEST(CollectedGrids, ImagesWithoutTheArrayAreAnErrorAndNoImagesAreNone)
{
  for (const bool areThere : { true, false })
  {
    const auto statuses = ThreadCommunicator::Collect(2,
      [&](Communicator& ranks)
      {
        MemoryImages mine;
        mine.AreThere = areThere && ranks.GetRank() == 1;
        return CollectedGrids::Collect(
          ranks, [&] { return mine; }, 1)
          .GetStatus();
      });
    for (const Status& status : statuses)
    {
      EXPECT_EQ(status.GetCode(), areThere ? StatusCode::NotFound : StatusCode::Ok);
    }
  }
}

TEST(CollectedGrids, AnErrorOfOneRankIsOneOfAll)
{
  for (const bool isOfPiece : { false, true })
  {
    const Status fault(StatusCode::InvalidArgument, "cannot be contoured");
    const auto statuses = ThreadCommunicator::Collect(3,
      [&](Communicator& ranks)
      {
        const auto describe = [&]() -> Result<MemoryImages>
        {
          const bool isFaulty = ranks.GetRank() == 1;
          if (isFaulty && !isOfPiece)
          {
            return fault;
          }
          MemoryImages mine{ { MakeMemoryImage(West, { ranks.GetRank() }) }, true };
          if (isFaulty)
          {
            mine.Images[0].MakePiece = [&](const GridGeometry&) -> Result<MemoryPiece>
            { return fault; };
          }
          return mine;
        };
        return CollectedGrids::Collect(ranks, describe, 1).GetStatus();
      });
    EXPECT_EQ(statuses[1].GetCode(), StatusCode::InvalidArgument);
    EXPECT_EQ(statuses[1].GetMessage(), fault.GetMessage());
    for (const int other : { 0, 2 })
    {
      EXPECT_EQ(statuses[static_cast<std::size_t>(other)].GetCode(), StatusCode::RemoteFailure);
    }
  }
}
