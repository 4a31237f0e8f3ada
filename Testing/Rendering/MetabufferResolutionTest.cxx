// SPDX-License-Identifier: BSD-3-Clause
// Resolutions by rank, compared with images that each rank draws in a small window, without
// viewports, and that the test upsamples and merges pixel by pixel.
#include "RankScene.h"

#include "vtkMetabufferPass.h"

#include "vtkActor.h"
#include "vtkMultiProcessController.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>

using namespace isosurface;

namespace
{

constexpr int DivisibleWidth = 216; // divisible by all divisors of these tests
constexpr int DivisibleHeight = 168;

/// All ranks' small images, on rank 0.
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

/// What one rank drew, one sample for each block.
struct SmallImage
{
  int Divisor = 1;
  int Columns = 0;
  int Rows = 0;
  const std::uint32_t* Colors = nullptr;
  const float* Depths = nullptr;

  bool IsActive(int column, int row) const
  {
    return column >= 0 && row >= 0 && column < this->Columns && row < this->Rows &&
      this->Depths[row * this->Columns + column] < 1.0F;
  }
};

// The color at the center of a pixel, interpolated between the centers of the active blocks around it
// by a sum of fractions with the denominator 4 * divisor^2.
std::uint32_t GetSmoothColor(const SmallImage& small, int x, int y)
{
  const int d = small.Divisor;
  std::uint32_t color = 0;
  for (int byte = 0; byte < 4; ++byte)
  {
    long sum = 0;
    long weights = 0;
    for (int row = y / d - 1; row <= y / d + 1; ++row)
    {
      for (int column = x / d - 1; column <= x / d + 1; ++column)
      {
        const long across = 2 * d - std::abs(2 * x + 1 - (2 * column + 1) * d);
        const long up = 2 * d - std::abs(2 * y + 1 - (2 * row + 1) * d);
        if (across > 0 && up > 0 && small.IsActive(column, row))
        {
          sum += across * up * (small.Colors[row * small.Columns + column] >> (8 * byte) & 0xff);
          weights += across * up;
        }
      }
    }
    color |= static_cast<std::uint32_t>((2 * sum + weights) / (2 * weights)) << (8 * byte);
  }
  return color;
}

/// How the reference merges small images.
struct Composition
{
  std::vector<int> Divisors;
  bool IsSmooth = false;
  int Samples = 1; ///< of a pixel, in each direction
};

// Four pixels become one.
Image AverageFour(const Image& fine)
{
  Image coarse;
  coarse.Width = fine.Width / 2;
  coarse.Height = fine.Height / 2;
  for (int y = 0; y < coarse.Height; ++y)
  {
    for (int x = 0; x < coarse.Width; ++x)
    {
      std::uint32_t color = 0;
      float depth = 1.0F;
      for (int byte = 0; byte < 4; ++byte)
      {
        unsigned sum = 2;
        for (int sample = 0; sample < 4; ++sample)
        {
          const auto index =
            static_cast<std::size_t>((2 * y + sample / 2) * fine.Width + 2 * x + sample % 2);
          sum += fine.Colors[index] >> (8 * byte) & 0xff;
          depth = std::min(depth, fine.Depths[index]);
        }
        color |= sum / 4 << (8 * byte);
      }
      coarse.Colors.push_back(color);
      coarse.Depths.push_back(depth);
    }
  }
  return coarse;
}

/// The image of a display, on rank 0, made of what each rank draws in a window of 1/divisor of its
/// size.
Image MergeSmallImages(
  const Scene& scene, const CameraPlace& camera, const Composition& composition)
{
  const int width = composition.Samples * DivisibleWidth;
  const int height = composition.Samples * DivisibleHeight;
  const int mine = composition.Divisors[static_cast<std::size_t>(GetRank())];
  const Image drawn =
    RenderAlone(scene.Make(GetRank(), GetNumberOfRanks()), camera, width / mine, height / mine);
  const std::vector<std::uint32_t> colors = GatherOnRootRank(drawn.Colors);
  const std::vector<float> depths = GatherOnRootRank(drawn.Depths);
  Image merged;
  if (GetRank() != 0)
  {
    return merged;
  }
  merged.Width = width;
  merged.Height = height;
  merged.Colors.assign(static_cast<std::size_t>(width) * static_cast<std::size_t>(height), 0);
  merged.Depths.assign(merged.Colors.size(), 1.0F);
  std::size_t first = 0;
  for (const int divisor : composition.Divisors)
  {
    const SmallImage small{ divisor, width / divisor, height / divisor, colors.data() + first,
      depths.data() + first };
    for (int y = 0; y < height; ++y)
    {
      for (int x = 0; x < width; ++x)
      {
        const auto pixel = static_cast<std::size_t>(y * width + x);
        const int sample = y / divisor * small.Columns + x / divisor;
        if (small.Depths[sample] < 1.0F && small.Depths[sample] <= merged.Depths[pixel])
        {
          merged.Depths[pixel] = small.Depths[sample];
          merged.Colors[pixel] =
            composition.IsSmooth ? GetSmoothColor(small, x, y) : small.Colors[sample];
        }
      }
    }
    first += static_cast<std::size_t>(small.Columns) * static_cast<std::size_t>(small.Rows);
  }
  return composition.Samples == 1 ? merged : AverageFour(merged);
}

void SetDivisors(RankWindow& window, const std::vector<int>& divisors)
{
  window.GetPass()->SetNumberOfDivisors(static_cast<int>(divisors.size()));
  for (std::size_t rank = 0; rank < divisors.size(); ++rank)
  {
    window.GetPass()->SetDivisor(static_cast<int>(rank), divisors[rank]);
  }
}

/// One for each rank, from the beginning again where there are more ranks.
void DealToRanks(std::vector<int>& divisors)
{
  const std::size_t given = divisors.size();
  divisors.resize(static_cast<std::size_t>(GetNumberOfRanks()));
  for (std::size_t rank = given; rank < divisors.size(); ++rank)
  {
    divisors[rank] = divisors[rank - given];
  }
}

} // namespace

TEST(MetabufferResolution, MixedResolutionsAreSmallImagesMergedOneByOne)
{
  RankWindow ours(RankWindow::Metabuffer, DivisibleWidth, DivisibleHeight);
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
        DealToRanks(divisors);
        SetDivisors(ours, divisors);
        const Image expected = MergeSmallImages(scene, camera, { divisors });
        for (const int mode : { vtkMetabufferPass::DIRECT_SEND, vtkMetabufferPass::ICET })
        {
          ours.GetPass()->SetCompositeMode(mode);
          const Image image = ours.Render();
          if (GetRank() == 0)
          {
            EXPECT_EQ(CountDifferentColors(image, expected), 0U)
              << scene.Name << ", " << camera.Name << ", " << divisors[0];
            EXPECT_EQ(CountDifferentDepths(image, expected), 0U)
              << scene.Name << ", " << camera.Name << ", " << divisors[0];
          }
        }
      }
    }
  }
}

TEST(MetabufferResolution, SmoothAndSupersampledImagesAreMergedOneByOne)
{
  RankWindow ours(RankWindow::Metabuffer, DivisibleWidth, DivisibleHeight);
  for (const std::size_t index : { 0U, 1U, 2U })
  {
    const Scene scene = GetScenes()[index];
    ours.SetScene(scene);
    for (const CameraPlace& camera : { GetCameraPlaces()[0], GetCameraPlaces()[2] })
    {
      ours.SetCamera(camera);
      for (std::vector<int> divisors : { std::vector<int>{ 1, 1, 1, 1 }, { 4, 1, 3, 2 } })
      {
        DealToRanks(divisors);
        SetDivisors(ours, divisors);
        for (const int way : { 1, 2, 3 })
        {
          const bool isSmooth = way % 2 == 1;
          const int samples = 1 + way / 2;
          ours.GetPass()->SetSmoothUpsampling(isSmooth);
          ours.GetPass()->SetAntiAliasing(samples == 2);
          const Image expected = MergeSmallImages(scene, camera, { divisors, isSmooth, samples });
          const Image image = ours.Render();
          if (GetRank() == 0)
          {
            const std::string what = scene.Name + ", " + camera.Name + ", " +
              std::to_string(divisors[0]) + ", " + std::to_string(way);
            EXPECT_EQ(image.Width, DivisibleWidth) << what;
            EXPECT_EQ(CountDifferentColors(image, expected), 0U) << what;
            EXPECT_EQ(CountDifferentDepths(image, expected), 0U) << what;
          }
        }
      }
    }
  }
}

TEST(MetabufferResolution, ADivisorThatDoesNotDivideTheDisplayMovesNothing)
{
  // 211 = 4 * 52 + 3: drawn as the low left corner of a display of 212 x 164, in which the centers of
  // blocks are corners of pixels of this one. Props differ by one block at most.
  RankWindow odd(RankWindow::Metabuffer, 211, 163);
  odd.SetScene(GetScenes()[2]);
  odd.SetCamera(GetCameraPlaces()[0]);
  const Image full = odd.Render();
  SetDivisors(odd, { 4 });
  const Image coarse = odd.Render();
  if (GetRank() != 0)
  {
    return;
  }
  std::size_t silhouette = 0;
  for (int y = 4; y < 163 - 4; ++y)
  {
    for (int x = 4; x < 211 - 4; ++x)
    {
      const auto isActive = [](const Image& image, int column, int row)
      { return image.Depths[static_cast<std::size_t>(row * 211 + column)] < 1.0F; };
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
  RankWindow ours(RankWindow::Metabuffer, DivisibleWidth, DivisibleHeight);
  ours.SetScene(GetScenes()[2]);
  ours.SetCamera(GetCameraPlaces()[0]);
  ours.Render();
  const auto full = static_cast<double>(ours.GetPass()->GetDrawnPixels());
  SetDivisors(ours, { 2 });
  ours.Render();
  const auto half = static_cast<double>(ours.GetPass()->GetDrawnPixels());
  EXPECT_GT(half, 0.25 * full);
  EXPECT_LT(half, 0.25 * full * 1.3 + 32); // the edges of a viewport of a few pixels
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
