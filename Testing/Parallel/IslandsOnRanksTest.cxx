// SPDX-License-Identifier: BSD-3-Clause
// The islands of a surface that all ranks have together are those that one rank alone finds.
#include "ParallelVolumes.h"

#include "vtkBlockedVolumeReader.h"
#include "vtkDataArray.h"
#include "vtkFieldData.h"
#include "vtkMultiProcessController.h"
#include "vtkNew.h"
#include "vtkPolyData.h"
#include "vtkStabbingContour.h"

#include "Ranks/Query/Refinement.h"

#include <algorithm>
#include <cmath>
#include <functional>

using namespace isosurface;

namespace
{

constexpr double IslandsIsovalue = 60;

/// Large bodies in a dust of noise.
vtkSmartPointer<vtkImageData> MakeDustyImage()
{
  return MakeImage({ -9, 60, 3, 72, 0, 68 }, VTK_FLOAT,
    [noise = MakeNoise(1000, 9)](int i, int j, int k) mutable
    {
      const double value = noise(i, j, k);
      const double ball = 75 - std::hypot(i - 22, j - 30, k - 31);
      const double rod = 64 - std::hypot(i - 50, k - 40);
      return std::max({ value < 12 ? 60 + value : value / 20, ball, rod });
    });
}

using Change = std::function<void(vtkStabbingContour*)>;

std::vector<double> ListIslands(vtkPolyData* surface)
{
  std::vector<double> rows;
  for (const char* name : { "Islands", "KeptIslands", "IslandTriangles", "IslandArea",
         "IslandVolume", "IslandBinSize", "IslandBinIslands", "IslandBinTriangles" })
  {
    vtkDataArray* array = surface->GetFieldData()->GetArray(name);
    EXPECT_TRUE(array) << name;
    for (vtkIdType row = 0; array && row < array->GetNumberOfTuples(); ++row)
    {
      rows.push_back(array->GetTuple1(row));
    }
  }
  return rows;
}

/// Expects of this rank's output what one rank makes. Collective.
void ExpectIslandsOf(vtkPolyData* mine, vtkStabbingContour* alone, const std::string& what)
{
  const EdgeSurface all = GatherSurface(mine);
  std::string rows;
  for (const double row : ListIslands(mine))
  {
    rows.append(reinterpret_cast<const char*>(&row), sizeof(row));
  }
  const std::vector<std::string> ofRanks = GatherTexts(rows);
  if (GetRank() != 0)
  {
    return;
  }
  alone->Update();
  EXPECT_TRUE(AreEqual(all, ToEdges(alone->GetOutput()))) << what;
  EXPECT_GT(ListIslands(alone->GetOutput())[0], 100) << "dust";
  EXPECT_GT(alone->GetOutput()->GetNumberOfPolys(), 0);
  std::string expected;
  for (const double row : ListIslands(alone->GetOutput()))
  {
    expected.append(reinterpret_cast<const char*>(&row), sizeof(row));
  }
  for (const std::string& one : ofRanks)
  {
    EXPECT_EQ(one, expected) << what << ": bit for bit on every rank";
  }
}

std::vector<std::pair<std::string, Change>> MakeIslandChanges()
{
  using Filter = vtkStabbingContour;
  return {
    { "largest", [](Filter* contour) { contour->SetMaximumIslands(1); } },
    { "many of equal size", [](Filter* contour) { contour->SetMaximumIslands(57); } },
    { "by area",
      [](Filter* contour)
      {
        contour->SetIslandSize(Filter::AREA);
        contour->SetMinimumIslandSize(4);
      } },
    { "by volume, closed",
      [](Filter* contour)
      {
        contour->SetIslandSize(Filter::VOLUME);
        contour->SetMaximumIslands(30);
        contour->CloseBoundaryOn();
        contour->DropDegenerateTrianglesOn();
      } },
    { "at a point",
      [](Filter* contour)
      {
        contour->SetMinimumIslandSize(100);
        contour->UseIslandPointOn();
        contour->SetIslandPoint(50, 20, 40);
      } },
    { "of two isovalues, with ids",
      [](Filter* contour)
      {
        contour->SetValue(1, 66);
        contour->ComputeIslandIdsOn();
      } },
  };
}

vtkSmartPointer<vtkStabbingContour> MakeIslandContour(
  vtkMultiProcessController* controller, const Change& change)
{
  auto contour = vtkSmartPointer<vtkStabbingContour>::New();
  contour->SetController(controller);
  SelectPoints(contour, "density");
  contour->SetValue(0, IslandsIsovalue);
  change(contour);
  return contour;
}

// A contour of this process alone behind a reader of its own.
vtkSmartPointer<vtkStabbingContour> MakeIslandContourAlone(
  const std::string& path, const Change& change)
{
  vtkNew<vtkBlockedVolumeReader> reader;
  reader->SetController(nullptr);
  reader->SetFileName(path.c_str());
  auto contour = MakeIslandContour(nullptr, change);
  contour->SetInputConnection(reader->GetOutputPort());
  return contour;
}

} // namespace

TEST(IslandsOnRanks, OfImagesAreThoseOfTheWhole)
{
  const auto image = MakeDustyImage();
  const auto source = MakeSource(image);
  for (const auto& [name, change] : MakeIslandChanges())
  {
    const auto contour = MakeIslandContour(GetRanks(), change);
    const ExpectNoErrors errors(contour);
    contour->SetInputConnection(source->GetOutputPort());
    contour->UpdatePiece(GetRank(), GetNumberOfRanks(), 0);
    const auto alone = MakeIslandContour(nullptr, change);
    alone->SetInputDataObject(image);
    ExpectIslandsOf(contour->GetOutput(), alone, name);
  }
}

TEST(IslandsOnRanks, OfVolumesAreThoseOfTheWholeAtEveryLevel)
{
  const auto image = MakeDustyImage();
  const SharedVolume volume("IslandsOnRanks", image, { 16, 5 });
  for (const auto& [name, change] : MakeIslandChanges())
  {
    for (const int level : { 0, 1 })
    {
      vtkNew<vtkBlockedVolumeReader> reader;
      reader->SetFileName(volume.Path.c_str());
      const auto contour = MakeIslandContour(GetRanks(), change);
      const ExpectNoErrors errors(contour);
      contour->SetInputConnection(reader->GetOutputPort());
      contour->SetLevel(level);
      contour->UpdatePiece(GetRank(), GetNumberOfRanks(), 0);

      vtkNew<vtkBlockedVolumeReader> own;
      own->SetController(nullptr);
      own->SetFileName(volume.Path.c_str());
      const auto alone = MakeIslandContour(nullptr, change);
      alone->SetInputConnection(own->GetOutputPort());
      alone->SetLevel(level);
      ExpectIslandsOf(contour->GetOutput(), alone, name + ", level " + std::to_string(level));
    }
  }
}

// Which rank has which block is then left to chance.
TEST(IslandsOnRanks, AreTheSameWithDynamicBalance)
{
  const SharedVolume volume("IslandsInBalance", MakeDustyImage(), { 16, 2 });
  const Change change = MakeIslandChanges()[1].second;
  const auto contour = MakeIslandContour(GetRanks(), change);
  vtkNew<vtkBlockedVolumeReader> reader;
  reader->SetFileName(volume.Path.c_str());
  contour->SetInputConnection(reader->GetOutputPort());
  contour->DynamicBalanceOn();
  contour->UpdatePiece(GetRank(), GetNumberOfRanks(), 0);
  const auto alone = MakeIslandContourAlone(volume.Path, change);
  ExpectIslandsOf(contour->GetOutput(), alone, "with dynamic balance");
}

// What is prepared beside the window goes through the same choice, and so do its coarse levels.
TEST(IslandsOnRanks, AreChosenAtEachStepOfARefinement)
{
  const SharedVolume volume("IslandsRefined", MakeDustyImage(), { 16, 2 });
  const Change change = [](vtkStabbingContour* contour) { contour->SetMaximumIslands(2); };
  const auto contour = MakeIslandContour(GetRanks(), change);
  const ExpectNoErrors errors(contour);
  vtkNew<vtkBlockedVolumeReader> reader;
  reader->SetFileName(volume.Path.c_str());
  contour->SetInputConnection(reader->GetOutputPort());
  contour->ProgressiveOn();
  contour->UpdatePiece(GetRank(), GetNumberOfRanks(), 0);
  EXPECT_FALSE(contour->GetFinal());
  for (int pass = 0; pass < 10 && !contour->GetFinal(); ++pass)
  {
    const std::vector<double> rows = ListIslands(contour->GetOutput());
    EXPECT_EQ(rows[1], std::min(2.0, rows[0])) << "at a coarse level";
    do
    {
      contour->PrepareRefinement(20);
    } while (Refinement::FromValues(contour->GetRefinement()).Stage == RefinementStage::Working);
    contour->Refine();
    contour->UpdatePiece(GetRank(), GetNumberOfRanks(), 0);
  }
  EXPECT_TRUE(contour->GetFinal());
  const auto alone = MakeIslandContourAlone(volume.Path, change);
  ExpectIslandsOf(contour->GetOutput(), alone, "refined");
}

// A surface on one rank alone: the others have nothing, and enter every step.
TEST(IslandsOnRanks, OfAnImageOnOneRankAreThoseOfTheWhole)
{
  const auto image = MakeDustyImage();
  const Change change = MakeIslandChanges()[5].second;
  const auto contour = MakeIslandContour(GetRanks(), change);
  const ExpectNoErrors errors(contour);
  contour->SetInputDataObject(GetRank() == 0 ? image : vtkSmartPointer<vtkImageData>::New());
  contour->Update();
  const auto alone = MakeIslandContour(nullptr, change);
  alone->SetInputDataObject(image);
  ExpectIslandsOf(contour->GetOutput(), alone, "on one rank");
}
