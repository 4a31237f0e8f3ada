// SPDX-License-Identifier: BSD-3-Clause
// Time steps from writer to surface.
#include "EventCounter.h"
#include "ScratchFolder.h"
#include "TestVolumes.h"
#include "TimeSource.h"

#include "vtkBlockedVolumeReader.h"
#include "vtkStabbingContour.h"

#include "vtkDoubleArray.h"
#include "vtkFieldData.h"
#include "vtkInformation.h"
#include "vtkNew.h"
#include "vtkPartitionedDataSet.h"
#include "vtkPointData.h"
#include "vtkStreamingDemandDrivenPipeline.h"
#include "vtkStringArray.h"

using namespace isosurface;

namespace
{

class TimeSteps : public testing::Test
{
protected:
  TimeSteps()
  {
    this->Source->SetTimes({ -1, 0.5, 2, 7 });
    this->Writer->SetInputConnection(this->Source->GetOutputPort());
    this->Writer->SetFileName(this->Path.c_str());
    this->Writer->SetBlockSize(16);
    this->Writer->SetNumberOfStores(2);
    this->Reader->SetFileName(this->Path.c_str());
    this->Contour->SetInputConnection(this->Reader->GetOutputPort());
    this->Contour->SetValue(0, 12.5);
  }

  // Appends the image of a time.
  bool Append(double time)
  {
    this->Writer->SetAppendTimeStep(true);
    this->Source->UpdateTimeStep(time);
    return this->Writer->Write() == 1;
  }

  std::vector<double> ListTimes()
  {
    this->Reader->Modified();
    this->Reader->UpdateInformation();
    vtkInformation* info = this->Reader->GetOutputInformation(0);
    using Pipeline = vtkStreamingDemandDrivenPipeline;
    if (!info->Has(Pipeline::TIME_STEPS()))
    {
      return {};
    }
    const double* times = info->Get(Pipeline::TIME_STEPS());
    std::vector<double> list(times, times + info->Length(Pipeline::TIME_STEPS()));
    EXPECT_EQ(info->Get(Pipeline::TIME_RANGE())[0], list.front());
    EXPECT_EQ(info->Get(Pipeline::TIME_RANGE())[1], list.back());
    return list;
  }

  // The contour of what is asked for is that of the image of a step, and so is the reader's output.
  void ExpectStep(double asked, double step)
  {
    this->Contour->UpdateTimeStep(asked);
    EdgeSurface surface = ToEdges(this->Contour->GetOutput());
    EXPECT_TRUE(AreEqual(surface, ContourByFlyingEdges(TimeSource::MakeImageAt(step), 12.5)))
      << "time " << asked;
    EXPECT_EQ(
      this->Contour->GetOutput()->GetInformation()->Get(vtkDataObject::DATA_TIME_STEP()), step);

    const auto alone = MakeReader(this->Path);
    alone->UpdateTimeStep(asked);
    auto* image = vtkImageData::SafeDownCast(alone->GetOutput()->GetPartition(0));
    ASSERT_NE(image, nullptr);
    EXPECT_EQ(image->GetPointData()->GetScalars()->GetTuple1(100),
      TimeSource::MakeImageAt(step)->GetPointData()->GetScalars()->GetTuple1(100));
  }

  const ScratchFolder Folder;
  const std::string Path = this->Folder.GetPath("volume.bvol");
  vtkNew<TimeSource> Source;
  vtkNew<vtkBlockedVolumeWriter> Writer;
  vtkNew<vtkBlockedVolumeReader> Reader;
  vtkNew<vtkStabbingContour> Contour;
};

} // namespace

TEST_F(TimeSteps, OfTheInputAreAllWrittenAndReadAtTheTimeAskedFor)
{
  for (const int memoryLimit : { 0, 64 })
  {
    this->Writer->SetMemoryLimit(memoryLimit);
    this->Writer->SetWriteAllTimeSteps(true);
    const ProgressKeeper progress(this->Writer);
    ASSERT_EQ(this->Writer->Write(), 1);
    EXPECT_TRUE(progress.IsRising()) << testing::PrintToString(progress.Shares);
    EXPECT_EQ(this->ListTimes(), (std::vector<double>{ -1, 0.5, 2, 7 }));
    this->ExpectStep(0.5, 0.5);
    this->ExpectStep(7, 7);
    this->ExpectStep(-1, -1);
    // The last one before, as other readers do; the first one before all.
    this->ExpectStep(1.99, 0.5);
    this->ExpectStep(100, 7);
    this->ExpectStep(-5, -1);
  }
}

TEST_F(TimeSteps, OfTheInputAreNotWrittenUnlessAskedFor)
{
  this->Source->UpdateTimeStep(2);
  ASSERT_EQ(this->Writer->Write(), 1);
  EXPECT_EQ(this->ListTimes(), std::vector<double>{ 2 });
  this->ExpectStep(0, 2);
}

TEST_F(TimeSteps, AreSeenWhenAppendedOnceTheReaderIsModified)
{
  std::vector<double> times;
  for (const double time : { -1.0, 0.5, 2.0 })
  {
    ASSERT_TRUE(this->Append(time));
    times.push_back(time);
    EXPECT_EQ(this->ListTimes(), times);
    for (const double step : times)
    {
      this->ExpectStep(step, step);
    }
  }
}

TEST_F(TimeSteps, OfAllOfTheInputAreAppended)
{
  ASSERT_TRUE(this->Append(-1));
  this->Source->SetTimes({ 0.5, 2 });
  this->Writer->SetWriteAllTimeSteps(true);
  ASSERT_EQ(this->Writer->Write(), 1);
  EXPECT_EQ(this->ListTimes(), (std::vector<double>{ -1, 0.5, 2 }));
  this->ExpectStep(1, 0.5);
}

TEST_F(TimeSteps, WithoutATimeCannotBeAppended)
{
  this->Writer->SetInputData(TimeSource::MakeImageAt(0));
  this->Writer->SetAppendTimeStep(true);
  const ErrorCounter errors(this->Writer);
  EXPECT_EQ(this->Writer->Write(), 0);
  ExpectOneError(errors, { "has no time", "--time", "WriteAllTimeSteps" });
}

TEST_F(TimeSteps, InAnotherUnitOfLengthAreErrors)
{
  const auto append = [&](double time, const char* unit)
  {
    const auto image = TimeSource::MakeImageAt(0);
    image->GetInformation()->Set(vtkDataObject::DATA_TIME_STEP(), time);
    vtkNew<vtkStringArray> units;
    units->SetName("PhysicalSizeUnit");
    units->InsertNextValue(unit);
    image->GetFieldData()->AddArray(units);
    this->Writer->SetInputData(image);
    this->Writer->SetAppendTimeStep(true);
    return this->Writer->Write() == 1;
  };
  // One that is not known may be that of the others.
  ASSERT_TRUE(append(0, ""));
  ASSERT_TRUE(append(1, "mm"));
  ASSERT_TRUE(append(2, ""));
  const ErrorCounter errors(this->Writer);
  EXPECT_FALSE(append(3, "m"));
  ExpectOneError(errors, { this->Path, "coordinates are in mm, and not in m" });
}

// As readers of single files give it.
TEST_F(TimeSteps, OfAFieldTimeValueAreAppended)
{
  for (const double time : { 0.5, 2.0 })
  {
    const auto image = TimeSource::MakeImageAt(0);
    vtkNew<vtkDoubleArray> value;
    value->SetName("TimeValue");
    value->InsertNextValue(time);
    image->GetFieldData()->AddArray(value);
    this->Writer->SetInputData(image);
    this->Writer->SetAppendTimeStep(true);
    EXPECT_EQ(this->Writer->Write(), 1);
  }
  EXPECT_EQ(this->ListTimes(), (std::vector<double>{ 0.5, 2.0 }));
}

TEST_F(TimeSteps, StoppedOnTheWayLeaveTheOldFile)
{
  WriteVolume(TimeSource::MakeImageAt(3), this->Path);
  const std::uint64_t before = ComputeFingerprint(this->Path);
  this->Writer->SetWriteAllTimeSteps(true);
  for (const double stop : { 0.1, 0.3, 0.6, 0.9 })
  {
    const ProgressKeeper progress(this->Writer, StopAbove(this->Writer, stop));
    EXPECT_EQ(this->Writer->Write(), 0);
    EXPECT_EQ(ComputeFingerprint(this->Path), before) << stop;
    this->Writer->SetAbortExecute(0);
  }
  ASSERT_EQ(this->Writer->Write(), 1);
  EXPECT_EQ(this->ListTimes().size(), 4u);
}
