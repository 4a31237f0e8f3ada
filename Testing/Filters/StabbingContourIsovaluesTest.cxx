// SPDX-License-Identifier: BSD-3-Clause
#include "TestImages.h"

#include "vtkDataArray.h"
#include "vtkPointData.h"

#include <limits>

using namespace isosurface;

namespace
{

constexpr Extent IsovaluesGrid{ 0, 40, 0, 20, 0, 33 };

std::int64_t CountEdges(vtkImageData* image)
{
  return 3 * image->GetNumberOfPoints();
}

// The part of a contour that belongs to the number-th isovalue.
EdgeSurface GetPart(vtkPolyData* contour, vtkImageData* image, int number)
{
  return ToEdges(contour, number * CountEdges(image), (number + 1) * CountEdges(image));
}

} // namespace

TEST(StabbingContourIsovalues, IsovalueOfManySamplesEqualsFlyingEdges)
{
  const auto image = MakeImage(IsovaluesGrid, VTK_UNSIGNED_CHAR, MakeNoise(3, 11));
  for (const double isovalue : { 0.0, 1.0, 2.0, 2.5 })
  {
    EXPECT_TRUE(AreEqual(ContourToEdges(image, isovalue), ContourByFlyingEdges(image, isovalue)));
  }
}

TEST(StabbingContourIsovalues, IsovalueOutsideTheRangeHasNoSurface)
{
  const double infinity = std::numeric_limits<double>::infinity();
  for (const int type : { VTK_UNSIGNED_CHAR, VTK_INT, VTK_FLOAT, VTK_DOUBLE })
  {
    const auto image = MakeImage(IsovaluesGrid, type, MakeNoise(100, 12));
    for (const double isovalue : { -1.0, -0.001, 99.5, 1e300, -1e300, infinity, -infinity,
           std::numeric_limits<double>::quiet_NaN() })
    {
      const auto output = Contour(image, { isovalue });
      EXPECT_EQ(output->GetNumberOfPoints(), 0) << isovalue;
      EXPECT_EQ(output->GetNumberOfCells(), 0) << isovalue;
    }
  }
}

TEST(StabbingContourIsovalues, NoIsovalueHasNoSurface)
{
  const auto output = Contour(MakeImage(IsovaluesGrid, VTK_FLOAT, MakeWaves()), {});
  EXPECT_EQ(output->GetNumberOfPoints(), 0);
  EXPECT_EQ(output->GetNumberOfCells(), 0);
}

TEST(StabbingContourIsovalues, SeveralAreTheUnionOfEach)
{
  const auto image = MakeImage(IsovaluesGrid, VTK_FLOAT, MakeWaves());
  // One of them without a surface, one twice, not in order.
  const std::vector<double> isovalues{ 0.3, -0.2, 7.0, 0.3, 0.0 };
  const auto all = Contour(image, isovalues);
  vtkIdType points = 0;
  vtkIdType cells = 0;
  for (std::size_t number = 0; number < isovalues.size(); ++number)
  {
    const EdgeSurface part = GetPart(all, image, static_cast<int>(number));
    EXPECT_TRUE(AreEqual(part, ContourByFlyingEdges(image, isovalues[number])));
    points += static_cast<vtkIdType>(part.Points.size());
    cells += static_cast<vtkIdType>(part.Triangles.size());
  }
  EXPECT_EQ(all->GetNumberOfPoints(), points);
  EXPECT_EQ(all->GetNumberOfCells(), cells);
}

TEST(StabbingContourIsovalues, GlobalIdsAreUnique)
{
  const auto image = MakeImage(IsovaluesGrid, VTK_SHORT, MakeNoise(50, 13));
  const auto output = Contour(image, { 10, 10, 24.5, 40 });
  ExpectDistinctIds(output);
}

TEST(StabbingContourIsovalues, ScalarsTellTheIsovalueOfEachPoint)
{
  const auto image = MakeImage(IsovaluesGrid, VTK_FLOAT, MakeWaves());
  const std::vector<double> isovalues{ 0.25, -0.5, 0.0 };
  const auto output = Contour(image, isovalues);
  vtkDataArray* ids = output->GetPointData()->GetGlobalIds();
  vtkDataArray* scalars = output->GetPointData()->GetScalars();
  ASSERT_NE(ids, nullptr);
  ASSERT_NE(scalars, nullptr);
  for (vtkIdType point = 0; point < output->GetNumberOfPoints(); ++point)
  {
    const auto number = static_cast<std::size_t>(
      static_cast<std::int64_t>(ids->GetTuple1(point)) / CountEdges(image));
    ASSERT_LT(number, isovalues.size());
    ASSERT_EQ(scalars->GetTuple1(point), isovalues[number]);
  }
}
