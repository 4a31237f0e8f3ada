// SPDX-License-Identifier: BSD-3-Clause
// Walls of several windows show the image of one large display.
#include "RankScene.h"

#include "vtkMetabufferPass.h"

#include "vtkActor.h"
#include "vtkMultiProcessController.h"

#include <gtest/gtest.h>

using namespace isosurface;

namespace
{

/// Rank 0's image, on all ranks.
Image BroadcastFromRootRank(Image image)
{
  vtkMultiProcessController* controller = vtkMultiProcessController::GetGlobalController();
  controller->Broadcast(&image.Width, 1, 0);
  controller->Broadcast(&image.Height, 1, 0);
  image.Colors.resize(
    static_cast<std::size_t>(image.Width) * static_cast<std::size_t>(image.Height));
  image.Depths.resize(image.Colors.size());
  controller->Broadcast(reinterpret_cast<char*>(image.Colors.data()),
    static_cast<vtkIdType>(4 * image.Colors.size()), 0);
  controller->Broadcast(image.Depths.data(), static_cast<vtkIdType>(image.Depths.size()), 0);
  return image;
}

/// Tiles are by rank: from left to right, the upper row first, as ParaView has them.
void ExpectPartOf(
  const Image& display, const Image& tile, int columns, int rows, const std::string& what)
{
  const int left = GetRank() % columns * tile.Width;
  const int bottom = (rows - 1 - GetRank() / columns) * tile.Height;
  std::size_t different = 0;
  for (int y = 0; y < tile.Height; ++y)
  {
    for (int x = 0; x < tile.Width; ++x)
    {
      const auto here = static_cast<std::size_t>(y * tile.Width + x);
      const auto there = static_cast<std::size_t>((bottom + y) * display.Width + left + x);
      different +=
        tile.Colors[here] == display.Colors[there] && tile.Depths[here] == display.Depths[there]
        ? 0
        : 1;
    }
  }
  EXPECT_EQ(different, 0U) << what << ", tile " << GetRank();
}

void CheckWall(int columns, int rows, const std::vector<int>& divisors)
{
  constexpr int TileWidth = 96;
  constexpr int TileHeight = 72;
  RankWindow single(RankWindow::Metabuffer, columns * TileWidth, rows * TileHeight);
  RankWindow wall(RankWindow::Metabuffer, TileWidth, TileHeight, columns, rows);
  for (RankWindow* window : { &single, &wall })
  {
    for (std::size_t rank = 0; rank < divisors.size(); ++rank)
    {
      window->GetPass()->SetDivisor(static_cast<int>(rank), divisors[rank]);
    }
  }
  for (const Scene& scene : GetScenes())
  {
    single.SetScene(scene);
    wall.SetScene(scene);
    for (const CameraPlace& camera : GetCameraPlaces())
    {
      if (camera.Name == "near" || camera.Name == "beside")
      {
        continue; // seconds, for what the tests of full resolution have seen
      }
      single.SetCamera(camera);
      wall.SetCamera(camera);
      const Image display = BroadcastFromRootRank(single.Render());
      for (const int mode : { vtkMetabufferPass::DIRECT_SEND, vtkMetabufferPass::ICET })
      {
        wall.GetPass()->SetCompositeMode(mode);
        const Image tile = wall.Render();
        EXPECT_EQ(tile.IsEmpty(), GetRank() >= columns * rows);
        if (!tile.IsEmpty())
        {
          EXPECT_EQ(tile.Width, TileWidth);
          EXPECT_EQ(tile.Height, TileHeight);
          ExpectPartOf(display, tile, columns, rows, scene.Name + ", " + camera.Name);
        }
      }
    }
  }
}

} // namespace

TEST(MetabufferWall, OfTwoTilesShowsTheOneBigImage)
{
  if (GetNumberOfRanks() < 2)
  {
    GTEST_SKIP() << "each tile needs a rank";
  }
  CheckWall(2, 1, { 1 });
  CheckWall(1, 2, { 2, 1, 4 });
}

TEST(MetabufferWall, OfThreeTilesShowsTheOneBigImage)
{
  if (GetNumberOfRanks() < 3)
  {
    GTEST_SKIP() << "each tile needs a rank";
  }
  CheckWall(3, 1, { 1 });
}

TEST(MetabufferWall, OfFourTilesShowsTheOneBigImage)
{
  if (GetNumberOfRanks() < 4)
  {
    GTEST_SKIP() << "each tile needs a rank";
  }
  CheckWall(2, 2, { 1 });
  CheckWall(2, 2, { 1, 2, 4, 1 });
}
