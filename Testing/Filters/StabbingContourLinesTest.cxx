// SPDX-License-Identifier: BSD-3-Clause
#include "RectilinearFixtures.h"
#include "TestImages.h"

#include "vtkContourSpectrum.h"
#include "vtkExecutive.h"
#include "vtkMassProperties.h"
#include "vtkMultiBlockDataSet.h"
#include "vtkNew.h"
#include "vtkPointData.h"
#include "vtkRectilinearGrid.h"
#include "vtkStructuredGrid.h"
#include "vtkTable.h"
#include "vtkUnstructuredGrid.h"

#include <cmath>

using namespace isosurface;

namespace
{

constexpr Extent LinesGrid{ 0, 70, 0, 35, 0, 37 };

std::string ContourInVain(vtkDataObject* input)
{
  const auto contour = MakeContour(input, 8.0);
  const ErrorCounter errors(contour);
  contour->Update();
  EXPECT_EQ(errors.Messages.size(), 1u);
  return errors.Messages.empty() ? "" : errors.Messages.front();
}

} // namespace

TEST(StabbingContourLines, RectilinearGridEqualsTheStockFilterToTheLastBit)
{
  for (const int type : { VTK_FLOAT, VTK_DOUBLE, VTK_UNSIGNED_SHORT, VTK_INT })
  {
    const auto grid = MakeLinedGrid(MakeImage(LinesGrid, type, MakeNoise(50000, 2)));
    const auto expected = ContourByStockFilter(grid, 20000.5);
    const auto surface = Contour(grid, { 20000.5 });
    EXPECT_GT(expected->GetNumberOfCells(), 1000);
    EXPECT_EQ(surface->GetNumberOfPoints(), expected->GetNumberOfPoints());
    EXPECT_TRUE(TakeTriangles(surface) == TakeTriangles(expected)) << type;
  }
}

TEST(StabbingContourLines, ExtentThatDoesNotBeginAtZeroEqualsTheStockFilter)
{
  const auto image = MakeImage({ -9, 40, 100, 120, 31, 66 }, VTK_FLOAT, MakeNoise(50000, 3));
  const auto grid = MakeLinedGrid(image);
  EXPECT_TRUE(TakeTriangles(Contour(grid, { 20000.5 })) ==
    TakeTriangles(ContourByStockFilter(grid, 20000.5)));
}

TEST(StabbingContourLines, PiecesWithGhostLayersHaveTheSurfaceOfTheWhole)
{
  const auto grid = MakeLinedGrid(MakeImage(LinesGrid, VTK_FLOAT, MakeWaves(100.0)));
  vtkNew<vtkMultiBlockDataSet> blocks;
  const Extent extents[2] = { { 0, 41, 0, 35, 0, 37 }, { 39, 70, 0, 35, 0, 37 } };
  int own[2][6] = { { 0, 40, 0, 35, 0, 37 }, { 40, 70, 0, 35, 0, 37 } };
  for (unsigned int n = 0; n < 2; ++n)
  {
    const auto part = CutLinedGrid(grid, extents[n]);
    part->GenerateGhostArray(own[n], true);
    blocks->SetBlock(n, part);
  }
  EXPECT_TRUE(AreEqual(ToEdges(Contour(blocks, { 8.0 })), ToEdges(Contour(grid, { 8.0 }))));
}

// At even distances a rectilinear grid is an image.
TEST(StabbingContourLines, OptionsDoToARectilinearGridWhatTheyDoToAnImage)
{
  const auto image = MakeImage({ 0, 40, 0, 35, 0, 37 }, VTK_SHORT, MakeNoise(7, 5));
  const auto lined = MakeLinedGrid(image);
  for (vtkDataArray* lines :
    { lined->GetXCoordinates(), lined->GetYCoordinates(), lined->GetZCoordinates() })
  {
    for (vtkIdType n = 0; n < lines->GetNumberOfTuples(); ++n)
    {
      lines->SetComponent(n, 0, static_cast<double>(n));
    }
  }
  for (const int option : { 0, 1, 2, 3, 4 })
  {
    EdgeSurface surfaces[2];
    for (const int n : { 0, 1 })
    {
      const auto contour = MakeContour(n == 0 ? static_cast<vtkDataObject*>(image) : lined, 3.0);
      contour->SetDropDegenerateTriangles(option == 1 || option == 3);
      contour->SetCloseBoundary(option == 2 || option == 3);
      contour->SetUseRegion(option == 4);
      contour->SetRegionPosition(33, 1, 1);
      contour->SetRegionLength(4, 4, 4);
      contour->Update();
      surfaces[n].Add(contour->GetOutput());
      surfaces[n].DropNormals();
    }
    EXPECT_FALSE(surfaces[0].Triangles.empty());
    EXPECT_TRUE(AreEqual(surfaces[1], surfaces[0])) << option;
  }
}

TEST(StabbingContourLines, RegionIsOneOfTheWorld)
{
  const auto grid = MakeLinedGrid(MakeImage(LinesGrid, VTK_FLOAT, MakeWaves(100.0)));
  const auto contour = MakeContour(grid, 8.0);
  contour->UseRegionOn();
  const double x = grid->GetXCoordinates()->GetComponent(65, 0);
  contour->SetRegionPosition(x, -100, -100);
  contour->SetRegionLength(1, 1000, 1000);
  contour->Update();
  ASSERT_GT(contour->GetOutput()->GetNumberOfPoints(), 0);
  // Blocks of 32 cells: the last one begins at line 64.
  EXPECT_GE(contour->GetOutput()->GetBounds()[0],
    static_cast<float>(grid->GetXCoordinates()->GetComponent(64, 0)));
}

TEST(StabbingContourLines, SkippedNotANumberLeavesGoodNormals)
{
  const auto image = MakeImage(LinesGrid, VTK_DOUBLE, [](int, int, int) { return 0.0; });
  const auto grid = MakeLinedGrid(image);
  vtkDataArray* samples = grid->GetPointData()->GetScalars();
  for (vtkIdType point = 0; point < grid->GetNumberOfPoints(); ++point)
  {
    const double* x = grid->GetPoint(point);
    samples->SetComponent(point, 0, point % 50 == 0 ? std::nan("") : x[0] - 2 * x[1] + 2 * x[2]);
  }
  const auto contour = MakeContour(grid, 5.0);
  contour->SkipNotANumberOn();
  contour->Update();
  vtkDataArray* normals = contour->GetOutput()->GetPointData()->GetNormals();
  ASSERT_GT(normals->GetNumberOfTuples(), 1000);
  for (vtkIdType point = 0; point < normals->GetNumberOfTuples(); ++point)
  {
    // A vertex between two unknown ones has no difference along that axis.
    const double* normal = normals->GetTuple(point);
    for (int axis = 0; axis < 3; ++axis)
    {
      ASSERT_FALSE(std::isnan(normal[axis]));
    }
  }
}

TEST(StabbingContourLines, ANewIsovalueFollowsChangedSamplesAndLines)
{
  const auto grid = MakeLinedGrid(MakeImage(LinesGrid, VTK_FLOAT, MakeNoise(50000, 6)));
  const auto contour = MakeContour(grid, 20000.5);
  contour->Update();
  vtkDataArray* samples = grid->GetPointData()->GetScalars();
  for (vtkIdType n = 0; n < samples->GetNumberOfTuples(); ++n)
  {
    samples->SetComponent(n, 0, 50000 - samples->GetComponent(n, 0));
  }
  samples->Modified();
  grid->GetXCoordinates()->SetComponent(0, 0, -100.0);
  grid->Modified();
  contour->Update();
  EXPECT_TRUE(
    TakeTriangles(contour->GetOutput()) == TakeTriangles(ContourByStockFilter(grid, 20000.5)));
}

TEST(StabbingContourLines, LinesThatDoNotAscendAreRefused)
{
  const auto grid = MakeLinedGrid(MakeImage(LinesGrid, VTK_FLOAT, MakeWaves(100.0)));
  grid->GetYCoordinates()->SetComponent(3, 0, -50.0);
  EXPECT_NE(ContourInVain(grid).find("do not ascend on axis y"), std::string::npos);
}

TEST(StabbingContourLines, OtherDataSetsAreRefusedWithWhatToTakeInstead)
{
  vtkNew<vtkStructuredGrid> curvilinear;
  curvilinear->SetDimensions(2, 2, 2);
  vtkNew<vtkUnstructuredGrid> unstructured;
  for (vtkDataSet* input :
    { static_cast<vtkDataSet*>(curvilinear), static_cast<vtkDataSet*>(unstructured) })
  {
    const std::string message = ContourInVain(input);
    EXPECT_NE(message.find(input->GetClassName()), std::string::npos) << message;
    EXPECT_NE(message.find("take Contour, or put Resample To Image"), std::string::npos) << message;
  }
}

// Samples that are a linear function of the place in the world: of them areas and volumes are
// exact.
TEST(StabbingContourLines, SpectrumTellsAreaAndVolumeInTheWorld)
{
  const auto image = MakeImage(LinesGrid, VTK_FLOAT, [](int, int, int) { return 0.0; });
  const auto grid = MakeLinedGrid(image);
  vtkDataArray* samples = grid->GetPointData()->GetScalars();
  for (vtkIdType point = 0; point < grid->GetNumberOfPoints(); ++point)
  {
    samples->SetComponent(point, 0, grid->GetPoint(point)[0]);
  }
  vtkNew<vtkContourSpectrum> spectrum;
  spectrum->SetInputData(grid);
  spectrum->Update();
  vtkTable* table = spectrum->GetOutput();
  const double* bounds = grid->GetBounds();
  const double face = (bounds[3] - bounds[2]) * (bounds[5] - bounds[4]);
  const vtkIdType rows = table->GetNumberOfRows();
  ASSERT_GT(rows, 1000);
  const auto get = [table](const char* column, vtkIdType row)
  { return table->GetValueByName(row, column).ToDouble(); };
  for (vtkIdType row = 5; row + 5 < rows; ++row)
  {
    ASSERT_NEAR(get("Area", row), face, 1e-3 * face) << row;
    const double volume = (bounds[1] - get("Isovalue", row)) * face;
    ASSERT_NEAR(get("Volume", row), volume, 1e-4 * face * (bounds[1] - bounds[0])) << row;
  }
}

// The area of the triangles is the oracle.
TEST(StabbingContourLines, SpectrumOfACurvedSurfaceHasTheAreaOfItsTriangles)
{
  const auto grid = MakeLinedGrid(MakeImage(LinesGrid, VTK_SHORT, MakeWaves(90)));
  vtkNew<vtkContourSpectrum> spectrum;
  spectrum->SetInputData(grid);
  spectrum->Update();
  vtkTable* table = spectrum->GetOutput();
  for (vtkIdType row = 40; row < table->GetNumberOfRows(); row += 25)
  {
    const double isovalue = table->GetValueByName(row, "Isovalue").ToDouble();
    const auto surface = Contour(grid, { isovalue });
    vtkNew<vtkMassProperties> measured;
    measured->SetInputData(surface);
    measured->Update();
    EXPECT_EQ(table->GetValueByName(row, "Triangles").ToDouble(),
      static_cast<double>(surface->GetNumberOfCells()));
    if (surface->GetNumberOfCells() > 5000)
    {
      EXPECT_NEAR(table->GetValueByName(row, "Area").ToDouble(), measured->GetSurfaceArea(),
        0.05 * measured->GetSurfaceArea());
    }
  }
}
