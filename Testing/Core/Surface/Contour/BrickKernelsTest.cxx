// SPDX-License-Identifier: BSD-3-Clause
#include "Fixtures/TestBlockSource.h"
#include "Surface/Contour/BrickKernel.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <limits>
#include <random>
#include <vector>

using namespace isosurface;

namespace
{

// Compares bits, but all NaN are equal, since the bits of a NaN are not specified.
template <typename T>
bool AreEqual(const std::vector<T>& first, const std::vector<T>& second)
{
  return std::equal(first.begin(), first.end(), second.begin(), second.end(),
    [](const T& one, const T& other)
    { return std::memcmp(&one, &other, sizeof(T)) == 0 || (one != one && other != other); });
}

// The results of all kernels for a brick of samples.
template <typename T>
struct Products
{
  std::vector<std::uint64_t> Inside;
  std::vector<std::uint32_t> Offsets;
  std::vector<EdgeCode> Codes;
  std::vector<double> Parameters;
  std::vector<float> Coordinates;
  std::vector<float> Normals;
  std::vector<float> Points;
  std::vector<float> WorldNormals;
  std::vector<std::int64_t> GlobalIds;
  std::vector<std::int32_t> Triangles;
  std::vector<std::int64_t> Polygons;
  BrickCounts Counts{};
  T Minimum = std::numeric_limits<T>::max();
  T Maximum = std::numeric_limits<T>::lowest();
  bool NotANumber = false;

  Products(const BrickKernels& kernels, const BrickSamples& samples, T threshold,
    const WorldTransform& transform);
  void MakeCells(
    const BrickKernels& kernels, const BrickSamples& samples, const BrickOwnership& ownership);
};

template <typename T>
Products<T>::Products(const BrickKernels& kernels, const BrickSamples& samples, T threshold,
  const WorldTransform& transform)
{
  const auto rows = static_cast<std::size_t>(samples.Size[1] * samples.Size[2]);
  this->Inside.resize(rows);
  this->Offsets.resize(rows);
  this->Codes.resize(3 * rows * MaximumBrickSize + EdgeCodeSlack);
  BrickOwnership ownership;
  std::memset(&ownership, 0xff, sizeof(ownership));

  const ValueType type = ValueTypeOf<T>::Value;
  kernels.ClassifyRows(type, samples, &threshold, this->Inside.data());
  this->Counts = kernels.NumberRows(
    samples.Size, this->Inside.data(), ownership, this->Offsets.data(), this->Codes.data());
  const std::uint32_t points = this->Counts.Points;
  this->Codes.resize(points);
  this->Parameters.resize(points);
  this->Coordinates.resize(points);
  this->Normals.resize(3 * std::size_t(points));
  this->Points.resize(3 * std::size_t(points));
  this->WorldNormals.resize(3 * std::size_t(points));
  this->GlobalIds.resize(points);
  kernels.LocatePoints(type, samples, static_cast<double>(threshold), this->Codes.data(), points,
    this->Coordinates.data(), this->Parameters.data());
  kernels.ComputeNormals(
    type, samples, this->Codes.data(), this->Parameters.data(), points, this->Normals.data());
  PointOutput output{};
  output.Codes = this->Codes.data();
  output.Coordinates = this->Coordinates.data();
  output.Normals = this->Normals.data();
  output.NumberOfPoints = points;
  output.Points = this->Points.data();
  output.WorldNormals = this->WorldNormals.data();
  output.GlobalIds = this->GlobalIds.data();
  output.FirstGlobalId = 1234567;
  kernels.WritePoints(samples, transform, output);
  this->MakeCells(kernels, samples, ownership);

  SampleRows plane{};
  plane.First = samples.First;
  for (int axis = 0; axis < 2; ++axis)
  {
    plane.Stride[axis] = samples.Stride[axis];
    plane.Size[axis] = samples.Size[axis];
  }
  kernels.JoinRange(type, plane, &this->Minimum, &this->Maximum, &this->NotANumber);
}

template <typename T>
void Products<T>::MakeCells(
  const BrickKernels& kernels, const BrickSamples& samples, const BrickOwnership& ownership)
{
  this->Triangles.resize(3 * std::size_t(this->Counts.Triangles));
  this->Polygons.resize(this->Counts.Triangles + 2 * std::size_t(this->Counts.Polygons));
  std::vector<std::int64_t> offsets(this->Counts.Polygons);
  NumberedRows numbered{ this->Inside.data(), this->Offsets.data(), &ownership, 99, {} };
  std::memcpy(numbered.Size, samples.Size, sizeof(numbered.Size));
  EdgeRow x[2][MaximumBrickSize];
  EdgeRow y[2][MaximumBrickSize];
  EdgeRow z[2][MaximumBrickSize];
  std::int64_t columns[6][MaximumBrickSize];
  for (auto& column : columns)
  {
    std::fill(std::begin(column), std::end(column), &column - columns);
  }
  std::int32_t* triangle = this->Triangles.data();
  std::int64_t* corner = this->Polygons.data();
  std::int64_t* offset = offsets.data();
  std::int64_t index = 0;
  for (int k = 0; k + 1 < samples.Size[2]; ++k)
  {
    RowSlab slab{};
    for (int plane = 0; plane < 2; ++plane)
    {
      kernels.FindRows(numbered, k + plane, x[plane], y[plane], z[plane]);
      slab.Inside[plane] = this->Inside.data() + (k + plane) * samples.Size[1];
      slab.X[plane] = x[plane];
      slab.Y[plane] = y[plane];
      slab.ColumnY[0][plane] = columns[plane];
      slab.ColumnY[1][plane] = columns[2 + plane];
      slab.ColumnZ[plane] = columns[4 + plane];
    }
    slab.Z = z[0];
    slab.Size[0] = samples.Size[0];
    slab.Size[1] = samples.Size[1];
    slab.Cases = GetCellCases(false);
    slab.FirstColumnInRow = k % 2 == 0;
    triangle =
      kernels.WriteTriangles32(slab, triangle, this->Triangles.data() + this->Triangles.size());
    kernels.WritePolygons64(slab, corner, offset, index);
  }
  EXPECT_EQ(triangle, this->Triangles.data() + this->Triangles.size());
  EXPECT_EQ(corner, this->Polygons.data() + this->Polygons.size());
  EXPECT_EQ(offset, offsets.data() + offsets.size());
}

WorldTransform MakeTransform(WorldTransform::Kind steps, bool roundedOnce)
{
  WorldTransform transform{ steps, { 0.1, -2, 1e3 }, {}, {} };
  for (int n = 0; n < 12; ++n)
  {
    transform.Points[n] = 0.3 * n - 1.7;
  }
  for (int n = 0; n < 9; ++n)
  {
    transform.Normals[n] = 1.1 - 0.37 * n;
  }
  transform.NormalsRoundedOnce = roundedOnce;
  return transform;
}

template <typename T>
class BrickKernelsOfType : public testing::Test
{
};
TYPED_TEST_SUITE(BrickKernelsOfType, AllValueTypes);

} // namespace

TYPED_TEST(BrickKernelsOfType, BothKernelsAreBitwiseEqual)
{
  const BrickKernels* newer = GetAvx2BrickKernels();
  if (!newer)
  {
    GTEST_SKIP() << "this processor or this build has one kernel only";
  }
  std::mt19937 random(80);
  for (int trial = 0; trial < 30; ++trial)
  {
    const auto draw = [&random] { return static_cast<int>(2 + random() % 32); };
    const int size[3] = { trial % 3 == 0 ? 33 : draw(), draw(), draw() };
    auto volume =
      MakeRandomVolume<TypeParam>(random, { size[0], size[1], size[2] }, trial % 2 == 0 ? 3 : 120);
    BrickSamples samples{};
    samples.First = volume.Samples.data();
    for (int axis = 0; axis < 3; ++axis)
    {
      samples.Stride[axis] = volume.GetView().Stride[axis];
      samples.Size[axis] = size[axis];
      samples.Dimensions[axis] = size[axis];
      samples.KnownHigh[axis] = size[axis];
      samples.ExtentLow[axis] = -7 * axis;
    }
    const auto transform =
      MakeTransform(static_cast<WorldTransform::Kind>(trial % 3), trial % 6 >= 3);
    const auto threshold = static_cast<TypeParam>(trial % 2 == 0 ? 1 : 40);
    const Products<TypeParam> one(GetBaselineBrickKernels(), samples, threshold, transform);
    const Products<TypeParam> other(*newer, samples, threshold, transform);
    EXPECT_TRUE(AreEqual(one.Inside, other.Inside));
    EXPECT_TRUE(AreEqual(one.Offsets, other.Offsets));
    EXPECT_TRUE(AreEqual(one.Codes, other.Codes));
    EXPECT_TRUE(AreEqual(one.Parameters, other.Parameters));
    EXPECT_TRUE(AreEqual(one.Coordinates, other.Coordinates));
    EXPECT_TRUE(AreEqual(one.Normals, other.Normals));
    EXPECT_TRUE(AreEqual(one.Points, other.Points));
    EXPECT_TRUE(AreEqual(one.WorldNormals, other.WorldNormals));
    EXPECT_TRUE(AreEqual(one.GlobalIds, other.GlobalIds));
    EXPECT_TRUE(AreEqual(one.Triangles, other.Triangles));
    EXPECT_TRUE(AreEqual(one.Polygons, other.Polygons));
    EXPECT_EQ(one.Counts.Triangles, other.Counts.Triangles);
    EXPECT_EQ(one.Counts.Polygons, other.Counts.Polygons);
    EXPECT_EQ(one.Minimum, other.Minimum);
    EXPECT_EQ(one.Maximum, other.Maximum);
    EXPECT_EQ(one.NotANumber, other.NotANumber);
  }
}
