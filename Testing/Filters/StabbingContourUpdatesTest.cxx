// SPDX-License-Identifier: BSD-3-Clause
#include "EventCounter.h"
#include "TestImages.h"

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

testing::AssertionResult HasSurfaceOf(vtkStabbingContour* contour, vtkImageData* image)
{
  contour->Update();
  return IsSurfaceOf(contour->GetOutput(), image, contour->GetValue(0));
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
  for (const bool isImageTold : { false, true })
  {
    const auto image = MakeFlatImage();
    const auto contour = MakeContour(image, 50.0);
    EXPECT_TRUE(HasSurfaceOf(contour, image));
    Overwrite(image);
    // The latter is what many do after writing through GetScalarPointer().
    vtkObject* told = image->GetPointData()->GetScalars();
    (isImageTold ? image.Get() : told)->Modified();
    EXPECT_TRUE(HasSurfaceOf(contour, image)) << isImageTold;
  }
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
    EXPECT_TRUE(HasSurfaceOf(contour, image));
  }
}

TEST(StabbingContourUpdates, ExchangedArrayGivesItsSurface)
{
  const auto image = MakeImage(UpdatesGrid, VTK_FLOAT, MakeWaves());
  const auto other = MakeFlatImage();
  other->GetPointData()->GetScalars()->SetName("other");
  image->GetPointData()->AddArray(other->GetPointData()->GetScalars());
  const auto contour = MakeContour(image, 0.2);
  SelectPoints(contour, "other");
  EXPECT_TRUE(HasSurfaceOf(contour, other));
  EXPECT_STREQ(contour->GetOutput()->GetPointData()->GetScalars()->GetName(), "other");
  SelectPoints(contour, "density");
  EXPECT_TRUE(HasSurfaceOf(contour, image));
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
    EXPECT_TRUE(HasSurfaceOf(contour, image));
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
  const EventCounter executions(source, vtkCommand::StartEvent);
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
  EXPECT_EQ(executions.Count, 1);
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
