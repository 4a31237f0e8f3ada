// SPDX-License-Identifier: BSD-3-Clause
// Images in memory that ranks have parts of, without ghost layers, rectilinear and with cell
// arrays.
#include "ParallelVolumes.h"

#include "RectilinearFixtures.h"

#include "vtkBlockedVolumeReader.h"
#include "vtkBlockedVolumeWriter.h"
#include "vtkEdgeIndexWriter.h"
#include "vtkStabbingContour.h"

#include "vtkCellData.h"
#include "vtkDoubleArray.h"
#include "vtkExecutive.h"
#include "vtkMultiBlockDataSet.h"
#include "vtkMultiProcessController.h"
#include "vtkNew.h"
#include "vtkPointData.h"
#include "vtkPoints.h"
#include "vtkPolyData.h"
#include "vtkRectilinearGrid.h"
#include "vtkUnstructuredGrid.h"

#include "Storage/Store/BlockedVolumeHeader.h"

#include <algorithm>

using namespace isosurface;

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
  const ExpectNoErrors errors(contour);
  contour->SetController(GetRanks());
  contour->SetInputDataObject(input);
  contour->SetInputArrayToProcess(0, 0, 0, association, "density");
  contour->SetValue(0, 8.0);
  contour->Update();
  return contour->GetOutput();
}

/// Collective.
void ExpectSurfaceOfOneRank(vtkPolyData* mine, vtkDataObject* whole,
  int association = vtkDataObject::FIELD_ASSOCIATION_POINTS)
{
  const EdgeSurface all = GatherSurface(mine);
  if (GetRank() != 0)
  {
    return;
  }
  vtkNew<vtkStabbingContour> alone;
  alone->SetController(nullptr);
  alone->SetInputDataObject(whole);
  alone->SetInputArrayToProcess(0, 0, 0, association, "density");
  alone->SetValue(0, 8.0);
  alone->Update();
  EXPECT_FALSE(all.Triangles.empty());
  EXPECT_TRUE(AreEqual(all, ToEdges(alone->GetOutput())));
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
  ExpectSurfaceOf(ContourPiece(MakeBlocks(CutImage(whole, CutSlab(0)))), whole, 8.0);
}

TEST(GridsOnRanks, LeftHandedImagesHaveTheSurfaceOfTheWhole)
{
  const auto whole = MakeRough();
  whole->SetDirectionMatrix(0, -1, 0, -1, 0, 0, 0, 0, -1);
  whole->SetSpacing(0.5, -2, -1);
  ExpectSurfaceOfOneRank(ContourPiece(MakeBlocks(CutImage(whole, CutSlab(0)))), whole);
}

TEST(GridsOnRanks, LargeCoordinatesGiveDoublePointsOnEveryRank)
{
  const auto whole = MakeRough();
  whole->SetOrigin(448000, 6000000, -2000);
  whole->SetSpacing(0.05, 0.05, 0.05);
  // The last rank has nothing.
  const bool isLast = GetRank() + 1 == GetNumberOfRanks() && GetRank() > 0;
  const auto blocks =
    isLast ? vtkSmartPointer<vtkMultiBlockDataSet>::New() : MakeBlocks(CutImage(whole, CutSlab(0)));
  vtkNew<vtkStabbingContour> contour;
  contour->SetController(GetRanks());
  contour->SetInputDataObject(blocks);
  contour->SetValue(0, 8.0);
  contour->Update();
  EXPECT_EQ(contour->GetOutput()->GetPoints()->GetDataType(), VTK_DOUBLE);
}

TEST(GridsOnRanks, RectilinearGridsThatMeetHaveTheSurfaceOfTheWhole)
{
  const auto whole = MakeLinedGrid(MakeRough());
  ExpectSurfaceOfOneRank(ContourPiece(MakeBlocks(CutLinedGrid(whole, CutSlab(0)))), whole);
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
    const ExpectNoErrors errors(writer);
    writer->SetController(GetRanks());
    writer->SetInputConnection(source->GetOutputPort());
    writer->SetFileName(path.c_str());
    writer->SetBlockSize(16);
    writer->SetNumberOfStores(5);
    writer->SetMemoryLimit(memoryLimit);
    writer->Write();
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
  ExpectSurfaceOfOneRank(pipeline.Update({ 8.0 }), whole);
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
  ExpectSurfaceOfOneRank(ContourPiece(MakeBlocks(piece), vtkDataObject::FIELD_ASSOCIATION_CELLS),
    whole, vtkDataObject::FIELD_ASSOCIATION_CELLS);
}

// As behind Group Datasets: each rank has a slab of each member.
TEST(GridsOnRanks, MembersOfAnEnsembleKeepTheirSurfaces)
{
  const auto first = MakeRough();
  const auto second = MakeImage(WholeGrid, VTK_FLOAT, MakeWaves(90.0));
  vtkNew<vtkMultiBlockDataSet> group;
  group->SetBlock(0, CutImage(first, CutSlab(0)));
  group->SetBlock(1, CutImage(second, CutSlab(0)));
  const auto mine = ContourPiece(group);
  const std::int64_t edges = 3 * first->GetNumberOfPoints();
  const EdgeSurface surfaces[2] = { GatherSurface(mine, 0, edges), GatherSurface(mine, edges) };
  if (GetRank() == 0)
  {
    EXPECT_TRUE(AreEqual(surfaces[0], ContourByFlyingEdges(first, 8.0)));
    EXPECT_TRUE(AreEqual(surfaces[1], ContourByFlyingEdges(second, 8.0)));
  }
}

TEST(GridsOnRanks, MembersAreRefusedByNameWhereOneGridIsNeeded)
{
  const SharedFolder folder("members");
  vtkNew<vtkMultiBlockDataSet> group;
  group->SetBlock(0, CutImage(MakeRough(), CutSlab(0)));
  group->SetBlock(1, CutImage(MakeImage(WholeGrid, VTK_FLOAT, MakeWaves(90.0)), CutSlab(0)));
  vtkNew<vtkStabbingContour> contour;
  contour->SetController(GetRanks());
  contour->SetInputDataObject(group);
  contour->SetValue(0, 8.0);
  vtkNew<vtkEdgeIndexWriter> writer;
  const ErrorCounter errors(writer);
  writer->SetController(GetRanks());
  writer->SetInputConnection(contour->GetOutputPort());
  const std::string path = folder.GetPath("members.eix");
  writer->SetFileName(path.c_str());
  writer->Write();
  ExpectOneError(errors, { "other samples where they meet", "Extract Block" });
  EXPECT_FALSE(GetLocalFileSystem().Exists(path));
}

TEST(GridsOnRanks, PiecesWithOtherSamplesWhereTheyMeetAreNotJoined)
{
  const auto samples = MakeImage(WholeGrid, VTK_FLOAT,
    [waves = MakeWaves(100.0)](int i, int j, int k) { return waves(i, j, k) + 5.0 * GetRank(); });
  const auto slab = CutImage(samples, CutSlab(0));
  const auto mine = ContourPiece(MakeBlocks(slab));
  // Normals at the seam are those of the slab alone, and no id is there twice.
  std::int64_t firstId = 0;
  for (int rank = 0; rank < GetRank(); ++rank)
  {
    const int cells = WholeGrid[1] - WholeGrid[0];
    const int width = cells * (rank + 1) / GetNumberOfRanks() - cells * rank / GetNumberOfRanks();
    firstId +=
      3LL * (width + 1) * (WholeGrid[3] - WholeGrid[2] + 1) * (WholeGrid[5] - WholeGrid[4] + 1);
  }
  EXPECT_TRUE(AreEqual(ToEdges(mine, firstId), ContourByFlyingEdges(slab, 8.0)));
  EXPECT_EQ(ToEdges(mine, 0, firstId).Points.size(), 0u);
}

// A whole that every rank has is contoured once.
TEST(GridsOnRanks, AnImageThatAllRanksHaveIsContouredOnce)
{
  const auto whole = MakeRough();
  const auto mine = ContourPiece(whole);
  EXPECT_EQ(SumOverRanks(static_cast<std::uint64_t>(mine->GetNumberOfCells())),
    static_cast<std::uint64_t>(RunFlyingEdges(whole, 8.0, false)->GetNumberOfCells()));
}

TEST(GridsOnRanks, UnstructuredDataOnOneRankIsAnErrorOfAll)
{
  vtkNew<vtkStabbingContour> contour;
  const ErrorCounter errors(contour);
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
