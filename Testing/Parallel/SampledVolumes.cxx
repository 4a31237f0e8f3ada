// SPDX-License-Identifier: BSD-3-Clause
#include "SampledVolumes.h"

#include "vtkDataArray.h"
#include "vtkDataSetAttributes.h"
#include "vtkMultiProcessController.h"
#include "vtkNew.h"
#include "vtkPointData.h"
#include "vtkProbeFilter.h"
#include "vtkUnsignedCharArray.h"

#include <algorithm>
#include <cmath>

namespace isosurface
{
namespace
{

// Whether our filters say that a point is beyond the volume.
bool IsOutside(vtkDataSet* dataset, vtkIdType point)
{
  vtkDataArray* mask = dataset->GetPointData()->GetArray("vtkValidPointMask");
  if (mask && mask->GetTuple1(point) == 0)
  {
    return true;
  }
  vtkUnsignedCharArray* ghosts = dataset->GetPointGhostArray();
  return ghosts && (ghosts->GetValue(point) & vtkDataSetAttributes::HIDDENPOINT) != 0;
}

} // namespace

vtkSmartPointer<vtkImageData> MakeSampledImage(int type)
{
  auto image = MakeImage(SampledExtent, type, MakeWaves(100));
  TurnObliquely(image);
  return image;
}

vtkSmartPointer<vtkBlockedVolumeReader> OpenOnRanks(const std::string& path)
{
  auto reader = MakeReader(path);
  reader->SetController(GetRanks());
  return reader;
}

vtkSmartPointer<vtkVolumeSlice> MakeSlice(
  vtkBlockedVolumeReader* reader, vtkImageData* image, const std::array<double, 3>& normal)
{
  auto slice = vtkSmartPointer<vtkVolumeSlice>::New();
  slice->SetInputConnection(reader->GetOutputPort());
  // Off the middle, where values would be halfway between two integers.
  const double* center = image->GetCenter();
  slice->SetOrigin(center[0] + 0.31, center[1] + 0.17, center[2] + 0.23);
  slice->SetNormal(normal.data());
  return slice;
}

void ExpectStockValues(vtkDataSet* points, vtkImageData* image)
{
  // VTK 9.6's filter clears the ghost array of its input.
  const auto copy = vtkSmartPointer<vtkDataSet>::Take(points->NewInstance());
  copy->DeepCopy(points);
  vtkNew<vtkProbeFilter> probe;
  probe->SetInputData(copy);
  probe->SetSourceData(image);
  probe->Update();
  vtkDataArray* mine = points->GetPointData()->GetArray("density");
  vtkDataArray* stock = probe->GetOutput()->GetPointData()->GetArray("density");
  vtkDataArray* mask = probe->GetOutput()->GetPointData()->GetArray("vtkValidPointMask");
  ASSERT_TRUE(mine && stock && mask);
  EXPECT_EQ(mine->GetDataType(), stock->GetDataType());
  const bool isInteger = mine->GetDataTypeSize() < 4;
  const double tolerance = isInteger ? 1 : 1e-3;
  std::size_t wrong = 0;
  std::size_t unlike = 0;
  vtkIdType compared = 0;
  for (vtkIdType point = 0; point < points->GetNumberOfPoints(); ++point)
  {
    // On the faces of the volume stock takes points that are off by a hundredth of a cell, or leaves
    // out those that are off by a rounding error.
    if (mask->GetTuple1(point) == 1 && !IsOutside(points, point))
    {
      const double difference = std::abs(mine->GetTuple1(point) - stock->GetTuple1(point));
      wrong += difference > tolerance;
      unlike += difference > 1e-3;
      ++compared;
    }
  }
  EXPECT_EQ(wrong, 0u);
  EXPECT_LT(unlike, 1 + compared / 20) << "values that are not halfway between integers";
  EXPECT_GE(compared, points->GetNumberOfPoints() / 3);
}

void ExpectWhole(vtkImageData* part, const int* whole)
{
  const std::uint64_t cells = SumOverRanks(
    part->GetNumberOfPoints() > 0 ? static_cast<std::uint64_t>(part->GetNumberOfCells()) : 0);
  std::uint64_t expected = 1;
  for (int axis = 0; axis < 3; ++axis)
  {
    expected *= static_cast<std::uint64_t>(std::max(1, whole[2 * axis + 1] - whole[2 * axis]));
  }
  EXPECT_EQ(cells, expected);
}

} // namespace isosurface
