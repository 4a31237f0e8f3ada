// SPDX-License-Identifier: BSD-3-Clause
// Between reader and contour, on all ranks: other filters, and stops.
#include "EventCounter.h"
#include "ParallelVolumes.h"

#include "vtkBlockedVolumeReader.h"
#include "vtkStabbingContour.h"

#include "vtkArrayCalculator.h"
#include "vtkExecutive.h"
#include "vtkMultiProcessController.h"
#include "vtkPartitionedDataSet.h"
#include "vtkPassThrough.h"
#include "vtkPointData.h"
#include "vtkUnsignedCharArray.h"

namespace isosurface
{
namespace
{

class ParallelPipeline : public testing::Test
{
protected:
  ParallelPipeline()
    : Folder(testing::UnitTest::GetInstance()->current_test_info()->name())
    , Image(MakeClosedVolume({ -41, 28, -7, 53, -90, -8 }, VTK_SHORT))
    , Path(this->Folder.GetPath("volume.bvol"))
    , Pipeline(this->Path)
  {
    TurnObliquely(this->Image);
    WriteFromPieces(this->Image, PieceSource::SUB_EXTENTS, this->Path, { 16, 4, 0 });
    this->Pipeline.Contour->SetInputArrayToProcess(
      0, 0, 0, vtkDataObject::FIELD_ASSOCIATION_POINTS, "density");
  }

  void ExpectUnion(double isovalue, vtkImageData* image)
  {
    EdgeSurface mine;
    mine.Add(this->Pipeline.Update({ isovalue }));
    EdgeSurface all = GatherSurfaces(mine);
    all.MergeEqualPoints();
    if (GetRank() == 0)
    {
      EXPECT_FALSE(all.Triangles.empty());
      EXPECT_TRUE(AreEqual(all, ContourByFlyingEdges(image, isovalue))) << "at " << isovalue;
    }
  }

  // Of all ranks, without ghosts.
  std::uint64_t CountCells()
  {
    std::uint64_t cells = 0;
    vtkPartitionedDataSet* blocks = this->Pipeline.Reader->GetOutput();
    for (unsigned int index = 0; index < blocks->GetNumberOfPartitions(); ++index)
    {
      vtkDataSet* block = blocks->GetPartition(index);
      vtkUnsignedCharArray* ghosts = block->GetCellGhostArray();
      for (vtkIdType cell = 0; cell < block->GetNumberOfCells(); ++cell)
      {
        cells += ghosts && ghosts->GetValue(cell) != 0 ? 0 : 1;
      }
    }
    return SumOverRanks(cells);
  }
  std::uint64_t CountAllCells() const
  {
    return static_cast<std::uint64_t>(this->Image->GetNumberOfCells());
  }

  const SharedFolder Folder;
  const vtkSmartPointer<vtkImageData> Image;
  const std::string Path;
  ContourPipeline Pipeline;
};

TEST_F(ParallelPipeline, HandlePassesPassThrough)
{
  vtkNew<vtkPassThrough> pass;
  pass->SetInputConnection(this->Pipeline.Reader->GetOutputPort());
  this->Pipeline.Contour->SetInputConnection(pass->GetOutputPort());
  for (const double isovalue : { 200.0, 60.5 })
  {
    this->ExpectUnion(isovalue, this->Image);
    EXPECT_EQ(SumOverRanks(GetCost(this->Pipeline.Contour->GetOutput(), "ActiveBlocks")),
      CountActiveBlocks(this->Image, 16, isovalue).ActiveBlocks);
    EXPECT_EQ(this->CountCells(), 1u) << "the reader's output is not needed";
  }
}

TEST_F(ParallelPipeline, FilterThatChangesValuesSeesAllCells)
{
  auto makeCalculator = []()
  {
    auto calculator = vtkSmartPointer<vtkArrayCalculator>::New();
    calculator->AddScalarArrayName("density");
    calculator->SetFunction("100 - density");
    calculator->SetResultArrayName("density");
    calculator->SetResultArrayType(VTK_SHORT);
    return calculator;
  };
  const auto whole = makeCalculator();
  whole->SetInputData(this->Image);
  whole->Update();
  auto* image = vtkImageData::SafeDownCast(whole->GetOutputDataObject(0));
  image->GetPointData()->SetActiveScalars("density");

  const auto calculator = makeCalculator();
  calculator->SetInputConnection(this->Pipeline.Reader->GetOutputPort());
  this->Pipeline.Contour->SetInputConnection(calculator->GetOutputPort());
  this->ExpectUnion(-50.5, image);
  EXPECT_EQ(this->CountCells(), this->CountAllCells());
}

TEST_F(ParallelPipeline, StopOfOneRankStopsAllWithoutError)
{
  const bool isMine = GetRank() == GetNumberOfRanks() - 1;
  vtkStabbingContour* contour = this->Pipeline.Contour;
  {
    const ErrorCounter executiveErrors(contour->GetExecutive());
    const ProgressKeeper progress(contour,
      [=](double)
      {
        if (isMine)
        {
          contour->SetAbortExecute(1);
        }
      });
    EXPECT_EQ(this->Pipeline.Update({ 60.5 })->GetNumberOfPoints(), 0);
    EXPECT_EQ(executiveErrors.Messages, std::vector<std::string>());
    contour->SetAbortExecute(0);
    contour->Modified();
  }
  this->ExpectUnion(60.5, this->Image);

  vtkBlockedVolumeReader* reader = this->Pipeline.Reader;
  {
    const ErrorCounter errors(reader);
    const ErrorCounter executiveErrors(reader->GetExecutive());
    const ProgressKeeper progress(reader,
      [=](double)
      {
        if (isMine)
        {
          reader->SetAbortExecute(1);
        }
      });
    reader->Modified();
    reader->UpdatePiece(GetRank(), GetNumberOfRanks(), 0);
    EXPECT_EQ(errors.Messages, std::vector<std::string>());
    EXPECT_EQ(executiveErrors.Messages, std::vector<std::string>());
    EXPECT_EQ(this->CountCells(), 0u);
    reader->SetAbortExecute(0);
    reader->Modified();
  }
  reader->UpdatePiece(GetRank(), GetNumberOfRanks(), 0);
  EXPECT_EQ(this->CountCells(), this->CountAllCells());
}

} // namespace
} // namespace isosurface
