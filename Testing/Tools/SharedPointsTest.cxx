// SPDX-License-Identifier: BSD-3-Clause
#include "SharedPoints.h"

#include <gtest/gtest.h>

using namespace isosurface;

namespace
{

constexpr Index3 Dimensions = { 3, 5, 5 };

/// Of the edge from a vertex along x.
std::int64_t MakeId(std::int64_t i, std::int64_t j, std::int64_t k)
{
  return 3 * (i + Dimensions[0] * (j + Dimensions[1] * k));
}

std::vector<std::uint64_t> Number(SharedPoints& points, const std::vector<std::int64_t>& ids)
{
  Mesh mesh;
  mesh.GlobalIds = ids.data();
  mesh.NumberOfPoints = ids.size();
  return points.Number(mesh).Values;
}

} // namespace

TEST(SharedPoints, AreNumberedOnceIfNothingIsKeptOfThePieceThatBeginsALayer)
{
  for (const bool isKept : { true, false })
  {
    SharedPoints points(Dimensions);
    points.Begin({ { { 0, 0, 0 }, { 3, 5, 3 } }, 3, true });
    EXPECT_EQ(Number(points, { MakeId(0, 1, 2), MakeId(0, 3, 2), MakeId(0, 4, 1) }),
      (std::vector<std::uint64_t>{ 0, 1, 2 }));
    points.Begin({ { { 0, 0, 2 }, { 3, 3, 5 } }, 2, true });
    if (isKept)
    {
      EXPECT_EQ(
        Number(points, { MakeId(0, 1, 2), MakeId(0, 2, 3) }), (std::vector<std::uint64_t>{ 0, 3 }));
    }
    points.Begin({ { { 0, 2, 2 }, { 3, 5, 5 } }, 2, false });
    EXPECT_EQ(
      Number(points, { MakeId(0, 3, 2), MakeId(0, 2, 3) }), (std::vector<std::uint64_t>{ 1, 3 }));
    EXPECT_EQ(points.GetNumberOfPoints(), 4u);
  }
}
