// SPDX-License-Identifier: BSD-3-Clause
// The surface at a level of detail is that of the subsampled image, whatever the level is stored
// in.
#include "BlockChecks.h"
#include "ScratchFolder.h"
#include "TestVolumes.h"

#include "vtkBlockedVolumeReader.h"
#include "vtkStabbingContour.h"

#include "vtkPartitionedDataSet.h"
#include "vtkPassThrough.h"
#include "vtkPolyData.h"

#include <cmath>

using namespace isosurface;

namespace
{

struct LevelVolume
{
  Extent Bounds;
  int BlockSize;
  int Levels;
};

const LevelVolume Volumes[] = {
  { { -41, 28, -7, 53, -90, -8 }, 16, 2 + 2 + 5 }, // odd lengths, several blocks each way
  { { 0, 128, 3, 67, 5, 100 }, 32, 2 + 6 },        // multiples of the blocks, and others
  { { 0, 150, -1, 1, 0, 34 }, 16, 2 + 2 + 5 },     // thin
  { { 2, 20, 0, 14, 0, 15 }, 32, 6 },              // a single block
};

class StabbingContourLevels : public testing::TestWithParam<LevelVolume>
{
protected:
  StabbingContourLevels()
    : Image(MakeImage(GetParam().Bounds, VTK_SHORT, MakeNoise(200, 3)))
    , Path(Folder.GetPath("volume.bvol"))
  {
    TurnObliquely(this->Image);
    WriteVolume(
      this->Image, this->Path, { GetParam().BlockSize, 3, vtkBlockedVolumeWriter::RANDOM });
  }

  const ScratchFolder Folder;
  const vtkSmartPointer<vtkImageData> Image;
  const std::string Path;
};

TEST_P(StabbingContourLevels, HaveTheSurfaceOfTheSubsampledImage)
{
  vtkNew<vtkBlockedVolumeReader> reader;
  vtkNew<vtkStabbingContour> contour;
  const ExpectNoErrors readerErrors(reader);
  const ExpectNoErrors errors(contour);
  reader->SetFileName(this->Path.c_str());
  contour->SetInputConnection(reader->GetOutputPort());
  contour->SetValue(0, 80);
  for (int level = 0; level < GetParam().Levels; ++level)
  {
    contour->SetLevel(level);
    const EdgeSurface expected = ContourByFlyingEdges(SubsampleImage(this->Image, level), 80);
    for (const int pieces : { 1, 3 })
    {
      EdgeSurface all;
      for (int piece = 0; piece < pieces; ++piece)
      {
        contour->UpdatePiece(piece, pieces, 0);
        all.Add(contour->GetOutput());
        EXPECT_EQ(GetCost(contour->GetOutput(), "Level"), static_cast<std::uint64_t>(level));
      }
      all.MergeEqualPoints();
      EXPECT_TRUE(AreEqual(all, expected)) << "level " << level << ", " << pieces << " pieces";
      EXPECT_TRUE(level > 0 || !all.Triangles.empty());
    }
  }
  contour->SetLevel(40);
  contour->Update();
  EXPECT_EQ(
    GetCost(contour->GetOutput(), "Level"), static_cast<std::uint64_t>(GetParam().Levels - 1))
    << "the coarsest one";
}

TEST_P(StabbingContourLevels, AreThoseOfTheVolumeBehindAFilterThatPassesSamples)
{
  vtkNew<vtkBlockedVolumeReader> reader;
  vtkNew<vtkPassThrough> between;
  vtkNew<vtkStabbingContour> contour;
  const ExpectNoErrors errors(contour);
  reader->SetFileName(this->Path.c_str());
  between->SetInputConnection(reader->GetOutputPort());
  contour->SetInputConnection(between->GetOutputPort());
  contour->SetValue(0, 80);
  for (const int level : { 0, 3, 1, 2 })
  {
    contour->SetLevel(level);
    contour->Update();
    EXPECT_TRUE(IsSurfaceOf(contour->GetOutput(), SubsampleImage(this->Image, level), 80))
      << "level " << level;
    EXPECT_EQ(GetCost(contour->GetOutput(), "Level"), static_cast<std::uint64_t>(level));
  }
}

INSTANTIATE_TEST_SUITE_P(Volumes, StabbingContourLevels, testing::ValuesIn(Volumes));

// The image's own surface without cells at NaN is checked against the stock filter elsewhere.
TEST(StabbingContourLevel, OfAVolumeWithNotANumberHasTheHolesOfItsImage)
{
  const ScratchFolder folder;
  const auto image = MakeImage({ 0, 70, 0, 40, 0, 35 }, VTK_FLOAT,
    [waves = MakeWaves(100.0), noise = MakeNoise(50, 4)](int i, int j, int k) mutable
    { return noise(i, j, k) == 0 ? std::nan("") : waves(i, j, k); });
  WriteVolume(image, folder.GetPath("volume.bvol"), { 16, 3 });
  const auto reader = MakeReader(folder.GetPath("volume.bvol"));
  for (int level = 0; level < 3; ++level)
  {
    vtkNew<vtkStabbingContour> ofImage;
    ofImage->SetInputData(SubsampleImage(image, level));
    vtkNew<vtkStabbingContour> ofVolume;
    ofVolume->SetInputConnection(reader->GetOutputPort());
    ofVolume->SetLevel(level);
    for (vtkStabbingContour* contour : { ofImage.Get(), ofVolume.Get() })
    {
      contour->SetValue(0, 8.5);
      contour->SkipNotANumberOn();
    }
    ofImage->Update();
    const EdgeSurface expected = ToEdges(ofImage->GetOutput());
    EXPECT_FALSE(expected.Triangles.empty());
    for (const int pieces : { 1, 3, 5 })
    {
      EdgeSurface all;
      for (int piece = 0; piece < pieces; ++piece)
      {
        ofVolume->UpdatePiece(piece, pieces, 0);
        all.Add(ofVolume->GetOutput());
      }
      all.MergeEqualPoints();
      EXPECT_TRUE(AreEqual(all, expected)) << "level " << level << ", " << pieces << " pieces";
    }
  }
}

TEST(StabbingContourLevel, IsFullResolutionForImageData)
{
  const auto image = MakeImage({ 0, 20, 0, 20, 0, 20 }, VTK_SHORT, MakeNoise(200, 3));
  const auto contour = MakeContour(image, 80);
  contour->SetLevel(2);
  contour->Update();
  EXPECT_TRUE(IsSurfaceOf(contour->GetOutput(), image, 80));
  EXPECT_EQ(GetCost(contour->GetOutput(), "Level"), 0u);
}

TEST(BlockedVolumeReaderLevels, AreTheSubsampledImageDownToASingleBlock)
{
  // A quarter of a mebibyte at level 2.
  const auto image = MakeImage({ 3, 262, 0, 200, -5, 190 }, VTK_FLOAT, MakeNoise(200, 3));
  const ScratchVolume volume(image, { 32, 4 });
  const auto reader = MakeReader(volume.Path);
  const ExpectNoErrors errors(reader);
  reader->SetMemoryLimit(1);
  for (const int pieces : { 1, 2, 3 })
  {
    std::vector<vtkSmartPointer<vtkPartitionedDataSet>> kept;
    std::vector<vtkPartitionedDataSet*> all;
    for (int piece = 0; piece < pieces; ++piece)
    {
      kept.push_back(ReadPiece(reader, piece, pieces));
      all.push_back(kept.back());
      EXPECT_EQ(reader->GetLevel(), 2);
    }
    const BlockChecks checks{ image, 2 };
    EXPECT_TRUE(checks.HaveValues(all, "density")) << pieces;
    EXPECT_TRUE(checks.HaveEachCellOnce(all)) << pieces;
  }
}

} // namespace
