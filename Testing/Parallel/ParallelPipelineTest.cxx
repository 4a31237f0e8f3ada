// SPDX-License-Identifier: BSD-3-Clause
// Between reader and contour, on all ranks: other filters, and stops.
#include "EventCounter.h"
#include "ParallelVolumes.h"

#include "vtkBlockedVolumeReader.h"
#include "vtkContourSpectrum.h"
#include "vtkDistributeIsosurface.h"
#include "vtkStabbingContour.h"

#include "vtkArrayCalculator.h"
#include "vtkExecutive.h"
#include "vtkMultiProcessController.h"
#include "vtkPartitionedDataSet.h"
#include "vtkPassThrough.h"
#include "vtkPointData.h"
#include "vtkTable.h"
#include "vtkUnsignedCharArray.h"

using namespace isosurface;

namespace
{

vtkSmartPointer<vtkArrayCalculator> MakeCalculator()
{
  auto calculator = vtkSmartPointer<vtkArrayCalculator>::New();
  calculator->AddScalarArrayName("density");
  calculator->SetFunction("100 - density");
  calculator->SetResultArrayName("density");
  calculator->SetResultArrayType(VTK_SHORT);
  return calculator;
}

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
    SelectPoints(this->Pipeline.Contour, "density");
  }

  void ExpectUnion(double isovalue, vtkImageData* image)
  {
    vtkPolyData* mine = this->Pipeline.Update({ isovalue });
    EXPECT_GT(SumOverRanks(static_cast<std::uint64_t>(mine->GetNumberOfPolys())), 0u);
    ExpectSurfaceOf(mine, image, isovalue);
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
  const auto whole = MakeCalculator();
  whole->SetInputData(this->Image);
  whole->Update();
  auto* image = vtkImageData::SafeDownCast(whole->GetOutputDataObject(0));
  image->GetPointData()->SetActiveScalars("density");

  const auto calculator = MakeCalculator();
  calculator->SetInputConnection(this->Pipeline.Reader->GetOutputPort());
  this->Pipeline.Contour->SetInputConnection(calculator->GetOutputPort());
  this->ExpectUnion(-50.5, image);
  EXPECT_EQ(this->CountCells(), this->CountAllCells());
}

TEST_F(ParallelPipeline, StopOfOneRankAndErrorOfAnotherStopAll)
{
  if (GetNumberOfRanks() == 1)
  {
    GTEST_SKIP() << "one rank is not stopped while another one fails";
  }
  const std::string path = this->Folder.GetPath("noise.bvol");
  WriteFromPieces(MakeImage({ 0, 40, 0, 36, 0, 44 }, VTK_UNSIGNED_CHAR, MakeNoise(250, 3)),
    PieceSource::SUB_EXTENTS, path, { 16, 1 });
  OnFirstRank(
    [&]
    {
      FlipBit(GetFirstStore(path) + "/blocks", -8000); // not in the slab of rank 0
    });
  vtkBlockedVolumeReader* reader = this->Pipeline.Reader;
  reader->SetFileName(path.c_str());
  const auto calculator = MakeCalculator();
  calculator->SetInputConnection(reader->GetOutputPort());
  this->Pipeline.Contour->SetInputConnection(calculator->GetOutputPort());
  this->Pipeline.Contour->SetValue(0, 39.5);
  const ErrorCounter errors(reader);
  {
    const ProgressKeeper progress(reader, StopAbove(reader, GetRank() == 0 ? -1 : 1));
    this->Pipeline.Contour->UpdatePiece(GetRank(), GetNumberOfRanks(), 0);
  }
  EXPECT_EQ(errors.Messages, std::vector<std::string>());
  EXPECT_EQ(this->CountCells(), 0u);
  reader->SetAbortExecute(0);
  this->Pipeline.Contour->UpdatePiece(GetRank(), GetNumberOfRanks(), 0);
  EXPECT_EQ(errors.Messages.size(), 1u) << "the damage is told once nobody stops";
}

TEST_F(ParallelPipeline, SpectrumBehindAStoppedReaderIsThereAfterwards)
{
  vtkBlockedVolumeReader* reader = this->Pipeline.Reader;
  vtkNew<vtkContourSpectrum> spectrum;
  spectrum->SetInputConnection(reader->GetOutputPort());
  reader->SetAbortExecute(GetRank() == 0 ? 1 : 0);
  spectrum->UpdatePiece(GetRank(), GetNumberOfRanks(), 0);
  EXPECT_EQ(spectrum->GetOutput()->GetNumberOfColumns(), 0);
  spectrum->UpdatePiece(GetRank(), GetNumberOfRanks(), 0);
  reader->SetAbortExecute(0);
  spectrum->UpdatePiece(GetRank(), GetNumberOfRanks(), 0);
  EXPECT_EQ(spectrum->GetOutput()->GetNumberOfColumns(), GetRank() == 0 ? 7 : 0);
}

TEST_F(ParallelPipeline, DistributionBehindAStoppedSourceStopsOnAllRanks)
{
  const auto calculator = MakeCalculator();
  calculator->SetInputConnection(this->Pipeline.Reader->GetOutputPort());
  this->Pipeline.Contour->SetInputConnection(calculator->GetOutputPort());
  this->Pipeline.Contour->SetValue(0, 39.5);
  vtkNew<vtkDistributeIsosurface> distribute;
  distribute->SetInputConnection(this->Pipeline.Contour->GetOutputPort());
  const ErrorCounter errors(distribute);
  this->Pipeline.Reader->SetAbortExecute(GetRank() == 0 ? 1 : 0);
  distribute->UpdatePiece(GetRank(), GetNumberOfRanks(), 0);
  EXPECT_EQ(errors.Messages, std::vector<std::string>());
  EXPECT_EQ(distribute->GetOutput()->GetNumberOfPoints(), 0);
  this->Pipeline.Reader->SetAbortExecute(0);
  distribute->UpdatePiece(GetRank(), GetNumberOfRanks(), 0);
  EXPECT_EQ(errors.Messages, std::vector<std::string>());
  EXPECT_GT(
    SumOverRanks(static_cast<std::uint64_t>(distribute->GetOutput()->GetNumberOfPoints())), 0u);
}

TEST_F(ParallelPipeline, StopOfOneRankStopsAllWithoutError)
{
  const bool isMine = GetRank() == GetNumberOfRanks() - 1;
  vtkStabbingContour* contour = this->Pipeline.Contour;
  {
    const ExpectNoErrors executiveErrors(contour->GetExecutive());
    const ProgressKeeper progress(contour, StopAbove(contour, isMine ? -1 : 1));
    EXPECT_EQ(this->Pipeline.Update({ 60.5 })->GetNumberOfPoints(), 0);
    // Unmodified, what has stopped executes again: on all ranks.
    EXPECT_EQ(this->Pipeline.Update({ 60.5 })->GetNumberOfPoints(), 0);
    contour->SetAbortExecute(0);
    contour->Modified();
  }
  this->ExpectUnion(60.5, this->Image);

  vtkBlockedVolumeReader* reader = this->Pipeline.Reader;
  {
    const ExpectNoErrors errors(reader);
    const ExpectNoErrors executiveErrors(reader->GetExecutive());
    const ProgressKeeper progress(reader, StopAbove(reader, isMine ? -1 : 1));
    reader->Modified();
    reader->UpdatePiece(GetRank(), GetNumberOfRanks(), 0);
    reader->UpdatePiece(GetRank(), GetNumberOfRanks(), 0);
    EXPECT_EQ(this->CountCells(), 0u);
    reader->SetAbortExecute(0);
    reader->Modified();
  }
  reader->UpdatePiece(GetRank(), GetNumberOfRanks(), 0);
  EXPECT_EQ(this->CountCells(), this->CountAllCells());
}

} // namespace
