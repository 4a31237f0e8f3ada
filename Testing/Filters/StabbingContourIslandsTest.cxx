// SPDX-License-Identifier: BSD-3-Clause
// Islands of the surface: those of vtkPolyDataConnectivityFilter, with the areas and volumes of
// vtkMassProperties.
#include "TestImages.h"

#include "vtkCellArray.h"
#include "vtkCellData.h"
#include "vtkDataArray.h"
#include "vtkDistributeIsosurface.h"
#include "vtkFieldData.h"
#include "vtkMassProperties.h"
#include "vtkMultiPieceDataSet.h"
#include "vtkNew.h"
#include "vtkPointData.h"
#include "vtkPolyDataConnectivityFilter.h"
#include "vtkTriangleFilter.h"

#include <algorithm>
#include <cmath>
#include <limits>

using namespace isosurface;

namespace
{

constexpr Extent IslandGrid{ -3, 47, 0, 40, 5, 42 };
constexpr double IslandValue = 60;

/// Two balls in a dust of noise, nothing at the border.
vtkSmartPointer<vtkImageData> MakeIslands()
{
  auto noise = MakeNoise(400, 8);
  const auto image = MakeImage(IslandGrid, VTK_FLOAT,
    [&noise](int i, int j, int k)
    {
      const double value = noise(i, j, k);
      const bool isAtBorder = i == IslandGrid[0] || i == IslandGrid[1] || j == IslandGrid[2] ||
        j == IslandGrid[3] || k == IslandGrid[4] || k == IslandGrid[5];
      const double large = 72 - std::hypot(i - 12, j - 20, k - 22);
      const double small = 66 - std::hypot(i - 36, j - 30, k - 30);
      const double dust = value < 4 ? 50 + 4 * value : 0;
      return isAtBorder ? 0 : std::max({ dust + (value < 3 ? 15 : 0), large, small });
    });
  image->SetOrigin(0.5, -20, 100);
  image->SetSpacing(0.5, 0.75, 2);
  return image;
}

struct StockIsland
{
  vtkIdType Triangles = 0;
  double Area = 0;
  double Volume = 0;
};

/// By stock filters, the largest first.
std::vector<StockIsland> FindStockIslands(vtkPolyData* surface)
{
  vtkNew<vtkPolyDataConnectivityFilter> all;
  all->SetInputData(surface);
  all->SetExtractionModeToAllRegions();
  all->ColorRegionsOn();
  all->Update();
  vtkPolyData* regions = all->GetOutput();
  vtkDataArray* ids = regions->GetPointData()->GetArray("RegionId");
  const auto count = static_cast<std::size_t>(all->GetNumberOfExtractedRegions());
  std::vector<vtkSmartPointer<vtkCellArray>> cells(count);
  vtkNew<vtkIdList> corners;
  for (vtkIdType cell = 0; cell < regions->GetNumberOfCells(); ++cell)
  {
    regions->GetCellPoints(cell, corners);
    auto& own = cells[static_cast<std::size_t>(ids->GetTuple1(corners->GetId(0)))];
    own = own ? own : vtkSmartPointer<vtkCellArray>::New();
    own->InsertNextCell(corners);
  }
  std::vector<StockIsland> islands;
  for (const auto& own : cells)
  {
    vtkNew<vtkPolyData> one;
    one->SetPoints(regions->GetPoints());
    one->SetPolys(own);
    vtkNew<vtkMassProperties> mass;
    mass->SetInputData(one);
    mass->Update();
    islands.push_back({ own->GetNumberOfCells(), mass->GetSurfaceArea(), mass->GetVolume() });
  }
  std::stable_sort(islands.begin(), islands.end(),
    [](const StockIsland& a, const StockIsland& b) { return a.Triangles > b.Triangles; });
  return islands;
}

double GetField(vtkPolyData* surface, const char* name, vtkIdType row = 0)
{
  vtkDataArray* array = surface->GetFieldData()->GetArray(name);
  EXPECT_TRUE(array) << name;
  return array ? array->GetTuple1(row) : 0;
}

vtkIdType CountRows(vtkPolyData* surface, const char* name)
{
  vtkDataArray* array = surface->GetFieldData()->GetArray(name);
  return array ? array->GetNumberOfTuples() : -1;
}

/// Expects the islands that the filter lists, and those of a surface with all islands.
void ExpectStockIslands(vtkPolyData* listed, const std::vector<StockIsland>& stock)
{
  EXPECT_EQ(GetField(listed, "Islands"), static_cast<double>(stock.size()));
  std::vector<StockIsland> mine;
  const vtkIdType rows = CountRows(listed, "IslandTriangles");
  ASSERT_EQ(rows, std::min<vtkIdType>(1000, static_cast<vtkIdType>(stock.size())));
  // Of the same number of triangles, both may have another order.
  auto expected = stock;
  expected.resize(static_cast<std::size_t>(rows));
  for (vtkIdType row = 0; row < rows; ++row)
  {
    mine.push_back({ static_cast<vtkIdType>(GetField(listed, "IslandTriangles", row)),
      GetField(listed, "IslandArea", row), GetField(listed, "IslandVolume", row) });
  }
  for (auto* list : { &mine, &expected })
  {
    std::stable_sort(list->begin(), list->end(),
      [](const StockIsland& a, const StockIsland& b)
      { return a.Triangles != b.Triangles ? a.Triangles > b.Triangles : a.Area > b.Area; });
  }
  for (std::size_t n = 0; n < mine.size(); ++n)
  {
    EXPECT_EQ(mine[n].Triangles, expected[n].Triangles) << n;
    EXPECT_NEAR(mine[n].Area, expected[n].Area, 1e-6 * expected[n].Area) << n;
    EXPECT_NEAR(mine[n].Volume, expected[n].Volume, 2e-5 * expected[n].Volume) << n;
  }
}

} // namespace

TEST(StabbingContourIslands, AreThoseOfStockFilters)
{
  const auto image = MakeIslands();
  const auto stock = FindStockIslands(Contour(image, { IslandValue }));
  ASSERT_GT(stock.size(), 200u);
  const auto contour = MakeContour(image, IslandValue);
  contour->ComputeIslandIdsOn();
  contour->Update();
  vtkPolyData* all = contour->GetOutput();
  ExpectStockIslands(all, stock);
  EXPECT_EQ(GetField(all, "KeptIslands"), GetField(all, "Islands"));

  vtkDataArray* ids = all->GetCellData()->GetArray("IslandId");
  ASSERT_TRUE(ids);
  ASSERT_EQ(ids->GetNumberOfTuples(), all->GetNumberOfCells());
  std::vector<vtkIdType> triangles(stock.size(), 0);
  for (vtkIdType cell = 0; cell < ids->GetNumberOfTuples(); ++cell)
  {
    ++triangles.at(static_cast<std::size_t>(ids->GetTuple1(cell)));
  }
  for (std::size_t n = 0; n < stock.size(); ++n)
  {
    EXPECT_EQ(triangles[n], stock[n].Triangles) << n;
  }
}

TEST(StabbingContourIslands, AreHiddenByEachSize)
{
  const auto image = MakeIslands();
  const auto stock = FindStockIslands(Contour(image, { IslandValue }));
  const auto contour = MakeContour(image, IslandValue);
  contour->AddInterpolatedArray("density");
  contour->ComputeScalarsOff();
  const double limits[] = { static_cast<double>(stock[1].Triangles), 0.9 * stock[1].Area,
    0.9 * stock[1].Volume };
  for (const int size :
    { vtkStabbingContour::TRIANGLES, vtkStabbingContour::AREA, vtkStabbingContour::VOLUME })
  {
    contour->SetIslandSize(size);
    contour->SetMinimumIslandSize(limits[size]);
    contour->SetMaximumIslands(0);
    contour->Update();
    vtkPolyData* two = contour->GetOutput();
    EXPECT_EQ(two->GetNumberOfPolys(), stock[0].Triangles + stock[1].Triangles);
    EXPECT_EQ(GetField(two, "KeptIslands"), 2);
    EXPECT_EQ(GetField(two, "Islands"), static_cast<double>(stock.size()));
    EXPECT_EQ(
      two->GetPointData()->GetArray("density")->GetNumberOfTuples(), two->GetNumberOfPoints());
    EXPECT_EQ(two->GetPointData()->GetNormals()->GetNumberOfTuples(), two->GetNumberOfPoints());
    ExpectDistinctIds(two);
    EXPECT_TRUE(IsClosedManifold(ToEdges(two)));
    contour->SetMinimumIslandSize(0);
    contour->SetMaximumIslands(1);
    contour->Update();
    EXPECT_EQ(contour->GetOutput()->GetNumberOfPolys(), stock[0].Triangles);
    EXPECT_EQ(std::string(contour->GetIslandSummary()).rfind("1 of ", 0), 0u);
  }
}

TEST(StabbingContourIslands, AreThoseOfEachIsovalueAndKeepTheirScalars)
{
  const auto image = MakeIslands();
  vtkNew<vtkStabbingContour> contour;
  contour->SetInputData(image);
  SetIsovalues(contour, { IslandValue, 62 });
  contour->SetMaximumIslands(2);
  contour->Update();
  EXPECT_EQ(CountRows(contour->GetOutput(), "KeptIslands"), 2);
  const std::string summary = contour->GetIslandSummary();
  EXPECT_NE(summary.find("; 62: 2 of "), std::string::npos) << summary;
  vtkPolyData* four = contour->GetOutput();
  const auto outer = FindStockIslands(Contour(image, { IslandValue }));
  const auto inner = FindStockIslands(Contour(image, { 62 }));
  EXPECT_EQ(four->GetNumberOfPolys(),
    outer[0].Triangles + outer[1].Triangles + inner[0].Triangles + inner[1].Triangles);
  vtkDataArray* scalars = four->GetPointData()->GetScalars();
  ASSERT_EQ(scalars->GetNumberOfTuples(), four->GetNumberOfPoints());
  const auto alone = MakeContour(image, 62);
  alone->SetMaximumIslands(2);
  alone->Update();
  vtkIdType ofInner = 0;
  for (vtkIdType point = 0; point < scalars->GetNumberOfTuples(); ++point)
  {
    ofInner += scalars->GetTuple1(point) == 62 ? 1 : 0;
  }
  EXPECT_EQ(ofInner, alone->GetOutput()->GetNumberOfPoints());
}

TEST(StabbingContourIslands, AtAPointIsTheNearest)
{
  const auto image = MakeIslands();
  const auto contour = MakeContour(image, IslandValue);
  contour->SetMaximumIslands(2);
  contour->UseIslandPointOn();
  const double centres[2][3] = { { 0.5 + 12 * 0.5, -20 + 20 * 0.75, 100 + 22 * 2 },
    { 0.5 + 36 * 0.5, -20 + 30 * 0.75, 100 + 30 * 2 } };
  const auto stock = FindStockIslands(Contour(image, { IslandValue }));
  for (std::size_t n = 0; n < 2; ++n)
  {
    contour->SetIslandPoint(centres[n][0], centres[n][1], centres[n][2]);
    contour->Update();
    EXPECT_EQ(contour->GetOutput()->GetNumberOfPolys(), stock[n].Triangles);
  }
}

// Pieces of an image have the points where they meet twice.
TEST(StabbingContourIslands, OfPiecesAreThoseOfTheWhole)
{
  const auto image = MakeIslands();
  vtkNew<vtkMultiPieceDataSet> pieces;
  const int cuts[] = { IslandGrid[0], 11, 12, IslandGrid[1] };
  for (unsigned int n = 0; n < 3; ++n)
  {
    pieces->SetPiece(n,
      CutImage(image,
        { cuts[n], cuts[n + 1], IslandGrid[2], IslandGrid[3], IslandGrid[4], IslandGrid[5] }));
  }
  const auto contour = MakeContour(pieces, IslandValue);
  contour->SetMaximumIslands(2);
  contour->Update();
  ExpectStockIslands(contour->GetOutput(), FindStockIslands(Contour(image, { IslandValue })));
}

// Options that change what the surface is made of.
TEST(StabbingContourIslands, WorkWithEveryOption)
{
  const auto image = MakeIslands();
  for (const bool polygons : { false, true })
  {
    const auto contour = MakeContour(image, 10); // meets the border
    contour->CloseBoundaryOn();
    contour->SetGenerateTriangles(!polygons);
    contour->SetDropDegenerateTriangles(!polygons);
    contour->Update();
    vtkNew<vtkTriangleFilter> triangles;
    triangles->SetInputData(contour->GetOutput());
    triangles->Update();
    const auto stock = FindStockIslands(triangles->GetOutput());
    contour->SetMaximumIslands(1);
    contour->Update();
    EXPECT_EQ(GetField(contour->GetOutput(), "Islands"), static_cast<double>(stock.size()));
    EXPECT_EQ(
      GetField(contour->GetOutput(), "IslandTriangles"), static_cast<double>(stock[0].Triangles));
  }
}

TEST(StabbingContourIslands, OffLeaveNoTrace)
{
  const auto image = MakeIslands();
  const auto contour = MakeContour(image, IslandValue);
  contour->SetMinimumIslandSize(-5);
  contour->SetMaximumIslands(-1);
  contour->SetIslandSize(vtkStabbingContour::AREA);
  contour->Update();
  EXPECT_FALSE(contour->FindsIslands()) << "negative limits are none";
  EXPECT_TRUE(IsSurfaceOf(contour->GetOutput(), image, IslandValue));
  EXPECT_EQ(CountRows(contour->GetOutput(), "Islands"), -1);
  EXPECT_STREQ(contour->GetIslandSummary(), "");
}

TEST(StabbingContourIslands, OfAnEmptySurfaceAreNone)
{
  const auto contour = MakeContour(MakeIslands(), 1e6);
  const ExpectNoErrors errors(contour);
  contour->SetMaximumIslands(2);
  contour->UseIslandPointOn();
  contour->ComputeIslandIdsOn();
  contour->Update();
  EXPECT_EQ(contour->GetOutput()->GetNumberOfCells(), 0);
  EXPECT_EQ(GetField(contour->GetOutput(), "Islands"), 0);
}

TEST(StabbingContourIslands, RefuseWhatIsNoNumber)
{
  const auto contour = MakeContour(MakeIslands(), IslandValue);
  ErrorCounter errors(contour);
  contour->SetMinimumIslandSize(std::numeric_limits<double>::quiet_NaN());
  contour->SetMaximumIslands(1);
  contour->Update();
  ExpectOneError(errors, { "MinimumIslandSize", "not a number" });
  errors.Messages.clear();
  contour->SetMinimumIslandSize(0);
  contour->UseIslandPointOn();
  contour->SetIslandPoint(0, std::numeric_limits<double>::infinity(), 0);
  contour->Update();
  ExpectOneError(errors, { "IslandPoint" });
}

TEST(StabbingContourIslands, IdsAreRefusedByThoseWhoTakeBlocks)
{
  const auto contour = MakeContour(MakeIslands(), IslandValue);
  contour->ComputeIslandIdsOn();
  vtkNew<vtkDistributeIsosurface> distribute;
  distribute->SetInputConnection(contour->GetOutputPort());
  const ErrorCounter errors(distribute);
  distribute->Update();
  ExpectOneError(errors, { "ComputeIslandIds", "arrays of triangles" });
}
