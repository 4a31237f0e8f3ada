// SPDX-License-Identifier: BSD-3-Clause
// Slices of a blocked volume and their isolines are those of stock VTK and of the isosurface, on any
// number of ranks.
#include "SampledVolumes.h"

#include "Ground/Base/FileSystem.h"
#include "vtkCommand.h"
#include "vtkDataArray.h"
#include "vtkInformation.h"
#include "vtkInformationVector.h"
#include "vtkMatrix3x3.h"
#include "vtkNew.h"
#include "vtkPointData.h"
#include "vtkPolyData.h"
#include "vtkStabbingContour.h"
#include "vtkStreamingDemandDrivenPipeline.h"
#include "vtkUnsignedCharArray.h"

#include "Ranks/Query/Refinement.h"

#include <cmath>
#include <cstring>
#include <filesystem>
#include <limits>
#include <set>

using namespace isosurface;

namespace
{

// The direction of an axis of an image.
std::array<double, 3> GetDirection(vtkImageData* image, int axis)
{
  vtkMatrix3x3* direction = image->GetDirectionMatrix();
  return { direction->GetElement(0, axis), direction->GetElement(1, axis),
    direction->GetElement(2, axis) };
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

} // namespace

TEST(SlicesOnRanks, SlicesAlongAxesAndObliqueOnesAreThoseOfStock)
{
  for (const int type : { VTK_SHORT, VTK_FLOAT, VTK_UNSIGNED_CHAR })
  {
    const auto image = MakeSampledImage(type);
    const SharedVolume volume("Slices", image, { 16, 3 });
    const auto reader = OpenOnRanks(volume.Path);
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

TEST(SlicesOnRanks, ASliceThroughVerticesHasTheSamplesBitByBit)
{
  const auto image = MakeSampledImage(VTK_FLOAT);
  const SharedVolume volume("VertexSlice", image, { 16, 2 });
  const auto reader = OpenOnRanks(volume.Path);
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

TEST(SlicesOnRanks, IsolinesOfAPlaneThroughVerticesHaveThePointsOfTheIsosurface)
{
  const auto image = MakeImage(SampledExtent, VTK_SHORT, MakeWaves(100));
  image->SetSpacing(0.5, 0.25, 2);
  const SharedVolume volume("Isolines", image, { 16, 3 });
  const auto reader = OpenOnRanks(volume.Path);
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
  const auto contour = MakeContour(image, isovalue);
  contour->SetController(nullptr); // of the image that each rank has, all by itself
  contour->Update();
  vtkPolyData* const surface = contour->GetOutput();
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

TEST(SlicesOnRanks, IsolinesOfAnObliquePlaneDoNotFollowTheFacesOfTheVolume)
{
  // Everything is inside: the isosurface is empty, and the samples around are above the isovalue.
  const auto image =
    MakeImage(SampledExtent, VTK_SHORT, [](int i, int, int) { return i == 0 ? 0 : 200; });
  const SharedVolume volume("BorderIsolines", image, { 16, 3 });
  const auto reader = OpenOnRanks(volume.Path);
  const auto slice = MakeSlice(reader, image, { 1, 2, 3 });
  slice->SetValue(0, 100);
  UpdatePart(slice.Get());
  const std::uint64_t lines =
    SumOverRanks(static_cast<std::uint64_t>(slice->GetIsolines()->GetNumberOfLines()));
  EXPECT_GT(lines, 10u);
  std::set<vtkIdType> used;
  for (vtkIdType cell = 0; cell < slice->GetIsolines()->GetNumberOfCells(); ++cell)
  {
    used.insert(slice->GetIsolines()->GetCell(cell)->GetPointId(0));
    used.insert(slice->GetIsolines()->GetCell(cell)->GetPointId(1));
    // The samples that are below the isovalue are those at x = 0.
    const double* bounds = slice->GetIsolines()->GetCell(cell)->GetBounds();
    ASSERT_LE(std::abs(bounds[0]), 1.5);
  }
  EXPECT_EQ(static_cast<vtkIdType>(used.size()), slice->GetIsolines()->GetNumberOfPoints());
  vtkDataArray* isovalues = slice->GetIsolines()->GetPointData()->GetScalars();
  for (vtkIdType point = 0; point < slice->GetIsolines()->GetNumberOfPoints(); ++point)
  {
    EXPECT_EQ(isovalues->GetTuple1(point), 100);
  }
}

TEST(SlicesOnRanks, IsolinesBesideNaNAreLeftOut)
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
    const auto reader = OpenOnRanks(volume.Path);
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

TEST(SlicesOnRanks, IsolinesOfAnArrayThatIsNotThereAreAWarning)
{
  const auto image = MakeSampledImage(VTK_SHORT);
  const SharedVolume volume("NoIsolines", image, { 16, 3 });
  const auto reader = OpenOnRanks(volume.Path);
  const auto slice = MakeSlice(reader, image, { 1, 2, 3 });
  slice->SetValue(0, 1);
  slice->SetIsolineArray("mass");
  const MessageKeeper warnings(slice, vtkCommand::WarningEvent);
  UpdatePart(slice.Get());
  EXPECT_EQ(SumOverRanks(warnings.Messages.size()), 1u);
  EXPECT_EQ(slice->GetIsolines()->GetNumberOfLines(), 0);
  EXPECT_GT(SumOverRanks(static_cast<std::uint64_t>(slice->GetOutput()->GetNumberOfPoints())), 0u);
}

TEST(SlicesOnRanks, PartsOfAnObliqueSliceHaveTheSameArrays)
{
  const auto image = MakeImage({ 0, 40, 0, 40, 0, 8 }, VTK_FLOAT, MakeWaves());
  const SharedVolume volume("SameArrays", image, { 16, 3 });
  const auto reader = OpenOnRanks(volume.Path);
  const auto slice = MakeSlice(reader, image, { 1, 1, 0 }); // all points are within the volume
  slice->SetOrigin(20, 20, 0);
  UpdatePart(slice.Get());
  if (slice->GetOutput()->GetNumberOfPoints() > 0)
  {
    EXPECT_TRUE(slice->GetOutput()->GetPointGhostArray());
  }
}

TEST(SlicesOnRanks, ALargeSliceIsOfTheFinestLevelThatHasFewEnoughPoints)
{
  const auto image = MakeImage({ 0, 149, 0, 149, 0, 5 }, VTK_FLOAT, MakeWaves());
  const SharedVolume volume("CoarseSlice", image, { 16, 2 });
  const auto reader = OpenOnRanks(volume.Path);
  const auto slice = MakeSlice(reader, image, { 0, 0, 1 });
  slice->SetMaximumPoints(0.01);
  UpdatePart(slice.Get());
  EXPECT_EQ(std::string(slice->GetShownText()), "75 x 75 points, level 1");
  ExpectWhole(
    slice->GetOutput(), SubsampleImage(CutImage(image, { 0, 149, 0, 149, 0, 0 }), 1)->GetExtent());
}

namespace
{

// Until the exact slice is there; returns the stage.
RefinementStage WaitForExact(vtkVolumeSlice* slice)
{
  const auto read = [&] { return Refinement::FromValues(slice->GetRefinement()).Stage; };
  do
  {
    slice->PrepareRefinement(20);
  } while (read() == RefinementStage::Working);
  return read();
}

} // namespace

TEST(SlicesOnRanks, AWindowGetsALargeSliceCoarseFirstAndScriptsGetTheExactOne)
{
  const auto image = MakeImage({ 0, 599, 0, 599, 0, 5 }, VTK_SHORT, MakeWaves(100));
  const SharedVolume volume("WindowSlice", image, { 16, 3 });
  const auto reader = OpenOnRanks(volume.Path);
  const std::string coarse = "150 x 150 points, level 2";
  const std::string exact = "600 x 600 points, full resolution";
  const auto slice = MakeSlice(reader, image, { 0, 0, 1 });
  const auto expect = [&](double z, const std::string& text)
  {
    slice->SetOrigin(0, 0, z);
    UpdatePart(slice.Get());
    EXPECT_EQ(std::string(slice->GetShownText()), text);
    EXPECT_EQ(slice->GetFinal(), text == exact ? 1 : 0);
    if (slice->GetOutput()->GetNumberOfPoints() > 0)
    {
      EXPECT_EQ(slice->GetOutput()->GetBounds()[4], z);
      ExpectStockValues(slice->GetOutput(), image);
    }
  };
  slice->AllowCoarse(1);
  expect(4, coarse);
  slice->AllowCoarse(0);
  expect(4, coarse); // the same slice
  EXPECT_EQ(WaitForExact(slice), RefinementStage::Ready);
  expect(4, coarse);
  slice->Refine();
  expect(4, exact);
  EXPECT_EQ(WaitForExact(slice), RefinementStage::None);

  expect(3, exact);
  slice->AllowCoarse(1);
  for (const double z : { 0, 4 }) // the exact one is being made, or stopped, when another is wanted
  {
    expect(z, coarse);
    slice->PrepareRefinement(0);
  }
  slice->DropRefinement();
  slice->Refine(); // without preparation
  expect(4, exact);
}

TEST(SlicesOnRanks, AreWhatThePipelineIsToldAlsoIfCoarseOnesAreAllowedAfterIt)
{
  const auto image = MakeImage({ 0, 599, 0, 599, 0, 5 }, VTK_SHORT, MakeWaves(100));
  const SharedVolume volume("ToldSlice", image, { 16, 3 });
  const auto slice = MakeSlice(OpenOnRanks(volume.Path), image, { 0, 0, 1 });
  for (const bool isCoarse : { true, false })
  {
    slice->AllowCoarse(isCoarse ? 0 : 1);
    slice->SetOrigin(0, 0, isCoarse ? 3 : 4);
    slice->UpdateInformation();
    slice->AllowCoarse(isCoarse ? 1 : 0);
    UpdatePart(slice.Get());
    EXPECT_EQ(slice->GetFinal(), isCoarse ? 0 : 1);
    vtkInformation* told = slice->GetOutputInformation(0);
    const int* whole = told->Get(vtkStreamingDemandDrivenPipeline::WHOLE_EXTENT());
    EXPECT_EQ(whole[1], isCoarse ? 149 : 599);
    vtkImageData* made = slice->GetOutput();
    if (made->GetNumberOfPoints() > 0)
    {
      EXPECT_EQ(made->GetSpacing()[0], told->Get(vtkDataObject::SPACING())[0]);
      EXPECT_LE(made->GetExtent()[1], whole[1]);
    }
  }
}

TEST(SlicesOnRanks, AnExactSliceThatCannotBeMadeIsAnErrorAfterRefine)
{
  const auto image = MakeImage({ 0, 599, 0, 599, 0, 5 }, VTK_SHORT, MakeWaves(100));
  const SharedVolume volume("LostSlice", image, { 16, 3 });
  const auto reader = OpenOnRanks(volume.Path);
  const auto slice = MakeSlice(reader, image, { 0, 0, 1 });
  slice->AllowCoarse(1);
  slice->SetOrigin(0, 0, 4);
  UpdatePart(slice.Get());
  EXPECT_EQ(slice->GetFinal(), 0);
  OnFirstRank(
    [&]
    {
      std::filesystem::resize_file(
        HidePath(volume.Path + ".stores") + "/000001/store-00002/blocks", 4096);
    });
  EXPECT_EQ(WaitForExact(slice), RefinementStage::Ready);
  slice->Refine();
  const ErrorCounter errors(slice);
  slice->UpdatePiece(GetRank(), GetNumberOfRanks(), 0);
  ExpectOneError(errors, { "store-00002/blocks" });
  EXPECT_EQ(slice->GetOutput()->GetNumberOfPoints(), 0);
  EXPECT_EQ(slice->GetFinal(), 1);
}
