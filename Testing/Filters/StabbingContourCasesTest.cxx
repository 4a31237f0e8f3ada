// SPDX-License-Identifier: BSD-3-Clause
#include "TestImages.h"

#include <random>

using namespace isosurface;

namespace
{

// The corners of a cell are inside by the bits of `number`; the other vertices are as told.
Field MakeCase(int number, int corner, double others)
{
  return [=](int i, int j, int k)
  {
    const int x = i - corner;
    const int y = j - corner;
    const int z = k - corner;
    if (x < 0 || x > 1 || y < 0 || y > 1 || z < 0 || z > 1)
    {
      return others;
    }
    // Values that differ put every point at a place of its own.
    const int bit = x + 2 * y + 4 * z;
    return (number >> bit & 1) != 0 ? 1.0 + 0.1 * bit : -1.0 - 0.07 * bit;
  };
}

void ExpectEqualInAllCases(const Extent& extent, int corner, double others)
{
  for (int number = 0; number < 256; ++number)
  {
    const auto image = MakeImage(extent, VTK_DOUBLE, MakeCase(number, corner, others));
    EXPECT_TRUE(AreEqual(ContourToEdges(image, 0.0), ContourByFlyingEdges(image, 0.0)))
      << "case " << number;
  }
}

} // namespace

TEST(StabbingContourCases, SingleCellEqualsFlyingEdgesInAll256Cases)
{
  ExpectEqualInAllCases({ 0, 1, 0, 1, 0, 1 }, 0, 0.0);
}

TEST(StabbingContourCases, CellBesideOutsideEqualsFlyingEdgesInAll256Cases)
{
  ExpectEqualInAllCases({ 0, 2, 0, 2, 0, 2 }, 0, -3.0);
  ExpectEqualInAllCases({ 0, 2, 0, 2, 0, 2 }, 1, -3.0);
}

TEST(StabbingContourCases, CellBesideInsideEqualsFlyingEdgesInAll256Cases)
{
  ExpectEqualInAllCases({ 0, 2, 0, 2, 0, 2 }, 0, 3.0);
  ExpectEqualInAllCases({ 0, 2, 0, 2, 0, 2 }, 1, 3.0);
}

TEST(StabbingContourCases, SurroundedCellIsClosedInAll256Cases)
{
  for (int number = 0; number < 256; ++number)
  {
    for (const double others : { -3.0, 3.0 })
    {
      const auto image = MakeImage({ 0, 3, 0, 3, 0, 3 }, VTK_FLOAT, MakeCase(number, 1, others));
      const EdgeSurface surface = ContourToEdges(image, 0.0);
      EXPECT_TRUE(IsClosedManifold(surface)) << "case " << number;
      EXPECT_TRUE(AreEqual(surface, ContourByFlyingEdges(image, 0.0))) << "case " << number;
    }
  }
}

// Few levels, so that many samples equal the isovalue.
TEST(StabbingContourCases, ThousandRandomGridsEqualFlyingEdges)
{
  std::mt19937 engine(20261121);
  const int types[] = { VTK_UNSIGNED_CHAR, VTK_SHORT, VTK_FLOAT, VTK_DOUBLE };
  for (int number = 0; number < 1000; ++number)
  {
    Extent extent{};
    for (int axis = 0; axis < 3; ++axis)
    {
      extent[2 * axis + 1] = 4 + static_cast<int>(engine() % 5);
    }
    const int levels = 2 + static_cast<int>(engine() % 4);
    const double isovalue = 0.5 * static_cast<double>(engine() % (2 * levels));
    const auto image = MakeImage(extent, types[number % 4], MakeNoise(levels, engine()));
    ASSERT_TRUE(AreEqual(ContourToEdges(image, isovalue), ContourByFlyingEdges(image, isovalue)))
      << "grid " << number << ", isovalue " << isovalue;
  }
}
