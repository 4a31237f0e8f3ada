// SPDX-License-Identifier: BSD-3-Clause
// Slices, boxes and values at points of a blocked volume are those that stock VTK makes of the whole
// image, on any number of ranks.
#include "ParallelVolumes.h"
#include "RectilinearFixtures.h"
#include "TimeSource.h"

#include "vtkBlockedVolumeReader.h"
#include "vtkVolumeProbe.h"
#include "vtkVolumeRegion.h"
#include "vtkVolumeSlice.h"

#include "vtkCommand.h"
#include "vtkCompositeDataSet.h"
#include "vtkDataArray.h"
#include "vtkDataSetAttributes.h"
#include "vtkImageData.h"
#include "vtkInformation.h"
#include "vtkInformationVector.h"
#include "vtkMatrix3x3.h"
#include "vtkMultiBlockDataSet.h"
#include "vtkMultiProcessController.h"
#include "vtkNew.h"
#include "vtkPointData.h"
#include "vtkPoints.h"
#include "vtkPolyData.h"
#include "vtkProbeFilter.h"
#include "vtkRectilinearGrid.h"
#include "vtkStreamingDemandDrivenPipeline.h"
#include "vtkUnsignedCharArray.h"

#include <cmath>
#include <cstring>
#include <filesystem>
#include <limits>
#include <set>
#include <string>

using namespace isosurface;

namespace
{

constexpr Extent SampledExtent = { -4, 60, 3, 35, 0, 49 };

vtkSmartPointer<vtkImageData> MakeSampledImage(int type)
{
  auto image = MakeImage(SampledExtent, type, MakeWaves(100));
  TurnObliquely(image);
  return image;
}

// Brings this rank's part up to date; a test fails if there is an error.
template <typename Filter>
void UpdatePart(Filter* filter)
{
  const ExpectNoErrors errors(filter);
  filter->SetController(GetRanks());
  filter->UpdatePiece(GetRank(), GetNumberOfRanks(), 0);
}

vtkSmartPointer<vtkVolumeSlice> MakeSlice(
  vtkBlockedVolumeReader* reader, vtkImageData* image, const std::array<double, 3>& normal)
{
  auto slice = vtkSmartPointer<vtkVolumeSlice>::New();
  slice->SetInputConnection(reader->GetOutputPort());
  // Off the middle, where values would be halfway between two integers.
  const double* center = image->GetCenter();
  slice->SetOrigin(center[0] + 0.31, center[1] + 0.17, center[2] + 0.23);
  slice->SetNormal(normal.data());
  return slice;
}

// The direction of an axis of an image.
std::array<double, 3> GetDirection(vtkImageData* image, int axis)
{
  vtkMatrix3x3* direction = image->GetDirectionMatrix();
  return { direction->GetElement(0, axis), direction->GetElement(1, axis),
    direction->GetElement(2, axis) };
}

// Whether our filters say that a point is beyond the volume.
bool IsOutside(vtkDataSet* dataset, vtkIdType point)
{
  vtkDataArray* mask = dataset->GetPointData()->GetArray("vtkValidPointMask");
  if (mask && mask->GetTuple1(point) == 0)
  {
    return true;
  }
  vtkUnsignedCharArray* ghosts = dataset->GetPointGhostArray();
  return ghosts && (ghosts->GetValue(point) & vtkDataSetAttributes::HIDDENPOINT) != 0;
}

// Expects in `values` what vtkProbeFilter finds in the image at the same points. Integers may differ
// by 1 where the value is halfway between two.
void ExpectStockValues(vtkDataSet* points, vtkImageData* image)
{
  vtkNew<vtkProbeFilter> probe;
  probe->SetInputData(points);
  probe->SetSourceData(image);
  probe->Update();
  vtkDataArray* mine = points->GetPointData()->GetArray("density");
  vtkDataArray* stock = probe->GetOutput()->GetPointData()->GetArray("density");
  vtkDataArray* mask = probe->GetOutput()->GetPointData()->GetArray("vtkValidPointMask");
  ASSERT_TRUE(mine && stock && mask);
  EXPECT_EQ(mine->GetDataType(), stock->GetDataType());
  const bool isInteger = mine->GetDataTypeSize() < 4;
  const double tolerance = isInteger ? 1 : 1e-3;
  std::size_t wrong = 0;
  std::size_t unlike = 0;
  vtkIdType compared = 0;
  for (vtkIdType point = 0; point < points->GetNumberOfPoints(); ++point)
  {
    // On the faces of the volume stock takes points that are off by a hundredth of a cell, or leaves
    // out those that are off by a rounding error.
    if (mask->GetTuple1(point) == 1 && !IsOutside(points, point))
    {
      const double difference = std::abs(mine->GetTuple1(point) - stock->GetTuple1(point));
      wrong += difference > tolerance;
      unlike += difference > 1e-3;
      ++compared;
    }
  }
  EXPECT_EQ(wrong, 0u);
  EXPECT_LT(unlike, 1 + compared / 20) << "values that are not halfway between integers";
  EXPECT_GE(compared, points->GetNumberOfPoints() / 3);
}

// Collective: the cells of all parts are those of an image of this many points.
void ExpectWhole(vtkImageData* part, const int* whole)
{
  const std::uint64_t cells = SumOverRanks(
    part->GetNumberOfPoints() > 0 ? static_cast<std::uint64_t>(part->GetNumberOfCells()) : 0);
  std::uint64_t expected = 1;
  for (int axis = 0; axis < 3; ++axis)
  {
    expected *= static_cast<std::uint64_t>(std::max(1, whole[2 * axis + 1] - whole[2 * axis]));
  }
  EXPECT_EQ(cells, expected);
}

} // namespace

TEST(SamplesOnRanks, SlicesAlongAxesAndObliqueOnesAreThoseOfStock)
{
  for (const int type : { VTK_SHORT, VTK_FLOAT, VTK_UNSIGNED_CHAR })
  {
    const auto image = MakeSampledImage(type);
    const SharedVolume volume("Slices", image, { 16, 3 });
    const auto reader = MakeReader(volume.Path);
    reader->SetController(GetRanks());
    std::vector<std::array<double, 3>> normals = { { 1, 2, 3 }, { -0.2, 0.9, 0.1 } };
    for (int axis = 0; axis < 3; ++axis)
    {
      normals.push_back(GetDirection(image, axis));
    }
    for (const auto& normal : normals)
    {
      const auto slice = MakeSlice(reader, image, normal);
      UpdatePart(slice.Get());
      ExpectWhole(slice->GetOutput(),
        slice->GetOutputInformation(0)->Get(vtkStreamingDemandDrivenPipeline::WHOLE_EXTENT()));
      if (slice->GetOutput()->GetNumberOfPoints() > 0)
      {
        ExpectStockValues(slice->GetOutput(), image);
      }
    }
  }
}

TEST(SamplesOnRanks, ASliceThroughVerticesHasTheSamplesBitByBit)
{
  const auto image = MakeSampledImage(VTK_FLOAT);
  const SharedVolume volume("VertexSlice", image, { 16, 2 });
  const auto reader = MakeReader(volume.Path);
  reader->SetController(GetRanks());
  for (const int interpolation : { vtkVolumeSlice::NEAREST, vtkVolumeSlice::LINEAR })
  {
    const auto slice = MakeSlice(reader, image, GetDirection(image, 2));
    double point[3];
    image->TransformIndexToPhysicalPoint(0, 0, 17, point);
    slice->SetOrigin(point);
    slice->SetInterpolation(interpolation);
    UpdatePart(slice.Get());
    const int* extent = slice->GetOutput()->GetExtent();
    std::size_t wrong = 0;
    for (int j = extent[2]; j <= extent[3]; ++j)
    {
      for (int i = extent[0]; i <= extent[1]; ++i)
      {
        wrong += slice->GetOutput()->GetScalarComponentAsDouble(i, j, 0, 0) !=
          image->GetScalarComponentAsDouble(i, j, 17, 0);
      }
    }
    EXPECT_EQ(wrong, 0u);
  }
}

// The points of lines that have cells, as bytes to compare; those of all ranks, on rank 0.
std::set<std::array<float, 3>> GatherPoints(const std::set<std::array<float, 3>>& mine)
{
  std::string text;
  for (const auto& point : mine)
  {
    text.append(reinterpret_cast<const char*>(point.data()), sizeof(point));
  }
  std::set<std::array<float, 3>> all;
  for (const std::string& part : GatherTexts(text))
  {
    for (std::size_t at = 0; at < part.size(); at += sizeof(std::array<float, 3>))
    {
      std::array<float, 3> point{};
      std::memcpy(point.data(), &part[at], sizeof(point));
      all.insert(point);
    }
  }
  return all;
}

TEST(SamplesOnRanks, IsolinesOfAPlaneThroughVerticesHaveThePointsOfTheIsosurface)
{
  const auto image = MakeImage(SampledExtent, VTK_SHORT, MakeWaves(100));
  image->SetSpacing(0.5, 0.25, 2);
  const SharedVolume volume("Isolines", image, { 16, 3 });
  const auto reader = MakeReader(volume.Path);
  reader->SetController(GetRanks());
  constexpr double isovalue = 17;
  constexpr double z = 34; // slice 17
  const auto slice = MakeSlice(reader, image, { 0, 0, 1 });
  slice->SetOrigin(0, 0, z);
  slice->SetValue(0, isovalue);
  slice->SetController(GetRanks());
  // Whoever takes the isolines alone gets those of this rank's part.
  using Pipeline = vtkStreamingDemandDrivenPipeline;
  vtkNew<vtkInformationVector> requests;
  for (int port = 0; port < 2; ++port)
  {
    vtkNew<vtkInformation> request;
    request->Set(Pipeline::UPDATE_PIECE_NUMBER(), GetRank());
    request->Set(Pipeline::UPDATE_NUMBER_OF_PIECES(), GetNumberOfRanks());
    requests->SetInformationObject(
      port, port == 1 ? request.Get() : vtkNew<vtkInformation>().Get());
  }
  slice->Update(1, requests);
  std::set<std::array<float, 3>> mine;
  for (vtkIdType point = 0; point < slice->GetIsolines()->GetNumberOfPoints(); ++point)
  {
    const double* at = slice->GetIsolines()->GetPoint(point);
    mine.insert(
      { static_cast<float>(at[0]), static_cast<float>(at[1]), static_cast<float>(at[2]) });
  }
  std::set<std::array<float, 3>> ofSurface;
  const auto surface = Contour(image, { isovalue });
  for (vtkIdType point = 0; point < surface->GetNumberOfPoints(); ++point)
  {
    const double* at = surface->GetPoint(point);
    if (at[2] == z)
    {
      ofSurface.insert(
        { static_cast<float>(at[0]), static_cast<float>(at[1]), static_cast<float>(at[2]) });
    }
  }
  EXPECT_GT(ofSurface.size(), 200u);
  EXPECT_EQ(GatherPoints(mine), ofSurface);
}

TEST(SamplesOnRanks, IsolinesOfAnObliquePlaneDoNotFollowTheFacesOfTheVolume)
{
  // Everything is inside: the isosurface is empty, and the samples around are above the isovalue.
  const auto image =
    MakeImage(SampledExtent, VTK_SHORT, [](int i, int, int) { return i == 0 ? 0 : 200; });
  const SharedVolume volume("BorderIsolines", image, { 16, 3 });
  const auto reader = MakeReader(volume.Path);
  reader->SetController(GetRanks());
  const auto slice = MakeSlice(reader, image, { 1, 2, 3 });
  slice->SetValue(0, 100);
  UpdatePart(slice.Get());
  const std::uint64_t lines =
    SumOverRanks(static_cast<std::uint64_t>(slice->GetIsolines()->GetNumberOfLines()));
  EXPECT_GT(lines, 10u);
  for (vtkIdType cell = 0; cell < slice->GetIsolines()->GetNumberOfCells(); ++cell)
  {
    // The samples that are below the isovalue are those at x = 0.
    const double* bounds = slice->GetIsolines()->GetCell(cell)->GetBounds();
    ASSERT_LE(std::abs(bounds[0]), 1.5);
  }
}

TEST(SamplesOnRanks, IsolinesBesideNaNAreLeftOut)
{
  const auto makeImage = [](float above)
  {
    return MakeImage({ 0, 40, 0, 40, 0, 1 }, VTK_FLOAT,
      [above](int i, int j, int) -> float { return i > 30 ? above : static_cast<float>(i + j); });
  };
  std::uint64_t lines[2];
  int number = 0;
  for (const float above : { 100.0F, std::numeric_limits<float>::quiet_NaN() })
  {
    const SharedVolume volume("NaNIsolines" + std::to_string(number), makeImage(above), { 16, 3 });
    const auto reader = MakeReader(volume.Path);
    reader->SetController(GetRanks());
    const auto slice = MakeSlice(reader, makeImage(above), { 0, 0, 1 });
    slice->SetOrigin(0, 0, 0);
    slice->SetValue(0, 10.5); // crosses i + j far from i = 30, and between 30 and NaN
    UpdatePart(slice.Get());
    for (vtkIdType cell = 0; cell < slice->GetIsolines()->GetNumberOfCells(); ++cell)
    {
      EXPECT_LT(slice->GetIsolines()->GetCell(cell)->GetBounds()[1], 11);
    }
    lines[number++] =
      SumOverRanks(static_cast<std::uint64_t>(slice->GetIsolines()->GetNumberOfCells()));
  }
  EXPECT_GT(lines[0], 10u);
  EXPECT_EQ(lines[0], lines[1]);
}

TEST(SamplesOnRanks, IsolinesOfAnArrayThatIsNotThereAreAWarning)
{
  const auto image = MakeSampledImage(VTK_SHORT);
  const SharedVolume volume("NoIsolines", image, { 16, 3 });
  const auto reader = MakeReader(volume.Path);
  reader->SetController(GetRanks());
  const auto slice = MakeSlice(reader, image, { 1, 2, 3 });
  slice->SetValue(0, 1);
  slice->SetIsolineArray("mass");
  const MessageKeeper warnings(slice, vtkCommand::WarningEvent);
  UpdatePart(slice.Get());
  EXPECT_EQ(SumOverRanks(warnings.Messages.size()), 1u);
  EXPECT_EQ(slice->GetIsolines()->GetNumberOfLines(), 0);
  EXPECT_GT(SumOverRanks(static_cast<std::uint64_t>(slice->GetOutput()->GetNumberOfPoints())), 0u);
}

TEST(SamplesOnRanks, PartsOfAnObliqueSliceHaveTheSameArrays)
{
  const auto image = MakeImage({ 0, 40, 0, 40, 0, 8 }, VTK_FLOAT, MakeWaves());
  const SharedVolume volume("SameArrays", image, { 16, 3 });
  const auto reader = MakeReader(volume.Path);
  reader->SetController(GetRanks());
  const auto slice = MakeSlice(reader, image, { 1, 1, 0 }); // all points are within the volume
  slice->SetOrigin(20, 20, 0);
  UpdatePart(slice.Get());
  if (slice->GetOutput()->GetNumberOfPoints() > 0)
  {
    EXPECT_TRUE(slice->GetOutput()->GetPointGhostArray());
  }
}

TEST(SamplesOnRanks, ALargeSliceIsOfTheFinestLevelThatHasFewEnoughPoints)
{
  const auto image = MakeImage({ 0, 149, 0, 149, 0, 5 }, VTK_FLOAT, MakeWaves());
  const SharedVolume volume("CoarseSlice", image, { 16, 2 });
  const auto reader = MakeReader(volume.Path);
  reader->SetController(GetRanks());
  const auto slice = MakeSlice(reader, image, { 0, 0, 1 });
  slice->SetMaximumPoints(0.01);
  UpdatePart(slice.Get());
  EXPECT_EQ(std::string(slice->GetShownText()), "75 x 75 points, level 1");
  ExpectWhole(
    slice->GetOutput(), SubsampleImage(CutImage(image, { 0, 149, 0, 149, 0, 0 }), 1)->GetExtent());
}

TEST(SamplesOnRanks, WhatLiesBeyondTheLastVerticesOfCoarseLevelsIsShown)
{
  // Coarse levels have no vertices at z = 1.
  const auto image = MakeImage({ 0, 599, 0, 599, 0, 1 }, VTK_FLOAT, MakeWaves());
  const SharedVolume volume("LastVertices", image, { 16, 2 });
  const auto reader = MakeReader(volume.Path);
  reader->SetController(GetRanks());
  const auto slice = MakeSlice(reader, image, { 0, 0, 1 });
  slice->SetOrigin(0, 0, 1);
  slice->SetMaximumPoints(0.1);
  UpdatePart(slice.Get());
  EXPECT_EQ(std::string(slice->GetShownText()), "600 x 600 points, full resolution");
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

TEST(SamplesOnRanks, ABoxHasTheSamplesOfTheImage)
{
  const auto image = MakeSampledImage(VTK_SHORT);
  const SharedVolume volume("Region", image, { 16, 3 });
  const auto reader = MakeReader(volume.Path);
  reader->SetController(GetRanks());
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
  const auto reader = MakeReader(volume.Path);
  reader->SetController(GetRanks());
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
  const auto reader = MakeReader(folder.GetPath("lined.bvol"));
  reader->SetController(GetRanks());
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
    const auto reader = MakeReader(volume.Path);
    reader->SetController(GetRanks());
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
  const auto reader = MakeReader(volume.Path);
  reader->SetController(GetRanks());
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
  const auto reader = MakeReader(volume.Path);
  reader->SetController(GetRanks());
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
    const auto reader = MakeReader(volume.Path);
    reader->SetController(GetRanks());
    reader->SetCacheSize(0);
    const auto slice = MakeSlice(reader, image, { 1, 2, 3 });
    UpdatePart(slice.Get());
    OnFirstRank([&]
      { std::filesystem::resize_file(volume.Path + ".stores/000001/store-00002/blocks", 4096); });
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
