// SPDX-License-Identifier: BSD-3-Clause
#include "Ranks/Compositing/ViewportCompositor.h"

#include "Fixtures/ThreadCommunicator.h"
#include "RandomImages.h"
#include "Ranks/Compositing/ImageScaling.h"

#include <gtest/gtest.h>

#include <mutex>

using namespace isosurface;

namespace
{

/// Pixel by pixel, rank by rank: of all samples over the pixel the nearest one, the last of equals.
ImageBuffer MergeOneByOne(const std::vector<Viewport>& viewports,
  const std::vector<ImageBuffer>& images, const PixelRectangle& tile)
{
  ImageBuffer merged;
  merged.Raster = tile;
  for (int y = tile.Y; y < tile.GetTop(); ++y)
  {
    for (int x = tile.X; x < tile.GetRight(); ++x)
    {
      std::uint32_t color = 0;
      float depth = 1.0F;
      for (std::size_t rank = 0; rank < viewports.size(); ++rank)
      {
        const int column = x / viewports[rank].Divisor;
        const int row = y / viewports[rank].Divisor;
        if (viewports[rank].Blocks.Contains(column, row))
        {
          const std::size_t index = images[rank].GetView().GetIndex(column, row);
          if (images[rank].Depths[index] < 1.0F && images[rank].Depths[index] <= depth)
          {
            depth = images[rank].Depths[index];
            color = images[rank].Colors[index];
          }
        }
      }
      merged.Colors.push_back(color);
      merged.Depths.push_back(depth);
    }
  }
  return merged;
}

struct Frame
{
  std::vector<Viewport> Viewports;
  std::vector<DisplayTile> Tiles;
  std::vector<ImageBuffer> Images;
};

Frame MakeFrame(const std::vector<Viewport>& viewports, const std::vector<DisplayTile>& tiles)
{
  Frame frame{ viewports, tiles, {} };
  for (std::size_t rank = 0; rank < viewports.size(); ++rank)
  {
    frame.Images.push_back(
      MakeRandomImage(viewports[rank].Blocks, static_cast<unsigned>(rank + 1)));
  }
  return frame;
}

/// Composites some frames one after the other with the same compositors; compares each tile.
void CheckFrames(int ranks, const std::vector<Frame>& frames)
{
  ThreadCommunicator::Run(ranks,
    [&frames](Communicator& communicator)
    {
      ViewportCompositor compositor;
      const auto me = static_cast<std::size_t>(communicator.GetRank());
      for (const Frame& frame : frames)
      {
        for (const bool wantsDepths : { false, true })
        {
          ImageBuffer shown;
          for (const DisplayTile& tile : frame.Tiles)
          {
            if (tile.Rank == communicator.GetRank())
            {
              shown.Raster = tile.Pixels;
            }
          }
          shown.Colors.assign(static_cast<std::size_t>(shown.Raster.GetArea()), 77);
          shown.Depths.assign(static_cast<std::size_t>(shown.Raster.GetArea()), 77);
          const Status status = compositor.Composite(communicator, { frame.Tiles }, frame.Viewports,
            frame.Images[me].GetView(),
            { shown.Colors.data(), wantsDepths ? shown.Depths.data() : nullptr }, wantsDepths);
          EXPECT_TRUE(status.IsOk()) << status.GetMessage();
          const ImageBuffer expected = MergeOneByOne(frame.Viewports, frame.Images, shown.Raster);
          EXPECT_EQ(shown.Colors, expected.Colors);
          if (wantsDepths)
          {
            EXPECT_EQ(shown.Depths, expected.Depths);
          }
        }
      }
    });
}

constexpr PixelRectangle ComposedDisplay{ 0, 0, 73, 59 };

} // namespace

TEST(ViewportCompositor, AnyViewportsAndResolutionsGiveTheImageMergedOneByOne)
{
  std::mt19937 random(11);
  for (const int ranks : { 1, 2, 3, 4, 7 })
  {
    std::vector<Frame> frames;
    for (int trial = 0; trial < 12; ++trial)
    {
      std::vector<Viewport> viewports;
      for (int rank = 0; rank < ranks; ++rank)
      {
        const int divisor = std::array<int, 5>{ 1, 1, 2, 3, 8 }[random() % 5];
        viewports.push_back(MakeViewport(MakeRandomRectangle(ComposedDisplay, random), divisor));
      }
      frames.push_back(MakeFrame(viewports, { { ComposedDisplay, trial % ranks } }));
    }
    CheckFrames(ranks, frames);
  }
}

TEST(ViewportCompositor, EqualNestedDisjointAndEmptyViewports)
{
  const Viewport all = MakeViewport(ComposedDisplay, 1);
  const Viewport inner = MakeViewport({ 20, 20, 30, 20 }, 1);
  const std::vector<DisplayTile> tiles = { { ComposedDisplay, 0 } };
  CheckFrames(3,
    { MakeFrame({ all, all, all }, tiles),
      MakeFrame({ inner, all, MakeViewport(ComposedDisplay, 4) }, tiles),
      MakeFrame({ MakeViewport({ 0, 0, 30, 59 }, 1), MakeViewport({ 30, 0, 20, 59 }, 2),
                  MakeViewport({ 50, 10, 23, 10 }, 1) },
        tiles),
      MakeFrame({ {}, all, {} }, tiles), MakeFrame({ {}, {}, {} }, tiles),
      MakeFrame({ inner, {}, inner }, tiles) });
}

TEST(ViewportCompositor, TilesOfAWallAreRectanglesOfTheWholeImage)
{
  std::mt19937 random(12);
  std::vector<Viewport> viewports;
  for (const int divisor : { 1, 2, 1, 4 })
  {
    viewports.push_back(MakeViewport(MakeRandomRectangle(ComposedDisplay, random), divisor));
  }
  viewports[0] = MakeViewport(ComposedDisplay, 1);
  CheckFrames(4,
    { MakeFrame(viewports,
        { { { 0, 0, 40, 30 }, 0 }, { { 40, 0, 33, 30 }, 1 }, { { 0, 30, 40, 29 }, 2 },
          { { 40, 30, 33, 29 }, 3 } }),
      MakeFrame(
        viewports, { { { 0, 0, 25, 59 }, 3 }, { { 25, 0, 24, 59 }, 1 }, { { 49, 0, 24, 59 }, 0 } }),
      // Tiles that overlap, as projectors do, and a frame between two screens.
      MakeFrame(viewports, { { { 0, 0, 45, 59 }, 2 }, { { 30, 0, 43, 59 }, 0 } }),
      MakeFrame(viewports, { { { 0, 0, 31, 59 }, 1 }, { { 37, 0, 36, 59 }, 0 } }) });
}

TEST(ViewportCompositor, WithAntialiasingPixelsAreMeansOfMergedSamples)
{
  std::mt19937 random(13);
  const DisplayLayout display =
    MakeDisplayLayout({ { { 0, 0, 20, 30 }, 1 }, { { 20, 0, 16, 30 }, 0 } }, 2);
  std::vector<Viewport> viewports;
  for (const int divisor : { 1, 2, 3 })
  {
    viewports.push_back(MakeViewport(MakeRandomRectangle(display.GetExtent(), random), divisor));
  }
  const Frame frame = MakeFrame(viewports, display.Tiles);
  ThreadCommunicator::Run(3,
    [&](Communicator& communicator)
    {
      const auto me = static_cast<std::size_t>(communicator.GetRank());
      const DisplayTile* tile = display.FindTile(communicator.GetRank());
      const PixelRectangle samples = tile ? tile->Pixels : PixelRectangle{};
      ImageBuffer shown;
      shown.Resize(display.CoverWithPixels(samples));
      ViewportCompositor compositor;
      EXPECT_TRUE(compositor
                    .Composite(communicator, display, viewports, frame.Images[me].GetView(),
                      { shown.Colors.data(), shown.Depths.data() }, true)
                    .IsOk());
      const ImageBuffer fine = MergeOneByOne(viewports, frame.Images, samples);
      ImageBuffer expected;
      expected.Resize(shown.Raster);
      AverageSamples(fine.Colors.data(), fine.Depths.data(), shown.Raster.Width,
        shown.Raster.Height, expected.Colors.data(), expected.Depths.data());
      EXPECT_EQ(shown.Colors, expected.Colors);
      EXPECT_EQ(shown.Depths, expected.Depths);
    });
}

TEST(ViewportCompositor, HalfTheResolutionTakesAQuarterOfTheBytes)
{
  std::array<std::uint64_t, 2> sent{};
  std::mutex mutex;
  const PixelRectangle display{ 0, 0, 512, 512 };
  for (const int divisor : { 1, 2 })
  {
    const Frame frame = MakeFrame(
      { MakeViewport(display, divisor), MakeViewport(display, divisor) }, { { display, 0 } });
    ThreadCommunicator::Run(2,
      [&](Communicator& communicator)
      {
        std::vector<std::uint32_t> colors(512 * 512);
        ViewportCompositor compositor;
        EXPECT_TRUE(compositor
                      .Composite(communicator, { frame.Tiles }, frame.Viewports,
                        frame.Images[static_cast<std::size_t>(communicator.GetRank())].GetView(),
                        { colors.data(), nullptr }, false)
                      .IsOk());
        const std::lock_guard<std::mutex> lock(mutex);
        sent[static_cast<std::size_t>(divisor - 1)] += compositor.GetBytesSent();
      });
  }
  EXPECT_GT(sent[1], 0U);
  EXPECT_NEAR(static_cast<double>(sent[0]) / static_cast<double>(sent[1]), 4.0, 0.2);
}

TEST(ViewportCompositor, AnErrorOfOneRankIsAnErrorOfAll)
{
  const Frame frame =
    MakeFrame({ MakeViewport(ComposedDisplay, 1), MakeViewport(ComposedDisplay, 1) },
      { { ComposedDisplay, 0 } });
  ThreadCommunicator::Run(2,
    [&](Communicator& communicator)
    {
      std::vector<std::uint32_t> colors(static_cast<std::size_t>(ComposedDisplay.GetArea()));
      ViewportCompositor compositor;
      // Rank 1 has no image.
      const ImageView mine = communicator.GetRank() == 0 ? frame.Images[0].GetView() : ImageView{};
      EXPECT_EQ(compositor
                  .Composite(communicator, { frame.Tiles }, frame.Viewports, mine,
                    { colors.data(), nullptr }, false)
                  .GetCode(),
        communicator.GetRank() == 1 ? StatusCode::InvalidArgument : StatusCode::RemoteFailure);
      // Two tiles for one rank; no place for the tile.
      EXPECT_FALSE(compositor
                     .Composite(communicator,
                       { { { ComposedDisplay, 0 }, { ComposedDisplay, 0 } } }, frame.Viewports,
                       frame.Images[static_cast<std::size_t>(communicator.GetRank())].GetView(),
                       { colors.data(), nullptr }, false)
                     .IsOk());
      EXPECT_FALSE(
        compositor
          .Composite(communicator, { frame.Tiles }, frame.Viewports,
            frame.Images[static_cast<std::size_t>(communicator.GetRank())].GetView(), {}, false)
          .IsOk());
      // The compositor is as good as new.
      EXPECT_TRUE(compositor
                    .Composite(communicator, { frame.Tiles }, frame.Viewports,
                      frame.Images[static_cast<std::size_t>(communicator.GetRank())].GetView(),
                      { colors.data(), nullptr }, false)
                    .IsOk());
    });
}
