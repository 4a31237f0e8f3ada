// SPDX-License-Identifier: BSD-3-Clause
#include "Ranks/Query/SurfaceMemory.h"

#include <gtest/gtest.h>

using namespace isosurface;

namespace
{

TEST(SurfaceMemory, HoldsTheArraysOfASurfaceAndItsCopyForDrawing)
{
  // An octahedron that is refined often has half as many points as triangles. What its arrays and
  // vertex buffers need at least, a triangle:
  const double cell = 3 * 4 + 4;
  const double point = 3 * 4;
  const double drawn = 3 * 4 + (3 + 3) * 4 / 2.0;
  ContourRequest request;
  const double positions = EstimateBytesPerTriangle(request);
  EXPECT_GE(positions, cell + point / 2 + drawn);
  EXPECT_LE(positions, 2 * (cell + point / 2 + drawn));
}

TEST(SurfaceMemory, GrowsByNormalsAndAttributesOfTheirTypes)
{
  ContourRequest request;
  const double positions = EstimateBytesPerTriangle(request);
  request.Normals = true;
  const double normals = EstimateBytesPerTriangle(request) - positions;
  EXPECT_GT(normals, 0);
  // Three components of short become float, as normals are.
  request.Attributes = { { ValueType::Int16, 3 } };
  EXPECT_DOUBLE_EQ(EstimateBytesPerTriangle(request), positions + 2 * normals);
  request.Attributes = { { ValueType::Float64, 3 } };
  EXPECT_DOUBLE_EQ(EstimateBytesPerTriangle(request), positions + 3 * normals);
}

TEST(SurfaceMemory, TheFirstSurfaceThatFitsIsFound)
{
  const std::vector<double> bytes = { 1000, 400, 100 };
  EXPECT_EQ(FindFittingSurface(bytes, 1250), 0u);
  EXPECT_EQ(FindFittingSurface(bytes, 1249), 1u);
  EXPECT_EQ(FindFittingSurface(bytes, 500), 1u);
  EXPECT_EQ(FindFittingSurface(bytes, 499), 2u);
}

TEST(SurfaceMemory, TheLastSurfaceIsTakenIfNoneFits)
{
  EXPECT_EQ(FindFittingSurface({ 1000, 400, 100 }, 1), 2u);
}

TEST(SurfaceMemory, UnknownMemoryIsEnough)
{
  EXPECT_EQ(FindFittingSurface({ 1000, 400, 100 }, 0), 0u);
}

} // namespace
