// SPDX-FileCopyrightText: Copyright (c) 2026, the ScalableIsosurface authors
// SPDX-License-Identifier: BSD-3-Clause
#include "vtkVolumeSlice.h"

#include "SampledImage.h"
#include "VolumeReading.h"

#include "vtkCellArray.h"
#include "vtkDataArray.h"
#include "vtkExecutive.h"
#include "vtkFlyingEdges2D.h"
#include "vtkIdList.h"
#include "vtkImageData.h"
#include "vtkInformation.h"
#include "vtkInformationVector.h"
#include "vtkMultiProcessController.h"
#include "vtkNew.h"
#include "vtkObjectFactory.h"
#include "vtkPointData.h"
#include "vtkPolyData.h"
#include "vtkUnsignedCharArray.h"

#include "ControllerCommunicator.h"
#include "ErrorReport.h"
#include "Ground/Base/Fingerprint.h"
#include "Storage/Sampling/PlaneLattice.h"
#include "Storage/Sampling/PointSampling.h"
#include "Storage/Store/BlockedVolume.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <utility>
#include <vector>

vtkStandardNewMacro(vtkVolumeSlice);
vtkCxxSetObjectMacro(vtkVolumeSlice, Controller, vtkMultiProcessController);

using isosurface::ImagePlan;
using isosurface::PlaneLattice;
using isosurface::Result;
using isosurface::Status;
using isosurface::StatusCode;

namespace
{

// Removes the lines in cells with a hidden point: one of their ends has no sample. So have the lines
// beside NaN: an end of them is nowhere.
void RemoveLinesWithoutSamples(vtkImageData* image, vtkPolyData* lines)
{
  vtkUnsignedCharArray* hidden = image->GetPointGhostArray();
  const int* extent = image->GetExtent();
  const vtkIdType row = extent[1] - extent[0] + 1;
  const auto isHidden = [&](const double middle[3])
  {
    if (std::isnan(middle[0] + middle[1] + middle[2]))
    {
      return true;
    }
    if (!hidden)
    {
      return false;
    }
    double index[3];
    image->TransformPhysicalPointToContinuousIndex(middle, index);
    const auto i = std::clamp<vtkIdType>(
      static_cast<vtkIdType>(std::floor(index[0])) - extent[0], 0, extent[1] - extent[0] - 1);
    const auto j = std::clamp<vtkIdType>(
      static_cast<vtkIdType>(std::floor(index[1])) - extent[2], 0, extent[3] - extent[2] - 1);
    const vtkIdType low = i + row * j;
    return (hidden->GetValue(low) | hidden->GetValue(low + 1) | hidden->GetValue(low + row) |
             hidden->GetValue(low + row + 1)) != 0;
  };
  vtkNew<vtkCellArray> kept;
  vtkNew<vtkIdList> ends;
  for (vtkIdType line = 0; line < lines->GetNumberOfLines(); ++line)
  {
    lines->GetLines()->GetCellAtId(line, ends);
    double first[3];
    double second[3];
    lines->GetPoint(ends->GetId(0), first);
    lines->GetPoint(ends->GetId(1), second);
    const double middle[3] = { (first[0] + second[0]) / 2, (first[1] + second[1]) / 2,
      (first[2] + second[2]) / 2 };
    if (!isHidden(middle))
    {
      kept->InsertNextCell(ends);
    }
  }
  lines->SetLines(kept);
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
  /// The isolines of an array of the image, without those in cells with a hidden point.
  void MakeIsolines(vtkImageData* image, vtkPolyData* isolines) const;
  /// The lattice at the finest level that has few enough points, or at the coarsest one that the
  /// plane meets.
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
  this->SetNumberOfOutputPorts(2);
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
int vtkVolumeSlice::FillOutputPortInformation(int port, vtkInformation* info)
{
  info->Set(vtkDataObject::DATA_TYPE_NAME(), port == 0 ? "vtkImageData" : "vtkPolyData");
  return 1;
}

//------------------------------------------------------------------------------
vtkPolyData* vtkVolumeSlice::GetIsolines()
{
  return vtkPolyData::SafeDownCast(this->GetOutputDataObject(1));
}

//------------------------------------------------------------------------------
void vtkVolumeSlice::SetIsolineArray(const char* name)
{
  const std::string changed = name ? name : "";
  if (this->IsolineArray != changed)
  {
    this->IsolineArray = changed;
    this->Modified();
  }
}

//------------------------------------------------------------------------------
vtkMTimeType vtkVolumeSlice::GetMTime()
{
  return std::max(this->Superclass::GetMTime(), this->Isovalues->GetMTime());
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
  output->GetInformationObject(1)->Set(vtkAlgorithm::CAN_HANDLE_PIECE_REQUEST(), 1);
  this->Internals->Image.TellImage(input[0]->GetInformationObject(0),
    output->GetInformationObject(0), this->Controller,
    [this](const isosurface::BlockedVolume& volume, const std::vector<std::size_t>&)
    { return this->Internals->Plan(volume); });
  return 1;
}

//------------------------------------------------------------------------------
int vtkVolumeSlice::RequestUpdateExtent(
  vtkInformation* request, vtkInformationVector** input, vtkInformationVector* output)
{
  const int port = std::max(0, request->Get(vtkExecutive::FROM_OUTPUT_PORT()));
  isosurface::AskVolume(
    *this, input[0]->GetInformationObject(0), output->GetInformationObject(port));
  return 1;
}

//------------------------------------------------------------------------------
int vtkVolumeSlice::RequestData(
  vtkInformation* request, vtkInformationVector** input, vtkInformationVector* output)
{
  Steps& steps = *this->Internals;
  const auto interpolation = this->Interpolation == NEAREST ? isosurface::Interpolation::Nearest
                                                            : isosurface::Interpolation::Linear;
  auto* isolines = vtkPolyData::GetData(output, 1);
  isolines->Initialize();
  int result = 0;
  const bool isMade = steps.Image.Make(
    request, input[0]->GetInformationObject(0), output, this->Controller, steps.SumProperties(),
    [&](const isosurface::BlockedVolume& volume, const std::vector<std::size_t>&)
    { return steps.Plan(volume); },
    [&](const isosurface::LevelSamples& samples, std::size_t variable,
      const isosurface::VertexBox& part, int threads, void* values, std::ptrdiff_t stride,
      std::uint8_t* isInside, isosurface::QueryStatistics& statistics,
      const isosurface::Progress& progress)
    {
      return steps.Lattice->Sample(samples, variable, interpolation, part, threads, values, stride,
        isInside, statistics, progress);
    },
    result);
  if (isMade)
  {
    steps.MakeIsolines(vtkImageData::GetData(output, 0), isolines);
  }
  return result;
}

//------------------------------------------------------------------------------
void vtkVolumeSlice::Steps::MakeIsolines(vtkImageData* image, vtkPolyData* isolines) const
{
  const int* size = image->GetDimensions();
  vtkContourValues* values = this->Filter.Isovalues;
  const std::string& name = this->Filter.IsolineArray;
  vtkDataArray* array = name.empty() ? image->GetPointData()->GetScalars()
                                     : image->GetPointData()->GetArray(name.c_str());
  if (values->GetNumberOfContours() == 0 || size[0] < 2 || size[1] < 2)
  {
    return;
  }
  if (!array)
  {
    isosurface::ReportWarning(&this->Filter,
      isosurface::ControllerCommunicator(this->Filter.Controller), Status::Ok(),
      "there are no isolines: the slice has no array \"" + name + "\"");
    return;
  }
  vtkNew<vtkImageData> scalars;
  scalars->CopyStructure(image);
  scalars->GetPointData()->SetScalars(array);
  vtkNew<vtkFlyingEdges2D> contour;
  contour->SetInputData(scalars);
  contour->SetNumberOfContours(static_cast<int>(values->GetNumberOfContours()));
  for (int number = 0; number < values->GetNumberOfContours(); ++number)
  {
    contour->SetValue(number, values->GetValue(number));
  }
  contour->Update();
  isolines->ShallowCopy(contour->GetOutput());
  RemoveLinesWithoutSamples(image, isolines);
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
  properties.AddText(this->Filter.IsolineArray);
  for (int number = 0; number < this->Filter.GetNumberOfContours(); ++number)
  {
    properties.AddReal(this->Filter.GetValue(number));
  }
  return properties.Get();
}

//------------------------------------------------------------------------------
Result<ImagePlan> vtkVolumeSlice::Steps::Plan(const isosurface::BlockedVolume& volume)
{
  isosurface::Plane plane;
  std::copy_n(this->Filter.Origin, 3, plane.Origin.begin());
  std::copy_n(this->Filter.Normal, 3, plane.Normal.begin());
  ImagePlan image;
  for (int level = 0; level < volume.GetNumberOfLevels(); ++level)
  {
    // An oblique slice of the last level has larger pixels, if need be.
    const double maximum = 1e6 * this->Filter.MaximumPoints;
    auto lattice =
      PlaneLattice::Make(volume.GetHeader().Grid.Coarsen(level), volume.GetLines(level), plane,
        level + 1 < volume.GetNumberOfLevels() ? PlaneLattice::Unlimited : maximum);
    if (!lattice && level == 0)
    {
      return Status(StatusCode::InvalidArgument,
        volume.GetPath() + ": the plane is beside the volume, or its normal is 0");
    }
    if (!lattice)
    {
      break; // the last vertices of a coarse level may lie before those of the volume
    }
    this->Lattice = std::move(lattice);
    image.Level = level;
    image.Grid = this->Lattice->GetImage();
    image.HasOutside = !this->Lattice->IsAligned();
    if (static_cast<double>(image.Grid.GetNumberOfVertices()) <= maximum)
    {
      break;
    }
  }
  const isosurface::Index3 size = image.Grid.GetDimensions();
  image.Size = std::to_string(size[0]) + " x " + std::to_string(size[1]) + " points";
  return image;
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
  os << indent << "IsolineArray: " << this->IsolineArray << "\n";
  this->Isovalues->PrintSelf(os, indent);
  os << indent << "Controller: " << this->Controller << "\n";
}
