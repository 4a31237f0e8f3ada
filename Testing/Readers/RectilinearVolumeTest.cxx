// SPDX-License-Identifier: BSD-3-Clause
// Blocked volumes on rectilinear grids. The oracle is VTK: its contour filter on the grid itself.
#include "RectilinearFixtures.h"
#include "ScratchFolder.h"
#include "TestVolumes.h"
#include "VolumeDamage.h"

#include "vtkBlockedVolumeReader.h"
#include "vtkContourSpectrum.h"
#include "vtkEdgeIndexWriter.h"
#include "vtkStabbingContour.h"

#include "vtkDataArray.h"
#include "vtkDoubleArray.h"
#include "vtkExecutive.h"
#include "vtkPartitionedDataSet.h"
#include "vtkPassThrough.h"
#include "vtkPointData.h"
#include "vtkTable.h"

#include <cmath>

using namespace isosurface;

namespace
{

constexpr Extent Whole{ -9, 61, 3, 40, 100, 144 };

vtkSmartPointer<vtkRectilinearGrid> MakeWhole(int type = VTK_FLOAT)
{
  return MakeLinedGrid(MakeImage(Whole, type, MakeNoise(30000, 2)));
}

class RectilinearVolume : public testing::Test
{
protected:
  RectilinearVolume()
    : Path(this->Folder.GetPath("volume.bvol"))
    , ReaderErrors(this->Reader)
    , Errors(this->Behind)
  {
    this->Reader->SetFileName(this->Path.c_str());
    this->Behind->SetInputConnection(this->Reader->GetOutputPort());
    this->Behind->SetValue(0, Isovalue);
  }
  ~RectilinearVolume() override
  {
    EXPECT_EQ(this->ReaderErrors.Messages, std::vector<std::string>());
    EXPECT_EQ(this->Errors.Messages, std::vector<std::string>());
  }

  static constexpr double Isovalue = 12000.5;
  const ScratchFolder Folder;
  const std::string Path;
  vtkNew<vtkBlockedVolumeReader> Reader;
  vtkNew<vtkStabbingContour> Behind;
  const ErrorCounter ReaderErrors;
  const ErrorCounter Errors;
};

bool HaveEqualPoints(vtkDataSet* a, vtkDataSet* b)
{
  bool areEqual = a->GetNumberOfPoints() == b->GetNumberOfPoints();
  for (vtkIdType point = 0; areEqual && point < a->GetNumberOfPoints(); ++point)
  {
    double x[3];
    a->GetPoint(point, x);
    const double* y = b->GetPoint(point);
    areEqual = std::equal(x, x + 3, y) &&
      a->GetPointData()->GetScalars()->GetComponent(point, 0) ==
        b->GetPointData()->GetScalars()->GetComponent(point, 0);
  }
  return areEqual;
}

TEST_F(RectilinearVolume, SurfaceOfEveryLevelIsThatOfTheStockFilterToTheLastBit)
{
  for (const int type : { VTK_FLOAT, VTK_UNSIGNED_SHORT })
  {
    const auto grid = MakeWhole(type);
    WriteVolume(grid, this->Path, { 16, 3 });
    this->Reader->Modified();
    for (int level = 0; level < 4; ++level)
    {
      this->Behind->SetLevel(level);
      this->Behind->Update();
      const auto expected = ContourByStockFilter(SubsampleLinedGrid(grid, level), Isovalue);
      EXPECT_GT(expected->GetNumberOfCells(), 100) << level;
      EXPECT_TRUE(TakeTriangles(this->Behind->GetOutput()) == TakeTriangles(expected)) << level;
    }
  }
}

TEST_F(RectilinearVolume, SurfaceHasThePointsAndIdsOfTheGridInMemory)
{
  const auto grid = MakeWhole();
  WriteVolume(grid, this->Path, { 32, 2 });
  const auto inMemory = MakeContour(grid, Isovalue);
  for (const int option : { 0, 1, 2, 3 })
  {
    EdgeSurface surfaces[2];
    for (vtkStabbingContour* contour : { inMemory.Get(), this->Behind.Get() })
    {
      contour->SetDropDegenerateTriangles(option == 1);
      contour->SetCloseBoundary(option == 2);
      contour->SetUseRegion(option == 3);
      contour->SetRegionPosition(grid->GetXCoordinates()->GetComponent(66, 0), -1000, -1000);
      contour->SetRegionLength(1, 5000, 5000);
      contour->Update();
      surfaces[contour == this->Behind ? 0 : 1].Add(contour->GetOutput());
    }
    EXPECT_FALSE(surfaces[0].Triangles.empty()) << option;
    EXPECT_TRUE(AreEqual(surfaces[0], surfaces[1])) << option;
  }
}

TEST_F(RectilinearVolume, IsGivenAUnitAndNoOtherPlace)
{
  const auto grid = MakeWhole();
  WriteVolume(grid, this->Path, { 16, 2 });
  this->Reader->SetLengthUnit("um");
  this->Reader->Update();
  EXPECT_STREQ(this->Reader->GetFoundUnit(), "unknown");
  EXPECT_TRUE(this->Reader->GetOutput()->GetFieldData()->GetAbstractArray("PhysicalSizeUnit"));
  for (const char* name : { "Spacing", "Origin" })
  {
    vtkNew<vtkBlockedVolumeReader> placed;
    const ErrorCounter errors(placed);
    placed->SetFileName(this->Path.c_str());
    name == std::string("Spacing") ? placed->SetSpacing(1, 2, 3) : placed->SetOrigin(1, 2, 3);
    placed->Update();
    ExpectOneError(
      errors, { "volume.bvol: " + std::string(name) + " cannot be set", "rectilinear" });
  }
}

TEST_F(RectilinearVolume, OtherConsumersGetARectilinearGrid)
{
  const auto grid = MakeWhole();
  WriteVolume(grid, this->Path, { 16, 3 });
  this->Reader->Update();
  ASSERT_EQ(this->Reader->GetOutput()->GetNumberOfPartitions(), 1u);
  auto* whole = vtkRectilinearGrid::SafeDownCast(this->Reader->GetOutput()->GetPartition(0));
  ASSERT_NE(whole, nullptr);
  EXPECT_TRUE(HaveEqualPoints(whole, grid));
  EXPECT_TRUE(std::equal(whole->GetExtent(), whole->GetExtent() + 6, Whole.begin()));

  // A contour behind a filter that the volume is not seen through joins the pieces of the ranks.
  const EdgeSurface expected = ToEdges(Contour(grid, { Isovalue }));
  EdgeSurface pieces;
  for (int piece = 0; piece < 3; ++piece)
  {
    this->Reader->UpdatePiece(piece, 3, 0);
    vtkNew<vtkPartitionedDataSet> part;
    part->DeepCopy(this->Reader->GetOutput());
    pieces.Add(Contour(part, { Isovalue }));
  }
  pieces.MergeEqualPoints();
  EXPECT_EQ(pieces.Triangles.size(), expected.Triangles.size());
}

TEST_F(RectilinearVolume, BoxThatStandsForItHasTheBoundsOfTheGrid)
{
  const auto grid = MakeWhole();
  WriteVolume(grid, this->Path, { 16, 3 });
  this->Behind->Update();
  auto* box = vtkRectilinearGrid::SafeDownCast(this->Reader->GetOutput()->GetPartition(0));
  ASSERT_NE(box, nullptr);
  EXPECT_EQ(box->GetNumberOfPoints(), 8);
  EXPECT_TRUE(std::equal(box->GetBounds(), box->GetBounds() + 6, grid->GetBounds()));
}

TEST_F(RectilinearVolume, SpectrumIsThatOfTheGridInMemory)
{
  const auto grid = MakeWhole();
  // Each store is rounded by itself: with one, the numbers are equal.
  WriteVolume(grid, this->Path, { 32, 1 });
  vtkNew<vtkContourSpectrum> ofVolume;
  ofVolume->SetInputConnection(this->Reader->GetOutputPort());
  ofVolume->Update();
  vtkNew<vtkContourSpectrum> ofGrid;
  ofGrid->SetInputData(grid);
  ofGrid->Update();
  vtkTable* table = ofVolume->GetOutput();
  ASSERT_EQ(table->GetNumberOfRows(), ofGrid->GetOutput()->GetNumberOfRows());
  for (const char* column : { "Isovalue", "Triangles", "ActiveCells", "Area", "Volume" })
  {
    ASSERT_NE(table->GetColumnByName(column), nullptr) << column;
    for (vtkIdType row = 0; row < table->GetNumberOfRows(); row += 10)
    {
      ASSERT_EQ(table->GetValueByName(row, column).ToDouble(),
        ofGrid->GetOutput()->GetValueByName(row, column).ToDouble())
        << column << " " << row;
    }
  }
}

TEST_F(RectilinearVolume, EstimatesAndBudgetsWorkAsOnImages)
{
  const auto grid = MakeLinedGrid(MakeImage(Whole, VTK_FLOAT, MakeWaves(30000.0)));
  WriteVolume(grid, this->Path, { 16, 3 });
  this->Behind->SetMaximumTriangles(500);
  this->Behind->Update();
  EXPECT_GT(GetCost(this->Behind->GetOutput(), "Level"), 0u);
  EXPECT_GT(this->Behind->GetOutput()->GetNumberOfCells(), 0);
  EXPECT_LE(this->Behind->GetOutput()->GetNumberOfCells(), 500);
}

TEST_F(RectilinearVolume, WrittenInSlabsHasTheFilesOfTheWholeGrid)
{
  const auto grid = MakeWhole();
  WriteVolume(grid, this->Path, { 16, 3 });
  vtkNew<LinedGridSource> source;
  source->Grid = grid;
  vtkNew<vtkBlockedVolumeWriter> writer;
  const ExpectNoErrors errors(writer);
  writer->SetInputConnection(source->GetOutputPort());
  writer->SetFileName(this->Folder.GetPath("slabs.bvol").c_str());
  writer->SetBlockSize(16);
  writer->SetNumberOfStores(3);
  writer->SetMemoryLimit(64);
  writer->Write();
  EXPECT_EQ(ReadBytes(this->Folder.GetPath("slabs.bvol")), ReadBytes(this->Path));
}

TEST_F(RectilinearVolume, WrittenAnewKeepsItsCoordinates)
{
  const auto grid = MakeWhole();
  WriteVolume(grid, this->Path, { 16, 3 });
  vtkNew<vtkBlockedVolumeWriter> writer;
  const ExpectNoErrors errors(writer);
  writer->SetInputConnection(this->Reader->GetOutputPort());
  const std::string anew = this->Folder.GetPath("anew.bvol");
  writer->SetFileName(anew.c_str());
  writer->SetNumberOfStores(2);
  writer->Write();
  const auto reader = MakeReader(anew);
  reader->Update();
  EXPECT_TRUE(HaveEqualPoints(reader->GetOutput()->GetPartition(0), grid));
}

TEST_F(RectilinearVolume, TimeStepAtOtherCoordinatesIsRefused)
{
  const auto grid = MakeWhole();
  const auto append = [&](double time)
  {
    grid->GetInformation()->Set(vtkDataObject::DATA_TIME_STEP(), time);
    vtkNew<vtkBlockedVolumeWriter> writer;
    const ErrorCounter errors(writer);
    writer->SetInputData(grid);
    writer->SetFileName(this->Path.c_str());
    writer->AppendTimeStepOn();
    writer->Write();
    return errors.Messages;
  };
  EXPECT_EQ(append(0), std::vector<std::string>());
  EXPECT_EQ(append(1), std::vector<std::string>());
  vtkNew<vtkDoubleArray> moved;
  moved->DeepCopy(grid->GetYCoordinates());
  moved->SetValue(0, -100);
  grid->SetYCoordinates(moved);
  const auto messages = append(2);
  ASSERT_EQ(messages.size(), 1u);
  EXPECT_NE(messages[0].find("its grid lines are at other coordinates"), std::string::npos);
}

TEST_F(RectilinearVolume, EdgeIndexRecordsCannotTellTheCoordinates)
{
  WriteVolume(MakeWhole(), this->Path, { 16, 3 });
  vtkNew<vtkEdgeIndexWriter> writer;
  const ErrorCounter errors(writer);
  writer->SetInputConnection(this->Behind->GetOutputPort());
  writer->SetFileName(this->Folder.GetPath("surface.eix").c_str());
  writer->Write();
  ExpectOneError(errors, { "volume.bvol has a rectilinear grid" });
}

TEST_F(RectilinearVolume, CoordinatesThatAreNoneAreRefused)
{
  const double faults[] = { std::nan(""), HUGE_VAL, -1e9 };
  for (const double fault : faults)
  {
    const auto grid = MakeWhole();
    vtkNew<vtkDoubleArray> lines;
    lines->DeepCopy(grid->GetZCoordinates());
    lines->SetValue(7, fault);
    grid->SetZCoordinates(lines);
    vtkNew<vtkBlockedVolumeWriter> writer;
    const ErrorCounter errors(writer);
    writer->SetInputData(grid);
    writer->SetFileName(this->Folder.GetPath("faulty.bvol").c_str());
    writer->Write();
    ExpectOneError(errors, { "on axis z" });
  }
}

} // namespace
