// SPDX-License-Identifier: BSD-3-Clause
#include "TestImages.h"

#include "vtkCallbackCommand.h"
#include "vtkCommand.h"
#include "vtkDataArray.h"
#include "vtkFieldData.h"
#include "vtkNew.h"
#include "vtkPassThrough.h"
#include "vtkPointData.h"
#include "vtkRTAnalyticSource.h"

using namespace isosurface;

namespace
{

constexpr Extent UpdatesGrid{ 0, 70, 0, 40, 0, 35 };

EdgeSurface Update(vtkStabbingContour* contour)
{
  contour->Update();
  EdgeSurface surface = ToEdges(contour->GetOutput());
  return surface;
}

// Values only in some blocks at first, then in all of them.
void Overwrite(vtkImageData* image)
{
  vtkDataArray* samples = image->GetPointData()->GetScalars();
  for (vtkIdType index = 0; index < samples->GetNumberOfTuples(); ++index)
  {
    samples->SetComponent(index, 0, static_cast<double>((index * 7919) % 101));
  }
}

vtkSmartPointer<vtkImageData> MakeFlatImage()
{
  return MakeImage(UpdatesGrid, VTK_FLOAT,
    [](int i, int j, int k) { return i == 5 && j == 5 && k == 5 ? 60.0 : 0.0; });
}

} // namespace

TEST(StabbingContourUpdates, ChangedSamplesGiveTheirNewSurface)
{
  const auto image = MakeFlatImage();
  const auto contour = MakeContour(image, 50.0);
  EXPECT_TRUE(AreEqual(Update(contour), ContourByFlyingEdges(image, 50.0)));
  Overwrite(image);
  image->GetPointData()->GetScalars()->Modified();
  EXPECT_TRUE(AreEqual(Update(contour), ContourByFlyingEdges(image, 50.0)));
}

// As many do after writing through GetScalarPointer().
TEST(StabbingContourUpdates, ChangedSamplesOfAModifiedImageGiveTheirNewSurface)
{
  const auto image = MakeFlatImage();
  const auto contour = MakeContour(image, 50.0);
  EXPECT_TRUE(AreEqual(Update(contour), ContourByFlyingEdges(image, 50.0)));
  Overwrite(image);
  image->Modified();
  EXPECT_TRUE(AreEqual(Update(contour), ContourByFlyingEdges(image, 50.0)));
}

TEST(StabbingContourUpdates, ExchangedInputGivesItsSurface)
{
  vtkNew<vtkStabbingContour> contour;
  contour->SetValue(0, 50.0);
  for (unsigned int seed = 0; seed < 5; ++seed)
  {
    const auto image =
      MakeImage(UpdatesGrid, VTK_UNSIGNED_CHAR, MakeNoise(60 + 40 * (seed % 2), seed));
    contour->SetInputData(image);
    EXPECT_TRUE(AreEqual(Update(contour), ContourByFlyingEdges(image, 50.0)));
  }
}

TEST(StabbingContourUpdates, ExchangedArrayGivesItsSurface)
{
  const auto image = MakeImage(UpdatesGrid, VTK_FLOAT, MakeWaves());
  const auto other = MakeFlatImage();
  other->GetPointData()->GetScalars()->SetName("other");
  image->GetPointData()->AddArray(other->GetPointData()->GetScalars());
  const auto contour = MakeContour(image, 0.2);
  contour->SetInputArrayToProcess(0, 0, 0, vtkDataObject::FIELD_ASSOCIATION_POINTS, "other");
  EXPECT_TRUE(AreEqual(Update(contour), ContourByFlyingEdges(other, 0.2)));
  EXPECT_STREQ(contour->GetOutput()->GetPointData()->GetScalars()->GetName(), "other");
  contour->SetInputArrayToProcess(0, 0, 0, vtkDataObject::FIELD_ASSOCIATION_POINTS, "density");
  EXPECT_TRUE(AreEqual(Update(contour), ContourByFlyingEdges(image, 0.2)));
  EXPECT_STREQ(contour->GetOutput()->GetPointData()->GetScalars()->GetName(), "density");
}

TEST(StabbingContourUpdates, ChangedIsovaluesGiveTheirSurfaces)
{
  const auto image = MakeImage(UpdatesGrid, VTK_FLOAT, MakeWaves());
  vtkNew<vtkStabbingContour> contour;
  contour->SetInputData(image);
  for (const double isovalue : { 0.0, 0.9, 5.0, -0.3, 0.0 })
  {
    contour->SetValue(0, isovalue);
    EXPECT_TRUE(AreEqual(Update(contour), ContourByFlyingEdges(image, isovalue)));
  }
}

TEST(StabbingContourUpdates, OutputIsNotTouchedByTheNextUpdate)
{
  const auto image = MakeImage(UpdatesGrid, VTK_FLOAT, MakeWaves());
  const auto contour = MakeContour(image, 0.0);
  contour->Update();
  vtkNew<vtkPolyData> kept;
  kept->ShallowCopy(contour->GetOutput());
  contour->SetValue(0, 0.3);
  contour->Update();
  EdgeSurface surface = ToEdges(kept);
  EXPECT_TRUE(AreEqual(surface, ContourByFlyingEdges(image, 0.0)));
}

// The request for blocks that travels upstream is none of an ordinary source's business.
TEST(StabbingContourUpdates, ChangedIsovaluesDoNotExecuteTheSourceAgain)
{
  vtkNew<vtkRTAnalyticSource> source;
  vtkNew<vtkPassThrough> passThrough;
  passThrough->SetInputConnection(source->GetOutputPort());
  int executions = 0;
  vtkNew<vtkCallbackCommand> count;
  count->SetClientData(&executions);
  count->SetCallback(
    [](vtkObject*, unsigned long, void* number, void*) { ++*static_cast<int*>(number); });
  source->AddObserver(vtkCommand::StartEvent, count);

  for (vtkAlgorithm* input : std::vector<vtkAlgorithm*>{ source, passThrough })
  {
    vtkNew<vtkStabbingContour> contour;
    contour->SetInputConnection(input->GetOutputPort());
    for (const double isovalue : { 157.0, 100.0, 200.0 })
    {
      contour->SetValue(0, isovalue);
      contour->Update();
      EXPECT_GT(contour->GetOutput()->GetNumberOfCells(), 0);
    }
  }
  EXPECT_EQ(executions, 1);
}

TEST(StabbingContourUpdates, UnchangedContourDoesNotExecuteAgain)
{
  const auto image = MakeImage(UpdatesGrid, VTK_FLOAT, MakeWaves());
  const auto contour = MakeContour(image, 0.1);
  contour->Update();
  const vtkMTimeType time = contour->GetOutput()->GetMTime();
  contour->SetValue(0, 0.1);
  contour->Update();
  EXPECT_EQ(contour->GetOutput()->GetMTime(), time);
}
