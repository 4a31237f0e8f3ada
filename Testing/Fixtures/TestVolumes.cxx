// SPDX-License-Identifier: BSD-3-Clause
#include "TestVolumes.h"

#include "vtkDataArray.h"
#include "vtkExtractVOI.h"
#include "vtkFieldData.h"
#include "vtkMatrix3x3.h"
#include "vtkPointData.h"

#include <algorithm>
#include <cmath>

namespace isosurface
{
namespace
{

// A whole number from 0 to 24 that looks random; the same everywhere.
int Roughness(int i, int j, int k)
{
  std::uint32_t hash = static_cast<std::uint32_t>(i) * 73856093u ^
    static_cast<std::uint32_t>(j) * 19349663u ^ static_cast<std::uint32_t>(k) * 83492791u;
  hash ^= hash >> 15;
  hash *= 2246822519u;
  hash ^= hash >> 13;
  return static_cast<int>(hash % 25u);
}

// The samples that a block stores: at the coarsest level all vertices of its box and ghost layer,
// at each finer one those with an odd coordinate.
std::uint64_t CountStoredSamples(
  const int first[3], const int last[3], const int dimensions[3], int blockSize)
{
  // A volume of several blocks has the coarser levels elsewhere.
  const bool isSingle = std::all_of(
    dimensions, dimensions + 3, [&](int vertices) { return vertices <= blockSize + 1; });
  const int coarsest = isSingle ? blockSize : 2;
  std::uint64_t samples = 0;
  for (int level = 0; (coarsest >> level) >= 1; ++level)
  {
    std::uint64_t all = 1;
    std::uint64_t even = 1;
    for (int axis = 0; axis < 3; ++axis)
    {
      const int low = std::max((first[axis] >> level) - 1, 0);
      const int high = std::min((last[axis] >> level) + 1, (dimensions[axis] - 1) >> level);
      all *= static_cast<std::uint64_t>(high - low + 1);
      even *= static_cast<std::uint64_t>(high / 2 - (low + 1) / 2 + 1);
    }
    samples += (coarsest >> level) == 1 ? all : all - even;
  }
  return samples;
}

} // namespace

vtkSmartPointer<vtkImageData> MakeClosedVolume(const Extent& extent, int type)
{
  return MakeImage(extent, type,
    [&extent](int i, int j, int k)
    {
      const int vertex[3] = { i, j, k };
      double square = 0;
      bool onBorder = false;
      for (int axis = 0; axis < 3; ++axis)
      {
        const int low = extent[2 * axis];
        const int high = extent[2 * axis + 1];
        onBorder = onBorder || vertex[axis] == low || vertex[axis] == high;
        const double half = 0.5 * (high - low) + 1;
        const double distance = (vertex[axis] - 0.5 * (low + high)) / half;
        square += distance * distance;
      }
      // Whole numbers: so some samples equal the isovalue, in every type.
      const double ball = std::floor(std::max(0.0, 220.0 * (1.0 - 1.2 * square)));
      return onBorder || ball == 0 ? 0.0 : ball + Roughness(i, j, k);
    });
}

void TurnObliquely(vtkImageData* image)
{
  image->SetOrigin(-12.5, 3.25, 1e3);
  image->SetSpacing(0.7, 1.3, 2.1);
  // A turn about (1, 2, 2) / 3 by 90 degrees: entries are ninths.
  const double ninth = 1.0 / 9.0;
  image->SetDirectionMatrix(1 * ninth, -4 * ninth, 8 * ninth, 8 * ninth, 4 * ninth, 1 * ninth,
    -4 * ninth, 7 * ninth, 4 * ninth);
}

void WriteVolume(
  vtkBlockedVolumeWriter* writer, const std::string& path, const VolumeSettings& settings)
{
  const ExpectNoErrors errors(writer);
  writer->SetFileName(path.c_str());
  writer->SetBlockSize(settings.BlockSize);
  writer->SetNumberOfStores(settings.NumberOfStores);
  writer->SetNumberOfReplicas(settings.NumberOfReplicas);
  writer->SetDistribution(settings.Distribution);
  writer->SetCompression(settings.Compression);
  EXPECT_EQ(writer->Write(), 1);
}

void WriteVolume(vtkDataObject* input, const std::string& path, const VolumeSettings& settings)
{
  vtkNew<vtkBlockedVolumeWriter> writer;
  writer->SetController(nullptr);
  writer->SetInputDataObject(input);
  WriteVolume(writer, path, settings);
}

ScratchVolume::ScratchVolume(vtkDataObject* input, const VolumeSettings& settings)
  : Path(Folder.GetPath("volume.bvol"))
{
  WriteVolume(input, this->Path, settings);
}

vtkSmartPointer<vtkBlockedVolumeReader> MakeReader(const std::string& path)
{
  auto reader = vtkSmartPointer<vtkBlockedVolumeReader>::New();
  reader->SetFileName(path.c_str());
  return reader;
}

vtkSmartPointer<vtkImageData> SubsampleImage(vtkImageData* image, int level)
{
  const int* extent = image->GetExtent();
  vtkNew<vtkExtractVOI> subsampled;
  subsampled->SetInputData(image);
  subsampled->SetVOI(image->GetExtent());
  subsampled->SetSampleRate(1 << level, 1 << level, 1 << level);
  subsampled->Update();
  // The same points, counted from 0 as the levels of a blocked volume are.
  vtkSmartPointer<vtkImageData> result = subsampled->GetOutput();
  if (level > 0)
  {
    double origin[3];
    image->TransformIndexToPhysicalPoint(extent[0], extent[2], extent[4], origin);
    const int* size = result->GetDimensions();
    result->SetExtent(0, size[0] - 1, 0, size[1] - 1, 0, size[2] - 1);
    result->SetOrigin(origin);
    result->SetDirectionMatrix(image->GetDirectionMatrix());
  }
  return result;
}

ExpectedCost CountActiveBlocks(vtkImageData* image, int blockSize, double isovalue)
{
  vtkDataArray* samples = image->GetPointData()->GetScalars();
  const int* dimensions = image->GetDimensions();
  ExpectedCost cost;
  int first[3];
  for (first[2] = 0; first[2] < std::max(1, dimensions[2] - 1); first[2] += blockSize)
  {
    for (first[1] = 0; first[1] < std::max(1, dimensions[1] - 1); first[1] += blockSize)
    {
      for (first[0] = 0; first[0] < std::max(1, dimensions[0] - 1); first[0] += blockSize)
      {
        int last[3];
        for (int axis = 0; axis < 3; ++axis)
        {
          last[axis] = std::min(first[axis] + blockSize, dimensions[axis] - 1);
        }
        bool hasInside = false;
        bool hasOutside = false;
        for (vtkIdType k = first[2]; k <= last[2]; ++k)
        {
          for (vtkIdType j = first[1]; j <= last[1]; ++j)
          {
            for (vtkIdType i = first[0]; i <= last[0]; ++i)
            {
              const double value =
                samples->GetComponent(i + dimensions[0] * (j + dimensions[1] * k), 0);
              (value >= isovalue ? hasInside : hasOutside) = true;
            }
          }
        }
        if (hasInside && hasOutside)
        {
          ++cost.ActiveBlocks;
          cost.StoredBytes += static_cast<std::uint64_t>(samples->GetDataTypeSize()) *
            CountStoredSamples(first, last, dimensions, blockSize);
        }
      }
    }
  }
  return cost;
}

std::uint64_t GetCost(vtkPolyData* surface, const char* name)
{
  vtkDataArray* values = surface->GetFieldData()->GetArray(name);
  EXPECT_NE(values, nullptr) << name;
  return values ? static_cast<std::uint64_t>(values->GetTuple1(0)) : 0;
}

} // namespace isosurface
