// SPDX-License-Identifier: BSD-3-Clause
// What is left out of an image, beside an image of everything, pixel by pixel.
#include "Surface/Drawing/VisibleRuns.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

using namespace isosurface;

namespace
{

constexpr int ImageWidth = 61;
constexpr int ImageHeight = 45;

using Matrix = std::array<double, 16>;
using Bounds = std::array<float, 6>;

/// From a box around the origin to clip coordinates: turned, moved away from the eye, and seen in
/// perspective or in parallel.
Matrix MakeView(std::mt19937& random, double distance, bool isParallel)
{
  std::uniform_real_distribution<double> angle(0, 6.3);
  const double a = angle(random);
  const double b = angle(random);
  const double near = 0.5;
  const double far = 12;
  const Matrix turn = { std::cos(a), 0, std::sin(a), 0,                            //
    std::sin(a) * std::sin(b), std::cos(b), -std::cos(a) * std::sin(b), 0,         //
    -std::sin(a) * std::cos(b), std::sin(b), std::cos(a) * std::cos(b), -distance, //
    0, 0, 0, 1 };
  const Matrix project = isParallel
    ? Matrix{ 0.5, 0, 0, 0, 0, 0.5, 0, 0, 0, 0, -2 / (far - near), -(far + near) / (far - near), 0,
        0, 0, 1 }
    : Matrix{ 1.5, 0, 0, 0, 0, 1.5, 0, 0, 0, 0, -(far + near) / (far - near),
        -2 * far * near / (far - near), 0, 0, -1, 0 };
  Matrix all{};
  for (std::size_t row = 0; row < 4; ++row)
  {
    for (std::size_t column = 0; column < 4; ++column)
    {
      for (std::size_t k = 0; k < 4; ++k)
      {
        all[4 * row + column] += project[4 * row + k] * turn[4 * k + column];
      }
    }
  }
  return all;
}

/// Where a point is drawn; depth -1: nowhere.
struct Fragment
{
  int X = 0;
  int Y = 0;
  float Depth = -1;
};

Fragment DrawPoint(const Matrix& matrix, const std::array<double, 3>& point)
{
  std::array<double, 4> clip{};
  for (std::size_t row = 0; row < 4; ++row)
  {
    clip[row] = matrix[4 * row] * point[0] + matrix[4 * row + 1] * point[1] +
      matrix[4 * row + 2] * point[2] + matrix[4 * row + 3];
  }
  Fragment fragment;
  const double w = clip[3];
  if (!(w > 0) || std::abs(clip[0]) >= w || std::abs(clip[1]) >= w || std::abs(clip[2]) >= w)
  {
    return fragment;
  }
  fragment.X = static_cast<int>((clip[0] / w + 1) / 2 * ImageWidth);
  fragment.Y = static_cast<int>((clip[1] / w + 1) / 2 * ImageHeight);
  fragment.Depth = static_cast<float>((clip[2] / w + 1) / 2);
  return fragment;
}

/// A surface whose runs are clouds of points, each in a box of its own.
struct Clouds
{
  TriangleMeasure Measure;
  std::vector<std::vector<std::array<double, 3>>> Points; ///< of each run, one for each triangle
};

Clouds MakeClouds(std::mt19937& random, std::size_t runs)
{
  std::uniform_real_distribution<double> place(-1, 1);
  Clouds clouds;
  for (std::size_t run = 0; run < runs; ++run)
  {
    // A few large plates without gaps are in front of what is small, or behind it.
    const bool isPlate = run % 40 == 0;
    const std::array<double, 3> centre{ place(random), place(random), place(random) };
    const std::size_t flat = random() % 3;
    Bounds bounds = { 9, -9, 9, -9, 9, -9 };
    clouds.Points.emplace_back();
    for (int n = 0; n < (isPlate ? 64 * 64 : 60); ++n)
    {
      std::array<double, 3> point{};
      const std::array<double, 3> onPlate{ n % 64 / 32.0 - 1, n / 64 / 32.0 - 1, 0 };
      for (std::size_t axis = 0; axis < 3; ++axis)
      {
        const double offset = isPlate ? 0.7 * onPlate[(axis + flat) % 3] : 0.1 * place(random);
        point[axis] = centre[axis] + offset;
        const auto value = static_cast<float>(point[axis]);
        point[axis] = static_cast<double>(value);
        bounds[2 * axis] = std::min(bounds[2 * axis], value);
        bounds[2 * axis + 1] = std::max(bounds[2 * axis + 1], value);
      }
      clouds.Points.back().push_back(point);
    }
    clouds.Measure.ProperTriangles.push_back(
      static_cast<std::uint32_t>(clouds.Points.back().size()));
    clouds.Measure.RunBounds.push_back(bounds);
  }
  return clouds;
}

/// An image by hand: of the nearest points, the last one that is drawn.
struct Image
{
  std::vector<float> Depths = std::vector<float>(ImageWidth * ImageHeight, 1.0F);
  std::vector<std::size_t> Shown = std::vector<std::size_t>(ImageWidth * ImageHeight, 0);

  void Draw(
    const Matrix& matrix, const Clouds& clouds, const std::vector<VisibleRuns::Range>& ranges)
  {
    std::size_t triangle = 0;
    for (const auto& run : clouds.Points)
    {
      for (const auto& point : run)
      {
        const bool isMeant = std::any_of(ranges.begin(), ranges.end(),
          [triangle](const VisibleRuns::Range& range)
          { return range.First <= triangle && triangle < range.Last; });
        const Fragment fragment = isMeant ? DrawPoint(matrix, point) : Fragment{};
        const auto pixel = static_cast<std::size_t>(fragment.Y * ImageWidth + fragment.X);
        if (fragment.Depth >= 0 && fragment.Depth <= this->Depths[pixel])
        {
          this->Depths[pixel] = fragment.Depth;
          this->Shown[pixel] = triangle + 1;
        }
        ++triangle;
      }
    }
  }
};

std::size_t CountTriangles(const std::vector<VisibleRuns::Range>& ranges)
{
  std::size_t count = 0;
  for (const VisibleRuns::Range& range : ranges)
  {
    EXPECT_LT(range.First, range.Last);
    count += range.Last - range.First;
  }
  return count;
}

/// Draws an image of the visible runs and compares it with that of all. Returns the share of the
/// triangles that is drawn.
double CheckImage(
  VisibleRuns& visible, DepthPyramid& pyramid, const Clouds& clouds, const Matrix& matrix)
{
  std::size_t all = 0;
  for (const std::uint32_t triangles : clouds.Measure.ProperTriangles)
  {
    all += triangles;
  }
  Image expected;
  expected.Draw(matrix, clouds, { { 0, all } });
  Image drawn;
  visible.Begin(BoxProjection(matrix, ImageWidth, ImageHeight));
  std::size_t triangles = 0;
  int portions = 0;
  for (auto ranges = visible.FindFirst(pyramid); portions == 0 || !ranges.empty();
       ranges = visible.FindNext(pyramid))
  {
    triangles += CountTriangles(ranges);
    drawn.Draw(matrix, clouds, ranges);
    pyramid.Build(drawn.Depths, ImageWidth, ImageHeight);
    ++portions;
  }
  EXPECT_LE(portions, 2);
  EXPECT_EQ(drawn.Depths, expected.Depths);
  EXPECT_EQ(drawn.Shown, expected.Shown);
  return static_cast<double>(triangles) / static_cast<double>(all);
}

} // namespace

TEST(BoxProjection, ContainsWhatIsInTheBox)
{
  std::mt19937 random(3);
  std::uniform_real_distribution<double> place(-1, 1);
  int outside = 0;
  int unknown = 0;
  for (int n = 0; n < 400; ++n)
  {
    const Matrix matrix = MakeView(random, n % 4, n % 2 == 0);
    std::array<double, 3> low{};
    std::array<double, 3> high{};
    Bounds bounds{};
    for (std::size_t axis = 0; axis < 3; ++axis)
    {
      const double centre = 2 * place(random);
      const double size = 0.3 * std::abs(place(random));
      bounds[2 * axis] = static_cast<float>(centre - size);
      bounds[2 * axis + 1] = static_cast<float>(centre + size);
      low[axis] = static_cast<double>(bounds[2 * axis]);
      high[axis] = static_cast<double>(bounds[2 * axis + 1]);
    }
    const ProjectedBox box = BoxProjection(matrix, ImageWidth, ImageHeight).Project(bounds);
    outside += box.IsOutside ? 1 : 0;
    unknown += !box.IsOutside && !box.IsKnown ? 1 : 0;
    for (int point = 0; point < 200; ++point)
    {
      std::array<double, 3> at{};
      for (std::size_t axis = 0; axis < 3; ++axis)
      {
        const double share = point < 8 ? (point >> axis) & 1 : (place(random) + 1) / 2;
        at[axis] = low[axis] + share * (high[axis] - low[axis]);
      }
      const Fragment fragment = DrawPoint(matrix, at);
      if (fragment.Depth < 0)
      {
        continue;
      }
      EXPECT_FALSE(box.IsOutside);
      if (box.IsKnown)
      {
        EXPECT_LT(box.Depth, fragment.Depth);
        EXPECT_TRUE(box.Pixels.Left <= fragment.X && fragment.X < box.Pixels.Right);
        EXPECT_TRUE(box.Pixels.Bottom <= fragment.Y && fragment.Y < box.Pixels.Top);
      }
    }
  }
  EXPECT_GT(outside, 40);
  EXPECT_GT(unknown, 15);
  EXPECT_LT(outside + unknown, 320);
}

TEST(BoxProjection, ContainsWhatIsRoundedToSinglePrecision)
{
  // Next to the eye, in a large surface far from the world's origin.
  constexpr double near = 0.05;
  constexpr double far = 100;
  const std::array<double, 3> origin{ 5000, -3000, 800 };
  std::mt19937 random(17);
  std::uniform_real_distribution<double> place(-1, 1);
  double most = 0;
  for (int n = 0; n < 2000; ++n)
  {
    // Of places relative to the origin; the eye is anywhere in the surface, and looks along -z.
    const std::array<double, 3> eye{ 40 * place(random), 40 * place(random), 40 * place(random) };
    const double a = -(far + near) / (far - near);
    const double b = -2 * far * near / (far - near);
    const Matrix relative = { 1.5, 0, 0, -1.5 * eye[0], 0, 1.5, 0, -1.5 * eye[1], 0, 0, a,
      -a * eye[2] + b, 0, 0, -1, eye[2] };
    Matrix world = relative;
    for (std::size_t row = 0; row < 4; ++row)
    {
      for (std::size_t axis = 0; axis < 3; ++axis)
      {
        world[4 * row + 3] -= relative[4 * row + axis] * origin[axis];
      }
    }
    std::array<float, 3> point{};
    for (std::size_t axis = 0; axis < 3; ++axis)
    {
      const double offset =
        axis == 2 ? -0.06 - 0.03 * std::abs(place(random)) : 0.03 * place(random);
      point[axis] = static_cast<float>(origin[axis] + eye[axis] + offset);
    }
    const Bounds bounds = { point[0], point[0], point[1], point[1], point[2], point[2] };
    const ProjectedBox box = BoxProjection(world, ImageWidth, ImageHeight, origin).Project(bounds);
    std::array<float, 4> clip{};
    std::array<double, 4> exact{};
    for (std::size_t row = 0; row < 4; ++row)
    {
      clip[row] = static_cast<float>(relative[4 * row + 3]);
      exact[row] = relative[4 * row + 3];
      for (std::size_t axis = 0; axis < 3; ++axis)
      {
        const double drawn = static_cast<double>(point[axis]) - origin[axis];
        clip[row] += static_cast<float>(relative[4 * row + axis]) * static_cast<float>(drawn);
        exact[row] += relative[4 * row + axis] * drawn;
      }
    }
    if (!box.IsKnown)
    {
      continue;
    }
    const float depth = (clip[2] / clip[3] + 1) / 2;
    EXPECT_LE(box.Depth, depth);
    most = std::max(most, (exact[2] / exact[3] + 1) / 2 - static_cast<double>(depth));
  }
  EXPECT_GT(most, 2e-5) << "rounding plays no part";
}

TEST(BoxProjection, KnowsNothingOfABoxWithoutPointsOrWithoutEnd)
{
  std::mt19937 random(1);
  const ProjectedBox box = BoxProjection(MakeView(random, 4, false), ImageWidth, ImageHeight)
                             .Project({ 1, -1, 1, -1, 1, -1 });
  EXPECT_FALSE(box.IsKnown);
  EXPECT_FALSE(box.IsOutside);
  constexpr float infinity = std::numeric_limits<float>::infinity();
  const ProjectedBox endless = BoxProjection(MakeView(random, 4, false), ImageWidth, ImageHeight)
                                 .Project({ -infinity, infinity, -1, 1, -1, 1 });
  EXPECT_FALSE(endless.IsKnown);
  EXPECT_FALSE(endless.IsOutside);
}

TEST(DepthPyramid, TellsNoBoxBehindThatHasAPixelInFront)
{
  std::mt19937 random(5);
  std::uniform_real_distribution<float> depth(0, 1);
  int behind = 0;
  for (int image = 0; image < 40; ++image)
  {
    // Squares of equal depth, of all sizes, and some holes.
    std::vector<float> depths(ImageWidth * ImageHeight);
    const int side = 1 + static_cast<int>(random() % 30);
    std::vector<float> ofSquares(ImageWidth * ImageHeight);
    std::generate(ofSquares.begin(), ofSquares.end(), [&] { return depth(random); });
    for (int y = 0; y < ImageHeight; ++y)
    {
      for (int x = 0; x < ImageWidth; ++x)
      {
        depths[static_cast<std::size_t>(y * ImageWidth + x)] = random() % 500 == 0
          ? 1
          : ofSquares[static_cast<std::size_t>(y / side * ImageWidth + x / side)];
      }
    }
    DepthPyramid pyramid;
    EXPECT_FALSE(pyramid.IsBehind({ false, true, { 0, 1, 0, 1 }, 2 })) << "there is no image yet";
    pyramid.Build(depths, ImageWidth, ImageHeight);
    for (int n = 0; n < 300; ++n)
    {
      ProjectedBox box;
      box.Pixels.Left = static_cast<int>(random() % 80) - 10;
      box.Pixels.Bottom = static_cast<int>(random() % 60) - 10;
      box.Pixels.Right = box.Pixels.Left + 1 + static_cast<int>(random() % (n % 2 == 0 ? 6 : 70));
      box.Pixels.Top = box.Pixels.Bottom + 1 + static_cast<int>(random() % (n % 2 == 0 ? 6 : 50));
      box.Depth = depth(random);
      bool isBehind = true;
      for (int y = std::max(0, box.Pixels.Bottom); y < std::min(ImageHeight, box.Pixels.Top); ++y)
      {
        for (int x = std::max(0, box.Pixels.Left); x < std::min(ImageWidth, box.Pixels.Right); ++x)
        {
          isBehind = isBehind && depths[static_cast<std::size_t>(y * ImageWidth + x)] < box.Depth;
        }
      }
      EXPECT_TRUE(isBehind || !pyramid.IsBehind(box));
      behind += pyramid.IsBehind(box) ? 1 : 0;
    }
  }
  EXPECT_GT(behind, 1000);
}

TEST(VisibleRuns, GiveTheImageOfAllWithFewerTriangles)
{
  std::mt19937 random(11);
  for (const bool isParallel : { false, true })
  {
    // From inside of the surface, from near, where some of it is beyond the image, and from afar.
    for (const double distance : { 0.3, 2.0, 4.0 })
    {
      SCOPED_TRACE("distance " + std::to_string(distance));
      const Clouds clouds = MakeClouds(random, 400);
      VisibleRuns visible;
      DepthPyramid pyramid;
      visible.Take(clouds.Measure);
      double still = 0;
      for (int view = 0; view < 6; ++view)
      {
        const Matrix matrix = MakeView(random, distance, isParallel);
        CheckImage(visible, pyramid, clouds, matrix);
        still = CheckImage(visible, pyramid, clouds, matrix);
      }
      EXPECT_LT(still, 0.95) << "nothing was left out";
      // Of another surface the image before is all that is known.
      const Clouds other = MakeClouds(random, 300);
      visible.Take(other.Measure);
      CheckImage(visible, pyramid, other, MakeView(random, distance, isParallel));
    }
  }
}

TEST(VisibleRuns, AllAreDrawnAtOnceIfNothingIsKnown)
{
  std::mt19937 random(2);
  const Clouds clouds = MakeClouds(random, 40);
  VisibleRuns visible;
  visible.Take(clouds.Measure);
  visible.Begin(BoxProjection(MakeView(random, 5, true), ImageWidth, ImageHeight));
  const auto ranges = visible.FindFirst(DepthPyramid());
  ASSERT_EQ(ranges.size(), 1u);
  EXPECT_EQ(ranges[0].First, 0u);
  EXPECT_EQ(CountTriangles(ranges), CountTriangles(visible.FindDrawn()));
}

TEST(VisibleRuns, BeginAnewIfTooLittleWasDrawnFirst)
{
  std::mt19937 random(7);
  const Clouds clouds = MakeClouds(random, 40);
  const Matrix matrix = MakeView(random, 5, false);
  VisibleRuns visible;
  visible.Take(clouds.Measure);
  visible.Begin(BoxProjection(matrix, ImageWidth, ImageHeight));
  DepthPyramid wrong;
  wrong.Build(std::vector<float>(ImageWidth * ImageHeight, 0.0F), ImageWidth, ImageHeight);
  EXPECT_TRUE(visible.FindFirst(wrong).empty());
  DepthPyramid nothing;
  nothing.Build(std::vector<float>(ImageWidth * ImageHeight, 1.0F), ImageWidth, ImageHeight);
  const auto ranges = visible.FindNext(nothing);
  EXPECT_TRUE(visible.HasBegunAnew());
  EXPECT_EQ(ranges.size(), 1u);
  EXPECT_TRUE(visible.FindNext(nothing).empty());
}

TEST(VisibleRuns, OfAPixelAreAllThatHaveAPointThere)
{
  std::mt19937 random(13);
  const Clouds clouds = MakeClouds(random, 60);
  const Matrix matrix = MakeView(random, 3, false);
  VisibleRuns visible;
  visible.Take(clouds.Measure);
  visible.Begin(BoxProjection(matrix, ImageWidth, ImageHeight));
  const auto all = visible.FindFirst(DepthPyramid());
  Image expected;
  expected.Draw(matrix, clouds, all);
  for (int n = 0; n < 40; ++n)
  {
    const int x = static_cast<int>(random() % ImageWidth);
    const int y = static_cast<int>(random() % ImageHeight);
    const auto ranges = visible.FindDrawnAt(x, y);
    EXPECT_LT(CountTriangles(ranges), CountTriangles(all));
    Image drawn;
    drawn.Draw(matrix, clouds, ranges);
    const auto pixel = static_cast<std::size_t>(y * ImageWidth + x);
    EXPECT_EQ(drawn.Depths[pixel], expected.Depths[pixel]);
    EXPECT_EQ(drawn.Shown[pixel], expected.Shown[pixel]);
  }
}
