// SPDX-License-Identifier: BSD-3-Clause
// The contract between consumers and the reader: who asks for what gets just that, and nobody else
// notices.
#include "BlockChecks.h"
#include "EventCounter.h"
#include "ScratchFolder.h"
#include "TestVolumes.h"

#include "vtkBlockedVolumeReader.h"
#include "vtkInformationBlockedVolumeKey.h"
#include "vtkInformationStabbingRequestKey.h"
#include "vtkStabbingContour.h"
#include "vtkStabbingRequest.h"

#include "vtkArrayCalculator.h"
#include "vtkCellData.h"
#include "vtkCommand.h"
#include "vtkDataArray.h"
#include "vtkDataSet.h"
#include "vtkInformation.h"
#include "vtkPartitionedDataSet.h"
#include "vtkPassArrays.h"
#include "vtkPassThrough.h"
#include "vtkPointData.h"
#include "vtkPolyData.h"
#include "vtkThreshold.h"
#include "vtkUnstructuredGrid.h"

namespace isosurface
{
namespace
{

constexpr double High = 200.0;
constexpr double Low = 60.5;

class StabbingRequest : public testing::Test
{
protected:
  StabbingRequest()
    : Image(MakeClosedVolume({ -41, 28, -7, 53, -90, -8 }, VTK_SHORT))
    , ReaderRuns(this->Reader, vtkCommand::StartEvent)
    , ReaderErrors(this->Reader)
  {
    TurnObliquely(this->Image);
    WriteVolume(this->Image, this->Folder.GetPath("volume.bvol"), { 16, 3 });
    this->Reader->SetFileName(this->Folder.GetPath("volume.bvol").c_str());
  }
  ~StabbingRequest() override
  {
    EXPECT_EQ(this->ReaderErrors.Messages, std::vector<std::string>());
  }

  // Updates a contour and compares.
  void ExpectSurface(vtkStabbingContour* contour, double isovalue)
  {
    const ErrorCounter errors(contour);
    contour->SetValue(0, isovalue);
    contour->Update();
    EXPECT_EQ(errors.Messages, std::vector<std::string>());
    EdgeSurface surface;
    surface.Add(contour->GetOutput());
    EXPECT_FALSE(surface.Triangles.empty());
    EXPECT_TRUE(AreEqual(surface, ContourByFlyingEdges(this->Image, isovalue)))
      << "at " << isovalue;
  }

  std::uint64_t CountActive(double isovalue)
  {
    return CountActiveBlocks(this->Image, 16, isovalue).ActiveBlocks;
  }
  std::uint64_t CountBlocks() { return this->Reader->GetOutput()->GetNumberOfPartitions(); }

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
  contour->SetInputArrayToProcess(0, 0, 0, vtkDataObject::FIELD_ASSOCIATION_POINTS, "density");
}

TEST_F(StabbingRequest, ThroughPassThroughGivesActiveBlocksAlone)
{
  vtkNew<vtkPassThrough> pass;
  pass->SetInputConnection(this->Reader->GetOutputPort());
  vtkNew<vtkStabbingContour> contour;
  Connect(contour, pass);
  for (const double isovalue : { High, Low, 1.0 })
  {
    this->ExpectSurface(contour, isovalue);
    EXPECT_EQ(this->CountBlocks(), this->CountActive(isovalue)) << "at " << isovalue;
    EXPECT_TRUE((BlockChecks{ this->Image }.HaveValues({ this->Reader->GetOutput() }, "density")));
    EXPECT_EQ(GetCost(contour->GetOutput(), "ActiveBlocks"), this->CountActive(isovalue));
  }
  EXPECT_EQ(this->ReaderRuns.Count, 3);
}

TEST_F(StabbingRequest, ThroughPassArraysGivesActiveBlocksAlone)
{
  vtkNew<vtkPassArrays> pass;
  pass->SetInputConnection(this->Reader->GetOutputPort());
  pass->AddPointDataArray("density");
  pass->AddPointDataArray("vtkGhostType");
  pass->AddCellDataArray("vtkGhostType");
  vtkNew<vtkStabbingContour> contour;
  Connect(contour, pass);
  this->ExpectSurface(contour, High);
  EXPECT_EQ(this->CountBlocks(), this->CountActive(High));
}

TEST_F(StabbingRequest, ThroughSeveralPassThroughsGivesActiveBlocksAlone)
{
  vtkNew<vtkPassThrough> first;
  first->SetInputConnection(this->Reader->GetOutputPort());
  vtkNew<vtkPassThrough> second;
  second->SetInputConnection(first->GetOutputPort());
  vtkNew<vtkStabbingContour> contour;
  Connect(contour, second);
  this->ExpectSurface(contour, High);
  EXPECT_EQ(this->CountBlocks(), this->CountActive(High));
  this->ExpectSurface(contour, Low);
  EXPECT_EQ(this->CountBlocks(), this->CountActive(Low));
}

TEST_F(StabbingRequest, NothingActiveGivesNoBlocks)
{
  vtkNew<vtkPassThrough> pass;
  pass->SetInputConnection(this->Reader->GetOutputPort());
  vtkNew<vtkStabbingContour> contour;
  const ErrorCounter errors(contour);
  Connect(contour, pass);
  contour->SetValue(0, 1e4);
  contour->Update();
  EXPECT_EQ(errors.Messages, std::vector<std::string>());
  EXPECT_EQ(contour->GetOutput()->GetNumberOfPoints(), 0);
  EXPECT_EQ(this->CountBlocks(), 0u);
}

TEST_F(StabbingRequest, DoesNotPassFiltersThatChangeValues)
{
  // 100 - density: other blocks are active than those of the stored values.
  vtkNew<vtkArrayCalculator> calculator;
  calculator->SetInputConnection(this->Reader->GetOutputPort());
  calculator->AddScalarArrayName("density");
  calculator->SetFunction("100 - density");
  calculator->SetResultArrayName("density");
  calculator->SetResultArrayType(VTK_SHORT);
  vtkNew<vtkStabbingContour> contour;
  Connect(contour, calculator);

  vtkNew<vtkArrayCalculator> wholeCalculator;
  wholeCalculator->SetInputData(this->Image);
  wholeCalculator->AddScalarArrayName("density");
  wholeCalculator->SetFunction("100 - density");
  wholeCalculator->SetResultArrayName("density");
  wholeCalculator->SetResultArrayType(VTK_SHORT);
  wholeCalculator->Update();
  auto* whole = vtkImageData::SafeDownCast(wholeCalculator->GetOutputDataObject(0));
  whole->GetPointData()->SetActiveScalars("density");

  for (const double isovalue : { -50.5, 70.0 })
  {
    contour->SetValue(0, isovalue);
    contour->Update();
    EdgeSurface surface;
    surface.Add(contour->GetOutput());
    EXPECT_TRUE(AreEqual(surface, ContourByFlyingEdges(whole, isovalue))) << "at " << isovalue;
    EXPECT_FALSE(surface.Triangles.empty());
    EXPECT_TRUE((BlockChecks{ this->Image }.HaveEachCellOnce({ this->Reader->GetOutput() })));
  }
  EXPECT_EQ(this->ReaderRuns.Count, 1) << "another isovalue is no reason to read again";
}

TEST_F(StabbingRequest, BehindReaderTakesBlocksFromVolume)
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

TEST_F(StabbingRequest, BehindReaderNeedsNoArrayName)
{
  vtkNew<vtkStabbingContour> contour;
  contour->SetInputConnection(this->Reader->GetOutputPort());
  this->ExpectSurface(contour, High);
}

TEST_F(StabbingRequest, BehindReaderPutsBoxInPlaceOfBlocks)
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

TEST_F(StabbingRequest, ContoursOfOneReaderDoNotDisturbEachOther)
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

TEST_F(StabbingRequest, PassingContoursOfOneReaderDoNotDisturbEachOther)
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
class StabbingRequestBesideStock
  : public StabbingRequest
  , public testing::WithParamInterface<bool>
{
protected:
  void ExpectAllCellsInThreshold()
  {
    this->Threshold->Update();
    vtkIdType cells = 0;
    for (vtkDataSet* dataSet :
      vtkCompositeDataSet::GetDataSets<vtkDataSet>(this->Threshold->GetOutputDataObject(0)))
    {
      vtkDataArray* ghosts = dataSet->GetCellData()->GetArray("vtkGhostType");
      for (vtkIdType cell = 0; cell < dataSet->GetNumberOfCells(); ++cell)
      {
        cells += !ghosts || ghosts->GetTuple1(cell) == 0 ? 1 : 0;
      }
    }
    EXPECT_EQ(cells, this->Image->GetNumberOfCells());
  }

  vtkNew<vtkThreshold> Threshold;
};

TEST_P(StabbingRequestBesideStock, StockConsumersSeeAllCells)
{
  vtkNew<vtkPassThrough> pass;
  pass->SetInputConnection(this->Reader->GetOutputPort());
  vtkAlgorithm* input = this->Reader;
  if (GetParam())
  {
    input = pass;
  }
  vtkNew<vtkStabbingContour> contour;
  Connect(contour, input);
  this->Threshold->SetInputConnection(input->GetOutputPort());
  this->Threshold->SetThresholdFunction(vtkThreshold::THRESHOLD_LOWER);
  this->Threshold->SetLowerThreshold(1e9);
  this->Threshold->SetInputArrayToProcess(
    0, 0, 0, vtkDataObject::FIELD_ASSOCIATION_POINTS, "density");

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

TEST_P(StabbingRequestBesideStock, StockConsumerAfterContourSeesAllCells)
{
  vtkNew<vtkPassThrough> pass;
  pass->SetInputConnection(this->Reader->GetOutputPort());
  vtkAlgorithm* input = this->Reader;
  if (GetParam())
  {
    input = pass;
  }
  vtkNew<vtkStabbingContour> contour;
  Connect(contour, input);
  this->ExpectSurface(contour, High);
  this->Threshold->SetInputConnection(input->GetOutputPort());
  this->Threshold->SetThresholdFunction(vtkThreshold::THRESHOLD_LOWER);
  this->Threshold->SetLowerThreshold(1e9);
  this->Threshold->SetInputArrayToProcess(
    0, 0, 0, vtkDataObject::FIELD_ASSOCIATION_POINTS, "density");
  this->ExpectAllCellsInThreshold();
  // The reader itself, asked by nobody in particular.
  this->ExpectSurface(contour, Low);
  this->Reader->Modified();
  this->Reader->Update();
  EXPECT_TRUE((BlockChecks{ this->Image }.HaveEachCellOnce({ this->Reader->GetOutput() })));
}

std::string NameOfInput(const testing::TestParamInfo<bool>& info)
{
  return info.param ? "BehindPassThrough" : "BehindReader";
}

INSTANTIATE_TEST_SUITE_P(Inputs, StabbingRequestBesideStock, testing::Bool(), NameOfInput);

TEST_F(StabbingRequest, IsServedByOutputMadeForTheSame)
{
  vtkNew<vtkStabbingRequest> nothing;
  vtkNew<vtkStabbingRequest> high;
  high->SetArrayName("density");
  high->SetIsovalues({ High });
  vtkNew<vtkStabbingRequest> alsoHigh;
  alsoHigh->SetArrayName("density");
  alsoHigh->SetIsovalues({ High });
  vtkNew<vtkStabbingRequest> low;
  low->SetArrayName("density");
  low->SetIsovalues({ Low });
  vtkNew<vtkStabbingRequest> other;
  other->SetArrayName("pressure");
  other->SetIsovalues({ High });
  vtkNew<vtkStabbingRequest> handle;
  handle->SetHandleOnly(true);
  vtkStabbingRequest* const none = nullptr;
  for (vtkStabbingRequest* made : { none, nothing.Get(), high.Get(), handle.Get() })
  {
    EXPECT_TRUE(vtkStabbingRequest::Serves(made, handle));
  }
  for (vtkStabbingRequest* wanted : { none, nothing.Get(), high.Get() })
  {
    EXPECT_FALSE(vtkStabbingRequest::Serves(handle, wanted));
  }
  EXPECT_TRUE(vtkStabbingRequest::Serves(nullptr, nothing));
  EXPECT_TRUE(vtkStabbingRequest::Serves(nothing, nullptr));
  EXPECT_TRUE(vtkStabbingRequest::Serves(high, alsoHigh));
  EXPECT_FALSE(vtkStabbingRequest::Serves(high, low));
  EXPECT_FALSE(vtkStabbingRequest::Serves(high, other));
  EXPECT_FALSE(vtkStabbingRequest::Serves(high, nothing));
  EXPECT_FALSE(vtkStabbingRequest::Serves(nullptr, high));
}

} // namespace
} // namespace isosurface
