// SPDX-License-Identifier: BSD-3-Clause
#include "TestImages.h"

#include "vtkCellData.h"
#include "vtkCellDataToPointData.h"
#include "vtkDataArray.h"
#include "vtkDataSetAttributes.h"
#include "vtkIdList.h"
#include "vtkImageData.h"
#include "vtkMultiBlockDataSet.h"
#include "vtkNew.h"
#include "vtkPointData.h"
#include "vtkStabbingContour.h"
#include "vtkUniformGrid.h"
#include "vtkUnsignedCharArray.h"

#include "CellArrays.h"

#include <algorithm>
#include <cstring>
#include <string>

using namespace isosurface;

namespace
{

// An image without point arrays. Its cells have values of a field.
vtkSmartPointer<vtkImageData> MakeCellImage(const Extent& extent, int type, const Field& field)
{
  Extent cells = extent;
  for (const int high : { 1, 3, 5 })
  {
    cells[high] = std::max(cells[high - 1], cells[high] - 1);
  }
  const auto samples = MakeImage(cells, type, field);
  auto image = vtkSmartPointer<vtkImageData>::New();
  image->SetExtent(const_cast<int*>(extent.data()));
  image->GetCellData()->SetScalars(samples->GetPointData()->GetScalars());
  return image;
}

vtkSmartPointer<vtkImageData> ConvertByStockFilter(vtkImageData* image)
{
  vtkNew<vtkCellDataToPointData> convert;
  convert->SetInputData(image);
  convert->Update();
  return vtkImageData::SafeDownCast(convert->GetOutput());
}

vtkSmartPointer<vtkPolyData> ContourCells(vtkDataObject* input, double isovalue)
{
  vtkNew<vtkStabbingContour> contour;
  const ExpectNoErrors errors(contour);
  contour->SetInputDataObject(input);
  contour->SetInputArrayToProcess(0, 0, 0, vtkDataObject::FIELD_ASSOCIATION_CELLS, "density");
  contour->SetValue(0, isovalue);
  contour->Update();
  return contour->GetOutput();
}

void ExpectEqualArrays(vtkDataArray* made, vtkDataArray* expected, const std::string& what)
{
  ASSERT_EQ(made->GetDataType(), expected->GetDataType()) << what;
  ASSERT_EQ(made->GetNumberOfValues(), expected->GetNumberOfValues()) << what;
  const auto bytes = static_cast<std::size_t>(made->GetNumberOfValues() * made->GetDataTypeSize());
  EXPECT_EQ(std::memcmp(made->GetVoidPointer(0), expected->GetVoidPointer(0), bytes), 0) << what;
}

} // namespace

TEST(StabbingContourCells, AveragesEqualTheStockFilterForAllTypesAndGrids)
{
  for (const Extent& extent :
    { Extent{ 0, 9, 0, 8, 0, 7 }, Extent{ -3, 5, 4, 4, 7, 20 }, Extent{ 2, 2, 0, 0, 1, 9 } })
  {
    for (const int type : { VTK_CHAR, VTK_UNSIGNED_CHAR, VTK_SHORT, VTK_UNSIGNED_SHORT, VTK_INT,
           VTK_UNSIGNED_INT, VTK_LONG_LONG, VTK_UNSIGNED_LONG_LONG, VTK_FLOAT, VTK_DOUBLE })
    {
      const bool isUnsigned = type == VTK_UNSIGNED_CHAR || type == VTK_UNSIGNED_SHORT ||
        type == VTK_UNSIGNED_INT || type == VTK_UNSIGNED_LONG_LONG;
      const auto image = MakeCellImage(extent, type,
        [noise = MakeNoise(1000, 5), isUnsigned](int i, int j, int k) mutable
        { return noise(i, j, k) / 8.1 - (isUnsigned ? 0 : 60); });
      vtkDataArray* cells = image->GetCellData()->GetScalars();
      const auto made = AverageToPoints(image, cells, 2);
      ASSERT_TRUE(made.IsOk());
      ExpectEqualArrays(*made, ConvertByStockFilter(image)->GetPointData()->GetArray("density"),
        cells->GetDataTypeAsString());
    }
  }
}

TEST(StabbingContourCells, HiddenAndRefinedCellsCountInAveragesAsForTheStockFilter)
{
  const auto image = MakeCellImage({ 0, 20, 0, 19, 0, 18 }, VTK_DOUBLE, MakeNoise(1000, 6));
  const unsigned char refined = vtkDataSetAttributes::REFINEDCELL;
  const unsigned char hidden = vtkDataSetAttributes::HIDDENCELL;
  for (const unsigned char other : { refined, hidden })
  {
    vtkNew<vtkUniformGrid> grid;
    grid->DeepCopy(image);
    vtkUnsignedCharArray* flags = grid->AllocateCellGhostArray();
    for (vtkIdType cell = 0; cell < grid->GetNumberOfCells(); ++cell)
    {
      flags->SetValue(cell, cell % 2 == 0 ? refined : cell % 5 == 0 ? other : 0);
    }
    const auto made = AverageToPoints(grid, grid->GetCellData()->GetArray("density"), 2);
    ASSERT_TRUE(made.IsOk());
    ExpectEqualArrays(*made, ConvertByStockFilter(grid)->GetPointData()->GetArray("density"),
      std::to_string(other));
  }
}

// vtkCellDataToPointData leaves out other cells, by which of their corners is hidden.
TEST(StabbingContourCells, CellsAtHiddenPointsHaveNoPartInAverages)
{
  const auto image = MakeCellImage({ 0, 8, 0, 9, 0, 10 }, VTK_DOUBLE, MakeNoise(1000, 7));
  vtkNew<vtkUniformGrid> grid;
  grid->DeepCopy(image);
  for (vtkIdType point = 0; point < grid->GetNumberOfPoints(); point += 11)
  {
    grid->BlankPoint(point);
  }
  vtkDataArray* cells = grid->GetCellData()->GetArray("density");
  const auto made = AverageToPoints(grid, cells, 2);
  ASSERT_TRUE(made.IsOk());
  vtkNew<vtkIdList> around;
  for (vtkIdType point = 0; point < grid->GetNumberOfPoints(); ++point)
  {
    image->GetPointCells(point, around);
    double sum = 0;
    int count = 0;
    for (vtkIdType n = 0; n < around->GetNumberOfIds(); ++n)
    {
      if (grid->IsCellVisible(around->GetId(n)))
      {
        sum += cells->GetComponent(around->GetId(n), 0);
        ++count;
      }
    }
    EXPECT_NEAR((*made)->GetComponent(point, 0), count == 0 ? 0 : sum / count, 1e-9);
  }
}

TEST(StabbingContourCells, CellArrayIsContouredAsBehindCellDataToPointData)
{
  for (const int type : { VTK_UNSIGNED_CHAR, VTK_FLOAT })
  {
    const auto image = MakeCellImage({ -7, 40, 3, 39, 0, 35 }, type, MakeNoise(200, 7));
    image->SetSpacing(0.5, 1.25, 2.0);
    const EdgeSurface expected = ContourByFlyingEdges(ConvertByStockFilter(image), 99.5);
    EXPECT_FALSE(expected.Triangles.empty());
    EXPECT_TRUE(AreEqual(ToEdges(ContourCells(image, 99.5)), expected));
  }
}

TEST(StabbingContourCells, ActiveCellScalarsAreTakenWhereThereAreNoneOfPoints)
{
  const auto image = MakeCellImage({ 0, 20, 0, 20, 0, 20 }, VTK_FLOAT, MakeNoise(200, 8));
  EXPECT_TRUE(
    AreEqual(ContourToEdges(image, 99.5), ContourByFlyingEdges(ConvertByStockFilter(image), 99.5)));
}

TEST(StabbingContourCells, PieceWithGhostCellsHasTheSurfaceOfTheWhole)
{
  const auto image = MakeCellImage({ 0, 30, 0, 20, 0, 20 }, VTK_FLOAT, MakeNoise(200, 9));
  vtkNew<vtkMultiBlockDataSet> blocks;
  const int extents[2][6] = { { 0, 17, 0, 20, 0, 20 }, { 13, 30, 0, 20, 0, 20 } };
  const int own[2][6] = { { 0, 15, 0, 20, 0, 20 }, { 15, 30, 0, 20, 0, 20 } };
  for (unsigned int n = 0; n < 2; ++n)
  {
    vtkNew<vtkImageData> piece;
    piece->DeepCopy(image);
    piece->Crop(extents[n]);
    piece->GenerateGhostArray(const_cast<int*>(own[n]), true);
    blocks->SetBlock(n, piece);
  }
  EXPECT_TRUE(AreEqual(ToEdges(ContourCells(blocks, 99.5)), ToEdges(ContourCells(image, 99.5))));
}

TEST(StabbingContourCells, CellArraysAreInterpolatedAsAverages)
{
  const auto image = MakeImage({ 0, 20, 0, 20, 0, 20 }, VTK_FLOAT, MakeWaves(100.0));
  const auto cells = MakeCellImage({ 0, 20, 0, 20, 0, 20 }, VTK_DOUBLE, MakeNoise(200, 10));
  cells->GetCellData()->GetScalars()->SetName("material");
  image->GetCellData()->AddArray(cells->GetCellData()->GetScalars());
  const auto contour = [](vtkImageData* input)
  {
    vtkNew<vtkStabbingContour> filter;
    filter->SetInputData(input);
    SelectPoints(filter, "density");
    filter->AddInterpolatedArray("material");
    filter->SetValue(0, 8.0);
    filter->Update();
    return vtkSmartPointer<vtkPolyData>(filter->GetOutput());
  };
  ExpectEqualArrays(contour(image)->GetPointData()->GetArray("material"),
    contour(ConvertByStockFilter(image))->GetPointData()->GetArray("material"), "material");
}

TEST(StabbingContourCells, ChangedCellsGiveAChangedSurface)
{
  const auto image = MakeCellImage({ 0, 20, 0, 20, 0, 20 }, VTK_FLOAT, MakeNoise(200, 11));
  const auto contour = MakeContour(image, 99.5);
  contour->Update();
  contour->SetValue(0, 101.5);
  contour->Update();
  EXPECT_TRUE(IsSurfaceOf(contour->GetOutput(), ConvertByStockFilter(image), 101.5));
  vtkDataArray* cells = image->GetCellData()->GetScalars();
  for (vtkIdType cell = 0; cell < cells->GetNumberOfTuples(); ++cell)
  {
    cells->SetComponent(cell, 0, 200 - cells->GetComponent(cell, 0));
  }
  cells->Modified();
  image->Modified();
  contour->Update();
  EXPECT_TRUE(IsSurfaceOf(contour->GetOutput(), ConvertByStockFilter(image), 101.5));
}
