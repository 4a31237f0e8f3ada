// SPDX-License-Identifier: BSD-3-Clause
// A coarse surface first, finer ones on request, the full one last.
#include "EventCounter.h"
#include "ScratchFolder.h"
#include "TestVolumes.h"

#include "vtkBlockedVolumeReader.h"
#include "vtkStabbingContour.h"

#include "Ground/Base/FileSystem.h"
#include "Ranks/Query/Refinement.h"
#include "vtkCellArray.h"
#include "vtkDataArray.h"
#include "vtkPassThrough.h"
#include "vtkPointData.h"
#include "vtkPoints.h"
#include "vtkPolyData.h"

#include <gtest/gtest.h>

#include <cstring>
#include <filesystem>
#include <string>
#include <vector>

using namespace isosurface;

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

  /// Works beside this thread until the stage is another one than that of work.
  RefinementStage PrepareToTheEnd()
  {
    do
    {
      this->Contour->PrepareRefinement(5);
    } while (this->GetStage() == RefinementStage::Working);
    return this->GetStage();
  }
  Refinement GetRefinement() { return Refinement::FromValues(this->Contour->GetRefinement()); }
  RefinementStage GetStage() { return this->GetRefinement().Stage; }

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
    EXPECT_TRUE(IsSurfaceOf(
      this->Contour->GetOutput(), SubsampleImage(this->Image, this->GetLevel()), isovalue))
      << "level " << this->GetLevel();
  }

  static testing::AssertionResult AreBitwiseEqual(vtkPolyData* surface, vtkPolyData* expected)
  {
    const auto same = [](vtkDataArray* a, vtkDataArray* b)
    {
      return a && b && a->GetDataType() == b->GetDataType() &&
        a->GetNumberOfValues() == b->GetNumberOfValues() &&
        std::memcmp(a->GetVoidPointer(0), b->GetVoidPointer(0),
          static_cast<std::size_t>(a->GetNumberOfValues() * a->GetDataTypeSize())) == 0;
    };
    vtkPointData* arrays = surface->GetPointData();
    vtkPointData* others = expected->GetPointData();
    const bool equal = same(surface->GetPoints()->GetData(), expected->GetPoints()->GetData()) &&
      same(arrays->GetNormals(), others->GetNormals()) &&
      same(arrays->GetGlobalIds(), others->GetGlobalIds()) &&
      same(arrays->GetScalars(), others->GetScalars()) &&
      same(surface->GetPolys()->GetConnectivityArray(),
        expected->GetPolys()->GetConnectivityArray()) &&
      same(surface->GetPolys()->GetOffsetsArray(), expected->GetPolys()->GetOffsetsArray());
    return equal ? testing::AssertionSuccess() : testing::AssertionFailure() << "bits differ";
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

TEST_F(StabbingContourProgressive, ExtractsBesideAndThenTakesTheSameSurface)
{
  const auto atOnce = MakeContour(this->Reader, 0.3);
  const ProgressKeeper extraction(atOnce);
  atOnce->Update();
  ASSERT_GT(extraction.Shares.size(), 10u);
  int passes = 0;
  for (this->Contour->Update(); !this->Contour->GetFinal(); ++passes)
  {
    const vtkMTimeType filter = this->Contour->GetMTime();
    const vtkMTimeType output = this->Contour->GetOutput()->GetMTime();
    ASSERT_EQ(this->PrepareToTheEnd(), RefinementStage::Ready);
    EXPECT_EQ(this->GetRefinement().Share, 1);
    const int next = this->GetRefinement().NextLevel;
    this->Contour->Update();
    EXPECT_EQ(this->Contour->GetMTime(), filter) << "what is shown has not changed";
    EXPECT_EQ(this->Contour->GetOutput()->GetMTime(), output);

    this->Contour->Refine();
    const ProgressKeeper progress(this->Contour);
    this->Contour->Update();
    EXPECT_EQ(this->GetLevel(), next);
    for (const double share : progress.Shares)
    {
      EXPECT_TRUE(share == 0 || share == 1) << "something was extracted anew";
    }
  }
  EXPECT_GT(passes, 0);
  EXPECT_TRUE(AreBitwiseEqual(this->Contour->GetOutput(), atOnce->GetOutput()));
  this->ExpectSurfaceOfItsLevel(0.3);
  EXPECT_EQ(this->PrepareToTheEnd(), RefinementStage::None);
  this->ExpectNoErrors();
}

TEST_F(StabbingContourProgressive, DropsWhatAChangeHasMadeUseless)
{
  this->Contour->Update();
  this->Contour->PrepareRefinement(0);
  EXPECT_NE(this->GetStage(), RefinementStage::None);
  this->Contour->SetValue(0, 0.25);
  this->Contour->PrepareRefinement(0);
  EXPECT_EQ(this->GetStage(), RefinementStage::None) << "changed, and not executed yet";
  this->Contour->Update();
  EXPECT_FALSE(this->Contour->GetFinal());
  this->ExpectSurfaceOfItsLevel(0.25);

  // A change while a finished surface waits to be taken.
  ASSERT_EQ(this->PrepareToTheEnd(), RefinementStage::Ready);
  this->Contour->Refine();
  this->Contour->SetValue(0, 0.3);
  this->Contour->Update();
  this->ExpectSurfaceOfItsLevel(0.3);

  ASSERT_EQ(this->PrepareToTheEnd(), RefinementStage::Ready);
  this->Contour->DropRefinement();
  EXPECT_EQ(this->FinishLevels().back(), 0) << "Refine extracts what is not prepared";
  this->ExpectSurfaceOfItsLevel(0.3);
  this->ExpectNoErrors();
}

TEST_F(StabbingContourProgressive, AllowsCoarseSurfacesForAWhile)
{
  this->Contour->ProgressiveOff();
  this->Contour->Update();
  EXPECT_TRUE(this->Contour->GetFinal());
  const vtkMTimeType time = this->Contour->GetMTime();
  this->Contour->AllowCoarse(1);
  EXPECT_EQ(this->Contour->GetMTime(), time);
  this->Contour->UpdatePiece(0, 2, 0);
  EXPECT_EQ(this->GetLevel(), 0) << "nothing has changed";

  this->Contour->SetValue(0, 0.25);
  this->Contour->Update();
  this->Contour->AllowCoarse(0);
  EXPECT_FALSE(this->Contour->GetFinal());
  const int first = this->GetLevel();
  EXPECT_GT(first, 0);
  this->Contour->UpdatePiece(0, 2, 0);
  EXPECT_EQ(this->GetLevel(), first) << "all consumers get the same level";
  this->Contour->UpdatePiece(0, 1, 0);
  EXPECT_EQ(this->FinishLevels().back(), 0);
  this->ExpectSurfaceOfItsLevel(0.25);

  this->Contour->SetValue(0, 0.3);
  this->Contour->Update();
  EXPECT_TRUE(this->Contour->GetFinal()) << "no longer allowed";
  this->ExpectSurfaceOfItsLevel(0.3);
  this->ExpectNoErrors();
}

TEST_F(StabbingContourProgressive, AsksBeforeASurfaceThatDoesNotFitIntoMemory)
{
  this->Contour->Update();
  const vtkMTimeType time = this->Contour->GetMTime();
  this->Contour->SetRefinementMemory(0.01);
  EXPECT_EQ(this->Contour->GetMTime(), time);
  this->Contour->PrepareRefinement(0);
  const Refinement refinement = this->GetRefinement();
  EXPECT_EQ(refinement.Stage, RefinementStage::TooLarge);
  EXPECT_EQ(refinement.ShownLevel, this->GetLevel());
  EXPECT_LT(refinement.NextLevel, refinement.ShownLevel);
  EXPECT_EQ(refinement.FittingLevel, refinement.ShownLevel)
    << "the level that fits is the one that is there";
  EXPECT_GT(refinement.Bytes, 0.8 * refinement.FreeBytes);
  this->Contour->AcceptSize();
  EXPECT_EQ(this->PrepareToTheEnd(), RefinementStage::Ready);
  EXPECT_EQ(this->FinishLevels().back(), 0);
  const auto triangles = static_cast<double>(this->Contour->GetOutput()->GetNumberOfPolys());

  this->Contour->SetValue(0, 0.3001);
  this->Contour->Update();
  EXPECT_EQ(this->PrepareToTheEnd(), RefinementStage::TooLarge) << "consent is for one surface";
  this->Contour->SetRefinementMemory(0);
  for (; this->PrepareToTheEnd() == RefinementStage::Ready; this->Contour->Update())
  {
    this->Contour->Refine();
  }
  EXPECT_NEAR(this->Contour->GetOutput()->GetNumberOfPolys(), triangles, 0.01 * triangles);
  this->ExpectNoErrors();
}

TEST_F(StabbingContourProgressive, WarnsInScriptsBeforeASurfaceThatDoesNotFitIntoMemory)
{
  const MessageKeeper warnings(this->Contour, vtkCommand::WarningEvent);
  this->Contour->ProgressiveOff();
  this->Contour->Update();
  EXPECT_TRUE(warnings.Messages.empty());
  this->Contour->SetRefinementMemory(0.01);
  this->Contour->SetValue(0, 0.3001);
  this->Contour->Update();
  ASSERT_EQ(warnings.Messages.size(), 1u);
  EXPECT_NE(warnings.Messages[0].find(" MiB of memory on a rank"), std::string::npos);
  EXPECT_GT(this->Contour->GetOutput()->GetNumberOfPolys(), 0) << "it is only a warning";
  this->ExpectNoErrors();
}

} // namespace
