// SPDX-License-Identifier: BSD-3-Clause
#include "Surface/Drawing/SharedDepths.h"

#include "Fixtures/ThreadCommunicator.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <random>
#include <vector>

using namespace isosurface;

namespace
{

constexpr int SharedWidth = 61; // the last squares are narrower
constexpr int SharedHeight = 45;
constexpr int SharingRanks = 3;

/// Each rank draws one half or all of the image.
PixelBox GetPart(int rank)
{
  return rank == 0 ? PixelBox{ 0, 30, 0, SharedHeight }
    : rank == 1    ? PixelBox{ 13, SharedWidth, 5, SharedHeight }
                   : PixelBox{ 0, SharedWidth, 0, SharedHeight };
}

std::vector<float> MakeDepths(int rank)
{
  std::mt19937 random(static_cast<unsigned int>(rank + 1));
  std::uniform_real_distribution<float> depth(0, 1);
  std::vector<float> depths(SharedWidth * SharedHeight);
  std::generate(depths.begin(), depths.end(), [&] { return depth(random); });
  return depths;
}

PixelBox Cut(const PixelBox& box)
{
  return { box.Left, std::min(box.Right, SharedWidth), box.Bottom,
    std::min(box.Top, SharedHeight) };
}

float FindFarthest(const std::vector<float>& depths, const PixelBox& box)
{
  float farthest = 0;
  for (int y = box.Bottom; y < box.Top; ++y)
  {
    for (int x = box.Left; x < box.Right; ++x)
    {
      farthest = std::max(farthest, depths[static_cast<std::size_t>(y * SharedWidth + x)]);
    }
  }
  return farthest;
}

bool IsInside(const PixelBox& inner, const PixelBox& outer)
{
  return inner.Left >= outer.Left && inner.Right <= outer.Right && inner.Bottom >= outer.Bottom &&
    inner.Top <= outer.Top;
}

/// The nearest of what ranks have told of the square, and of what `rank` has drawn there.
float FindExpected(const PixelBox& square, int rank)
{
  float expected = FindFarthest(MakeDepths(rank), square);
  for (int other = 0; other < SharingRanks; ++other)
  {
    if (IsInside(square, GetPart(other)))
    {
      expected = std::min(expected, FindFarthest(MakeDepths(other), square));
    }
  }
  return expected;
}

SharedDepths::ReduceMaximum ReduceBy(Communicator& communicator)
{
  return [&communicator](std::vector<std::uint64_t>& depths)
  {
    communicator.ReduceMaximum(depths);
    return true;
  };
}

const int LastMapper = 0;
const int OtherMapper = 0;

} // namespace

TEST(SharedDepths, ABoxIsBehindWhatAnyRankHasDrawnInAllOfASquare)
{
  ThreadCommunicator::Run(SharingRanks,
    [](Communicator& communicator)
    {
      const int rank = communicator.GetRank();
      SharedDepths shared;
      shared.Begin(SharedWidth, SharedHeight, GetPart(rank), &LastMapper);
      shared.Connect(ReduceBy(communicator));
      DepthPyramid drawn;
      drawn.Build(MakeDepths(rank), SharedWidth, SharedHeight);
      shared.Share(&LastMapper, drawn);
      shared.End();
      EXPECT_TRUE(shared.IsWanted());
      for (int y = 0; y < SharedHeight; y += 4)
      {
        for (int x = 0; x < SharedWidth; x += 4)
        {
          const PixelBox square = Cut({ x, x + 4, y, y + 4 });
          const float expected = FindExpected(square, rank);
          EXPECT_FALSE(drawn.IsBehind({ false, true, square, expected })) << x << ", " << y;
          EXPECT_TRUE(drawn.IsBehind({ false, true, square, expected + 1e-6F })) << x << ", " << y;
        }
      }
    });
}

TEST(SharedDepths, RanksThatDrawNothingOrOtherwiseEndTheImageWithTheOthers)
{
  ThreadCommunicator::Run(SharingRanks,
    [](Communicator& communicator)
    {
      const int rank = communicator.GetRank();
      SharedDepths shared;
      const PixelBox all = { 0, SharedWidth, 0, SharedHeight };
      for (int image = 0; image < 3; ++image)
      {
        shared.Begin(SharedWidth, SharedHeight, all, &LastMapper);
        shared.Connect(ReduceBy(communicator));
        DepthPyramid drawn;
        drawn.Build(
          std::vector<float>(SharedWidth * SharedHeight, 0.1F), SharedWidth, SharedHeight);
        if (rank == 1)
        {
          shared.Share(&OtherMapper, drawn);
          EXPECT_FALSE(shared.IsWanted());
        }
        if (rank == 2)
        {
          DepthPyramid far;
          far.Build(std::vector<float>(SharedWidth * SharedHeight, 1), SharedWidth, SharedHeight);
          shared.Share(&LastMapper, far);
          EXPECT_TRUE(shared.IsWanted());
          EXPECT_FALSE(far.IsBehind({ false, true, all, 1 })) << "nobody else told anything";
        }
        shared.End();
      }
    });
}

TEST(SharedDepths, TheMapperThatSharedIsWantedAgainAfterOtherImages)
{
  SharedDepths shared;
  const PixelBox all = { 0, SharedWidth, 0, SharedHeight };
  DepthPyramid drawn;
  drawn.Build(std::vector<float>(SharedWidth * SharedHeight, 1), SharedWidth, SharedHeight);
  const auto draw = [&](const void* last, bool isConnected, const void* mapper)
  {
    shared.Begin(SharedWidth, SharedHeight, all, last);
    const bool wanted = shared.IsWanted();
    if (isConnected)
    {
      shared.Connect([](std::vector<std::uint64_t>&) { return true; });
    }
    if (mapper)
    {
      shared.Share(mapper, drawn);
    }
    shared.End();
    return wanted;
  };
  EXPECT_FALSE(draw(&LastMapper, false, &LastMapper)) << "nothing is known";
  EXPECT_TRUE(draw(&LastMapper, true, &LastMapper));
  EXPECT_TRUE(draw(&LastMapper, false, nullptr)) << "but it was coarser";
  EXPECT_TRUE(draw(&LastMapper, true, &LastMapper));
  EXPECT_FALSE(draw(&OtherMapper, false, nullptr)) << "a thinned surface";
  EXPECT_FALSE(draw(nullptr, true, nullptr)) << "other ranks want depths";
  EXPECT_TRUE(draw(&LastMapper, true, &LastMapper));
  EXPECT_TRUE(draw(&LastMapper, true, nullptr)) << "it leaves out nothing any more";
  EXPECT_FALSE(draw(&LastMapper, false, nullptr));
}

TEST(SharedDepths, WhatAnImageBeforeToldIsForgotten)
{
  SharedDepths shared;
  const PixelBox all = { 0, SharedWidth, 0, SharedHeight };
  DepthPyramid drawn;
  drawn.Build(std::vector<float>(SharedWidth * SharedHeight, 1), SharedWidth, SharedHeight);
  shared.Begin(SharedWidth, SharedHeight, all, &LastMapper);
  shared.Connect(
    [](std::vector<std::uint64_t>& depths)
    {
      std::fill(depths.begin(), depths.end(), ~std::uint32_t{ 0 }); // depths of 0
      return true;
    });
  shared.Share(&LastMapper, drawn);
  EXPECT_TRUE(drawn.IsBehind({ false, true, all, 0.5F }));

  drawn.Build(std::vector<float>(SharedWidth * SharedHeight, 1), SharedWidth, SharedHeight);
  shared.Begin(SharedWidth, SharedHeight, all, &LastMapper);
  shared.Share(&LastMapper, drawn);
  EXPECT_FALSE(drawn.IsBehind({ false, true, all, 0.5F }));
  EXPECT_TRUE(shared.IsWanted()) << "the next image pays";

  shared.Begin(SharedWidth, SharedHeight, all, &LastMapper);
  shared.Connect([](std::vector<std::uint64_t>&) { return false; }); // a rank has no memory
  shared.Share(&LastMapper, drawn);
  EXPECT_FALSE(drawn.IsBehind({ false, true, all, 0.5F }));
}
