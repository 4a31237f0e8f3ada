// SPDX-License-Identifier: BSD-3-Clause
#include "TestImages.h"

#include "vtkAMRBox.h"
#include "vtkAMRUtilities.h"
#include "vtkCellData.h"
#include "vtkCompositeDataSet.h"
#include "vtkContourFilter.h"
#include "vtkFloatArray.h"
#include "vtkIdList.h"
#include "vtkNew.h"
#include "vtkOverlappingAMR.h"
#include "vtkPointData.h"
#include "vtkStructuredData.h"
#include "vtkUniformGrid.h"
#include "vtkVersion.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

using namespace isosurface;

namespace
{

constexpr Extent Grid{ 0, 40, 0, 36, 0, 34 };

vtkSmartPointer<vtkUniformGrid> MakeUniformGrid(vtkImageData* image)
{
  auto grid = vtkSmartPointer<vtkUniformGrid>::New();
  grid->ShallowCopy(image);
  return grid;
}

// How many triangles lie in each cell of a grid, told by their centers.
std::map<vtkIdType, int> CountTriangles(vtkPolyData* surface, vtkImageData* image)
{
  std::map<vtkIdType, int> counts;
  vtkNew<vtkIdList> corners;
  for (vtkIdType cell = 0; cell < surface->GetNumberOfCells(); ++cell)
  {
    surface->GetCellPoints(cell, corners);
    double center[3] = { 0, 0, 0 };
    for (vtkIdType n = 0; n < 3; ++n)
    {
      for (int axis = 0; axis < 3; ++axis)
      {
        center[axis] += surface->GetPoint(corners->GetId(n))[axis] / 3;
      }
    }
    int index[3];
    double within[3];
    image->ComputeStructuredCoordinates(center, index, within);
    ++counts[image->ComputeCellId(index)];
  }
  return counts;
}

// The stock filter of VTK 9.3.20240617, in ParaView 5.13, contours cells at hidden points, although
// vtkUniformGrid calls them invisible there, too: from 9.3 on, it is given hidden cells instead.
vtkSmartPointer<vtkPolyData> ContourByStockFilter(vtkUniformGrid* grid, double isovalue)
{
  vtkNew<vtkUniformGrid> cells;
  cells->DeepCopy(grid);
#if VTK_VERSION_NUMBER >= VTK_VERSION_CHECK(9, 3, 0)
  for (vtkIdType cell = 0; cell < grid->GetNumberOfCells(); ++cell)
  {
    if (!grid->IsCellVisible(cell))
    {
      cells->BlankCell(cell);
    }
  }
#endif
  vtkNew<vtkContourFilter> contour;
  contour->SetInputData(cells);
  SelectPoints(contour, "density");
  contour->SetValue(0, isovalue);
  contour->ComputeNormalsOff();
  contour->Update();
  return contour->GetOutput();
}

// The same triangles as vtkContourFilter, cell by cell, which are those of the whole grid there.
void ExpectEqualsStockFilter(vtkUniformGrid* grid, vtkImageData* whole, double isovalue)
{
  const auto expected = ContourByStockFilter(grid, isovalue);
  const auto surface = Contour(grid, { isovalue });
  EXPECT_GT(expected->GetNumberOfCells(), 0);
  EXPECT_EQ(surface->GetNumberOfCells(), expected->GetNumberOfCells());
  EXPECT_EQ(surface->GetNumberOfPoints(), expected->GetNumberOfPoints());
  EXPECT_EQ(CountTriangles(surface, grid), CountTriangles(expected, grid));
  EdgeSurface own = ToEdges(surface);
  own.DropNormals();
  EdgeSurface all = ContourByFlyingEdges(whole, isovalue);
  all.DropNormals();
  EXPECT_TRUE(std::includes(
    all.Triangles.begin(), all.Triangles.end(), own.Triangles.begin(), own.Triangles.end()));
  EXPECT_TRUE(
    std::includes(all.Points.begin(), all.Points.end(), own.Points.begin(), own.Points.end()));
  EXPECT_LT(own.Triangles.size(), all.Triangles.size());
}

// Two levels: a coarse grid, and a fine one that covers a part of it.
vtkSmartPointer<vtkOverlappingAMR> MakeTwoLevels(const Field& field)
{
  auto amr = vtkSmartPointer<vtkOverlappingAMR>::New();
#if VTK_VERSION_NUMBER >= VTK_VERSION_CHECK(9, 6, 0)
  amr->Initialize({ 1, 1 });
#else
  const int blocksPerLevel[] = { 1, 1 };
  amr->Initialize(2, blocksPerLevel);
#endif
  double origin[3] = { 0, 0, 0 };
  amr->SetOrigin(origin);
  int cube[] = { 2, 2, 2 };
  amr->SetGridDescription(vtkStructuredData::GetDataDescription(cube));
  amr->SetRefinementRatio(0, 2);
  for (unsigned int level = 0; level < 2; ++level)
  {
    const double step = level == 0 ? 1.0 : 0.5;
    double spacing[3] = { step, step, step };
    amr->SetSpacing(level, spacing);
    const int low = level == 0 ? 0 : 16;
    const int size = level == 0 ? 32 : 28;
    const vtkAMRBox box(low, low, low, low + size - 1, low + size - 1, low + size - 1);
    amr->SetAMRBox(level, 0, box);
    const auto image = MakeImage({ 0, size, 0, size, 0, size }, VTK_FLOAT,
      [&](int i, int j, int k)
      { return field(2 * (low + i) >> level, 2 * (low + j) >> level, 2 * (low + k) >> level); });
    image->SetOrigin(low * step, low * step, low * step);
    image->SetSpacing(spacing);
    amr->SetDataSet(level, 0, MakeUniformGrid(image));
  }
  vtkAMRUtilities::BlankCells(amr);
  return amr;
}

} // namespace

TEST(StabbingContourBlanking, HiddenCellsOfAUniformGridHaveNoSurface)
{
  const auto image = MakeImage(Grid, VTK_FLOAT, MakeNoise(1 << 20, 1));
  const auto grid = MakeUniformGrid(image);
  for (vtkIdType cell = 0; cell < grid->GetNumberOfCells(); cell += 3)
  {
    grid->BlankCell(cell);
  }
  ExpectEqualsStockFilter(grid, image, 3e5);
}

TEST(StabbingContourBlanking, CellsAtHiddenPointsOfAUniformGridHaveNoSurface)
{
  const auto image = MakeImage(Grid, VTK_FLOAT, MakeNoise(1 << 20, 2));
  const auto grid = MakeUniformGrid(image);
  for (vtkIdType point = 0; point < grid->GetNumberOfPoints(); point += 37)
  {
    grid->BlankPoint(point);
  }
  ExpectEqualsStockFilter(grid, image, 3e5);
  for (vtkIdType cell = 0; cell < grid->GetNumberOfCells(); cell += 5)
  {
    grid->BlankCell(cell);
  }
  grid->Modified();
  ExpectEqualsStockFilter(grid, image, 3e5);
}

// As for vtkContourFilter.
TEST(StabbingContourBlanking, MarksOfPlainImageDataHideNothing)
{
  const auto image = MakeImage(Grid, VTK_FLOAT, MakeWaves(100.0));
  const EdgeSurface expected = ContourByFlyingEdges(image, 8.0);
  const auto grid = MakeUniformGrid(image);
  for (vtkIdType cell = 0; cell < grid->GetNumberOfCells(); cell += 3)
  {
    grid->BlankCell(cell);
  }
  image->GetCellData()->ShallowCopy(grid->GetCellData());
  EXPECT_TRUE(AreEqual(ContourToEdges(image, 8.0), expected));
  EXPECT_TRUE(AreEqual(ContourByFlyingEdges(image, 8.0), expected));
}

// A plane: its gradient is the same everywhere, and samples that are hidden are far off it.
TEST(StabbingContourBlanking, HiddenSamplesHaveNoInfluenceOnNormals)
{
  const auto image = MakeImage(Grid, VTK_FLOAT,
    [](int i, int j, int k) { return j == 16 && i > 9 && k > 5 ? 1e6 : 2.0 * i - j + 2.0 * k; });
  const auto grid = MakeUniformGrid(image);
  for (int k = 6; k <= Grid[5]; ++k)
  {
    for (int i = 10; i <= Grid[1]; ++i)
    {
      grid->BlankPoint(i, 16, k);
    }
  }
  const auto surface = Contour(grid, { 30.25 });
  ExpectNormal(surface, { -2.0 / 3, 1.0 / 3, -2.0 / 3 });
}

TEST(StabbingContourBlanking, CoarseCellsUnderFinerGridsHaveNoSurface)
{
  const auto noise = MakeImage({ 0, 80, 0, 80, 0, 80 }, VTK_FLOAT, MakeNoise(1 << 20, 3));
  const auto amr = MakeTwoLevels(
    [&](int i, int j, int k) { return noise->GetScalarComponentAsDouble(i, j, k, 0); });
  vtkNew<vtkContourFilter> stock;
  stock->SetInputData(amr);
  SelectPoints(stock, "density");
  stock->SetValue(0, 4e5);
  stock->ComputeNormalsOff();
  stock->Update();
  vtkIdType triangles = 0;
  vtkIdType points = 0;
  for (vtkDataSet* level :
    vtkCompositeDataSet::GetDataSets<vtkDataSet>(stock->GetOutputDataObject(0)))
  {
    triangles += level->GetNumberOfCells();
    points += level->GetNumberOfPoints();
  }
  const auto surface = Contour(amr, { 4e5 });
  EXPECT_GT(triangles, 0);
  EXPECT_EQ(surface->GetNumberOfCells(), triangles);
  EXPECT_EQ(surface->GetNumberOfPoints(), points);

  vtkIdType separate = 0;
  for (vtkDataSet* level : vtkCompositeDataSet::GetDataSets<vtkDataSet>(amr))
  {
    auto* grid = vtkUniformGrid::SafeDownCast(level);
    separate += ContourByStockFilter(grid, 4e5)->GetNumberOfCells();
    const auto own = Contour(grid, { 4e5 });
    EXPECT_EQ(CountTriangles(own, grid), CountTriangles(ContourByStockFilter(grid, 4e5), grid));
  }
  EXPECT_EQ(separate, triangles);
}

TEST(StabbingContourBlanking, SkippedNotANumberLeavesAHoleInsteadOfAWall)
{
  const double none = std::numeric_limits<double>::quiet_NaN();
  const auto image = MakeImage(Grid, VTK_FLOAT, MakeWaves(100.0));
  const auto holed = MakeImage(Grid, VTK_FLOAT,
    [&](int i, int j, int k)
    { return i > 20 && j > 9 && k < 12 ? none : image->GetScalarComponentAsDouble(i, j, k, 0); });
  // The oracle hides the same points.
  const auto grid = MakeUniformGrid(image);
  vtkDataArray* samples = holed->GetPointData()->GetScalars();
  for (vtkIdType point = 0; point < grid->GetNumberOfPoints(); ++point)
  {
    if (std::isnan(samples->GetComponent(point, 0)))
    {
      grid->BlankPoint(point);
    }
  }
  const auto expected = ContourByStockFilter(grid, 8.0);

  const auto contour = MakeContour(holed, 8.0);
  contour->Update();
  const vtkIdType walled = contour->GetOutput()->GetNumberOfCells();
  contour->SkipNotANumberOn();
  contour->Update();
  EXPECT_EQ(contour->GetOutput()->GetNumberOfCells(), expected->GetNumberOfCells());
  EXPECT_EQ(contour->GetOutput()->GetNumberOfPoints(), expected->GetNumberOfPoints());
  EXPECT_GT(walled, expected->GetNumberOfCells());
  double bounds[6];
  contour->GetOutput()->GetBounds(bounds);
  EXPECT_FALSE(std::isnan(bounds[0]));
}
