// SPDX-License-Identifier: BSD-3-Clause
#include "EventCounter.h"
#include "TestImages.h"

#include "vtkBitArray.h"
#include "vtkCellData.h"
#include "vtkExecutive.h"
#include "vtkFloatArray.h"
#include "vtkMultiBlockDataSet.h"
#include "vtkNew.h"
#include "vtkPointData.h"
#include "vtkUnstructuredGrid.h"

#include <algorithm>
#include <utility>

using namespace isosurface;

namespace
{

constexpr Extent ErrorsGrid{ 0, 20, 0, 20, 0, 20 };

vtkSmartPointer<vtkImageData> MakeLargeImage()
{
  return MakeImage({ 0, 150, 0, 150, 0, 150 }, VTK_UNSIGNED_CHAR, MakeNoise(200, 1));
}

vtkSmartPointer<vtkImageData> MakeGoodImage()
{
  return MakeImage(ErrorsGrid, VTK_FLOAT, MakeWaves());
}

void Select(vtkStabbingContour* contour, const char* array,
  int association = vtkDataObject::FIELD_ASSOCIATION_POINTS)
{
  contour->SetInputArrayToProcess(0, 0, 0, association, array);
}

void AddArray(vtkDataSetAttributes* attributes, const char* name, int components, vtkIdType size)
{
  vtkNew<vtkFloatArray> array;
  array->SetName(name);
  array->SetNumberOfComponents(components);
  array->SetNumberOfTuples(size);
  array->Fill(0.0);
  attributes->AddArray(array);
}

// The contour must report one error that has the words, and have an empty output. The pipeline's
// own report of the failure is not of interest.
void ExpectError(vtkStabbingContour* contour, const std::vector<std::string>& words)
{
  const ErrorCounter errors(contour);
  contour->Update();
  ExpectOneError(errors, words);
  EXPECT_EQ(contour->GetOutput()->GetNumberOfPoints(), 0);
  EXPECT_EQ(contour->GetOutput()->GetNumberOfCells(), 0);
}

void ExpectGoodSurface(vtkStabbingContour* contour)
{
  const ExpectNoErrors errors(contour);
  contour->Update();
  EdgeSurface surface = ToEdges(contour->GetOutput());
  EXPECT_TRUE(AreEqual(surface, ContourByFlyingEdges(MakeGoodImage(), 0.1)));
}

} // namespace

TEST(StabbingContourErrors, ArraysThatCannotBeContouredAreNamed)
{
  const auto image = MakeGoodImage();
  AddArray(image->GetPointData(), "velocity", 3, image->GetNumberOfPoints());
  AddArray(image->GetPointData(), "short", 1, 17);
  AddArray(image->GetCellData(), "material", 1, image->GetNumberOfCells());
  vtkNew<vtkBitArray> mask;
  mask->SetName("mask");
  mask->SetNumberOfTuples(image->GetNumberOfPoints());
  image->GetPointData()->AddArray(mask);
  const auto contour = MakeContour(image, 0.1);
  contour->SetComponent(4); // of arrays of several
  const std::pair<const char*, std::vector<std::string>> faults[] = {
    { "pressure", { "pressure" } },
    { "velocity", { "velocity", "3 components", "no component 4" } },
    { "mask", { "mask", "bit" } },
    { "short", { "short", "17" } },
    { "material", { "no point array \"material\"", "cell arrays \"material\"" } },
  };
  for (const auto& [array, words] : faults)
  {
    Select(contour, array);
    ExpectError(contour, words);
    Select(contour, "density");
    ExpectGoodSurface(contour);
  }
}

TEST(StabbingContourErrors, MissingArrayOfACompositeIsNamed)
{
  vtkNew<vtkMultiBlockDataSet> blocks;
  blocks->SetBlock(0, MakeGoodImage());
  const auto contour = MakeContour(blocks, 0.1);
  Select(contour, "pressure");
  ExpectError(contour, { "pressure" });
  Select(contour, "density");
  ExpectGoodSurface(contour);
}

TEST(StabbingContourErrors, ImageWithoutArraysIsAnError)
{
  vtkNew<vtkImageData> image;
  image->SetDimensions(5, 5, 5);
  const auto contour = MakeContour(image, 0.1);
  ExpectError(contour, { "no point array" });
  contour->SetInputData(MakeGoodImage());
  ExpectGoodSurface(contour);
}

// A composite may have the array in some of its images only.
TEST(StabbingContourErrors, ImagesOfACompositeWithoutTheArrayAreLeftOut)
{
  vtkNew<vtkImageData> other;
  other->SetDimensions(5, 5, 5);
  vtkNew<vtkMultiBlockDataSet> blocks;
  blocks->SetBlock(0, other);
  blocks->SetBlock(1, MakeGoodImage());
  const auto contour = MakeContour(blocks, 0.1);
  Select(contour, "density");
  ExpectGoodSurface(contour);
}

TEST(StabbingContourErrors, InputWithCellArraysAloneTellsThem)
{
  vtkNew<vtkImageData> image;
  image->SetDimensions(5, 5, 5);
  AddArray(image->GetCellData(), "material", 1, image->GetNumberOfCells());
  AddArray(image->GetCellData(), "pressure", 1, image->GetNumberOfCells());
  const auto contour = MakeContour(image, 0.1);
  ExpectError(
    contour, { "no point array that is active", "cell arrays \"material\", \"pressure\"" });
}

TEST(StabbingContourErrors, CellArrayOfTheWrongLengthIsNamed)
{
  const auto image = MakeGoodImage();
  AddArray(image->GetCellData(), "short", 1, 17);
  const auto contour = MakeContour(image, 0.1);
  Select(contour, "short", vtkDataObject::FIELD_ASSOCIATION_CELLS);
  ExpectError(contour, { "short", "17" });
}

TEST(StabbingContourErrors, DataSetThatIsNoImageIsNamed)
{
  vtkNew<vtkMultiBlockDataSet> blocks;
  blocks->SetBlock(0, MakeGoodImage());
  blocks->SetBlock(1, vtkNew<vtkUnstructuredGrid>());
  const auto contour = MakeContour(blocks, 0.1);
  ExpectError(contour, { "vtkUnstructuredGrid" });
  blocks->SetBlock(1, nullptr);
  blocks->Modified();
  ExpectGoodSurface(contour);
}

TEST(StabbingContourErrors, ProgressRunsFromZeroToOne)
{
  vtkNew<vtkMultiBlockDataSet> blocks;
  blocks->SetBlock(0, MakeLargeImage());
  blocks->SetBlock(1, MakeGoodImage());
  for (vtkDataObject* input : { blocks->GetBlock(0), static_cast<vtkDataObject*>(blocks) })
  {
    const auto contour = MakeContour(input, 30.0);
    const ProgressKeeper progress(contour);
    contour->Update();
    EXPECT_TRUE(progress.IsRising()) << testing::PrintToString(progress.Shares);
    EXPECT_EQ(progress.Shares.at(0), 0.0);
    EXPECT_GT(progress.Shares.size(), 7u);
  }
}

TEST(StabbingContourErrors, AbortEndsEarlyWithoutASurfaceAndWithoutAnError)
{
  for (const double abortAt : { 0.1, 0.5, 0.8 })
  {
    const auto contour = MakeContour(MakeLargeImage(), 30.0);
    {
      const ExpectNoErrors errors(contour);
      const ProgressKeeper progress(contour, StopAbove(contour, abortAt));
      contour->Update();
      // The pipeline itself ends with 1.
      EXPECT_TRUE(std::none_of(progress.Shares.begin(), progress.Shares.end(),
        [=](double share) { return share > abortAt + 0.1 && share < 1.0; }));
    }
    EXPECT_EQ(contour->GetOutput()->GetNumberOfPoints(), 0);
    EXPECT_EQ(contour->GetOutput()->GetNumberOfCells(), 0);
    const ProgressKeeper progress(contour);
    contour->SetAbortExecute(0);
    contour->Modified();
    contour->Update();
    EXPECT_EQ(progress.Shares.back(), 1.0);
    EXPECT_GT(contour->GetOutput()->GetNumberOfCells(), 0);
  }
}
