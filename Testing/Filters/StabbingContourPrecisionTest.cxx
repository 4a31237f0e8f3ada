// SPDX-License-Identifier: BSD-3-Clause
#include "TestImages.h"

#include "vtkDoubleArray.h"
#include "vtkMultiBlockDataSet.h"
#include "vtkNew.h"
#include "vtkPointData.h"
#include "vtkPoints.h"
#include "vtkPolyData.h"
#include "vtkRectilinearGrid.h"

#include <algorithm>
#include <cmath>

using namespace isosurface;

namespace
{

const double MapOrigin[] = { 448000, 6000000, -2000 };

// A ball of radius 11.5.
vtkSmartPointer<vtkImageData> MakeBallImage(double spacing)
{
  const auto image = MakeImage({ 0, 31, 0, 31, 0, 31 }, VTK_FLOAT,
    [](int i, int j, int k) { return 11.5 - std::hypot(i - 16.0, j - 16.0, k - 16.0); });
  image->SetOrigin(MapOrigin);
  image->SetSpacing(spacing, spacing, spacing);
  return image;
}

vtkSmartPointer<vtkPolyData> ContourTo(vtkDataObject* input, int precision)
{
  const auto contour = MakeContour(input, 0.0);
  contour->SetOutputPointsPrecision(precision);
  contour->Update();
  return contour->GetOutput();
}

// In samples.
double FindErrorOfRadius(vtkPolyData* surface, double spacing)
{
  double error = 0;
  for (vtkIdType number = 0; number < surface->GetNumberOfPoints(); ++number)
  {
    double point[3];
    surface->GetPoint(number, point);
    const double radius = std::hypot((point[0] - MapOrigin[0]) / spacing - 16,
      (point[1] - MapOrigin[1]) / spacing - 16, (point[2] - MapOrigin[2]) / spacing - 16);
    error = std::max(error, std::abs(radius - 11.5));
  }
  return error;
}

} // namespace

TEST(StabbingContourPrecision, DefaultIsDoubleWhereFloatDoesNotSuffice)
{
  const auto fine = MakeBallImage(0.05);
  const auto surface = Contour(fine, { 0.0 });
  EXPECT_EQ(surface->GetPoints()->GetDataType(), VTK_DOUBLE);
  EXPECT_LT(FindErrorOfRadius(surface, 0.05), 0.05);
  const auto coarse = MakeBallImage(12.5);
  EXPECT_EQ(Contour(coarse, { 0.0 })->GetPoints()->GetDataType(), VTK_FLOAT);
  EXPECT_TRUE(IsSurfaceOf(Contour(coarse, { 0.0 }), coarse, 0.0));
}

TEST(StabbingContourPrecision, IsThatOfTheProperty)
{
  const auto fine = MakeBallImage(0.05);
  const auto single = ContourTo(fine, vtkAlgorithm::SINGLE_PRECISION);
  EXPECT_EQ(single->GetPoints()->GetDataType(), VTK_FLOAT);
  EXPECT_GT(FindErrorOfRadius(single, 0.05), 1);
  const auto coarse = MakeBallImage(12.5);
  const auto exact = ContourTo(coarse, vtkAlgorithm::DOUBLE_PRECISION);
  EXPECT_EQ(exact->GetPoints()->GetDataType(), VTK_DOUBLE);
  EXPECT_LT(FindErrorOfRadius(exact, 12.5), 0.05);
}

TEST(StabbingContourPrecision, IsOneForAllImagesOfAnInput)
{
  vtkNew<vtkMultiBlockDataSet> blocks;
  const auto near = MakeBallImage(1);
  near->SetOrigin(0, 0, 0);
  blocks->SetBlock(0, near);
  EXPECT_EQ(Contour(blocks, { 0.0 })->GetPoints()->GetDataType(), VTK_FLOAT);
  blocks->SetBlock(1, MakeBallImage(0.05));
  const auto both = Contour(blocks, { 0.0 });
  EXPECT_EQ(both->GetPoints()->GetDataType(), VTK_DOUBLE);
  EXPECT_EQ(both->GetNumberOfPoints(), 2 * Contour(near, { 0.0 })->GetNumberOfPoints());
}

TEST(StabbingContourPrecision, OfRectilinearGridsFollowsTheirLines)
{
  const auto image = MakeBallImage(0.05);
  vtkNew<vtkRectilinearGrid> grid;
  grid->SetDimensions(32, 32, 32);
  vtkNew<vtkDoubleArray> lines[3];
  for (int axis = 0; axis < 3; ++axis)
  {
    for (int n = 0; n < 32; ++n)
    {
      lines[axis]->InsertNextValue(MapOrigin[axis] + 0.05 * n);
    }
  }
  grid->SetXCoordinates(lines[0]);
  grid->SetYCoordinates(lines[1]);
  grid->SetZCoordinates(lines[2]);
  grid->GetPointData()->ShallowCopy(image->GetPointData());
  const auto surface = Contour(grid, { 0.0 });
  EXPECT_EQ(surface->GetPoints()->GetDataType(), VTK_DOUBLE);
  EXPECT_GT(surface->GetNumberOfPoints(), 1000);
  EXPECT_LT(FindErrorOfRadius(surface, 0.05), 0.05);
}
