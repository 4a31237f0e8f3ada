// SPDX-License-Identifier: BSD-3-Clause
// Ranks at resolutions of their own: beside pictures that each rank draws in a small window,
// without viewports, which the test enlarges and merges pixel by pixel.
#include "RankScene.h"

#include "vtkMetabufferPass.h"

#include "vtkActor.h"
#include "vtkMultiProcessController.h"

#include <gtest/gtest.h>

using namespace isosurface;

namespace
{

constexpr int Width = 216; // divisible by all divisors of these tests
constexpr int Height = 168;

/// All ranks' small pictures, on rank 0.
template <typename Value>
std::vector<Value> GatherOnRootRank(const std::vector<Value>& mine)
{
  vtkMultiProcessController* controller = vtkMultiProcessController::GetGlobalController();
  const auto ranks = static_cast<std::size_t>(GetNumberOfRanks());
  const auto bytes = static_cast<vtkIdType>(mine.size() * sizeof(Value));
  std::vector<vtkIdType> lengths(ranks);
  std::vector<vtkIdType> offsets(ranks, 0);
  controller->AllGather(&bytes, lengths.data(), 1);
  for (std::size_t rank = 1; rank < ranks; ++rank)
  {
    offsets[rank] = offsets[rank - 1] + lengths[rank - 1];
  }
  std::vector<Value> all(static_cast<std::size_t>(offsets.back() + lengths.back()) / sizeof(Value));
  controller->GatherV(reinterpret_cast<const char*>(mine.data()),
    reinterpret_cast<char*>(all.data()), bytes, lengths.data(), offsets.data(), 0);
  return all;
}

/// The picture of a display on rank 0, of what each rank draws in a window of 1/divisor of the
/// size.
Picture MergeSmallPictures(
  const Scene& scene, const CameraPlace& camera, const std::vector<int>& divisors)
{
  const int mine = divisors[static_cast<std::size_t>(GetRank())];
  const Picture small =
    RenderAlone(scene.Make(GetRank(), GetNumberOfRanks()), camera, Width / mine, Height / mine);
  const std::vector<std::uint32_t> colors = GatherOnRootRank(small.Colors);
  const std::vector<float> depths = GatherOnRootRank(small.Depths);
  Picture merged;
  if (GetRank() != 0)
  {
    return merged;
  }
  merged.Width = Width;
  merged.Height = Height;
  merged.Colors.assign(static_cast<std::size_t>(Width) * Height, 0);
  merged.Depths.assign(static_cast<std::size_t>(Width) * Height, 1.0F);
  std::size_t first = 0;
  for (const int divisor : divisors)
  {
    for (int y = 0; y < Height; ++y)
    {
      for (int x = 0; x < Width; ++x)
      {
        const std::size_t pixel = static_cast<std::size_t>(y) * Width + static_cast<std::size_t>(x);
        const std::size_t sample = first +
          static_cast<std::size_t>(y / divisor) * static_cast<std::size_t>(Width / divisor) +
          static_cast<std::size_t>(x / divisor);
        if (depths[sample] < 1.0F && depths[sample] <= merged.Depths[pixel])
        {
          merged.Depths[pixel] = depths[sample];
          merged.Colors[pixel] = colors[sample];
        }
      }
    }
    first += static_cast<std::size_t>(Width / divisor) * static_cast<std::size_t>(Height / divisor);
  }
  return merged;
}

void SetDivisors(RankWindow& window, const std::vector<int>& divisors)
{
  window.GetPass()->SetNumberOfDivisors(static_cast<int>(divisors.size()));
  for (std::size_t rank = 0; rank < divisors.size(); ++rank)
  {
    window.GetPass()->SetDivisor(static_cast<int>(rank), divisors[rank]);
  }
}

} // namespace

TEST(MetabufferResolution, MixedResolutionsAreSmallPicturesMergedOneByOne)
{
  RankWindow ours(RankWindow::Metabuffer, Width, Height);
  const std::vector<std::vector<int>> choices = { { 1, 2, 4, 3 }, { 4, 1, 1, 2 }, { 2, 2, 2, 2 },
    { 8, 6, 4, 12 } };
  for (const Scene& scene : GetScenes())
  {
    ours.SetScene(scene);
    for (const CameraPlace& camera : GetCameraPlaces())
    {
      if (camera.Name == "near" || camera.Name == "beside")
      {
        continue; // seconds, for what the tests of full resolution have seen
      }
      ours.SetCamera(camera);
      for (std::vector<int> divisors : choices)
      {
        divisors.resize(static_cast<std::size_t>(GetNumberOfRanks()));
        SetDivisors(ours, divisors);
        const Picture expected = MergeSmallPictures(scene, camera, divisors);
        for (const int mode : { vtkMetabufferPass::DIRECT_SEND, vtkMetabufferPass::ICET })
        {
          ours.GetPass()->SetCompositeMode(mode);
          const Picture picture = ours.Render();
          if (GetRank() == 0)
          {
            EXPECT_EQ(CountDifferentColors(picture, expected), 0U)
              << scene.Name << ", " << camera.Name << ", " << divisors[0];
            EXPECT_EQ(CountDifferentDepths(picture, expected), 0U)
              << scene.Name << ", " << camera.Name << ", " << divisors[0];
          }
        }
      }
    }
  }
}

TEST(MetabufferResolution, ADivisorThatDoesNotDivideTheDisplayMovesNothing)
{
  // 211 = 4 * 52 + 3: drawn as the low left part of a display of 212 x 164, whose blocks' middles
  // are pixels' corners of this one. The same part of the scene is there, one block at most apart.
  RankWindow odd(RankWindow::Metabuffer, 211, 163);
  odd.SetScene(GetScenes()[2]);
  odd.SetCamera(GetCameraPlaces()[0]);
  const Picture full = odd.Render();
  SetDivisors(odd, { 4 });
  const Picture coarse = odd.Render();
  if (GetRank() != 0)
  {
    return;
  }
  std::size_t silhouette = 0;
  for (int y = 4; y < 163 - 4; ++y)
  {
    for (int x = 4; x < 211 - 4; ++x)
    {
      const auto isActive = [](const Picture& picture, int column, int row)
      { return picture.Depths[static_cast<std::size_t>(row * 211 + column)] < 1.0F; };
      if (isActive(full, x, y) == isActive(coarse, x, y))
      {
        continue;
      }
      ++silhouette;
      bool isNearEdge = false;
      for (int row = y - 4; row <= y + 4; ++row)
      {
        for (int column = x - 4; column <= x + 4; ++column)
        {
          isNearEdge = isNearEdge || isActive(full, column, row) != isActive(full, x, y);
        }
      }
      EXPECT_TRUE(isNearEdge) << x << ", " << y;
    }
  }
  EXPECT_GT(silhouette, 0U);
}

TEST(MetabufferResolution, HalfTheResolutionDrawsAQuarterOfThePixels)
{
  RankWindow ours(RankWindow::Metabuffer, Width, Height);
  ours.SetScene(GetScenes()[2]);
  ours.SetCamera(GetCameraPlaces()[0]);
  ours.Render();
  const auto full = static_cast<double>(ours.GetPass()->GetFrameCost().DrawnPixels);
  SetDivisors(ours, { 2 });
  ours.Render();
  const auto half = static_cast<double>(ours.GetPass()->GetFrameCost().DrawnPixels);
  EXPECT_GT(half, 0.25 * full);
  EXPECT_LT(half, 0.25 * full * 1.3);
  int viewport[5];
  ours.GetPass()->GetViewport(GetNumberOfRanks() - 1, viewport);
  EXPECT_EQ(viewport[4], 2);
  ours.GetPass()->GetViewport(GetNumberOfRanks(), viewport);
  EXPECT_EQ(viewport[2], 0);
}

TEST(MetabufferResolution, DivisorsAreThoseOfTheListAndItsLastOne)
{
  vtkNew<vtkMetabufferPass> pass;
  EXPECT_EQ(pass->GetDivisor(3), 1);
  pass->SetDivisor(1, 4);
  EXPECT_EQ(pass->GetNumberOfDivisors(), 2);
  EXPECT_EQ(pass->GetDivisor(0), 1);
  EXPECT_EQ(pass->GetDivisor(1), 4);
  EXPECT_EQ(pass->GetDivisor(9), 4);
  pass->SetNumberOfDivisors(0);
  EXPECT_EQ(pass->GetDivisor(1), 1);
}
