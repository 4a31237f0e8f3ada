// SPDX-License-Identifier: BSD-3-Clause
#include "Surface/Drawing/DrawingBuffers.h"

#include "TriangleSamples.h"

#include <gtest/gtest.h>

#include <limits>
#include <numeric>
#include <vector>

using namespace isosurface;

namespace
{

bool AreSame(const float* a, const float* b)
{
  return a[0] == b[0] && a[1] == b[1] && a[2] == b[2];
}

std::vector<std::uint32_t> ListTrianglesOfThreePlaces(const OwnTriangles& surface)
{
  std::vector<std::uint32_t> indices;
  for (std::size_t n = 0; n < surface.Triangles.size(); n += 3)
  {
    const float* places[3];
    for (std::size_t corner = 0; corner < 3; ++corner)
    {
      places[corner] =
        surface.Points.data() + 3 * static_cast<std::size_t>(surface.Triangles[n + corner]);
    }
    if (!AreSame(places[0], places[1]) && !AreSame(places[1], places[2]) &&
      !AreSame(places[0], places[2]))
    {
      indices.insert(indices.end(), surface.Triangles.begin() + static_cast<std::ptrdiff_t>(n),
        surface.Triangles.begin() + static_cast<std::ptrdiff_t>(n + 3));
    }
  }
  return indices;
}

std::vector<std::uint32_t> Copy(const TriangleSurface& surface, int threads)
{
  const std::vector<std::uint32_t> counts = MeasureTriangles(surface, threads).ProperTriangles;
  // Two portions: the last two thirds of the runs, and the first third.
  const auto middle = counts.begin() + static_cast<std::ptrdiff_t>(counts.size() / 3);
  const std::size_t firsts = 3 * std::accumulate(counts.begin(), middle, std::size_t{ 0 });
  std::vector<std::uint32_t> indices(
    firsts + 3 * std::accumulate(middle, counts.end(), std::size_t{ 0 }));
  CopyProperTriangles(
    surface, counts, counts.size() / 3, counts.size(), indices.data() + firsts, threads);
  CopyProperTriangles(surface, counts, 0, counts.size() / 3, indices.data(), threads);
  return indices;
}

template <typename T>
std::vector<float> FindCoordinates(const std::vector<T>& values, int components, int component,
  const TextureRange& range, int threads = 2)
{
  const std::size_t tuples = values.size() / static_cast<std::size_t>(components);
  std::vector<float> coordinates(2 * tuples);
  FindTextureCoordinates(
    values.data(), tuples, components, component, range, coordinates.data(), threads);
  return coordinates;
}

} // namespace

TEST(DrawingBuffers, IndicesAreTheTrianglesOfThreePlacesInTheirOrder)
{
  OwnTriangles surface = MakeRandomTriangles(300, 200000, 5);
  const std::vector<std::uint32_t> expected = ListTrianglesOfThreePlaces(surface);
  for (int threads : { 1, 3 })
  {
    EXPECT_EQ(Copy(surface.GetView(), threads), expected);
    EXPECT_EQ(Copy(surface.GetView64(), threads), expected);
  }
}

TEST(DrawingBuffers, IndicesOfASurfaceWithoutDegenerateTrianglesAreItsConnectivity)
{
  OwnTriangles sphere = MakeSphere(200, 300);
  const std::vector<std::uint32_t> expected(sphere.Triangles.begin(), sphere.Triangles.end());
  EXPECT_EQ(Copy(sphere.GetView(), 2), expected);
  EXPECT_EQ(Copy(sphere.GetView64(), 2), expected);
}

TEST(DrawingBuffers, PointsAreShiftedAndScaledInDouble)
{
  const OwnTriangles sphere = MakeSphere(300, 300);
  const double shift[3] = { 1.0 / 3, -2e5, 7 };
  const double scale[3] = { 1e-3, 3, 1.0 / 7 };
  std::vector<float> result(sphere.Points.size());
  ShiftAndScale(sphere.Points.data(), sphere.Points.size() / 3, shift, scale, result.data(), 3);
  for (std::size_t n = 0; n < result.size(); ++n)
  {
    const double value = (static_cast<double>(sphere.Points[n]) - shift[n % 3]) * scale[n % 3];
    ASSERT_EQ(result[n], static_cast<float>(value));
  }
}

TEST(DrawingBuffers, TextureCoordinatesLeaveOneTexelBelowAndAboveTheRange)
{
  // Ten texels of 1 from 0 to 10, one more on both sides: 12 in all.
  const TextureRange range{ 0, 10, 10 };
  const std::vector<float> coordinates = FindCoordinates<float>({ -1, 0, 5, 10, 11 }, 1, 0, range);
  const std::vector<double> expected = { 0, 1.0 / 12, 0.5, 11.0 / 12, 1 };
  for (std::size_t n = 0; n < expected.size(); ++n)
  {
    EXPECT_NEAR(coordinates[2 * n], expected[n], 1e-6);
    EXPECT_EQ(coordinates[2 * n + 1], 0.49F);
  }
}

TEST(DrawingBuffers, TextureCoordinatesTellNumbersFromNan)
{
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const std::vector<float> coordinates = FindCoordinates<double>({ nan, 3 }, 1, 0, { 0, 10, 10 });
  EXPECT_EQ(coordinates[0], 0.5F);
  EXPECT_EQ(coordinates[1], 1.0F);
  EXPECT_EQ(coordinates[3], 0.49F);
}

TEST(DrawingBuffers, TextureCoordinatesAreClampedToAThousand)
{
  const double infinity = std::numeric_limits<double>::infinity();
  const std::vector<float> coordinates =
    FindCoordinates<double>({ 1e9, -1e9, infinity, -infinity }, 1, 0, { 0, 1, 256 });
  EXPECT_EQ(coordinates[0], 1000.0F);
  EXPECT_EQ(coordinates[2], -1000.0F);
  EXPECT_EQ(coordinates[4], 1000.0F);
  EXPECT_EQ(coordinates[6], -1000.0F);
}

TEST(DrawingBuffers, TextureCoordinatesAreThoseOfAComponentOrTheMagnitude)
{
  const std::vector<short> values = { 3, 4, 0, 5, 12, 1 };
  const TextureRange range{ 0, 14, 14 };
  const std::vector<float> second = FindCoordinates(values, 2, 1, range);
  EXPECT_EQ(second, FindCoordinates<short>({ 4, 5, 1 }, 1, 0, range));
  const std::vector<float> magnitude = FindCoordinates(values, 2, -1, range);
  EXPECT_EQ(magnitude[0], FindCoordinates<double>({ 5 }, 1, 0, range)[0]);
  // A component that the tuples do not have stands for the magnitude as well.
  EXPECT_EQ(FindCoordinates(values, 2, 2, range), magnitude);
}

TEST(DrawingBuffers, TextureCoordinatesDoNotDependOnThreads)
{
  const OwnTriangles sphere = MakeSphere(300, 300);
  const TextureRange range{ -1, 1, 64 };
  EXPECT_EQ(FindCoordinates(sphere.Points, 3, -1, range, 1),
    FindCoordinates(sphere.Points, 3, -1, range, 4));
}

TEST(DrawingBuffers, RunsEndWhereAnotherValueBegins)
{
  const std::vector<float> values = { 3, 3, 3, 1, 3, 3 };
  using Ends = std::vector<std::size_t>;
  EXPECT_EQ(FindRuns(values.data(), values.size(), 3), (Ends{ 3, 4, 6 }));
  EXPECT_EQ(FindRuns(values.data(), values.size(), 2), Ends{});
  EXPECT_EQ(FindRuns(values.data(), 0, 2), Ends{});
  const double none = std::numeric_limits<double>::quiet_NaN();
  const std::vector<double> unlike = { none, none };
  EXPECT_EQ(FindRuns(unlike.data(), unlike.size(), 2), (Ends{ 1, 2 }));
}
