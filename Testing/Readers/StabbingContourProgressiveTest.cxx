// SPDX-License-Identifier: BSD-3-Clause
// A coarse surface first, finer ones on request, the full one last.
#include "ScratchFolder.h"
#include "TestVolumes.h"

#include "vtkBlockedVolumeReader.h"
#include "vtkStabbingContour.h"

#include "vtkPassThrough.h"
#include "vtkPolyData.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <vector>

namespace isosurface
{
namespace
{

class StabbingContourProgressive : public testing::Test
{
protected:
  StabbingContourProgressive()
    : Image(MakeImage({ -3, 130, 0, 120, 5, 111 }, VTK_FLOAT, MakeWaves()))
    , Path(Folder.GetPath("volume.bvol"))
    , ReaderErrors(Reader)
    , Errors(Contour)
  {
    WriteVolume(this->Image, this->Path, { 16, 3 });
    this->Reader->SetFileName(this->Path.c_str());
    this->Contour->SetInputConnection(this->Reader->GetOutputPort());
    this->Contour->SetValue(0, 0.3);
    this->Contour->ProgressiveOn();
  }

  int GetLevel() { return static_cast<int>(GetCost(this->Contour->GetOutput(), "Level")); }

  /// The levels of all executions from now on until the surface is final.
  std::vector<int> FinishLevels()
  {
    std::vector<int> levels;
    this->Contour->Update();
    levels.push_back(this->GetLevel());
    while (!this->Contour->GetFinal() && levels.size() < 20)
    {
      this->Contour->Refine();
      this->Contour->Update();
      levels.push_back(this->GetLevel());
    }
    return levels;
  }

  void ExpectSurfaceOfItsLevel(double isovalue)
  {
    EdgeSurface surface;
    surface.Add(this->Contour->GetOutput());
    EXPECT_TRUE(AreEqual(
      surface, ContourByFlyingEdges(SubsampleImage(this->Image, this->GetLevel()), isovalue)))
      << "level " << this->GetLevel();
  }

  void ExpectNoErrors()
  {
    EXPECT_EQ(this->ReaderErrors.Messages, std::vector<std::string>());
    EXPECT_EQ(this->Errors.Messages, std::vector<std::string>());
  }

  const ScratchFolder Folder;
  const vtkSmartPointer<vtkImageData> Image;
  const std::string Path;
  vtkNew<vtkBlockedVolumeReader> Reader;
  vtkNew<vtkStabbingContour> Contour;
  const ErrorCounter ReaderErrors;
  ErrorCounter Errors;
};

TEST_F(StabbingContourProgressive, GoesFromACoarseSurfaceToTheFullOne)
{
  this->Contour->Update();
  EXPECT_FALSE(this->Contour->GetFinal());
  const vtkIdType first = this->Contour->GetOutput()->GetNumberOfPolys();
  EXPECT_GT(first, 0);
  int level = this->GetLevel();
  this->ExpectSurfaceOfItsLevel(0.3);
  while (!this->Contour->GetFinal())
  {
    this->Contour->Refine();
    this->Contour->Update();
    ASSERT_LT(this->GetLevel(), level);
    level = this->GetLevel();
    this->ExpectSurfaceOfItsLevel(0.3);
  }
  EXPECT_EQ(level, 0);
  EXPECT_LE(20 * first, this->Contour->GetOutput()->GetNumberOfPolys());

  const vtkMTimeType time = this->Contour->GetMTime();
  this->Contour->Refine();
  EXPECT_EQ(this->Contour->GetMTime(), time) << "nothing is finer";
  this->ExpectNoErrors();
}

TEST_F(StabbingContourProgressive, BeginsAnewAfterEachChange)
{
  const std::vector<int> levels = this->FinishLevels();
  ASSERT_GE(levels.size(), 3u);
  this->Contour->SetValue(0, 0.25);
  EXPECT_EQ(this->FinishLevels(), levels);

  this->Contour->SetValue(0, 0.3);
  this->Contour->Update();
  this->Contour->Refine();
  this->Contour->SetValue(0, 0.25);
  this->Contour->Update();
  EXPECT_EQ(this->GetLevel(), levels.front()) << "a change between Refine and Update";
  this->ExpectSurfaceOfItsLevel(0.25);

  this->Contour->Refine();
  this->Contour->Refine();
  this->Contour->Update();
  EXPECT_EQ(this->GetLevel(), levels[1]) << "two requests before one execution";

  this->Contour->SetLevel(1);
  const std::vector<int> coarser = this->FinishLevels();
  EXPECT_EQ(coarser.back(), 1);
  EXPECT_GT(coarser.size(), 1u);

  const std::string other = this->Folder.GetPath("other.bvol");
  WriteVolume(this->Image, other, { 16, 2 });
  this->Reader->SetFileName(other.c_str());
  EXPECT_EQ(this->FinishLevels(), coarser) << "another volume";
  this->ExpectNoErrors();
}

TEST_F(StabbingContourProgressive, EndsWhereABudgetEnds)
{
  const std::vector<int> levels = this->FinishLevels();
  this->Contour->SetMaximumTriangles(this->Contour->GetOutput()->GetNumberOfPolys() / 2);
  const std::vector<int> within = this->FinishLevels();
  EXPECT_EQ(within.front(), levels.front());
  EXPECT_EQ(within.back(), 1);
  EXPECT_LE(this->Contour->GetOutput()->GetNumberOfPolys(), this->Contour->GetMaximumTriangles());
  this->ExpectSurfaceOfItsLevel(0.3);

  this->Contour->SetMaximumTriangles(1);
  const std::vector<int> coarsest = this->FinishLevels();
  EXPECT_EQ(coarsest.size(), 1u);
  EXPECT_GT(coarsest.front(), levels.front());
  this->ExpectNoErrors();
}

TEST_F(StabbingContourProgressive, GivesAllPiecesOfAPassAtOneLevel)
{
  this->Contour->Update();
  const int first = this->GetLevel();
  do
  {
    EdgeSurface all;
    const int level = this->GetLevel();
    for (int piece = 0; piece < 3; ++piece)
    {
      this->Contour->UpdatePiece(piece, 3, 0);
      EXPECT_EQ(this->GetLevel(), level);
      all.Add(this->Contour->GetOutput());
    }
    all.MergeEqualPoints();
    EXPECT_TRUE(AreEqual(all, ContourByFlyingEdges(SubsampleImage(this->Image, level), 0.3)));
    this->Contour->Refine();
    this->Contour->UpdatePiece(0, 1, 0);
  } while (!this->Contour->GetFinal());
  EXPECT_GT(first, this->GetLevel());
  this->ExpectNoErrors();
}

TEST_F(StabbingContourProgressive, IsFinalAtOnceWhereItCannotBeProgressive)
{
  this->Contour->ProgressiveOff();
  this->Contour->Update();
  EXPECT_TRUE(this->Contour->GetFinal());
  EXPECT_EQ(this->GetLevel(), 0);

  this->Contour->ProgressiveOn();
  this->Contour->SetLevel(64);
  this->Contour->Update();
  EXPECT_TRUE(this->Contour->GetFinal()) << "nothing is coarser";
  this->Contour->SetLevel(0);

  this->Contour->SetInputData(this->Image);
  this->Contour->Update();
  EXPECT_TRUE(this->Contour->GetFinal()) << "image data";
  this->ExpectSurfaceOfItsLevel(0.3);

  vtkNew<vtkPassThrough> between;
  between->SetInputConnection(this->Reader->GetOutputPort());
  this->Contour->SetInputConnection(between->GetOutputPort());
  this->Contour->Update();
  EXPECT_FALSE(this->Contour->GetFinal()) << "a filter that passes samples on";
  this->ExpectNoErrors();
}

TEST_F(StabbingContourProgressive, TellsOfADamagedSpectrumAndGoesOnAfterItsRepair)
{
  this->Reader->UpdateInformation();
  std::filesystem::path spectra;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(this->Path + ".stores"))
  {
    if (entry.path().filename() == "spectra" && spectra.empty())
    {
      spectra = entry.path();
    }
  }
  ASSERT_FALSE(spectra.empty());
  const std::string bytes = ReadBytes(spectra.string());
  Truncate(spectra.string(), bytes.size() / 2);
  this->Contour->Update();
  ASSERT_EQ(this->Errors.Messages.size(), 1u);
  EXPECT_NE(this->Errors.Messages[0].find("spectra"), std::string::npos);
  EXPECT_TRUE(this->Contour->GetFinal()) << "there is nothing to refine";
  EXPECT_EQ(this->Contour->GetOutput()->GetNumberOfPolys(), 0);

  WriteBytes(spectra.string(), bytes);
  this->Errors.Messages.clear();
  this->Contour->Modified();
  EXPECT_EQ(this->FinishLevels().back(), 0);
  this->ExpectSurfaceOfItsLevel(0.3);
  this->ExpectNoErrors();
}

} // namespace
} // namespace isosurface
