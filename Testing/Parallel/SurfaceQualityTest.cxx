// SPDX-License-Identifier: BSD-3-Clause
// Closed surfaces, degenerate triangles, regions and interpolated arrays are the same ones for any
// number of ranks.
#include "ParallelVolumes.h"

#include "vtkDataArray.h"
#include "vtkFloatArray.h"
#include "vtkMultiProcessController.h"
#include "vtkNew.h"
#include "vtkPointData.h"
#include "vtkStabbingContour.h"

#include <algorithm>
#include <cmath>
#include <cstring>

using namespace isosurface;

namespace
{

constexpr int Options = 8;

/// Small whole numbers that reach the border everywhere, and another array.
vtkSmartPointer<vtkImageData> MakeOpenVolume()
{
  auto image = MakeImage({ -9, 41, 3, 47, 0, 38 }, VTK_SHORT,
    [](int i, int j, int k)
    { return std::floor(8 * std::sin(0.2 * i) * std::cos(0.17 * j + 0.05 * k)); });
  TurnObliquely(image);
  vtkNew<vtkFloatArray> other;
  other->SetName("other");
  other->SetNumberOfTuples(image->GetNumberOfPoints());
  for (vtkIdType n = 0; n < image->GetNumberOfPoints(); ++n)
  {
    other->SetValue(n, static_cast<float>(std::sin(0.1 * static_cast<double>(n))));
  }
  image->GetPointData()->AddArray(other);
  return image;
}

/// Each bit of `options` is one of the options.
void Apply(int options, vtkImageData* image, vtkStabbingContour* contour)
{
  contour->SetDropDegenerateTriangles((options & 1) != 0);
  contour->SetCloseBoundary((options & 2) != 0);
  contour->SetUseRegion((options & 4) != 0);
  double bounds[6];
  image->GetBounds(bounds);
  for (int axis = 0; axis < 3; ++axis)
  {
    bounds[2 * axis + 1] = bounds[2 * axis] + 0.6 * (bounds[2 * axis + 1] - bounds[2 * axis]);
  }
  contour->SetRegionBounds(bounds);
}

/// The surface of one rank that has the image as a whole.
vtkSmartPointer<vtkPolyData> ContourAlone(int options, vtkImageData* image)
{
  vtkNew<vtkStabbingContour> contour;
  contour->SetController(nullptr);
  contour->SetInputData(image);
  contour->SetValue(0, 2.0);
  contour->SetValue(1, 4.5);
  contour->AddInterpolatedArray("other");
  Apply(options, image, contour);
  contour->Update();
  return contour->GetOutput();
}

/// The value at each global id, of all ranks, as points of a surface.
EdgeSurface GatherArray(vtkPolyData* mine)
{
  EdgeSurface values;
  vtkDataArray* ids = mine->GetPointData()->GetGlobalIds();
  vtkDataArray* other = mine->GetPointData()->GetArray("other");
  EXPECT_TRUE(other || mine->GetNumberOfPoints() == 0);
  for (vtkIdType point = 0; other && point < mine->GetNumberOfPoints(); ++point)
  {
    EdgePoint value;
    value.Edge = static_cast<std::int64_t>(ids->GetTuple1(point));
    const float number = static_cast<float>(other->GetTuple1(point));
    std::memcpy(value.Position.data(), &number, sizeof(number));
    values.Points.push_back(value);
  }
  std::sort(values.Points.begin(), values.Points.end());
  return GatherSurfaces(values);
}

class SurfaceQuality : public testing::TestWithParam<int>
{
};

TEST_P(SurfaceQuality, IsThatOfTheWholeImageWithAnyOptions)
{
  const SharedFolder folder("SurfaceQuality-" + std::to_string(GetParam()));
  const std::string path = folder.GetPath("volume.bvol");
  const auto image = MakeOpenVolume();
  // Blocks of 32, as image data is cut: a region then has the same blocks.
  OnFirstRank([&] { WriteVolume(image, path, { 32, GetParam() }); });
  ContourPipeline pipeline(path);
  pipeline.Contour->AddInterpolatedArray("other");
  for (int options = 0; options < Options; ++options)
  {
    Apply(options, image, pipeline.Contour);
    vtkPolyData* mine = pipeline.Update({ 2.0, 4.5 });
    const EdgeSurface all = GatherSurface(mine);
    EdgeSurface values = GatherArray(mine);
    if (GetRank() != 0)
    {
      continue;
    }
    values.MergeEqualPoints();
    const auto alone = ContourAlone(options, image);
    EdgeSurface expected = ToEdges(alone);
    EXPECT_FALSE(expected.Triangles.empty());
    EXPECT_TRUE(AreEqual(all, expected)) << "options " << options;
    EXPECT_EQ(values.Points.size(), expected.Points.size()) << "options " << options;
    EXPECT_EQ(IsClosed(all), (options & 2) != 0 && (options & 4) == 0) << "options " << options;
    vtkDataArray* ids = alone->GetPointData()->GetGlobalIds();
    vtkDataArray* other = alone->GetPointData()->GetArray("other");
    vtkIdType wrong = 0;
    for (vtkIdType point = 0; point < alone->GetNumberOfPoints(); ++point)
    {
      EdgePoint value;
      value.Edge = static_cast<std::int64_t>(ids->GetTuple1(point));
      const float number = static_cast<float>(other->GetTuple1(point));
      std::memcpy(value.Position.data(), &number, sizeof(number));
      wrong += std::binary_search(values.Points.begin(), values.Points.end(), value) ? 0 : 1;
    }
    EXPECT_EQ(wrong, 0) << "options " << options;
  }
}

INSTANTIATE_TEST_SUITE_P(Stores, SurfaceQuality, testing::Values(1, 3, 4));

} // namespace
