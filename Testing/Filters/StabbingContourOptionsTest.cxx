// SPDX-License-Identifier: BSD-3-Clause
#include "TestImages.h"

#include "vtkCellArray.h"
#include "vtkCellArrayIterator.h"
#include "vtkDataArray.h"
#include "vtkDoubleArray.h"
#include "vtkFieldData.h"
#include "vtkFloatArray.h"
#include "vtkIdTypeArray.h"
#include "vtkNew.h"
#include "vtkPointData.h"
#include "vtkTriangleFilter.h"

#include <algorithm>
#include <map>

using namespace isosurface;

namespace
{

constexpr Extent OptionsGrid{ 0, 40, 0, 33, 0, 20 };

vtkSmartPointer<vtkPolyData> ContourAsPolygons(vtkImageData* image, double isovalue)
{
  const auto contour = MakeContour(image, isovalue);
  contour->GenerateTrianglesOff();
  contour->Update();
  return contour->GetOutput();
}

using Side = std::pair<vtkIdType, vtkIdType>;

// The sides of cells, between global ids, that are not undone by a side the other way round: for
// one grid cell, the loops in which the surface cuts its faces.
std::map<Side, int> FindBoundary(vtkPolyData* surface)
{
  std::map<Side, int> boundary;
  vtkDataArray* ids = surface->GetPointData()->GetGlobalIds();
  const auto cells = vtk::TakeSmartPointer(surface->GetPolys()->NewIterator());
  for (cells->GoToFirstCell(); !cells->IsDoneWithTraversal(); cells->GoToNextCell())
  {
    vtkIdType size = 0;
    const vtkIdType* points = nullptr;
    cells->GetCurrentCell(size, points);
    for (vtkIdType n = 0; n < size; ++n)
    {
      const auto from = static_cast<vtkIdType>(ids->GetTuple1(points[n]));
      const auto to = static_cast<vtkIdType>(ids->GetTuple1(points[(n + 1) % size]));
      // Sides that go the other way round count as -1.
      const Side side = std::minmax(from, to);
      if ((boundary[side] += from < to ? 1 : -1) == 0)
      {
        boundary.erase(side);
      }
    }
  }
  return boundary;
}

vtkIdType CountTriangles(vtkPolyData* polygons)
{
  vtkNew<vtkTriangleFilter> triangles;
  triangles->SetInputData(polygons);
  triangles->PassVertsOff();
  triangles->PassLinesOff();
  triangles->Update();
  return triangles->GetOutput()->GetNumberOfPolys();
}

void ExpectSamePoints(vtkPolyData* a, vtkPolyData* b)
{
  ASSERT_EQ(a->GetNumberOfPoints(), b->GetNumberOfPoints());
  for (vtkIdType point = 0; point < a->GetNumberOfPoints(); ++point)
  {
    for (int axis = 0; axis < 3; ++axis)
    {
      ASSERT_EQ(a->GetPoint(point)[axis], b->GetPoint(point)[axis]);
      ASSERT_EQ(a->GetPointData()->GetNormals()->GetComponent(point, axis),
        b->GetPointData()->GetNormals()->GetComponent(point, axis));
    }
    ASSERT_EQ(a->GetPointData()->GetGlobalIds()->GetTuple1(point),
      b->GetPointData()->GetGlobalIds()->GetTuple1(point));
  }
}

} // namespace

TEST(StabbingContourOptions, AllAttributesAreThereByDefault)
{
  const auto image = MakeImage(OptionsGrid, VTK_FLOAT, MakeWaves());
  const auto output = Contour(image, { 0.25 });
  vtkPointData* pointData = output->GetPointData();
  ASSERT_GT(output->GetNumberOfPoints(), 0);
  EXPECT_EQ(pointData->GetNumberOfArrays(), 3);
  ASSERT_NE(pointData->GetNormals(), nullptr);
  EXPECT_STREQ(pointData->GetNormals()->GetName(), "Normals");
  EXPECT_EQ(pointData->GetNormals()->GetNumberOfTuples(), output->GetNumberOfPoints());
  ASSERT_NE(pointData->GetGlobalIds(), nullptr);
  EXPECT_NE(vtkIdTypeArray::SafeDownCast(pointData->GetGlobalIds()), nullptr);
  ASSERT_NE(pointData->GetScalars(), nullptr);
  EXPECT_STREQ(pointData->GetScalars()->GetName(), "density");
  EXPECT_EQ(pointData->GetScalars()->GetNumberOfTuples(), output->GetNumberOfPoints());
  EXPECT_TRUE(output->CheckAttributes() == 0);
}

TEST(StabbingContourOptions, SurfaceIsTheSameWithoutNormalsAndScalars)
{
  const auto image = MakeImage(OptionsGrid, VTK_FLOAT, MakeWaves());
  const auto contour = MakeContour(image, 0.25);
  contour->ComputeNormalsOff();
  contour->ComputeScalarsOff();
  contour->Update();
  EXPECT_EQ(contour->GetOutput()->GetPointData()->GetNormals(), nullptr);
  EXPECT_EQ(contour->GetOutput()->GetPointData()->GetScalars(), nullptr);
  EXPECT_EQ(contour->GetOutput()->GetPointData()->GetNumberOfArrays(), 1);
  EdgeSurface surface = ToEdges(contour->GetOutput());
  EdgeSurface expected = ContourByFlyingEdges(image, 0.25);
  expected.DropNormals();
  EXPECT_TRUE(AreEqual(surface, expected));
}

TEST(StabbingContourOptions, ScalarsHoldTheIsovalueExactly)
{
  const auto image = MakeImage(OptionsGrid, VTK_FLOAT, MakeWaves());
  vtkSmartPointer<vtkDataArray> scalars = Contour(image, { 0.25 })->GetPointData()->GetScalars();
  EXPECT_NE(vtkFloatArray::SafeDownCast(scalars), nullptr);
  EXPECT_EQ(scalars->GetTuple1(0), 0.25);
  scalars = Contour(image, { 0.25, 0.1 })->GetPointData()->GetScalars();
  EXPECT_NE(vtkDoubleArray::SafeDownCast(scalars), nullptr);
  EXPECT_EQ(scalars->GetTuple1(0), 0.25);
  EXPECT_EQ(scalars->GetTuple1(scalars->GetNumberOfTuples() - 1), 0.1);
}

TEST(StabbingContourOptions, PolygonsOfACellAreTheLoopsOfItsTrianglesInAll256Cases)
{
  for (int number = 0; number < 256; ++number)
  {
    const auto image = MakeImage({ 0, 1, 0, 1, 0, 1 }, VTK_FLOAT,
      [=](int i, int j, int k)
      {
        const int bit = i + 2 * j + 4 * k;
        return (number >> bit & 1) != 0 ? 1.0 + 0.1 * bit : -1.0 - 0.07 * bit;
      });
    const auto triangles = Contour(image, { 0.0 });
    const auto polygons = ContourAsPolygons(image, 0.0);
    if (triangles->GetNumberOfCells() == 0)
    {
      EXPECT_EQ(polygons->GetNumberOfCells(), 0);
      continue;
    }
    ExpectSamePoints(polygons, triangles);
    // Each side of a polygon lies in a face of the cell.
    const std::map<Side, int> boundary = FindBoundary(polygons);
    EXPECT_EQ(boundary, FindBoundary(triangles)) << "case " << number;
    const vtkIdType corners = polygons->GetPolys()->GetNumberOfConnectivityIds();
    EXPECT_EQ(static_cast<vtkIdType>(boundary.size()), corners) << "case " << number;
    EXPECT_EQ(corners - 2 * polygons->GetNumberOfCells(), triangles->GetNumberOfCells());
  }
}

TEST(StabbingContourOptions, PolygonsHaveTheTrianglesPointsAndBoundary)
{
  for (const Field& field : { MakeWaves(), MakeNoise(10, 8) })
  {
    const auto image = MakeImage(OptionsGrid, VTK_FLOAT, field);
    const auto triangles = Contour(image, { 0.3 });
    const auto polygons = ContourAsPolygons(image, 0.3);
    ExpectSamePoints(polygons, triangles);
    EXPECT_LT(polygons->GetNumberOfCells(), triangles->GetNumberOfCells());
    EXPECT_EQ(polygons->GetPolys()->GetNumberOfConnectivityIds() - 2 * polygons->GetNumberOfCells(),
      triangles->GetNumberOfCells());
    EXPECT_EQ(FindBoundary(polygons), FindBoundary(triangles));
  }
}

TEST(StabbingContourOptions, PolygonsCanBeTriangulated)
{
  const auto image = MakeImage(OptionsGrid, VTK_FLOAT, MakeWaves());
  EXPECT_EQ(
    CountTriangles(ContourAsPolygons(image, 0.3)), Contour(image, { 0.3 })->GetNumberOfCells());
}

TEST(StabbingContourOptions, FieldDataTellsTheCost)
{
  const auto image = MakeImage(OptionsGrid, VTK_FLOAT, MakeWaves());
  for (const double isovalue : { 0.25, 5.0 })
  {
    const auto output = Contour(image, { isovalue });
    vtkFieldData* cost = output->GetFieldData();
    for (const char* name :
      { "Rank", "TreePagesRead", "DirectoryPagesRead", "ActiveBlocks", "BlocksRead", "BytesRead",
        "BlockCacheHits", "Triangles", "QuerySeconds", "ReadSeconds", "ExtractSeconds" })
    {
      ASSERT_NE(cost->GetArray(name), nullptr) << name;
      EXPECT_EQ(cost->GetArray(name)->GetNumberOfTuples(), 1) << name;
      EXPECT_GE(cost->GetArray(name)->GetTuple1(0), 0.0) << name;
    }
    EXPECT_EQ(cost->GetArray("Triangles")->GetTuple1(0), output->GetNumberOfCells());
    EXPECT_EQ(cost->GetArray("Rank")->GetTuple1(0), 0);
    // 40 x 33 x 20 cells are 2 x 2 x 1 blocks.
    EXPECT_EQ(cost->GetArray("ActiveBlocks")->GetTuple1(0), isovalue == 0.25 ? 4 : 0);
  }
}

TEST(StabbingContourOptions, NumberOfThreadsDoesNotChangeABit)
{
  const auto image = MakeImage({ 0, 100, 0, 70, 0, 66 }, VTK_SHORT, MakeWaves(1000.0));
  vtkNew<vtkPolyData> first;
  for (const int threads : { 1, 2, 7 })
  {
    const auto contour = MakeContour(image, -210.5);
    contour->SetValue(1, 333.0);
    contour->SetNumberOfThreads(threads);
    contour->Update();
    vtkPolyData* output = contour->GetOutput();
    if (threads == 1)
    {
      first->ShallowCopy(output);
      continue;
    }
    ExpectSamePoints(output, first);
    vtkCellArray* cells = output->GetPolys();
    ASSERT_EQ(cells->GetNumberOfCells(), first->GetPolys()->GetNumberOfCells());
    for (vtkIdType index = 0; index < cells->GetNumberOfConnectivityIds(); ++index)
    {
      ASSERT_EQ(cells->GetConnectivityArray()->GetTuple1(index),
        first->GetPolys()->GetConnectivityArray()->GetTuple1(index));
    }
  }
}
