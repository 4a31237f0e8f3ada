// SPDX-License-Identifier: BSD-3-Clause
// Surfaces that are extracted beside the window are those of all ranks together, taken by all at
// once.
#include "EventCounter.h"
#include "ParallelVolumes.h"

#include "TestImages.h"
#include "TestVolumes.h"
#include "vtkBlockedVolumeReader.h"
#include "vtkDataArray.h"
#include "vtkDataObject.h"
#include "vtkImageData.h"
#include "vtkMultiProcessController.h"
#include "vtkNew.h"
#include "vtkObjectFactory.h"
#include "vtkPassInputTypeAlgorithm.h"
#include "vtkPointData.h"
#include "vtkStabbingContour.h"

#include "Ranks/Query/Refinement.h"

#include <algorithm>
#include <atomic>
#include <cerrno>

#include <dlfcn.h>
#include <pthread.h>

namespace isosurface
{
namespace
{

constexpr RefinementStage Ready = RefinementStage::Ready;

std::atomic<bool> AreThreadsRefused{ false };

class RefinementOnRanks : public testing::TestWithParam<int>
{
protected:
  RefinementOnRanks()
    : Image(MakeClosedVolume({ -41, 68, -7, 103, -90, 28 }, VTK_SHORT))
    , Volume("Refinement-" + std::to_string(GetParam()), this->Image, { 16, GetParam() })
  {
  }

  /// Collective. Whether all ranks have the same of a number.
  static bool IsSame(double mine)
  {
    double lowest = mine;
    double highest = mine;
    GetRanks()->AllReduce(&mine, &lowest, 1, vtkCommunicator::MIN_OP);
    GetRanks()->AllReduce(&mine, &highest, 1, vtkCommunicator::MAX_OP);
    return lowest == highest;
  }

public:
  /// Collective. The stage after work, which is the same on all ranks in each slice.
  static RefinementStage Prepare(vtkStabbingContour* contour)
  {
    const auto read = [&] { return Refinement::FromValues(contour->GetRefinement()); };
    do
    {
      contour->PrepareRefinement(2);
      for (const double value : read().ToValues())
      {
        EXPECT_TRUE(IsSame(value)) << value;
      }
    } while (read().Stage == RefinementStage::Working);
    return read().Stage;
  }

protected:
  /// Collective. The surface after all refinements.
  static vtkPolyData* Finish(ContourPipeline& pipeline, double isovalue)
  {
    for (int passes = 0; !pipeline.Contour->GetFinal() && passes < 10; ++passes)
    {
      pipeline.Contour->Refine();
      pipeline.Update({ isovalue });
    }
    return pipeline.Contour->GetOutput();
  }

  const vtkSmartPointer<vtkImageData> Image;
  const SharedVolume Volume;
};

TEST_P(RefinementOnRanks, EndsWithTheSurfaceOfTheWholeVolume)
{
  ContourPipeline pipeline(this->Volume.Path);
  pipeline.Contour->ProgressiveOn();
  vtkPolyData* mine = pipeline.Update({ 60.5 });
  EXPECT_FALSE(pipeline.Contour->GetFinal());
  for (int passes = 0; !pipeline.Contour->GetFinal() && passes < 10; ++passes)
  {
    EXPECT_EQ(Prepare(pipeline.Contour), Ready);
    pipeline.Contour->Refine();
    mine = pipeline.Update({ 60.5 });
    EXPECT_TRUE(IsSame(static_cast<double>(GetCost(mine, "Level"))));
  }
  EXPECT_TRUE(pipeline.Contour->GetFinal());
  ExpectSurfaceOf(mine, this->Image, 60.5);
}

/// As ParaView's, of the same name, it makes a new copy, which shares the samples, at each update.
class vtkPVPostFilter : public vtkPassInputTypeAlgorithm
{
public:
  static vtkPVPostFilter* New();
  vtkTypeMacro(vtkPVPostFilter, vtkPassInputTypeAlgorithm);

protected:
  int RequestData(
    vtkInformation*, vtkInformationVector** input, vtkInformationVector* output) override
  {
    vtkDataObject::GetData(output)->ShallowCopy(vtkDataObject::GetData(input[0]));
    return 1;
  }
};
vtkStandardNewMacro(vtkPVPostFilter);

/// Images in memory that are large enough for a coarse surface first. Pieces of three ranks end at
/// vertices that are not of level 2.
class ImageRefinement : public testing::Test
{
protected:
  vtkPolyData* Update()
  {
    this->Contour->UpdatePiece(GetRank(), GetNumberOfRanks(), 0);
    return this->Contour->GetOutput();
  }
  std::uint64_t CountTriangles()
  {
    return SumOverRanks(static_cast<std::uint64_t>(this->Update()->GetNumberOfPolys()));
  }
  /// Shows a coarse surface and prepares the exact one.
  void Prepare()
  {
    this->Contour->AllowCoarse(1);
    this->Update();
    this->Contour->AllowCoarse(0);
    EXPECT_EQ(RefinementOnRanks::Prepare(this->Contour), Ready);
  }
  /// Puts what ParaView has behind each source between the source and the contour.
  void InsertPostFilter()
  {
    this->Copy->SetInputConnection(this->Source->GetOutputPort());
    this->Contour->SetInputConnection(this->Copy->GetOutputPort());
  }
  /// Whether an update extracts here and now. Work tells how far it is; what is there does not.
  bool Extracts()
  {
    const ProgressKeeper progress(this->Contour);
    this->Copy->Modified();
    this->Update();
    const auto isWork = [](double share) { return share > 0 && share < 1; };
    return SumOverRanks(static_cast<std::uint64_t>(
             std::count_if(progress.Shares.begin(), progress.Shares.end(), isWork))) > 0;
  }

  static constexpr double Isovalue = 60.5;
  const vtkSmartPointer<vtkImageData> Image =
    MakeClosedVolume({ -3, 207, 5, 214, 0, 201 }, VTK_UNSIGNED_CHAR);
  const vtkSmartPointer<PieceSource> Source = MakeSource(this->Image);
  const vtkNew<vtkPVPostFilter> Copy;
  const vtkSmartPointer<vtkStabbingContour> Contour = MakeContour(this->Source, Isovalue);
  const ExpectNoErrors Errors{ this->Contour };
};

TEST_F(ImageRefinement, KeepsItsIslandsAtEachStep)
{
  this->Contour->SetMaximumIslands(2);
  const std::uint64_t exact = this->CountTriangles();
  this->Contour->Modified();
  this->Contour->AllowCoarse(1);
  const std::uint64_t coarse = this->CountTriangles();
  this->Contour->AllowCoarse(0);
  EXPECT_GT(coarse, 0u);
  EXPECT_LT(coarse, exact / 2);
  EXPECT_EQ(RefinementOnRanks::Prepare(this->Contour), Ready);
  this->Contour->Refine();
  EXPECT_EQ(this->CountTriangles(), exact);
  EXPECT_EQ(std::string(this->Contour->GetIslandSummary()).rfind("2 of ", 0), 0u);
}

/// A coarse surface is that of every 2^level-th vertex, wherever the pieces of ranks end.
TEST_F(ImageRefinement, BeginsWithTheSurfaceOfTheSubsampledImage)
{
  this->Contour->AllowCoarse(1);
  vtkPolyData* mine = this->Update();
  EXPECT_EQ(GetCost(mine, "Level"), 2);
  ExpectSurfaceOf(mine, SubsampleImage(this->Image, 2), Isovalue);
}

// The contoured array is what it was contoured at, up to the rounding of its type.
TEST_F(ImageRefinement, BeginsWithInterpolatedArrays)
{
  const char* name = this->Image->GetPointData()->GetScalars()->GetName();
  this->Contour->ComputeScalarsOff();
  this->Contour->AddInterpolatedArray(name);
  this->Contour->AllowCoarse(1);
  EXPECT_GT(this->CountTriangles(), 0u);
  EXPECT_FALSE(this->Contour->GetFinal());
  vtkPolyData* mine = this->Contour->GetOutput();
  vtkDataArray* values = mine->GetPointData()->GetArray(name);
  ASSERT_TRUE(values);
  ASSERT_EQ(values->GetNumberOfTuples(), mine->GetNumberOfPoints());
  for (vtkIdType n = 0; n < values->GetNumberOfTuples(); ++n)
  {
    EXPECT_NEAR(values->GetComponent(n, 0), Isovalue, 0.5);
  }
}

/// A grid of so many samples a side that change from one to the next.
vtkSmartPointer<vtkImageData> MakeNoise(int side)
{
  return MakeImage({ 0, side - 1, 0, side - 1, 0, side - 1 }, VTK_UNSIGNED_CHAR,
    [](int i, int j, int k) { return ((i * 7919) ^ (j * 104729) ^ (k * 1299709)) >> 3 & 255; });
}

TEST_F(ImageRefinement, BeginsWithAFewTrianglesHoweverManyTheExactOneHas)
{
  const auto noise = MakeNoise(100);
  this->Source->SetImage(noise);
  this->Contour->AllowCoarse(1);
  EXPECT_LT(this->CountTriangles(), 100'000U);
  EXPECT_FALSE(this->Contour->GetFinal());
  this->Contour->AllowCoarse(0);
  EXPECT_EQ(RefinementOnRanks::Prepare(this->Contour), Ready);
  this->Contour->Refine();
  ExpectSurfaceOf(this->Update(), noise, Isovalue);
}

TEST_F(ImageRefinement, IsNotNeededForASmallSurface)
{
  const vtkSmartPointer<vtkImageData> small =
    MakeClosedVolume({ 0, 60, 0, 60, 0, 60 }, VTK_UNSIGNED_CHAR);
  this->Source->SetImage(small);
  this->Contour->AllowCoarse(1);
  ExpectSurfaceOf(this->Update(), small, Isovalue);
  EXPECT_TRUE(this->Contour->GetFinal());
}

TEST_F(ImageRefinement, IsTakenWithoutBeingExtractedAgain)
{
  EXPECT_TRUE(this->Extracts());
  this->Contour->Modified();
  this->Prepare();
  this->Contour->Refine();
  EXPECT_FALSE(this->Extracts());
  ExpectSurfaceOf(this->Contour->GetOutput(), this->Image, Isovalue);
}

TEST_F(ImageRefinement, IsTakenWithoutBeingExtractedAgainBehindAParaViewSource)
{
  this->InsertPostFilter();
  this->Prepare();
  this->Contour->Refine();
  EXPECT_FALSE(this->Extracts());
  ExpectSurfaceOf(this->Contour->GetOutput(), this->Image, Isovalue);
}

TEST_F(ImageRefinement, IsDroppedWhenTheImagesBehindAParaViewSourceChange)
{
  this->InsertPostFilter();
  this->Prepare();
  this->Contour->Refine();
  // In place, so that the samples are where they were.
  vtkDataArray* samples = this->Source->GetOutput()->GetPointData()->GetScalars();
  for (vtkIdType n = 0; n < samples->GetNumberOfValues(); n += 5)
  {
    samples->SetComponent(n, 0, 0);
  }
  this->Source->GetOutput()->Modified();
  EXPECT_TRUE(this->Extracts());
}

TEST_F(ImageRefinement, IsDroppedByAChangeWhileItIsMade)
{
  this->Contour->AllowCoarse(1);
  this->Update();
  this->Contour->PrepareRefinement(0);
  this->Contour->AllowCoarse(0);
  this->Contour->SetValue(0, 100.5);
  ExpectSurfaceOf(this->Update(), this->Image, 100.5);
  EXPECT_TRUE(this->Contour->GetFinal());
}

TEST_P(RefinementOnRanks, OfAnEarlierIsovalueIsDroppedByAll)
{
  ContourPipeline pipeline(this->Volume.Path);
  pipeline.Contour->ProgressiveOn();
  pipeline.Update({ 60.5 });
  pipeline.Contour->PrepareRefinement(0);
  pipeline.Update({ 100.5 });
  EXPECT_FALSE(pipeline.Contour->GetFinal());
  pipeline.Contour->PrepareRefinement(0);
  pipeline.Contour->DropRefinement();
  EXPECT_EQ(Prepare(pipeline.Contour), Ready);
  // One rank's surface is gone: it extracts anew, and all have the same surface.
  if (GetRank() == 0)
  {
    pipeline.Contour->DropRefinement();
  }
  ExpectSurfaceOf(Finish(pipeline, 100.5), this->Image, 100.5);
}

// Refine extracts without preparation then.
TEST_P(RefinementOnRanks, WithoutAThreadOnOneRankIsLeftToAllRanks)
{
  ContourPipeline pipeline(this->Volume.Path);
  pipeline.Contour->ProgressiveOn();
  pipeline.Contour->SetNumberOfThreads(1);
  pipeline.Update({ 60.5 });
  AreThreadsRefused = GetRank() == GetNumberOfRanks() - 1;
  EXPECT_EQ(Prepare(pipeline.Contour), Ready);
  AreThreadsRefused = false;
  ExpectSurfaceOf(Finish(pipeline, 60.5), this->Image, 60.5);
}

INSTANTIATE_TEST_SUITE_P(Stores, RefinementOnRanks, testing::Values(1, 3));

} // namespace
} // namespace isosurface

// The symbols of a program come before those of its libraries: a system that has no more threads.
extern "C" __attribute__((visibility("default"))) int pthread_create(
  pthread_t* thread, const pthread_attr_t* attributes, void* (*run)(void*), void* argument) noexcept
{
  if (isosurface::AreThreadsRefused)
  {
    return EAGAIN;
  }
  static const auto create =
    reinterpret_cast<decltype(&pthread_create)>(::dlsym(RTLD_NEXT, "pthread_create"));
  return create(thread, attributes, run, argument);
}
