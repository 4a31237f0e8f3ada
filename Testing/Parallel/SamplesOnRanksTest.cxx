// SPDX-License-Identifier: BSD-3-Clause
// Boxes and values at points of a blocked volume are those that stock VTK makes of the whole image,
// and errors are told by all ranks, on any number of them.
#include "RectilinearFixtures.h"
#include "SampledVolumes.h"
#include "TimeSource.h"

#include "vtkVolumeProbe.h"
#include "vtkVolumeRegion.h"

#include "Ground/Base/FileSystem.h"
#include "vtkCommand.h"
#include "vtkCompositeDataSet.h"
#include "vtkDataArray.h"
#include "vtkInformation.h"
#include "vtkMultiBlockDataSet.h"
#include "vtkNew.h"
#include "vtkPointData.h"
#include "vtkPoints.h"
#include "vtkPolyData.h"
#include "vtkRectilinearGrid.h"
#include "vtkStreamingDemandDrivenPipeline.h"

#include <cmath>
#include <filesystem>

using namespace isosurface;

TEST(SamplesOnRanks, WhatLiesBeyondTheLastVerticesOfCoarseLevelsIsShown)
{
  // Coarse levels have no vertices at z = 1.
  const auto image = MakeImage({ 0, 599, 0, 599, 0, 1 }, VTK_FLOAT, MakeWaves());
  const SharedVolume volume("LastVertices", image, { 16, 2 });
  const auto reader = OpenOnRanks(volume.Path);
  const auto slice = MakeSlice(reader, image, { 0, 0, 1 });
  slice->SetOrigin(0, 0, 1);
  slice->SetMaximumPoints(0.1);
  UpdatePart(slice.Get());
  EXPECT_EQ(std::string(slice->GetShownText()), "300 x 300 points, level 1");
  if (slice->GetOutput()->GetNumberOfPoints() > 0)
  {
    ExpectStockValues(slice->GetOutput(), image);
  }
  vtkNew<vtkVolumeRegion> region;
  region->SetInputConnection(reader->GetOutputPort());
  region->SetPosition(0, 0, 1);
  region->SetLength(599, 599, 0);
  region->SetMemoryLimit(1);
  UpdatePart(region.Get());
  const int level = GetNumberOfRanks() > 1 ? 0 : 1;
  ExpectWhole(vtkImageData::SafeDownCast(region->GetOutput()),
    SubsampleImage(CutImage(image, { 0, 599, 0, 599, 0, 0 }), level)->GetExtent());
}

TEST(SamplesOnRanks, OfAGridThatIsSetAreThoseOfTheImageThere)
{
  const auto image = MakeSampledImage(VTK_SHORT);
  const SharedVolume volume("Placed", image, { 16, 3 });
  const auto reader = OpenOnRanks(volume.Path);
  reader->SetSpacing(0.25, 3, 0.5);
  reader->SetOrigin(7, -80, 900);
  image->SetSpacing(0.25, 3, 0.5);
  image->SetOrigin(7, -80, 900);
  const auto slice = MakeSlice(reader, image, { 1, 2, 3 });
  UpdatePart(slice.Get());
  const auto points =
    SumOverRanks(static_cast<std::uint64_t>(slice->GetOutput()->GetNumberOfPoints()));
  EXPECT_GT(points, 100u);
  ExpectStockValues(slice->GetOutput(), image);
  vtkNew<vtkVolumeRegion> region;
  region->SetInputConnection(reader->GetOutputPort());
  double box[6];
  image->GetBounds(box);
  region->SetPosition(box[0], box[2], box[4]);
  region->SetLength(box[1] - box[0], box[3] - box[2], box[5] - box[4]);
  UpdatePart(region.Get());
  ExpectWhole(vtkImageData::SafeDownCast(region->GetOutput()), image->GetExtent());
  vtkNew<vtkPolyData> line;
  line->SetPoints(vtkNew<vtkPoints>());
  for (int point = 0; point < 20; ++point)
  {
    const double* center = image->GetCenter();
    line->GetPoints()->InsertNextPoint(center[0] + 0.1 * point, center[1] + point, center[2]);
  }
  vtkNew<vtkVolumeProbe> probe;
  probe->SetInputConnection(reader->GetOutputPort());
  probe->SetSourceData(line);
  UpdatePart(probe.Get());
  const auto datasets = vtkCompositeDataSet::GetDataSets<vtkDataSet>(probe->GetOutput());
  ASSERT_EQ(datasets.size(), 1u);
  ExpectStockValues(datasets[0], image);
}

TEST(SamplesOnRanks, ABoxHasTheSamplesOfTheImage)
{
  const auto image = MakeSampledImage(VTK_SHORT);
  const SharedVolume volume("Region", image, { 16, 3 });
  const auto reader = OpenOnRanks(volume.Path);
  vtkNew<vtkVolumeRegion> region;
  region->SetInputConnection(reader->GetOutputPort());
  const double* center = image->GetCenter();
  region->SetPosition(center[0] - 7, center[1] - 6, center[2] - 5);
  region->SetLength(14, 9, 8);
  UpdatePart(region.Get());
  auto* part = vtkImageData::SafeDownCast(region->GetOutput());
  ASSERT_TRUE(part);
  const int* whole =
    region->GetOutputInformation(0)->Get(vtkStreamingDemandDrivenPipeline::WHOLE_EXTENT());
  ExpectWhole(part, whole);
  std::size_t wrong = 0;
  for (vtkIdType point = 0; point < part->GetNumberOfPoints(); ++point)
  {
    const vtkIdType same = image->FindPoint(part->GetPoint(point));
    wrong += same < 0 ||
      image->GetPointData()->GetScalars()->GetTuple1(same) !=
        part->GetPointData()->GetScalars()->GetTuple1(point);
  }
  EXPECT_EQ(wrong, 0u);
  // All vertices in the box are there.
  std::size_t left = 0;
  for (int k = SampledExtent[4]; k <= SampledExtent[5]; ++k)
  {
    for (int j = SampledExtent[2]; j <= SampledExtent[3]; ++j)
    {
      for (int i = SampledExtent[0]; i <= SampledExtent[1]; ++i)
      {
        double at[3];
        image->TransformIndexToPhysicalPoint(i, j, k, at);
        bool isInBox = true;
        for (int axis = 0; axis < 3; ++axis)
        {
          isInBox &= at[axis] >= region->GetPosition()[axis] &&
            at[axis] <= region->GetPosition()[axis] + region->GetLength()[axis];
        }
        left += isInBox &&
          (i < whole[0] || i > whole[1] || j < whole[2] || j > whole[3] || k < whole[4] ||
            k > whole[5]);
      }
    }
  }
  EXPECT_EQ(left, 0u);
}

TEST(SamplesOnRanks, ABoxBeyondTheMemoryLimitIsOfACoarserLevel)
{
  const auto image = MakeImage({ 0, 99, 0, 99, 0, 79 }, VTK_FLOAT, MakeWaves());
  const SharedVolume volume("CoarseRegion", image, { 16, 2 });
  const auto reader = OpenOnRanks(volume.Path);
  vtkNew<vtkVolumeRegion> region;
  region->SetInputConnection(reader->GetOutputPort());
  region->SetPosition(0, 0, 0);
  region->SetLength(99, 99, 79);
  region->SetMemoryLimit(1);
  UpdatePart(region.Get());
  const auto coarse = SubsampleImage(image, GetNumberOfRanks() > 3 ? 0 : 1);
  auto* part = vtkImageData::SafeDownCast(region->GetOutput());
  ExpectWhole(part, coarse->GetExtent());
  for (vtkIdType point = 0; point < part->GetNumberOfPoints(); ++point)
  {
    const vtkIdType same = coarse->FindPoint(part->GetPoint(point));
    ASSERT_EQ(coarse->GetPointData()->GetScalars()->GetTuple1(same),
      part->GetPointData()->GetScalars()->GetTuple1(point));
  }
}

TEST(SamplesOnRanks, ABoxOfARectilinearGridIsRectilinear)
{
  const auto image = MakeImage({ 0, 40, 0, 30, 0, 35 }, VTK_FLOAT, MakeWaves());
  const auto grid = MakeLinedGrid(image, 5);
  const SharedFolder folder("LinedRegion");
  OnFirstRank([&] { WriteVolume(grid, folder.GetPath("lined.bvol"), { 16, 2 }); });
  const auto reader = OpenOnRanks(folder.GetPath("lined.bvol"));
  vtkNew<vtkVolumeRegion> region;
  region->SetInputConnection(reader->GetOutputPort());
  double bounds[6];
  grid->GetBounds(bounds);
  region->SetPosition(bounds[0], bounds[2], bounds[4]);
  region->SetLength(
    (bounds[1] - bounds[0]) / 2, (bounds[3] - bounds[2]) / 3, (bounds[5] - bounds[4]) / 2);
  UpdatePart(region.Get());
  auto* part = vtkRectilinearGrid::SafeDownCast(region->GetOutput());
  ASSERT_TRUE(part);
  EXPECT_GT(SumOverRanks(static_cast<std::uint64_t>(part->GetNumberOfPoints())), 1000u);
  for (vtkIdType point = 0; point < part->GetNumberOfPoints(); ++point)
  {
    const vtkIdType same = grid->FindPoint(part->GetPoint(point));
    ASSERT_GE(same, 0);
    ASSERT_EQ(grid->GetPointData()->GetScalars()->GetTuple1(same),
      part->GetPointData()->GetScalars()->GetTuple1(point));
  }
}

TEST(SamplesOnRanks, ValuesAtPointsAreThoseOfStock)
{
  for (const int type : { VTK_SHORT, VTK_DOUBLE })
  {
    const auto image = MakeSampledImage(type);
    const SharedVolume volume("Probe", image, { 16, 3 });
    const auto reader = OpenOnRanks(volume.Path);
    // A spiral of its own for each rank, which reaches beyond the volume, alone and among blocks.
    vtkNew<vtkPoints> points;
    for (int number = 0; number < 5000; ++number)
    {
      const double angle = 0.1 * number;
      const double radius = (number % 50 + GetRank()) * 0.5;
      points->InsertNextPoint(image->GetCenter()[0] + radius * std::cos(angle),
        image->GetCenter()[1] + radius * std::sin(angle),
        image->GetCenter()[2] + 0.004 * (number - 2500));
    }
    vtkNew<vtkPolyData> cloud;
    cloud->SetPoints(points);
    vtkNew<vtkMultiBlockDataSet> blocks;
    blocks->SetBlock(1, cloud);
    for (vtkDataObject* given :
      { static_cast<vtkDataObject*>(cloud), static_cast<vtkDataObject*>(blocks) })
    {
      vtkNew<vtkVolumeProbe> probe;
      probe->SetInputConnection(reader->GetOutputPort());
      probe->SetSourceData(given);
      UpdatePart(probe.Get());
      const auto datasets = vtkCompositeDataSet::GetDataSets<vtkDataSet>(probe->GetOutput());
      ASSERT_EQ(datasets.size(), 1u);
      EXPECT_EQ(datasets[0]->GetNumberOfPoints(), cloud->GetNumberOfPoints());
      ExpectStockValues(datasets[0], image);
      EXPECT_EQ(cloud->GetPointData()->GetArray("density"), nullptr);
    }
  }
}

TEST(SamplesOnRanks, PointsFollowTheTime)
{
  const SharedVolume volume("ProbeTimes", TimeSource::MakeImageAt(0), { 16, 3 });
  const auto reader = OpenOnRanks(volume.Path);
  vtkNew<TimeSource> points;
  points->SetTimes({ 1, 2, 5 });
  vtkNew<vtkVolumeProbe> probe;
  probe->SetInputConnection(reader->GetOutputPort());
  probe->SetSourceConnection(points->GetOutputPort());
  probe->SetController(GetRanks());
  probe->UpdateInformation();
  using Pipeline = vtkStreamingDemandDrivenPipeline;
  vtkInformation* info = probe->GetOutputInformation(0);
  ASSERT_EQ(info->Length(Pipeline::TIME_STEPS()), 3);
  for (const double time : { 1.0, 5.0, 2.0 })
  {
    probe->UpdateTimeStep(time, GetRank(), GetNumberOfRanks(), 0);
    EXPECT_EQ(probe->GetOutput()->GetNumberOfElements(vtkDataObject::POINT),
      points->GetOutput()->GetNumberOfPoints());
    vtkImageData* part = points->GetOutput(); // that was probed
    const auto whole = TimeSource::MakeImageAt(time);
    for (vtkIdType point = 0; point < part->GetNumberOfPoints(); ++point)
    {
      const vtkIdType same = whole->FindPoint(part->GetPoint(point));
      ASSERT_EQ(part->GetPointData()->GetScalars()->GetTuple1(point),
        whole->GetPointData()->GetScalars()->GetTuple1(same));
    }
  }
}

TEST(SamplesOnRanks, WhatIsBesideTheVolumeIsToldByAllAndTheNextRequestSucceeds)
{
  const auto image = MakeSampledImage(VTK_SHORT);
  const SharedVolume volume("Beside", image, { 16, 3 });
  const auto reader = OpenOnRanks(volume.Path);
  const auto slice = MakeSlice(reader, image, { 1, 0, 0 });
  slice->SetOrigin(1e6, 0, 0);
  vtkNew<vtkVolumeRegion> region;
  region->SetInputConnection(reader->GetOutputPort());
  region->SetPosition(1e6, 0, 0);
  const auto update = [](vtkAlgorithm* filter)
  { filter->UpdatePiece(GetRank(), GetNumberOfRanks(), 0); };
  {
    const ErrorCounter ofSlice(slice);
    update(slice);
    ExpectOneError(ofSlice, { volume.Path, "the plane is beside the volume" });
    const ErrorCounter ofRegion(region);
    update(region);
    ExpectOneError(ofRegion, { volume.Path, "the box is beside the volume" });
    EXPECT_STREQ(slice->GetShownText(), "");
    EXPECT_STREQ(region->GetShownText(), "");
  }
  slice->SetOrigin(image->GetCenter());
  UpdatePart(slice.Get());
  EXPECT_GT(SumOverRanks(static_cast<std::uint64_t>(slice->GetOutput()->GetNumberOfPoints())), 0u);
  region->SetPosition(image->GetCenter());
  UpdatePart(region.Get());
  EXPECT_GT(SumOverRanks(static_cast<std::uint64_t>(region->GetOutput()->GetNumberOfPoints())), 0u);
}

TEST(SamplesOnRanks, DataInMemoryIsSentToTheFiltersOfStock)
{
  const auto image = MakeSampledImage(VTK_SHORT);
  vtkNew<vtkVolumeSlice> slice;
  slice->SetInputData(image);
  const ErrorCounter errors(slice);
  slice->UpdatePiece(GetRank(), GetNumberOfRanks(), 0);
  ExpectOneError(errors, { "no blocked volume", "ParaView's Slice" });
}

TEST(SamplesOnRanks, AStoreThatIsLostMeanwhileIsReadElsewhereOrToldByAll)
{
  const auto image = MakeSampledImage(VTK_FLOAT);
  for (const int replicas : { 1, 2 })
  {
    VolumeSettings settings{ 16, 3 };
    settings.NumberOfReplicas = replicas;
    const SharedVolume volume("Lost" + std::to_string(replicas), image, settings);
    const auto reader = OpenOnRanks(volume.Path);
    reader->SetCacheSize(0);
    const auto slice = MakeSlice(reader, image, { 1, 2, 3 });
    UpdatePart(slice.Get());
    OnFirstRank(
      [&]
      {
        std::filesystem::resize_file(
          HidePath(volume.Path + ".stores") + "/000001/store-00002/blocks", 4096);
      });
    slice->SetNormal(1, 2, 4);
    const ErrorCounter errors(slice);
    const MessageKeeper warnings(slice, vtkCommand::WarningEvent);
    slice->UpdatePiece(GetRank(), GetNumberOfRanks(), 0);
    if (replicas == 1)
    {
      ExpectOneError(errors, { "store-00002/blocks" });
      EXPECT_EQ(slice->GetOutput()->GetNumberOfPoints(), 0);
    }
    else
    {
      EXPECT_EQ(errors.Messages, std::vector<std::string>());
      EXPECT_EQ(warnings.Messages.size(), GetRank() == 0 ? 1u : 0u);
      if (slice->GetOutput()->GetNumberOfPoints() > 0)
      {
        ExpectStockValues(slice->GetOutput(), image);
      }
    }
    reader->SetCacheSize(1024);
  }
}
