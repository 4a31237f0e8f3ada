// SPDX-FileCopyrightText: Copyright (c) 2026, the ScalableIsosurface authors
// SPDX-License-Identifier: BSD-3-Clause
#include "vtkVolumeRegion.h"

#include "vtkMultiProcessController.h"
#include "vtkObjectFactory.h"

#include "Ground/Base/Fingerprint.h"
#include "Ground/Volume/VertexPlaces.h"
#include "Storage/Sampling/ImagePlan.h"
#include "Storage/Store/BlockedVolume.h"

#include <cstdio>
#include <string>
#include <utility>

vtkStandardNewMacro(vtkVolumeRegion);

using isosurface::ImagePlan;
using isosurface::Status;
using isosurface::StatusCode;

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

// How many bytes one sample of each of the arrays takes.
double CountBytesOfSample(
  const isosurface::BlockedVolume& volume, const std::vector<std::size_t>& arrays)
{
  double bytes = 0;
  for (const std::size_t array : arrays)
  {
    const isosurface::ArrayDescription& description = volume.GetHeader().Arrays[array];
    bytes +=
      static_cast<double>(isosurface::GetValueSize(description.Type)) * description.Components;
  }
  return bytes;
}

// The vertices of full resolution around a box; empty if it is beside the volume.
isosurface::VertexBox FindVertices(
  const isosurface::BlockedVolume& volume, const double low[3], const double size[3])
{
  return isosurface::VertexPlaces(volume.GetHeader().Grid, volume.GetLines(0))
    .FindVerticesAround(
      { low[0], low[1], low[2] }, { low[0] + size[0], low[1] + size[1], low[2] + size[2] });
}

} // namespace

vtkVolumeRegion::vtkVolumeRegion() = default;
vtkVolumeRegion::~vtkVolumeRegion() = default;

std::uint64_t vtkVolumeRegion::SumProperties()
{
  isosurface::Fingerprint properties;
  properties.AddReals(this->Position);
  properties.AddReals(this->Length);
  properties.AddNumber(static_cast<std::uint64_t>(this->MemoryLimit));
  return properties.Get();
}

Status vtkVolumeRegion::Plan(const isosurface::BlockedVolume& volume,
  const std::vector<std::size_t>& arrays, bool, ImagePlan& plan)
{
  vtkMultiProcessController* ranks = this->GetController();
  const isosurface::VertexBox finest = FindVertices(volume, this->Position, this->Length);
  if (finest.IsEmpty())
  {
    return { StatusCode::InvalidArgument, volume.GetPath() + ": the box is beside the volume" };
  }
  auto found = isosurface::PlanBox(volume, finest,
    this->MemoryLimit * Mebibyte * (ranks ? ranks->GetNumberOfProcesses() : 1) /
      CountBytesOfSample(volume, arrays));
  if (!found)
  {
    return { StatusCode::InvalidArgument,
      volume.GetPath() + ": not even the coarsest level of the box fits the memory limit of " +
        std::to_string(this->MemoryLimit) + " MiB" };
  }
  plan = std::move(*found);
  return Status::Ok();
}

std::string vtkVolumeRegion::Describe(const ImagePlan& plan,
  const isosurface::BlockedVolume& volume, const std::vector<std::size_t>& arrays,
  const std::string& level)
{
  const double bytes = CountBytesOfSample(volume, arrays);
  const isosurface::Index3 size = plan.Grid.GetDimensions();
  const isosurface::VertexBox finest = FindVertices(volume, this->Position, this->Length);
  return std::to_string(size[0]) + " x " + std::to_string(size[1]) + " x " +
    std::to_string(size[2]) + " samples, " + DescribeMemory(bytes * plan.CountPoints()) + ", " +
    level +
    (plan.Level == 0 ? ""
                     : "; full resolution takes " +
          DescribeMemory(bytes * static_cast<double>(finest.GetNumberOfVertices())));
}

void vtkVolumeRegion::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  os << indent << "Position: " << this->Position[0] << " " << this->Position[1] << " "
     << this->Position[2] << "\n";
  os << indent << "Length: " << this->Length[0] << " " << this->Length[1] << " " << this->Length[2]
     << "\n";
  os << indent << "MemoryLimit: " << this->MemoryLimit << "\n";
}
