// SPDX-FileCopyrightText: Copyright (c) 2026, the ScalableIsosurface authors
// SPDX-License-Identifier: BSD-3-Clause
#include "vtkVolumeRegion.h"

#include "SampledImage.h"
#include "VolumeInput.h"

#include "vtkImageData.h"
#include "vtkInformation.h"
#include "vtkInformationVector.h"
#include "vtkMultiProcessController.h"
#include "vtkNew.h"
#include "vtkObjectFactory.h"

#include "Ground/Base/Fingerprint.h"
#include "Ground/Volume/VertexPlaces.h"
#include "Storage/Store/BlockedVolume.h"

#include <algorithm>
#include <cstdio>
#include <string>

vtkStandardNewMacro(vtkVolumeRegion);
vtkCxxSetObjectMacro(vtkVolumeRegion, Controller, vtkMultiProcessController);

using isosurface::ImagePlan;
using isosurface::Index3;
using isosurface::Result;
using isosurface::Status;
using isosurface::StatusCode;
using isosurface::VertexBox;

namespace
{

constexpr double Mebibyte = 1024.0 * 1024.0;

std::string DescribeMemory(double bytes)
{
  char text[32];
  std::snprintf(
    text, sizeof(text), bytes < 10 * Mebibyte ? "%.1f MiB" : "%.0f MiB", bytes / Mebibyte);
  return text;
}

// The vertices of a level around a box of vertices of full resolution. The last ones of the level may
// lie before the box.
VertexBox CoarsenAround(const VertexBox& finest, int level, const Index3& dimensions)
{
  VertexBox box;
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    const std::int64_t last = dimensions[axis] - 1;
    const std::int64_t step = std::int64_t{ 1 } << level;
    box.Low[axis] = std::min(last, finest.Low[axis] / step);
    box.High[axis] = std::min(last, (finest.High[axis] + step - 2) / step) + 1;
  }
  return box;
}

// How many bytes one sample of each of the arrays takes.
std::uint64_t CountBytesOfSample(
  const isosurface::BlockedVolume& volume, const std::vector<std::size_t>& arrays)
{
  std::uint64_t bytes = 0;
  for (const std::size_t array : arrays)
  {
    const isosurface::ArrayDescription& description = volume.GetHeader().Arrays[array];
    bytes += isosurface::GetValueSize(description.Type) *
      static_cast<std::uint64_t>(description.Components);
  }
  return bytes;
}

} // namespace

struct vtkVolumeRegion::Steps : isosurface::SampledImage
{
  explicit Steps(vtkVolumeRegion& filter)
    : SampledImage(filter)
    , Filter(filter)
  {
  }

  vtkMultiProcessController* GetController() const override { return this->Filter.Controller; }
  std::uint64_t SumProperties() const override;
  /// The finest level that keeps the memory limit.
  Result<ImagePlan> Plan(const isosurface::BlockedVolume& volume,
    const std::vector<std::size_t>& arrays, bool) const override;
  /// The vertices of full resolution around the box; empty if it is beside the volume.
  VertexBox FindVertices(const isosurface::BlockedVolume& volume) const;

  vtkVolumeRegion& Filter;
};

//------------------------------------------------------------------------------
vtkVolumeRegion::vtkVolumeRegion()
  : Internals(std::make_unique<Steps>(*this))
{
  this->SetController(vtkMultiProcessController::GetGlobalController());
}

//------------------------------------------------------------------------------
vtkVolumeRegion::~vtkVolumeRegion()
{
  this->SetController(nullptr);
}

//------------------------------------------------------------------------------
int vtkVolumeRegion::FillInputPortInformation(int, vtkInformation* info)
{
  info->Set(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE(), "vtkDataObject");
  return 1;
}

//------------------------------------------------------------------------------
const char* vtkVolumeRegion::GetShownText()
{
  return this->Internals->GetText().c_str();
}

//------------------------------------------------------------------------------
int vtkVolumeRegion::RequestDataObject(
  vtkInformation*, vtkInformationVector**, vtkInformationVector* output)
{
  vtkInformation* outInfo = output->GetInformationObject(0);
  if (!vtkDataObject::GetData(outInfo))
  {
    outInfo->Set(vtkDataObject::DATA_OBJECT(), vtkNew<vtkImageData>());
  }
  return 1;
}

//------------------------------------------------------------------------------
int vtkVolumeRegion::RequestInformation(
  vtkInformation*, vtkInformationVector** input, vtkInformationVector* output)
{
  return this->Internals->TellImage(input[0]->GetInformationObject(0), output);
}

//------------------------------------------------------------------------------
int vtkVolumeRegion::RequestUpdateExtent(
  vtkInformation*, vtkInformationVector** input, vtkInformationVector* output)
{
  isosurface::AskVolume(*this, input[0]->GetInformationObject(0), output->GetInformationObject(0));
  return 1;
}

//------------------------------------------------------------------------------
int vtkVolumeRegion::RequestData(
  vtkInformation* request, vtkInformationVector** input, vtkInformationVector* output)
{
  int result = 0;
  this->Internals->Make(request, input[0]->GetInformationObject(0), output, result);
  return result;
}

//------------------------------------------------------------------------------
std::uint64_t vtkVolumeRegion::Steps::SumProperties() const
{
  isosurface::Fingerprint properties;
  for (int axis = 0; axis < 3; ++axis)
  {
    properties.AddReal(this->Filter.Position[axis]);
    properties.AddReal(this->Filter.Length[axis]);
  }
  properties.AddNumber(static_cast<std::uint64_t>(this->Filter.MemoryLimit));
  return properties.Get();
}

//------------------------------------------------------------------------------
VertexBox vtkVolumeRegion::Steps::FindVertices(const isosurface::BlockedVolume& volume) const
{
  std::array<double, 3> low{};
  std::array<double, 3> high{};
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    low[axis] = this->Filter.Position[axis];
    high[axis] = low[axis] + this->Filter.Length[axis];
  }
  return isosurface::VertexPlaces(volume.GetHeader().Grid, volume.GetLines(0))
    .FindVerticesAround(low, high);
}

//------------------------------------------------------------------------------
Result<ImagePlan> vtkVolumeRegion::Steps::Plan(
  const isosurface::BlockedVolume& volume, const std::vector<std::size_t>& arrays, bool) const
{
  const int ranks = this->Filter.Controller ? this->Filter.Controller->GetNumberOfProcesses() : 1;
  const auto bytesOfSample = static_cast<double>(CountBytesOfSample(volume, arrays));
  const VertexBox finest = this->FindVertices(volume);
  if (finest.IsEmpty())
  {
    return Status(StatusCode::InvalidArgument, volume.GetPath() + ": the box is beside the volume");
  }
  const auto countBytes = [&](const VertexBox& box)
  { return bytesOfSample * static_cast<double>(box.GetNumberOfVertices()); };
  for (int level = 0; level < volume.GetNumberOfLevels(); ++level)
  {
    const isosurface::GridGeometry grid = volume.GetHeader().Grid.Coarsen(level);
    const VertexBox box = CoarsenAround(finest, level, grid.GetDimensions());
    const double bytes = countBytes(box);
    if (bytes > this->Filter.MemoryLimit * Mebibyte * ranks)
    {
      continue;
    }
    ImagePlan image;
    image.Level = level;
    image.Grid = grid;
    const Index3 size = box.GetSize();
    for (std::size_t axis = 0; axis < 3; ++axis)
    {
      image.Grid.Extent[2 * axis] += box.Low[axis];
      image.Grid.Extent[2 * axis + 1] = image.Grid.Extent[2 * axis] + size[axis] - 1;
    }
    if (const isosurface::GridLines* lines = volume.GetLines(level))
    {
      image.Lines = lines->Cut(box);
    }
    image.Fill = [low = box.Low](const isosurface::LevelSamples& samples, std::size_t variable,
                   const VertexBox& part, int threads, void* values, std::ptrdiff_t stride,
                   std::uint8_t*, isosurface::QueryStatistics& statistics,
                   const isosurface::Progress& progress)
    {
      return samples.Read(
        variable, part.Translate(low), { 1, 1, 1 }, threads, values, stride, statistics, progress);
    };
    image.Size = std::to_string(size[0]) + " x " + std::to_string(size[1]) + " x " +
      std::to_string(size[2]) + " samples, " + DescribeMemory(bytes);
    image.Note = level == 0 ? "" : "full resolution takes " + DescribeMemory(countBytes(finest));
    return image;
  }
  return Status(StatusCode::InvalidArgument,
    volume.GetPath() + ": not even the coarsest level of the box fits the memory limit of " +
      std::to_string(this->Filter.MemoryLimit) + " MiB");
}

//------------------------------------------------------------------------------
void vtkVolumeRegion::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  os << indent << "Position: " << this->Position[0] << " " << this->Position[1] << " "
     << this->Position[2] << "\n";
  os << indent << "Length: " << this->Length[0] << " " << this->Length[1] << " " << this->Length[2]
     << "\n";
  os << indent << "MemoryLimit: " << this->MemoryLimit << "\n";
  os << indent << "Controller: " << this->Controller << "\n";
}
