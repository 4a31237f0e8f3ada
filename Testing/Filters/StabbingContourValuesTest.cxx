// SPDX-License-Identifier: BSD-3-Clause
#include "TestImages.h"

#include "vtkDataArray.h"
#include "vtkNew.h"
#include "vtkPointData.h"
#include "vtkSOADataArrayTemplate.h"
#include "vtkSmartPointer.h"
#include "vtkStabbingContour.h"

#include <cmath>
#include <limits>

using namespace isosurface;

namespace
{

constexpr Extent ValuesGrid{ 0, 36, 0, 33, 0, 8 };
constexpr double NotANumber = std::numeric_limits<double>::quiet_NaN();
constexpr double Infinity = std::numeric_limits<double>::infinity();

vtkSmartPointer<vtkImageData> ConvertTo(int type, vtkImageData* image)
{
  vtkDataArray* samples = image->GetPointData()->GetScalars();
  auto copy = vtkSmartPointer<vtkImageData>::New();
  copy->CopyStructure(image);
  const auto converted = vtk::TakeSmartPointer(vtkDataArray::CreateDataArray(type));
  converted->DeepCopy(samples);
  copy->GetPointData()->SetScalars(converted);
  return copy;
}

// Waves of the given range, and a corner of its ends side by side.
Field MakeSpan(double low, double high)
{
  return [=, waves = MakeWaves()](int i, int j, int k)
  {
    if (i < 4 && j < 4)
    {
      return ((i + j + k) & 1) != 0 ? low : high;
    }
    return std::floor(low + (high - low) * (waves(i, j, k) + 1.0) / 2.0);
  };
}

} // namespace

class StabbingContourTypes : public testing::TestWithParam<int>
{
};

TEST_P(StabbingContourTypes, SmallValuesEqualFlyingEdges)
{
  const int type = GetParam();
  const bool isSigned = vtkDataArray::GetDataTypeMin(type) < 0;
  const auto image = MakeImage(ValuesGrid, type, MakeSpan(isSigned ? -100.0 : 0.0, 120.0));
  // vtkFlyingEdges3D lets differences of unsigned int and unsigned long wrap around; we do not.
  // The same values as double have no such trouble.
  const bool wraps = !isSigned && vtkDataArray::GetDataTypeSize(type) >= 4;
  const auto oracle = wraps ? ConvertTo(VTK_DOUBLE, image) : image;
  for (const double isovalue : { 1.0, 17.5, 90.0 })
  {
    EXPECT_TRUE(AreEqual(ContourToEdges(image, isovalue), ContourByFlyingEdges(oracle, isovalue)));
  }
}

// Up to 2^50, which double holds exactly with half a step. Differences of 32 and 64 bits overflow
// in vtkFlyingEdges3D: the oracle contours the same values as double.
TEST_P(StabbingContourTypes, WholeRangeEqualsFlyingEdgesOnDouble)
{
  const int type = GetParam();
  if (type == VTK_FLOAT || type == VTK_DOUBLE)
  {
    GTEST_SKIP() << "integers only";
  }
  const double low = std::max(vtkDataArray::GetDataTypeMin(type), -std::ldexp(1.0, 50));
  const double high = std::min(vtkDataArray::GetDataTypeMax(type), std::ldexp(1.0, 50));
  const auto image = MakeImage(ValuesGrid, type, MakeSpan(low, high));
  const auto oracle = ConvertTo(VTK_DOUBLE, image);
  for (const double share : { 0.1, 0.5, 0.9 })
  {
    const double isovalue = std::floor(low + share * (high - low)) + 0.5;
    EXPECT_TRUE(AreEqual(ContourToEdges(image, isovalue), ContourByFlyingEdges(oracle, isovalue)));
  }
  EXPECT_TRUE(AreEqual(ContourToEdges(image, high), ContourByFlyingEdges(oracle, high)));
  EXPECT_TRUE(AreEqual(ContourToEdges(image, low), ContourByFlyingEdges(oracle, low)));
}

INSTANTIATE_TEST_SUITE_P(AllOfVTK, StabbingContourTypes,
  testing::Values(VTK_CHAR, VTK_SIGNED_CHAR, VTK_UNSIGNED_CHAR, VTK_SHORT, VTK_UNSIGNED_SHORT,
    VTK_INT, VTK_UNSIGNED_INT, VTK_LONG, VTK_UNSIGNED_LONG, VTK_LONG_LONG, VTK_UNSIGNED_LONG_LONG,
    VTK_ID_TYPE, VTK_FLOAT, VTK_DOUBLE),
  [](const testing::TestParamInfo<int>& type)
  {
    std::string name = vtkImageScalarTypeNameMacro(type.param);
    name.erase(std::remove(name.begin(), name.end(), ' '), name.end());
    return name;
  });

// vtkFlyingEdges3D compares samples as double, for which these are all the same. The oracle
// contours what they are above 2^60. Only inside and outside can be told exactly, not the place on
// an edge.
TEST(StabbingContourValues, IntegersOf64BitsAreComparedExactly)
{
  const std::int64_t base = std::int64_t(1) << 60;
  const auto offsets = MakeImage(ValuesGrid, VTK_DOUBLE,
    [noise = MakeNoise(7, 5)](int i, int j, int k) mutable { return noise(i, j, k) - 3.0; });
  for (const int type : { VTK_LONG, VTK_LONG_LONG, VTK_UNSIGNED_LONG_LONG })
  {
    vtkNew<vtkImageData> image;
    image->CopyStructure(offsets);
    image->AllocateScalars(type, 1);
    auto* samples = static_cast<std::int64_t*>(image->GetScalarPointer());
    for (vtkIdType index = 0; index < image->GetNumberOfPoints(); ++index)
    {
      samples[index] = base +
        static_cast<std::int64_t>(offsets->GetPointData()->GetScalars()->GetComponent(index, 0));
    }
    const EdgeSurface surface = ContourToEdges(image, static_cast<double>(base));
    const EdgeSurface expected = ContourByFlyingEdges(offsets, 0.0);
    EXPECT_EQ(surface.Triangles, expected.Triangles);
    ASSERT_EQ(surface.Points.size(), expected.Points.size());
    for (std::size_t point = 0; point < expected.Points.size(); ++point)
    {
      ASSERT_EQ(surface.Points[point].Edge, expected.Points[point].Edge);
      ASSERT_EQ(surface.Points[point].Normal[0] == 0x7fc00000u, false);
    }
  }
}

TEST(StabbingContourValues, NaNRegionsEqualFlyingEdges)
{
  for (const int type : { VTK_FLOAT, VTK_DOUBLE })
  {
    const auto ball = MakeImage({ 0, 40, 0, 36, 0, 34 }, type,
      [waves = MakeWaves()](int i, int j, int k)
      {
        const int distance = (i - 31) * (i - 31) + (j - 18) * (j - 18) + (k - 17) * (k - 17);
        return distance < 100 ? NotANumber : waves(i, j, k);
      });
    const auto specks = MakeImage(ValuesGrid, type,
      [waves = MakeWaves(), noise = MakeNoise(9, 3)](int i, int j, int k) mutable
      { return noise(i, j, k) == 0.0 ? NotANumber : waves(i, j, k); });
    for (vtkImageData* image : { ball.Get(), specks.Get() })
    {
      for (const double isovalue : { -0.4, 0.0, 0.21 })
      {
        const EdgeSurface expected = ContourByFlyingEdges(image, isovalue);
        EXPECT_FALSE(expected.Triangles.empty());
        EXPECT_TRUE(AreEqual(ContourToEdges(image, isovalue), expected));
      }
    }
  }
}

TEST(StabbingContourValues, NothingButNaNHasNoSurface)
{
  const auto image = MakeImage(ValuesGrid, VTK_FLOAT, [](int, int, int) { return NotANumber; });
  EXPECT_EQ(Contour(image, { 0.0 })->GetNumberOfPoints(), 0);
}

// One block of NaN among others, and NaN first or last in a block.
TEST(StabbingContourValues, NaNDoesNotHideTheRestOfItsBlock)
{
  for (const int speck : { 0, 1, 16, 31, 32, 33 })
  {
    const auto image = MakeImage({ 0, 33, 0, 33, 0, 33 }, VTK_FLOAT,
      [&](int i, int j, int k) {
        return i == speck && j == speck && k == speck ? NotANumber : i == 20 && j == 3 ? 1.0 : 0.0;
      });
    EXPECT_TRUE(AreEqual(ContourToEdges(image, 0.5), ContourByFlyingEdges(image, 0.5)));
  }
}

TEST(StabbingContourValues, InfinitiesEqualFlyingEdges)
{
  for (const int type : { VTK_FLOAT, VTK_DOUBLE })
  {
    const auto image = MakeImage(ValuesGrid, type,
      [waves = MakeWaves(), noise = MakeNoise(12, 4)](int i, int j, int k) mutable
      {
        const double odd = noise(i, j, k);
        return odd == 0.0 ? Infinity : odd == 1.0 ? -Infinity : waves(i, j, k);
      });
    EXPECT_TRUE(AreEqual(ContourToEdges(image, 0.1), ContourByFlyingEdges(image, 0.1)));
  }
}

TEST(StabbingContourValues, ArrayOfOtherMemoryLayoutEqualsPlainOne)
{
  const auto image = MakeImage(ValuesGrid, VTK_FLOAT, MakeWaves());
  vtkNew<vtkSOADataArrayTemplate<float>> samples;
  samples->DeepCopy(image->GetPointData()->GetScalars());
  samples->SetName("density");
  vtkNew<vtkImageData> other;
  other->CopyStructure(image);
  other->GetPointData()->SetScalars(samples);
  EXPECT_TRUE(AreEqual(ContourToEdges(other, 0.1), ContourToEdges(image, 0.1)));
}
