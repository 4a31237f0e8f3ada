// SPDX-License-Identifier: BSD-3-Clause
#include "TestImages.h"

#include "vtkDataArray.h"
#include "vtkInformation.h"
#include "vtkInformationDoubleVectorKey.h"
#include "vtkInformationInformationVectorKey.h"
#include "vtkNew.h"
#include "vtkPointData.h"
#include "vtkSmartPointer.h"
#include "vtkVersionMacros.h"

#include <cmath>
#include <limits>
#include <vector>

using namespace isosurface;

namespace
{

vtkSmartPointer<vtkImageData> MakeMixedWaves()
{
  return MakeImage({ -3, 90, 5, 70, 0, 60 }, VTK_DOUBLE,
    [](int i, int j, int k)
    { return 50 * std::sin(0.21 * i) * std::cos(0.13 * j) + 7 * std::sin(0.4 * k); });
}

std::vector<vtkDataArray*> GetArrays(vtkPolyData* surface)
{
  std::vector<vtkDataArray*> arrays = { surface->GetPoints()->GetData() };
  for (int n = 0; n < surface->GetPointData()->GetNumberOfArrays(); ++n)
  {
    arrays.push_back(surface->GetPointData()->GetArray(n));
  }
  return arrays;
}

/// The oracle: a copy that knows no ranges yet.
void ExpectRangesOfVTK(vtkDataArray* array)
{
  const auto copy =
    vtkSmartPointer<vtkDataArray>::Take(vtkDataArray::CreateDataArray(array->GetDataType()));
  copy->SetNumberOfComponents(array->GetNumberOfComponents());
  copy->InsertTuples(0, array->GetNumberOfTuples(), 0, array);
  ASSERT_FALSE(copy->GetInformation()->Has(vtkDataArray::PER_COMPONENT()));
  for (int component = array->GetNumberOfComponents() > 1 ? -1 : 0;
       component < array->GetNumberOfComponents(); ++component)
  {
    double told[2], expected[2];
    array->GetRange(told, component);
    copy->GetRange(expected, component);
    EXPECT_EQ(told[0], expected[0]) << array->GetName() << ", component " << component;
    EXPECT_EQ(told[1], expected[1]) << array->GetName() << ", component " << component;
    array->GetFiniteRange(told, component);
    copy->GetFiniteRange(expected, component);
    EXPECT_EQ(told[0], expected[0]) << array->GetName() << ", component " << component;
    EXPECT_EQ(told[1], expected[1]) << array->GetName() << ", component " << component;
  }
}

} // namespace

TEST(StabbingContourRanges, AreThoseThatVTKFindsAndKnownBefore)
{
  const auto contour = MakeContour(MakeMixedWaves(), 3);
  contour->SetValue(1, -21.7);
  for (const int threads : { 1, 3 })
  {
    contour->SetNumberOfThreads(threads);
    contour->Update();
    // More than the tuples that one thread takes at once, and no multiple of them.
    ASSERT_GT(contour->GetOutput()->GetNumberOfPoints(), 66000);
    for (vtkDataArray* array : GetArrays(contour->GetOutput()))
    {
      vtkInformation* information = array->GetInformation();
      EXPECT_TRUE(information->Has(vtkDataArray::PER_COMPONENT())) << array->GetName();
      EXPECT_TRUE(information->Has(vtkDataArray::PER_FINITE_COMPONENT())) << array->GetName();
      EXPECT_EQ(
        information->Has(vtkDataArray::L2_NORM_RANGE()), array->GetNumberOfComponents() > 1);
      ExpectRangesOfVTK(array);
    }
  }
}

TEST(StabbingContourRanges, AreForgottenWhenAnArrayIsModified)
{
  const auto contour = MakeContour(MakeMixedWaves(), 3);
  contour->Update();
  vtkDataArray* points = contour->GetOutput()->GetPoints()->GetData();
  points->SetComponent(0, 1, 12345);
  points->Modified();
  EXPECT_EQ(points->GetRange(1)[1], 12345);
  ExpectRangesOfVTK(points);
}

#if VTK_VERSION_NUMBER >= VTK_VERSION_CHECK(9, 2, 0) // whose attributes have ranges

TEST(StabbingContourRanges, AreToldByAttributesWithoutALookAtTheValues)
{
  const auto contour = MakeContour(MakeMixedWaves(), 3);
  contour->Update();
  vtkPointData* arrays = contour->GetOutput()->GetPointData();
  for (int n = 0; n < arrays->GetNumberOfArrays(); ++n)
  {
    vtkDataArray* array = arrays->GetArray(n);
    const int norm = array->GetNumberOfComponents() > 1 ? -1 : 0;
    double expected[2], told[2];
    array->GetRange(expected, norm);
    array->SetComponent(0, 0, expected[1] + 1000); // unseen: the array is not told that it changed
    arrays->GetRange(n, told, norm);
    EXPECT_EQ(told[1], expected[1]) << array->GetName();
    array->Modified();
    arrays->GetRange(n, told, norm);
    EXPECT_GT(told[1], expected[1]) << array->GetName();
  }
}

#endif

TEST(StabbingContourRanges, OfValuesThatAreNotFiniteAreLeftToVTK)
{
  const auto image = MakeMixedWaves();
  vtkDataArray* samples = image->GetPointData()->GetScalars();
  for (vtkIdType sample = 0; sample < samples->GetNumberOfTuples(); sample += 41)
  {
    samples->SetComponent(sample, 0,
      sample % 2 == 0 ? std::numeric_limits<double>::infinity()
                      : std::numeric_limits<double>::quiet_NaN());
  }
  const auto contour = MakeContour(image, 3);
  contour->Update();
  for (vtkDataArray* array : GetArrays(contour->GetOutput()))
  {
    ExpectRangesOfVTK(array);
  }
}

TEST(StabbingContourRanges, OfNoSurfaceAreThoseOfVTK)
{
  const auto contour = MakeContour(MakeMixedWaves(), 1000);
  contour->Update();
  ASSERT_EQ(contour->GetOutput()->GetNumberOfPoints(), 0);
  for (vtkDataArray* array : GetArrays(contour->GetOutput()))
  {
    ExpectRangesOfVTK(array);
  }
}
