// SPDX-License-Identifier: BSD-3-Clause
#include "TestImages.h"

#include "vtkBitArray.h"
#include "vtkCallbackCommand.h"
#include "vtkCellData.h"
#include "vtkCommand.h"
#include "vtkExecutive.h"
#include "vtkFloatArray.h"
#include "vtkMultiBlockDataSet.h"
#include "vtkNew.h"
#include "vtkPointData.h"
#include "vtkUnstructuredGrid.h"

#include <algorithm>

using namespace isosurface;

namespace
{

constexpr Extent ErrorsGrid{ 0, 20, 0, 20, 0, 20 };

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
  const ErrorCounter pipelineErrors(contour->GetExecutive());
  contour->Update();
  ASSERT_EQ(errors.Messages.size(), 1u);
  for (const std::string& word : words)
  {
    EXPECT_NE(errors.Messages.front().find(word), std::string::npos)
      << '"' << word << "\" is not in: " << errors.Messages.front();
  }
  EXPECT_EQ(contour->GetOutput()->GetNumberOfPoints(), 0);
  EXPECT_EQ(contour->GetOutput()->GetNumberOfCells(), 0);
}

void ExpectGoodSurface(vtkStabbingContour* contour)
{
  const ErrorCounter errors(contour);
  contour->Update();
  EXPECT_EQ(errors.Messages, std::vector<std::string>());
  EdgeSurface surface = ToEdges(contour->GetOutput());
  EXPECT_TRUE(AreEqual(surface, ContourByFlyingEdges(MakeGoodImage(), 0.1)));
}

} // namespace

TEST(StabbingContourErrors, MissingArrayIsNamed)
{
  const auto contour = MakeContour(MakeGoodImage(), 0.1);
  ExpectGoodSurface(contour);
  Select(contour, "pressure");
  ExpectError(contour, { "pressure" });
  Select(contour, "density");
  ExpectGoodSurface(contour);
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

TEST(StabbingContourErrors, ArrayWithoutTheComponentIsNamed)
{
  const auto image = MakeGoodImage();
  AddArray(image->GetPointData(), "velocity", 3, image->GetNumberOfPoints());
  const auto contour = MakeContour(image, 0.1);
  Select(contour, "velocity");
  contour->SetComponent(4);
  ExpectError(contour, { "velocity", "3 components", "no component 4" });
  Select(contour, "density");
  ExpectGoodSurface(contour);
}

TEST(StabbingContourErrors, ArrayOfBitsIsNamed)
{
  const auto image = MakeGoodImage();
  vtkNew<vtkBitArray> mask;
  mask->SetName("mask");
  mask->SetNumberOfTuples(image->GetNumberOfPoints());
  image->GetPointData()->AddArray(mask);
  const auto contour = MakeContour(image, 0.1);
  Select(contour, "mask");
  ExpectError(contour, { "mask", "bit" });
  Select(contour, "density");
  ExpectGoodSurface(contour);
}

TEST(StabbingContourErrors, ArrayOfTheWrongLengthIsNamed)
{
  const auto image = MakeGoodImage();
  AddArray(image->GetPointData(), "short", 1, 17);
  const auto contour = MakeContour(image, 0.1);
  Select(contour, "short");
  ExpectError(contour, { "short", "17" });
  Select(contour, "density");
  ExpectGoodSurface(contour);
}

TEST(StabbingContourErrors, CellArrayInPlaceOfAPointArrayIsNamed)
{
  const auto image = MakeGoodImage();
  AddArray(image->GetCellData(), "material", 1, image->GetNumberOfCells());
  const auto contour = MakeContour(image, 0.1);
  Select(contour, "material");
  ExpectError(contour, { "no point array \"material\"", "cell arrays \"material\"" });
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

namespace
{

/// What ProgressEvent told; aborts when the progress reaches AbortAt.
struct ProgressRecord
{
  std::vector<double> Shares;
  double AbortAt = 2.0;

  void Observe(vtkAlgorithm* algorithm)
  {
    vtkNew<vtkCallbackCommand> command;
    command->SetClientData(this);
    command->SetCallback(
      [](vtkObject* caller, unsigned long, void* self, void*)
      {
        auto* record = static_cast<ProgressRecord*>(self);
        auto* source = static_cast<vtkAlgorithm*>(caller);
        record->Shares.push_back(source->GetProgress());
        if (source->GetProgress() >= record->AbortAt)
        {
          source->SetAbortExecute(1);
        }
      });
    algorithm->AddObserver(vtkCommand::ProgressEvent, command);
  }
};

vtkSmartPointer<vtkImageData> MakeLargeImage()
{
  return MakeImage({ 0, 150, 0, 150, 0, 150 }, VTK_UNSIGNED_CHAR, MakeNoise(200, 1));
}

} // namespace

TEST(StabbingContourErrors, ProgressRunsFromZeroToOne)
{
  vtkNew<vtkMultiBlockDataSet> blocks;
  blocks->SetBlock(0, MakeLargeImage());
  blocks->SetBlock(1, MakeGoodImage());
  for (vtkDataObject* input : { blocks->GetBlock(0), static_cast<vtkDataObject*>(blocks) })
  {
    vtkNew<vtkStabbingContour> contour;
    ProgressRecord record;
    record.Observe(contour);
    contour->SetInputDataObject(input);
    contour->SetValue(0, 30.0);
    contour->Update();
    ASSERT_FALSE(record.Shares.empty());
    EXPECT_EQ(record.Shares.front(), 0.0);
    EXPECT_EQ(record.Shares.back(), 1.0);
    EXPECT_TRUE(std::is_sorted(record.Shares.begin(), record.Shares.end()));
    EXPECT_GT(std::count_if(record.Shares.begin(), record.Shares.end(),
                [](double share) { return share > 0.0 && share < 1.0; }),
      5);
  }
}

TEST(StabbingContourErrors, AbortEndsEarlyWithoutASurfaceAndWithoutAnError)
{
  for (const double abortAt : { 0.1, 0.5, 0.8 })
  {
    vtkNew<vtkStabbingContour> contour;
    const ErrorCounter errors(contour);
    ProgressRecord record;
    record.AbortAt = abortAt;
    record.Observe(contour);
    contour->SetInputData(MakeLargeImage());
    contour->SetValue(0, 30.0);
    contour->Update();
    // The pipeline itself ends with 1.
    EXPECT_EQ(std::count_if(record.Shares.begin(), record.Shares.end(),
                [=](double share) { return share > abortAt + 0.1 && share < 1.0; }),
      0);
    EXPECT_EQ(contour->GetOutput()->GetNumberOfPoints(), 0);
    EXPECT_EQ(contour->GetOutput()->GetNumberOfCells(), 0);
    EXPECT_EQ(errors.Messages, std::vector<std::string>());

    record.AbortAt = 2.0;
    contour->SetAbortExecute(0);
    contour->Modified();
    contour->Update();
    EXPECT_EQ(record.Shares.back(), 1.0);
    EXPECT_GT(contour->GetOutput()->GetNumberOfCells(), 0);
  }
}
