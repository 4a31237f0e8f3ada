// SPDX-License-Identifier: BSD-3-Clause
// VTK's filters behind ours do what they do behind vtkFlyingEdges3D.
#include "TestImages.h"

#include "vtkAdaptiveSubdivisionFilter.h"
#include "vtkButterflySubdivisionFilter.h"
#include "vtkCleanPolyData.h"
#include "vtkCurvatures.h"
#include "vtkDecimatePro.h"
#include "vtkFeatureEdges.h"
#include "vtkFillHolesFilter.h"
#include "vtkLinearSubdivisionFilter.h"
#include "vtkLoopSubdivisionFilter.h"
#include "vtkMassProperties.h"
#include "vtkNew.h"
#include "vtkPolyDataConnectivityFilter.h"
#include "vtkPolyDataNormals.h"
#include "vtkQuadricDecimation.h"
#include "vtkReverseSense.h"
#include "vtkSmoothPolyDataFilter.h"
#include "vtkTriangleFilter.h"
#include "vtkWindowedSincPolyDataFilter.h"

#include <cmath>
#include <functional>

using namespace isosurface;

namespace
{

struct Consumer
{
  const char* Name;
  std::function<vtkSmartPointer<vtkPolyDataAlgorithm>()> Make;
  double Tolerance = 0; ///< of counts; some take triangles in the order in which they come
};

template <typename Filter>
vtkSmartPointer<vtkPolyDataAlgorithm> Make()
{
  return vtkSmartPointer<Filter>::New();
}

const Consumer Consumers[] = {
  { "Loop subdivision", Make<vtkLoopSubdivisionFilter> },
  { "butterfly subdivision", Make<vtkButterflySubdivisionFilter> },
  { "linear subdivision", Make<vtkLinearSubdivisionFilter> },
  { "adaptive subdivision",
    []() -> vtkSmartPointer<vtkPolyDataAlgorithm>
    {
      const auto filter = vtkSmartPointer<vtkAdaptiveSubdivisionFilter>::New();
      filter->SetMaximumEdgeLength(0.6);
      return filter;
    } },
  { "normals", Make<vtkPolyDataNormals> },
  { "clean", Make<vtkCleanPolyData> },
  { "curvatures", Make<vtkCurvatures> },
  { "feature edges", Make<vtkFeatureEdges> },
  { "holes", Make<vtkFillHolesFilter> },
  { "connectivity", Make<vtkPolyDataConnectivityFilter> },
  { "reversed", Make<vtkReverseSense> },
  { "triangles", Make<vtkTriangleFilter> },
  { "smooth", Make<vtkSmoothPolyDataFilter> },
  { "windowed sinc", Make<vtkWindowedSincPolyDataFilter> },
  { "decimated", Make<vtkDecimatePro>, 0.1 },
  { "quadric decimation", Make<vtkQuadricDecimation>, 0.1 },
};

double MeasureArea(vtkPolyData* surface)
{
  vtkNew<vtkTriangleFilter> triangles;
  triangles->SetInputData(surface);
  vtkNew<vtkMassProperties> measured;
  measured->SetInputConnection(triangles->GetOutputPort());
  return measured->GetSurfaceArea();
}

void ExpectSameBehind(vtkPolyData* surface, vtkPolyData* stock)
{
  for (const Consumer& consumer : Consumers)
  {
    const auto run = [&consumer](vtkPolyData* input)
    {
      const auto filter = consumer.Make();
      filter->SetInputDataObject(input);
      filter->Update();
      const auto output = vtkSmartPointer<vtkPolyData>::New();
      output->ShallowCopy(filter->GetOutput());
      return output;
    };
    const auto expected = run(stock);
    const auto output = run(surface);
    const auto cells = static_cast<double>(expected->GetNumberOfCells());
    EXPECT_NEAR(static_cast<double>(output->GetNumberOfCells()), cells, consumer.Tolerance * cells)
      << consumer.Name;
    if (expected->GetNumberOfPolys() > 0)
    {
      const double area = MeasureArea(expected);
      EXPECT_NEAR(MeasureArea(output), area, (1e-4 + consumer.Tolerance) * area) << consumer.Name;
    }
  }
}

} // namespace

TEST(StabbingContourConsumers, GetTheSameAsBehindFlyingEdges)
{
  // Open where the grid ends.
  const auto image = MakeImage({ 0, 12, 0, 13, 0, 9 }, VTK_FLOAT, MakeWaves());
  const auto surface = Contour(image, { 0.1234 });
  EXPECT_GT(surface->GetNumberOfCells(), 100);
  ExpectSameBehind(surface, RunFlyingEdges(image, 0.1234, true));
}
