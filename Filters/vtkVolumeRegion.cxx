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

using namespace isosurface;

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

} // namespace

std::uint64_t vtkVolumeRegion::SumProperties()
{
  Fingerprint properties;
  properties.AddReals(this->Position);
  properties.AddReals(this->Length);
  properties.AddNumber(static_cast<std::uint64_t>(this->MemoryLimit));
  return properties.Get();
}

Status vtkVolumeRegion::Plan(
  const BlockedVolume& volume, const std::vector<std::size_t>& arrays, bool, ImagePlan& plan)
{
  vtkMultiProcessController* ranks = this->GetController();
  const double* low = this->Position;
  const double* length = this->Length;
  // Of full resolution; empty if it is beside the volume.
  const VertexBox finest = VertexPlaces(volume.GetHeader().Grid, volume.GetLines(0))
                             .FindVerticesAround({ low[0], low[1], low[2] },
                               { low[0] + length[0], low[1] + length[1], low[2] + length[2] });
  if (finest.IsEmpty())
  {
    return { StatusCode::InvalidArgument, volume.GetPath() + ": the box is beside the volume" };
  }
  double bytes = 0; // of a sample of all arrays
  for (const std::size_t array : arrays)
  {
    const ArrayDescription& description = volume.GetHeader().Arrays[array];
    bytes += static_cast<double>(GetValueSize(description.Type)) * description.Components;
  }
  auto found = PlanBox(volume, finest,
    this->MemoryLimit * Mebibyte * (ranks ? ranks->GetNumberOfProcesses() : 1) / bytes);
  if (!found)
  {
    return { StatusCode::InvalidArgument,
      volume.GetPath() + ": not even the coarsest level of the box fits the memory limit of " +
        std::to_string(this->MemoryLimit) + " MiB" };
  }
  plan = std::move(*found);
  const Index3 size = plan.Grid.GetDimensions();
  plan.Size = std::to_string(size[0]) + " x " + std::to_string(size[1]) + " x " +
    std::to_string(size[2]) + " samples, " + DescribeMemory(bytes * plan.CountPoints());
  plan.Note = plan.Level == 0 ? ""
                              : "; full resolution takes " +
      DescribeMemory(bytes * static_cast<double>(finest.GetNumberOfVertices()));
  return Status::Ok();
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
