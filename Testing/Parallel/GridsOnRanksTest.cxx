// SPDX-License-Identifier: BSD-3-Clause
// Images in memory that ranks have parts of, without ghost layers, rectilinear and with cell
// arrays.
#include "ParallelVolumes.h"

#include "RectilinearFixtures.h"

#include "vtkBlockedVolumeReader.h"
#include "vtkBlockedVolumeWriter.h"
#include "vtkStabbingContour.h"

#include "vtkCellData.h"
#include "vtkDoubleArray.h"
#include "vtkExecutive.h"
#include "vtkMultiBlockDataSet.h"
#include "vtkMultiProcessController.h"
#include "vtkNew.h"
#include "vtkPointData.h"
#include "vtkPolyData.h"
#include "vtkRectilinearGrid.h"
#include "vtkUnstructuredGrid.h"

#include "Storage/Store/BlockedVolumeHeader.h"

#include <algorithm>
#include <cmath>

namespace isosurface
{
namespace
{

constexpr Extent WholeGrid{ -9, 60, 3, 47, 0, 38 };

vtkSmartPointer<vtkImageData> MakeRough()
{
  return MakeImage(WholeGrid, VTK_FLOAT,
    [waves = MakeWaves(100.0), noise = MakeNoise(20, 7)](int i, int j, int k) mutable
    { return waves(i, j, k) + noise(i, j, k); });
}

// This rank's slab of cells of the whole, with `layers` more on both sides.
Extent CutSlab(int layers)
{
  Extent slab = WholeGrid;
  const int cells = WholeGrid[1] - WholeGrid[0];
  slab[0] = std::max(WholeGrid[0], WholeGrid[0] + cells * GetRank() / GetNumberOfRanks() - layers);
  slab[1] =
    std::min(WholeGrid[1], WholeGrid[0] + cells * (GetRank() + 1) / GetNumberOfRanks() + layers);
  return slab;
}

vtkSmartPointer<vtkPolyData> ContourPiece(
  vtkDataObject* input, int association = vtkDataObject::FIELD_ASSOCIATION_POINTS)
{
  vtkNew<vtkStabbingContour> contour;
  const ErrorCounter errors(contour);
  contour->SetController(GetRanks());
  contour->SetInputDataObject(input);
  contour->SetInputArrayToProcess(0, 0, 0, association, "density");
  contour->SetValue(0, 8.0);
  contour->Update();
  EXPECT_EQ(errors.Messages, std::vector<std::string>());
  return contour->GetOutput();
}

void ExpectSurfaceOfOneRank(const EdgeSurface& surface, vtkDataObject* whole, int association)
{
  vtkNew<vtkStabbingContour> alone;
  alone->SetController(nullptr);
  alone->SetInputDataObject(whole);
  alone->SetInputArrayToProcess(0, 0, 0, association, "density");
  alone->SetValue(0, 8.0);
  alone->Update();
  EdgeSurface expected = ToEdges(alone->GetOutput());
  EXPECT_FALSE(expected.Triangles.empty());
  EXPECT_TRUE(AreEqual(surface, expected));
}

EdgeSurface Gather(vtkPolyData* mine)
{
  const EdgeSurface all = GatherSurface(mine);
  return all;
}

// A composite is contoured by all ranks together, whatever its whole extent.
vtkSmartPointer<vtkMultiBlockDataSet> MakeBlocks(vtkDataSet* piece)
{
  auto blocks = vtkSmartPointer<vtkMultiBlockDataSet>::New();
  blocks->SetBlock(0, piece);
  return blocks;
}

} // namespace

TEST(GridsOnRanks, ImagesThatMeetWithoutGhostLayersHaveTheSurfaceOfTheWhole)
{
  const auto whole = MakeRough();
  const EdgeSurface all = Gather(ContourPiece(MakeBlocks(CutImage(whole, CutSlab(0)))));
  if (GetRank() == 0)
  {
    EXPECT_TRUE(AreEqual(all, ContourByFlyingEdges(whole, 8.0)));
  }
}

TEST(GridsOnRanks, RectilinearGridsThatMeetHaveTheSurfaceOfTheWhole)
{
  const auto whole = MakeRough();
  const auto makeLined = [](vtkImageData* image)
  {
    auto grid = vtkSmartPointer<vtkRectilinearGrid>::New();
    grid->SetExtent(image->GetExtent());
    grid->GetPointData()->ShallowCopy(image->GetPointData());
    for (int axis = 0; axis < 3; ++axis)
    {
      vtkNew<vtkDoubleArray> lines;
      for (int n = image->GetExtent()[2 * axis]; n <= image->GetExtent()[2 * axis + 1]; ++n)
      {
        lines->InsertNextValue(n + 0.3 * std::sin(n));
      }
      axis == 0     ? grid->SetXCoordinates(lines)
        : axis == 1 ? grid->SetYCoordinates(lines)
                    : grid->SetZCoordinates(lines);
    }
    return grid;
  };
  const EdgeSurface all = Gather(ContourPiece(MakeBlocks(makeLined(CutImage(whole, CutSlab(0))))));
  if (GetRank() == 0)
  {
    ExpectSurfaceOfOneRank(all, makeLined(whole), vtkDataObject::FIELD_ASSOCIATION_POINTS);
  }
}

TEST(GridsOnRanks, RectilinearGridInPiecesIsWrittenAsAWholeAndContouredByAll)
{
  const SharedFolder folder("rectilinear");
  const auto whole = MakeLinedGrid(MakeRough());
  const std::string alone = folder.GetPath("alone.bvol");
  const std::string path = folder.GetPath("volume.bvol");
  if (GetRank() == 0)
  {
    WriteVolume(whole, alone, { 16, 5 });
  }
  vtkNew<LinedGridSource> source;
  source->Grid = whole;
  for (const int memoryLimit : { 64, 0 })
  {
    vtkNew<vtkBlockedVolumeWriter> writer;
    const ErrorCounter errors(writer);
    writer->SetController(GetRanks());
    writer->SetInputConnection(source->GetOutputPort());
    writer->SetFileName(path.c_str());
    writer->SetBlockSize(16);
    writer->SetNumberOfStores(5);
    writer->SetMemoryLimit(memoryLimit);
    writer->Write();
    EXPECT_EQ(errors.Messages, std::vector<std::string>());
    if (GetRank() == 0)
    {
      // The header has the checksums of all stores. Folders are numbered.
      const auto read = [](const std::string& name)
      { return BlockedVolumeHeader::Read(GetLocalFileSystem(), name); };
      auto expected = read(alone);
      const auto written = read(path);
      ASSERT_TRUE(expected.IsOk() && written.IsOk());
      expected->TimeSteps[0].Folder = written->TimeSteps[0].Folder;
      EXPECT_EQ(written->Format(), expected->Format());
    }
  }
  ContourPipeline pipeline(path);
  const EdgeSurface all = Gather(pipeline.Update({ 8.0 }));
  if (GetRank() == 0)
  {
    ExpectSurfaceOfOneRank(all, whole, vtkDataObject::FIELD_ASSOCIATION_POINTS);
  }
}

TEST(GridsOnRanks, PiecesAtOtherCoordinatesAreAnErrorOfAll)
{
  const SharedFolder folder("other-coordinates");
  vtkNew<LinedGridSource> source;
  const bool isLast = GetRank() == GetNumberOfRanks() - 1;
  source->Grid = MakeLinedGrid(MakeRough(), isLast ? 2 : 1);
  vtkNew<vtkBlockedVolumeWriter> writer;
  const ErrorCounter errors(writer);
  writer->SetController(GetRanks());
  writer->SetInputConnection(source->GetOutputPort());
  writer->SetFileName(folder.GetPath("volume.bvol").c_str());
  writer->Write();
  EXPECT_EQ(errors.Messages.size(), GetNumberOfRanks() > 1 ? 1u : 0u);
  for (const std::string& message : errors.Messages)
  {
    EXPECT_NE(message.find("several rectilinear grids"), std::string::npos) << message;
  }
}

TEST(GridsOnRanks, CellArraysWithGhostLayersHaveTheSurfaceOfTheWhole)
{
  const auto samples = MakeRough();
  vtkNew<vtkImageData> whole;
  whole->SetExtent(
    WholeGrid[0], WholeGrid[1] + 1, WholeGrid[2], WholeGrid[3] + 1, WholeGrid[4], WholeGrid[5] + 1);
  whole->GetCellData()->SetScalars(samples->GetPointData()->GetScalars());
  vtkNew<vtkImageData> piece;
  piece->DeepCopy(whole);
  Extent own = CutSlab(0);
  Extent grown = CutSlab(2);
  for (Extent* extent : { &own, &grown })
  {
    (*extent)[1] += (*extent)[1] == WholeGrid[1] ? 1 : 0;
    (*extent)[3] += 1;
    (*extent)[5] += 1;
  }
  piece->Crop(grown.data());
  piece->GenerateGhostArray(own.data(), true);
  const EdgeSurface all =
    Gather(ContourPiece(MakeBlocks(piece), vtkDataObject::FIELD_ASSOCIATION_CELLS));
  if (GetRank() == 0)
  {
    ExpectSurfaceOfOneRank(all, whole, vtkDataObject::FIELD_ASSOCIATION_CELLS);
  }
}

TEST(GridsOnRanks, UnstructuredDataOnOneRankIsAnErrorOfAll)
{
  vtkNew<vtkStabbingContour> contour;
  const ErrorCounter errors(contour);
  const ErrorCounter pipelineErrors(contour->GetExecutive());
  contour->SetController(GetRanks());
  const bool isLast = GetRank() == GetNumberOfRanks() - 1;
  vtkNew<vtkUnstructuredGrid> other;
  contour->SetInputDataObject(
    MakeBlocks(isLast ? static_cast<vtkDataSet*>(other) : MakeRough().Get()));
  contour->SetValue(0, 8.0);
  contour->Update();
  EXPECT_EQ(errors.Messages.size(), 1u);
  EXPECT_TRUE(!errors.Messages.empty() &&
    errors.Messages.front().find("vtkUnstructuredGrid") != std::string::npos);
}

} // namespace isosurface
