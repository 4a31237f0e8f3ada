// SPDX-License-Identifier: BSD-3-Clause
// Consumers that take blocks through the handle beside consumers of the reader's output: each gets
// what it asked for, in any order.
#include "BlockChecks.h"
#include "EventCounter.h"
#include "ScratchFolder.h"
#include "TestVolumes.h"

#include "vtkBlockedVolumeReader.h"
#include "vtkInformationBlockedVolumeKey.h"
#include "vtkStabbingContour.h"
#include "vtkVolumeProbe.h"

#include "vtkArrayCalculator.h"
#include "vtkCellData.h"
#include "vtkCommand.h"
#include "vtkDataArray.h"
#include "vtkDataArraySelection.h"
#include "vtkDataSet.h"
#include "vtkExecutive.h"
#include "vtkGroupDataSetsFilter.h"
#include "vtkInformation.h"
#include "vtkObjectFactory.h"
#include "vtkPartitionedDataSet.h"
#include "vtkPassArrays.h"
#include "vtkPassSelectedArrays.h"
#include "vtkPassThrough.h"
#include "vtkPointData.h"
#include "vtkPolyData.h"
#include "vtkPolyDataAlgorithm.h"
#include "vtkThreshold.h"
#include "vtkUnstructuredGrid.h"

using namespace isosurface;

namespace
{

constexpr double High = 200.0;
constexpr double Low = 60.5;

/// Has no data to give.
class FailingSource : public vtkPolyDataAlgorithm
{
public:
  static FailingSource* New();
  vtkTypeMacro(FailingSource, vtkPolyDataAlgorithm);

protected:
  FailingSource() { this->SetNumberOfInputPorts(0); }
  int RequestData(vtkInformation*, vtkInformationVector**, vtkInformationVector*) override
  {
    return 0;
  }
};
vtkStandardNewMacro(FailingSource);

class BlockedVolumeHandle : public testing::Test
{
protected:
  BlockedVolumeHandle()
    : Image(MakeClosedVolume({ -41, 28, -7, 53, -90, -8 }, VTK_SHORT))
    , ReaderRuns(this->Reader, vtkCommand::StartEvent)
    , ReaderErrors(this->Reader)
  {
    TurnObliquely(this->Image);
    WriteVolume(this->Image, this->Folder.GetPath("volume.bvol"), { 16, 3 });
    this->Reader->SetFileName(this->Folder.GetPath("volume.bvol").c_str());
  }
  ~BlockedVolumeHandle() override
  {
    EXPECT_EQ(this->ReaderErrors.Messages, std::vector<std::string>());
  }

  // Updates a contour and compares.
  void ExpectSurface(vtkStabbingContour* contour, double isovalue)
  {
    const ExpectNoErrors errors(contour);
    contour->SetValue(0, isovalue);
    contour->Update();
    const EdgeSurface surface = ToEdges(contour->GetOutput());
    EXPECT_FALSE(surface.Triangles.empty());
    EXPECT_TRUE(AreEqual(surface, ContourByFlyingEdges(this->Image, isovalue)))
      << "at " << isovalue;
  }

  std::uint64_t CountActive(double isovalue)
  {
    return CountActiveBlocks(this->Image, 16, isovalue).ActiveBlocks;
  }
  // Nothing but the active blocks was read: the reader's output is the box of the volume.
  void ExpectActiveBlocksAlone(vtkStabbingContour* contour, double isovalue)
  {
    this->ExpectSurface(contour, isovalue);
    EXPECT_EQ(GetCost(contour->GetOutput(), "ActiveBlocks"), this->CountActive(isovalue));
    ASSERT_EQ(this->Reader->GetOutput()->GetNumberOfPartitions(), 1u);
    EXPECT_EQ(this->Reader->GetOutput()->GetPartition(0)->GetNumberOfCells(), 1);
  }

  const ScratchFolder Folder;
  const vtkSmartPointer<vtkImageData> Image;
  vtkNew<vtkBlockedVolumeReader> Reader;
  const EventCounter ReaderRuns;
  const ErrorCounter ReaderErrors;
};

// A contour that is told the array by name: it knows nothing of the reader's active scalars.
void Connect(vtkStabbingContour* contour, vtkAlgorithm* input)
{
  contour->SetInputConnection(input->GetOutputPort());
  SelectPoints(contour, "density");
}

// A consumer of all cells.
void SetUpThreshold(vtkThreshold* threshold, vtkAlgorithm* input)
{
  threshold->SetInputConnection(input->GetOutputPort());
  threshold->SetThresholdFunction(vtkThreshold::THRESHOLD_LOWER);
  threshold->SetLowerThreshold(1e9);
  SelectPoints(threshold, "density");
}

TEST_F(BlockedVolumeHandle, PassesPassThrough)
{
  vtkNew<vtkPassThrough> pass;
  pass->SetInputConnection(this->Reader->GetOutputPort());
  vtkNew<vtkStabbingContour> contour;
  Connect(contour, pass);
  for (const double isovalue : { High, Low, 1.0 })
  {
    this->ExpectActiveBlocksAlone(contour, isovalue);
  }
  EXPECT_EQ(this->ReaderRuns.Count, 1) << "another isovalue is no reason to read again";
}

TEST_F(BlockedVolumeHandle, PassesSeveralFilters)
{
  vtkNew<vtkPassThrough> first;
  first->SetInputConnection(this->Reader->GetOutputPort());
  vtkNew<vtkPassArrays> second;
  second->SetInputConnection(first->GetOutputPort());
  second->AddPointDataArray("density");
  vtkNew<vtkPassThrough> third;
  third->SetInputConnection(second->GetOutputPort());
  vtkNew<vtkStabbingContour> contour;
  Connect(contour, third);
  this->ExpectActiveBlocksAlone(contour, High);
  this->ExpectActiveBlocksAlone(contour, Low);
}

TEST_F(BlockedVolumeHandle, PassesPassArraysWithTheArray)
{
  vtkNew<vtkPassArrays> pass;
  pass->SetInputConnection(this->Reader->GetOutputPort());
  pass->AddPointDataArray("density");
  vtkNew<vtkStabbingContour> contour;
  Connect(contour, pass);
  this->ExpectActiveBlocksAlone(contour, High);
  vtkNew<vtkPassSelectedArrays> selected;
  selected->SetInputConnection(this->Reader->GetOutputPort());
  selected->GetPointDataArraySelection()->EnableArray("density");
  Connect(contour, selected);
  this->ExpectActiveBlocksAlone(contour, Low);
}

TEST_F(BlockedVolumeHandle, ArraysThatPassArraysLeavesOutAreErrors)
{
  for (const bool isOutputThere : { false, true })
  {
    vtkNew<vtkPassArrays> pass;
    pass->SetInputConnection(this->Reader->GetOutputPort());
    pass->RemoveArraysOn();
    pass->AddPointDataArray("density");
    if (isOutputThere)
    {
      this->Reader->Update();
    }
    vtkNew<vtkStabbingContour> contour;
    ErrorCounter errors(contour);
    Connect(contour, pass);
    contour->SetValue(0, High);
    contour->Update();
    EXPECT_EQ(contour->GetOutput()->GetNumberOfPoints(), 0);
    ExpectOneError(errors, { "no point array \"density\"" });

    pass->ClearArrays();
    errors.Messages.clear();
    this->ExpectSurface(contour, High);
  }
}

TEST_F(BlockedVolumeHandle, NothingActiveGivesAnEmptySurface)
{
  vtkNew<vtkPassThrough> pass;
  pass->SetInputConnection(this->Reader->GetOutputPort());
  vtkNew<vtkStabbingContour> contour;
  const ExpectNoErrors errors(contour);
  Connect(contour, pass);
  contour->SetValue(0, 1e4);
  contour->Update();
  EXPECT_EQ(contour->GetOutput()->GetNumberOfPoints(), 0);
  EXPECT_EQ(GetCost(contour->GetOutput(), "ActiveBlocks"), 0u);
}

TEST_F(BlockedVolumeHandle, DoesNotPassFiltersThatChangeValues)
{
  vtkNew<vtkArrayCalculator> calculator;
  vtkNew<vtkArrayCalculator> wholeCalculator;
  for (vtkArrayCalculator* one : { calculator.Get(), wholeCalculator.Get() })
  {
    // Other blocks are active than those of the stored values.
    one->AddScalarArrayName("density");
    one->SetFunction("100 - density");
    one->SetResultArrayName("density");
    one->SetResultArrayType(VTK_SHORT);
  }
  calculator->SetInputConnection(this->Reader->GetOutputPort());
  vtkNew<vtkStabbingContour> contour;
  Connect(contour, calculator);
  wholeCalculator->SetInputData(this->Image);
  wholeCalculator->Update();
  auto* whole = vtkImageData::SafeDownCast(wholeCalculator->GetOutputDataObject(0));
  whole->GetPointData()->SetActiveScalars("density");

  for (const double isovalue : { -50.5, 70.0 })
  {
    contour->SetValue(0, isovalue);
    contour->Update();
    const EdgeSurface surface = ToEdges(contour->GetOutput());
    EXPECT_TRUE(AreEqual(surface, ContourByFlyingEdges(whole, isovalue))) << "at " << isovalue;
    EXPECT_FALSE(surface.Triangles.empty());
    EXPECT_TRUE((BlockChecks{ this->Image }.HaveEachCellOnce({ this->Reader->GetOutput() })));
  }
  EXPECT_EQ(this->ReaderRuns.Count, 1) << "another isovalue is no reason to read again";
}

TEST_F(BlockedVolumeHandle, BehindReaderTakesBlocksFromVolume)
{
  vtkNew<vtkStabbingContour> contour;
  Connect(contour, this->Reader);
  for (const double isovalue : { High, Low, High, 1.0 })
  {
    this->ExpectSurface(contour, isovalue);
    EXPECT_EQ(GetCost(contour->GetOutput(), "ActiveBlocks"), this->CountActive(isovalue));
  }
  EXPECT_EQ(this->ReaderRuns.Count, 1) << "another isovalue is no reason to read again";
}

TEST_F(BlockedVolumeHandle, BehindReaderNeedsNoArrayName)
{
  vtkNew<vtkStabbingContour> contour;
  contour->SetInputConnection(this->Reader->GetOutputPort());
  this->ExpectSurface(contour, High);
}

TEST_F(BlockedVolumeHandle, BehindReaderPutsBoxInPlaceOfBlocks)
{
  vtkNew<vtkStabbingContour> contour;
  Connect(contour, this->Reader);
  this->ExpectSurface(contour, High);
  vtkPartitionedDataSet* output = this->Reader->GetOutput();
  ASSERT_EQ(output->GetNumberOfPartitions(), 1u);
  auto* box = vtkImageData::SafeDownCast(output->GetPartition(0));
  ASSERT_NE(box, nullptr);
  EXPECT_EQ(box->GetNumberOfCells(), 1);
  double bounds[6];
  double expected[6];
  box->GetBounds(bounds);
  this->Image->GetBounds(expected);
  for (int side = 0; side < 6; ++side)
  {
    EXPECT_NEAR(bounds[side], expected[side], 1e-9);
  }
  ASSERT_NE(box->GetPointData()->GetScalars(), nullptr);
  EXPECT_STREQ(box->GetPointData()->GetScalars()->GetName(), "density");
  EXPECT_EQ(box->GetPointData()->GetScalars()->GetDataType(), VTK_SHORT);
  double range[2];
  double expectedRange[2];
  box->GetPointData()->GetScalars()->GetRange(range);
  this->Image->GetPointData()->GetScalars()->GetRange(expectedRange);
  EXPECT_EQ(range[0], expectedRange[0]);
  EXPECT_EQ(range[1], expectedRange[1]);
}

TEST_F(BlockedVolumeHandle, ContoursOfOneReaderDoNotDisturbEachOther)
{
  vtkNew<vtkPassThrough> pass;
  pass->SetInputConnection(this->Reader->GetOutputPort());
  vtkNew<vtkStabbingContour> behindReader;
  vtkNew<vtkStabbingContour> alsoBehindReader;
  vtkNew<vtkStabbingContour> behindPass;
  Connect(behindReader, this->Reader);
  Connect(alsoBehindReader, this->Reader);
  Connect(behindPass, pass);
  for (int turn = 0; turn < 3; ++turn)
  {
    this->ExpectSurface(behindReader, High - turn);
    this->ExpectSurface(behindPass, Low + turn);
    this->ExpectSurface(alsoBehindReader, Low - turn);
  }
}

TEST_F(BlockedVolumeHandle, PassingContoursOfOneReaderDoNotDisturbEachOther)
{
  vtkNew<vtkPassThrough> pass;
  pass->SetInputConnection(this->Reader->GetOutputPort());
  vtkNew<vtkStabbingContour> first;
  vtkNew<vtkStabbingContour> second;
  Connect(first, pass);
  Connect(second, pass);
  for (int turn = 0; turn < 3; ++turn)
  {
    this->ExpectSurface(first, High - turn);
    this->ExpectSurface(second, Low + turn);
    // Without a change nothing is computed, whatever the other one asked for.
    const EventCounter firstRuns(first, vtkCommand::StartEvent);
    first->Update();
    EXPECT_EQ(firstRuns.Count, 0);
  }
}

// Stock consumers, before, between and after contours: none of them may inherit a request.
class HandleBesideStock
  : public BlockedVolumeHandle
  , public testing::WithParamInterface<bool>
{
protected:
  HandleBesideStock()
  {
    this->Pass->SetInputConnection(this->Reader->GetOutputPort());
    SetUpThreshold(this->Threshold, this->Input);
  }

  void ExpectAllCellsInThreshold()
  {
    this->Threshold->Update();
    this->ExpectAllCells(this->Threshold->GetOutputDataObject(0));
  }

  void ExpectAllCells(vtkDataObject* pieces)
  {
    vtkIdType cells = 0;
    for (vtkDataSet* dataSet : vtkCompositeDataSet::GetDataSets<vtkDataSet>(pieces))
    {
      vtkDataArray* ghosts = dataSet->GetCellData()->GetArray("vtkGhostType");
      for (vtkIdType cell = 0; cell < dataSet->GetNumberOfCells(); ++cell)
      {
        cells += !ghosts || ghosts->GetTuple1(cell) == 0 ? 1 : 0;
      }
    }
    EXPECT_EQ(cells, this->Image->GetNumberOfCells());
  }

  const vtkNew<vtkPassThrough> Pass;
  vtkAlgorithm* const Input = GetParam() ? static_cast<vtkAlgorithm*>(this->Pass) : this->Reader;
  const vtkNew<vtkThreshold> Threshold;
};

TEST_P(HandleBesideStock, StockConsumersSeeAllCells)
{
  vtkNew<vtkStabbingContour> contour;
  Connect(contour, this->Input);

  this->ExpectAllCellsInThreshold();
  this->ExpectSurface(contour, High);
  this->ExpectAllCellsInThreshold();
  this->ExpectSurface(contour, Low);
  this->Threshold->Modified();
  this->ExpectAllCellsInThreshold();
  contour->Modified();
  this->ExpectSurface(contour, Low);
  this->Reader->Modified();
  this->ExpectSurface(contour, High);
  this->ExpectAllCellsInThreshold();
}

TEST_P(HandleBesideStock, StockConsumerAfterContourSeesAllCells)
{
  vtkNew<vtkStabbingContour> contour;
  Connect(contour, this->Input);
  this->ExpectSurface(contour, High);
  this->ExpectAllCellsInThreshold();
  // The reader itself, asked by nobody in particular.
  this->ExpectSurface(contour, Low);
  this->Reader->Modified();
  this->Reader->Update();
  EXPECT_TRUE((BlockChecks{ this->Image }.HaveEachCellOnce({ this->Reader->GetOutput() })));
}

TEST_P(HandleBesideStock, ProbedPointsThatAreMadeOfTheSameVolumeAreOfAllOfIt)
{
  vtkNew<vtkVolumeProbe> probe;
  probe->SetInputConnection(this->Input->GetOutputPort());
  probe->SetSourceConnection(this->Threshold->GetOutputPort());
  for (int turn = 0; turn < 2; ++turn)
  {
    probe->Update();
    this->ExpectAllCells(probe->GetOutputDataObject(0));
    // A box is what the next probe finds in the reader.
    vtkNew<vtkStabbingContour> contour;
    Connect(contour, this->Input);
    this->Reader->Modified();
    this->ExpectSurface(contour, High);
  }
}

TEST_P(HandleBesideStock, AProbeWhosePointsFailTakesNothing)
{
  const vtkNew<FailingSource> failing;
  {
    vtkNew<vtkVolumeProbe> probe;
    probe->SetInputConnection(this->Input->GetOutputPort());
    probe->SetSourceConnection(failing->GetOutputPort());
    for (int turn = 0; turn < 2; ++turn)
    {
      probe->Update();
      failing->Modified();
      vtkNew<vtkStabbingContour> contour; // after which the reader has a box
      Connect(contour, this->Input);
      this->ExpectSurface(contour, High);
    }
    probe->Update();
  }
  this->Reader->Update();
  EXPECT_TRUE((BlockChecks{ this->Image }.HaveEachCellOnce({ this->Reader->GetOutput() })));
}

std::string NameOfInput(const testing::TestParamInfo<bool>& info)
{
  return info.param ? "BehindPassThrough" : "BehindReader";
}

INSTANTIATE_TEST_SUITE_P(Inputs, HandleBesideStock, testing::Bool(), NameOfInput);

TEST_F(BlockedVolumeHandle, ContoursAndStockConsumersShareOneUpdate)
{
  // Whatever the order of the inputs, the threshold sees the whole volume.
  for (const bool contourFirst : { true, false })
  {
    vtkNew<vtkStabbingContour> contours[2];
    vtkNew<vtkThreshold> threshold;
    SetUpThreshold(threshold, this->Reader);
    threshold->Update();
    this->Reader->Modified();
    for (vtkStabbingContour* contour : { contours[0].Get(), contours[1].Get() })
    {
      Connect(contour, this->Reader);
      contour->SetValue(0, High);
    }
    const EventCounter runs(this->Reader, vtkCommand::StartEvent);
    vtkNew<vtkGroupDataSetsFilter> group;
    group->SetOutputTypeToPartitionedDataSetCollection();
    if (contourFirst)
    {
      group->AddInputConnection(contours[0]->GetOutputPort());
      group->AddInputConnection(contours[1]->GetOutputPort());
    }
    group->AddInputConnection(threshold->GetOutputPort());
    if (!contourFirst)
    {
      group->AddInputConnection(contours[0]->GetOutputPort());
      group->AddInputConnection(contours[1]->GetOutputPort());
    }
    group->Update();
    EXPECT_LE(runs.Count, 2);
    EXPECT_TRUE((BlockChecks{ this->Image }.HaveEachCellOnce({ this->Reader->GetOutput() })))
      << contourFirst;
    for (vtkStabbingContour* contour : { contours[0].Get(), contours[1].Get() })
    {
      EXPECT_TRUE(IsSurfaceOf(contour->GetOutput(), this->Image, High));
    }
  }
}

} // namespace
