// SPDX-FileCopyrightText: Copyright (c) 2026, the ScalableIsosurface authors
// SPDX-License-Identifier: BSD-3-Clause
#include "vtkVolumeSlice.h"

#include "SampledImage.h"

#include "vtkInformation.h"
#include "vtkInformationVector.h"
#include "vtkMultiProcessController.h"
#include "vtkObjectFactory.h"

#include "Ground/Base/Fingerprint.h"
#include "Storage/Sampling/PlaneLattice.h"
#include "Storage/Sampling/PointSampling.h"
#include "Storage/Store/BlockedVolume.h"

#include <algorithm>

vtkStandardNewMacro(vtkVolumeSlice);
vtkCxxSetObjectMacro(vtkVolumeSlice, Controller, vtkMultiProcessController);

using isosurface::ImagePlan;
using isosurface::PlaneLattice;
using isosurface::Result;
using isosurface::Status;
using isosurface::StatusCode;

namespace
{

std::string DescribeLevel(int level)
{
  return level == 0 ? "full resolution" : "level " + std::to_string(level);
}

} // namespace

struct vtkVolumeSlice::Steps
{
  explicit Steps(vtkVolumeSlice& filter)
    : Filter(filter)
    , Image(filter)
  {
  }

  vtkVolumeSlice& Filter;
  isosurface::SampledImage Image;
  std::optional<PlaneLattice> Lattice; ///< of the last plan

  std::uint64_t SumProperties() const;
  /// The lattice at the finest level that has few enough points.
  Result<ImagePlan> Plan(const isosurface::BlockedVolume& volume);
};

//------------------------------------------------------------------------------
vtkVolumeSlice::vtkVolumeSlice()
  : Origin{ 0, 0, 0 }
  , Normal{ 0, 0, 1 }
  , Interpolation(LINEAR)
  , MaximumPoints(16)
  , Controller(nullptr)
  , Internals(std::make_unique<Steps>(*this))
{
  this->SetController(vtkMultiProcessController::GetGlobalController());
}

//------------------------------------------------------------------------------
vtkVolumeSlice::~vtkVolumeSlice()
{
  this->SetController(nullptr);
}

//------------------------------------------------------------------------------
int vtkVolumeSlice::FillInputPortInformation(int, vtkInformation* info)
{
  info->Set(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE(), "vtkDataObject");
  return 1;
}

//------------------------------------------------------------------------------
const char* vtkVolumeSlice::GetShownText()
{
  return this->Internals->Image.GetText().c_str();
}

//------------------------------------------------------------------------------
int vtkVolumeSlice::RequestInformation(
  vtkInformation*, vtkInformationVector** input, vtkInformationVector* output)
{
  return this->Internals->Image.TellImage(input[0]->GetInformationObject(0),
    output->GetInformationObject(0), this->Controller,
    [this](const isosurface::BlockedVolume& volume, const std::vector<std::size_t>&)
    { return this->Internals->Plan(volume); });
}

//------------------------------------------------------------------------------
int vtkVolumeSlice::RequestUpdateExtent(
  vtkInformation*, vtkInformationVector** input, vtkInformationVector* output)
{
  isosurface::SampledImage::AskVolume(
    *this, input[0]->GetInformationObject(0), output->GetInformationObject(0));
  return 1;
}

//------------------------------------------------------------------------------
int vtkVolumeSlice::RequestData(
  vtkInformation*, vtkInformationVector** input, vtkInformationVector* output)
{
  Steps& steps = *this->Internals;
  const auto interpolation = this->Interpolation == NEAREST ? isosurface::Interpolation::Nearest
                                                            : isosurface::Interpolation::Linear;
  return steps.Image.Make(
    input[0]->GetInformationObject(0), output, this->Controller, steps.SumProperties(),
    [&](const isosurface::BlockedVolume& volume, const std::vector<std::size_t>&)
    { return steps.Plan(volume); },
    [&](const isosurface::LevelSamples& samples, std::size_t variable,
      const isosurface::VertexBox& part, int threads, void* values, std::ptrdiff_t stride,
      std::uint8_t* isInside, isosurface::QueryStatistics& statistics,
      const isosurface::Progress& progress)
    {
      return isosurface::SamplePoints(samples, variable, interpolation,
        steps.Lattice->MakePortions(part), threads, values, stride, isInside, statistics, progress);
    });
}

//------------------------------------------------------------------------------
std::uint64_t vtkVolumeSlice::Steps::SumProperties() const
{
  isosurface::Fingerprint properties;
  for (int axis = 0; axis < 3; ++axis)
  {
    properties.AddReal(this->Filter.Origin[axis]);
    properties.AddReal(this->Filter.Normal[axis]);
  }
  properties.AddNumber(static_cast<std::uint64_t>(this->Filter.Interpolation));
  properties.AddReal(this->Filter.MaximumPoints);
  return properties.Get();
}

//------------------------------------------------------------------------------
Result<ImagePlan> vtkVolumeSlice::Steps::Plan(const isosurface::BlockedVolume& volume)
{
  isosurface::Plane plane;
  std::copy_n(this->Filter.Origin, 3, plane.Origin.begin());
  std::copy_n(this->Filter.Normal, 3, plane.Normal.begin());
  for (int level = 0;; ++level)
  {
    this->Lattice =
      PlaneLattice::Make(volume.GetHeader().Grid.Coarsen(level), volume.GetLines(level), plane);
    if (!this->Lattice)
    {
      return Status(StatusCode::InvalidArgument,
        volume.GetPath() + ": the plane is beside the volume, or its normal is 0");
    }
    const isosurface::GridGeometry& grid = this->Lattice->GetImage();
    const bool isSmall =
      static_cast<double>(grid.GetNumberOfVertices()) <= 1e6 * this->Filter.MaximumPoints;
    if (isSmall || level + 1 == volume.GetNumberOfLevels())
    {
      ImagePlan image;
      image.Level = level;
      image.Grid = grid;
      image.HasOutside = !this->Lattice->IsAligned();
      const isosurface::Index3 size = grid.GetDimensions();
      image.Text = std::to_string(size[0]) + " x " + std::to_string(size[1]) + " points, " +
        DescribeLevel(level);
      return image;
    }
  }
}

//------------------------------------------------------------------------------
void vtkVolumeSlice::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  os << indent << "Origin: " << this->Origin[0] << " " << this->Origin[1] << " " << this->Origin[2]
     << "\n";
  os << indent << "Normal: " << this->Normal[0] << " " << this->Normal[1] << " " << this->Normal[2]
     << "\n";
  os << indent << "Interpolation: " << this->Interpolation << "\n";
  os << indent << "MaximumPoints: " << this->MaximumPoints << "\n";
  os << indent << "Controller: " << this->Controller << "\n";
}
