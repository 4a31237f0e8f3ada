// SPDX-License-Identifier: BSD-3-Clause
// Budgets of triangles and seconds, against the surfaces of all levels.
#include "BlockChecks.h"
#include "ScratchFolder.h"
#include "TestVolumes.h"

#include "vtkBlockedVolumeReader.h"
#include "vtkStabbingContour.h"

#include "vtkFieldData.h"
#include "vtkPolyData.h"
#include "vtkStringArray.h"

using namespace isosurface;

namespace
{

class StabbingContourBudget : public testing::Test
{
protected:
  StabbingContourBudget()
    : Path(Folder.GetPath("volume.bvol"))
  {
    const auto image = MakeImage({ 0, 90, 0, 80, 0, 70 }, VTK_SHORT, MakeNoise(200, 3));
    WriteVolume(image, this->Path, { 16, 3, vtkBlockedVolumeWriter::RANDOM });
    this->Reader->SetFileName(this->Path.c_str());
    this->Contour->SetInputConnection(this->Reader->GetOutputPort());
    this->Contour->SetValue(0, 80);
    this->Contour->SetValue(1, 120);
  }

  std::string GetLimit()
  {
    auto* limit = vtkStringArray::SafeDownCast(
      this->Contour->GetOutput()->GetFieldData()->GetAbstractArray("LevelLimit"));
    return limit ? limit->GetValue(0) : "not told";
  }
  vtkIdType CountTriangles(int level)
  {
    this->Contour->SetMaximumTriangles(0);
    this->Contour->SetTimeBudget(0);
    this->Contour->SetLevel(level);
    this->Contour->Update();
    this->Contour->SetLevel(0);
    EXPECT_EQ(this->GetLimit(), "not told");
    return this->Contour->GetOutput()->GetNumberOfPolys();
  }
  int GetLevel() { return static_cast<int>(GetCost(this->Contour->GetOutput(), "Level")); }

  const ScratchFolder Folder;
  const std::string Path;
  const vtkNew<vtkBlockedVolumeReader> Reader;
  const vtkNew<vtkStabbingContour> Contour;
};

} // namespace

TEST_F(StabbingContourBudget, OfTrianglesIsNeverExceeded)
{
  std::vector<vtkIdType> counts;
  for (int level = 0; level < 6; ++level)
  {
    counts.push_back(this->CountTriangles(level));
  }
  for (const vtkIdType most :
    { counts[0], counts[0] - 1, counts[1], counts[1] - 1, counts[2] + 9, counts[3] / 2 })
  {
    this->Contour->SetMaximumTriangles(most);
    this->Contour->Update();
    const int level = this->GetLevel();
    const vtkIdType triangles = this->Contour->GetOutput()->GetNumberOfPolys();
    EXPECT_LE(triangles, most);
    EXPECT_EQ(triangles, counts[static_cast<std::size_t>(level)]);
    EXPECT_EQ(this->GetLimit(), most >= counts[0] ? "" : "MaximumTriangles");
  }
  this->Contour->SetMaximumTriangles(counts[0]);
  this->Contour->Update();
  EXPECT_EQ(this->GetLevel(), 0) << "exact counts stand in the contour spectrum";
}

// Every other vertex is noise, all others are low: level 1 has more triangles than a fourth of level
// 0's, so an estimate of it is too low.
TEST_F(StabbingContourBudget, EstimateIsThatOfTheLevelThatIsShown)
{
  const auto image = MakeImage({ 0, 90, 0, 80, 0, 70 }, VTK_SHORT,
    [noise = MakeNoise(200, 5)](int i, int j, int k) mutable
    { return i % 2 == 0 && j % 2 == 0 && k % 2 == 0 ? noise(i, j, k) : 0.0; });
  WriteVolume(image, this->Path, { 16, 3, vtkBlockedVolumeWriter::RANDOM });
  this->Reader->Modified();
  const auto getEstimate = [this]
  {
    vtkDataArray* estimate =
      this->Contour->GetOutput()->GetFieldData()->GetArray("EstimatedTriangles");
    return estimate ? estimate->GetTuple1(0) : -1.0;
  };
  bool wasEstimateTooLow = false;
  for (const double share : { 0.9, 0.5, 0.3, 0.2, 0.1 })
  {
    const auto most = static_cast<vtkIdType>(share * static_cast<double>(this->CountTriangles(0)));
    this->Contour->SetMaximumTriangles(most);
    this->Contour->Update();
    const int level = this->GetLevel();
    const double estimate = getEstimate();
    for (int finer = 1; finer < level; ++finer)
    {
      this->Contour->SetLevel(finer);
      this->Contour->SetMaximumTriangles(1 << 30);
      this->Contour->Update();
      wasEstimateTooLow = wasEstimateTooLow || getEstimate() <= static_cast<double>(most);
    }
    this->Contour->SetLevel(level);
    this->Contour->SetMaximumTriangles(1 << 30);
    this->Contour->Update();
    ASSERT_EQ(this->GetLevel(), level);
    EXPECT_EQ(estimate, getEstimate()) << share;
  }
  EXPECT_TRUE(wasEstimateTooLow);
}

TEST_F(StabbingContourBudget, OfTimeGoesFromTheCoarsestLevelToTheFinest)
{
  this->Contour->SetTimeBudget(1e-9);
  this->Contour->Update();
  const int coarsest = this->GetLevel();
  EXPECT_GT(coarsest, 4);
  EXPECT_EQ(this->GetLimit(), "TimeBudget");
  this->Contour->SetTimeBudget(1e6);
  this->Contour->Update();
  EXPECT_EQ(this->GetLevel(), 0);
  EXPECT_EQ(this->GetLimit(), "");
  EXPECT_EQ(this->Contour->GetOutput()->GetNumberOfPolys(), this->CountTriangles(0));
  this->Contour->SetTimeBudget(1e6);
  this->Contour->SetLevel(2);
  this->Contour->Update();
  EXPECT_EQ(this->GetLevel(), 2) << "the finest that is wanted";
}
