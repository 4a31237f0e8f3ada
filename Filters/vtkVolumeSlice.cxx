// SPDX-FileCopyrightText: Copyright (c) 2026, the ScalableIsosurface authors
// SPDX-License-Identifier: BSD-3-Clause
#include "vtkVolumeSlice.h"

#include "SampledImage.h"
#include "VolumeInput.h"

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
#include "vtkPoints.h"
#include "vtkPolyData.h"
#include "vtkSmartPointer.h"
#include "vtkUnsignedCharArray.h"

#include "ControllerCommunicator.h"
#include "ErrorReport.h"
#include "Ground/Base/Fingerprint.h"
#include "Ground/Volume/PointPrecision.h"
#include "ImageSamples.h"
#include "Storage/Sampling/PlaneLattice.h"
#include "Storage/Sampling/PointSampling.h"
#include "Storage/Sampling/SampledLines.h"
#include "Storage/Store/BlockedVolume.h"

#include <algorithm>
#include <array>
#include <memory>
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

// Of a coarse slice: two cores read and draw it within some 0.1 s.
constexpr double CoarsePoints = 3e5;
// Level 1 is stored in the blocks of full resolution, and would read as much.
constexpr int CoarseLevel = 2;

// Leaves out the lines with a place without samples, and their points.
void RemoveLinesWithoutSamples(vtkImageData* image, vtkPolyData* lines)
{
  if (lines->GetNumberOfLines() == 0)
  {
    return;
  }
  const int* extent = image->GetExtent();
  isosurface::ImageLines all;
  for (vtkIdType point = 0; point < lines->GetNumberOfPoints(); ++point)
  {
    double index[3];
    image->TransformPhysicalPointToContinuousIndex(lines->GetPoint(point), index);
    all.Points.push_back({ index[0] - extent[0], index[1] - extent[2] });
  }
  vtkNew<vtkIdList> ends;
  for (vtkIdType line = 0; line < lines->GetNumberOfLines(); ++line)
  {
    lines->GetLines()->GetCellAtId(line, ends);
    all.Lines.push_back({ ends->GetId(0), ends->GetId(1) });
  }
  vtkUnsignedCharArray* hidden = image->GetPointGhostArray();
  const isosurface::KeptLines kept = isosurface::KeepSampledLines(all, extent[1] - extent[0] + 1,
    extent[3] - extent[2] + 1, hidden ? hidden->GetPointer(0) : nullptr);

  vtkNew<vtkIdList> numbers;
  for (const std::int64_t point : kept.Points)
  {
    numbers->InsertNextId(point);
  }
  vtkNew<vtkPoints> points;
  points->SetDataType(lines->GetPoints()->GetDataType());
  lines->GetPoints()->GetPoints(numbers, points);
  vtkNew<vtkCellArray> cells;
  for (const auto& line : kept.Lines)
  {
    cells->InsertNextCell({ line[0], line[1] });
  }
  vtkNew<vtkPolyData> sampled;
  sampled->SetPoints(points);
  sampled->SetLines(cells);
  vtkDataArray* scalars = lines->GetPointData()->GetScalars();
  vtkSmartPointer<vtkDataArray> isovalues = vtk::TakeSmartPointer(scalars->NewInstance());
  isovalues->SetName(scalars->GetName());
  isovalues->SetNumberOfTuples(numbers->GetNumberOfIds());
  scalars->GetTuples(numbers, isovalues);
  sampled->GetPointData()->SetScalars(isovalues);
  lines->ShallowCopy(sampled);
}

// Moves lines in structured coordinates to where the image is, with float64 points.
void PlaceInWorld(vtkImageData* image, vtkPolyData* lines)
{
  vtkNew<vtkPoints> points;
  points->SetDataTypeToDouble();
  points->SetNumberOfPoints(lines->GetNumberOfPoints());
  for (vtkIdType point = 0; point < lines->GetNumberOfPoints(); ++point)
  {
    double place[3];
    image->TransformContinuousIndexToPhysicalPoint(lines->GetPoint(point), place);
    points->SetPoint(point, place);
  }
  lines->SetPoints(points);
}

} // namespace

struct vtkVolumeSlice::Steps : isosurface::SampledImage
{
  explicit Steps(vtkVolumeSlice& filter)
    : SampledImage(filter)
    , Filter(filter)
  {
  }

  vtkMultiProcessController* GetController() const override { return this->Filter.Controller; }
  std::uint64_t SumProperties() const override;
  /// The plane at the finest level that has few enough points, or, if it may be coarse, at one that
  /// is soon there.
  Result<ImagePlan> Plan(const isosurface::BlockedVolume& volume, const std::vector<std::size_t>&,
    bool isCoarse) const override;
  /// The isolines of an array of the image, without those in cells with a hidden point.
  void MakeIsolines(vtkImageData* image, vtkPolyData* isolines) const;

  vtkVolumeSlice& Filter;
};

//------------------------------------------------------------------------------
vtkVolumeSlice::vtkVolumeSlice()
  : Refinement(isosurface::Refinement().ToValues())
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
  return this->Internals->GetText().c_str();
}

//------------------------------------------------------------------------------
void vtkVolumeSlice::AllowCoarse(vtkTypeBool allowed)
{
  this->Internals->AllowCoarse(allowed != 0);
}

//------------------------------------------------------------------------------
int vtkVolumeSlice::GetFinal()
{
  return this->Internals->IsFinal() ? 1 : 0;
}

//------------------------------------------------------------------------------
void vtkVolumeSlice::Refine()
{
  if (this->Internals->Refine())
  {
    this->Modified();
  }
}

//------------------------------------------------------------------------------
void vtkVolumeSlice::PrepareRefinement(int milliseconds)
{
  this->Refinement =
    this->Internals->PrepareRefinement(std::max(0, milliseconds) / 1000.0).ToValues();
}

//------------------------------------------------------------------------------
void vtkVolumeSlice::DropRefinement()
{
  this->Internals->DropRefinement();
}

//------------------------------------------------------------------------------
int vtkVolumeSlice::RequestInformation(
  vtkInformation*, vtkInformationVector** input, vtkInformationVector* output)
{
  output->GetInformationObject(1)->Set(vtkAlgorithm::CAN_HANDLE_PIECE_REQUEST(), 1);
  return this->Internals->TellImage(input[0]->GetInformationObject(0), output);
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
  auto* isolines = vtkPolyData::GetData(output, 1);
  isolines->Initialize();
  int result = 0;
  const bool isMade = steps.Make(request, input[0]->GetInformationObject(0), output, result);
  auto* image = vtkImageData::GetData(output, 0);
  if (!isMade || this->Isovalues->GetNumberOfContours() == 0)
  {
    return result;
  }
  isosurface::ControllerCommunicator ranks(this->Controller);
  const Status status = isosurface::AttemptOnAll(ranks, "the isolines cannot be made",
    [&]
    {
      steps.MakeIsolines(image, isolines);
      return Status::Ok();
    });
  if (!status.IsOk())
  {
    image->Initialize();
    isolines->Initialize();
  }
  return isosurface::EndExecution(this, output, status);
}

//------------------------------------------------------------------------------
void vtkVolumeSlice::Steps::MakeIsolines(vtkImageData* image, vtkPolyData* isolines) const
{
  const int* size = image->GetDimensions();
  vtkContourValues* values = this->Filter.Isovalues;
  const std::string& name = this->Filter.IsolineArray;
  vtkDataArray* array = name.empty() ? image->GetPointData()->GetScalars()
                                     : image->GetPointData()->GetArray(name.c_str());
  if (size[0] < 2 || size[1] < 2)
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
  const isosurface::GridGeometry grid = isosurface::MakeGridGeometry(image, image->GetExtent());
  const bool areDouble = isosurface::NeedsDoublePoints(grid, nullptr);
  if (areDouble)
  {
    scalars->SetOrigin(0, 0, 0);
    scalars->SetSpacing(1, 1, 1);
    scalars->SetDirectionMatrix(1, 0, 0, 0, 1, 0, 0, 0, 1);
  }
  vtkNew<vtkFlyingEdges2D> contour;
  contour->SetInputData(scalars);
  contour->SetNumberOfContours(static_cast<int>(values->GetNumberOfContours()));
  for (int number = 0; number < values->GetNumberOfContours(); ++number)
  {
    contour->SetValue(number, values->GetValue(number));
  }
  contour->Update();
  isolines->ShallowCopy(contour->GetOutput());
  if (areDouble)
  {
    PlaceInWorld(image, isolines);
  }
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
Result<ImagePlan> vtkVolumeSlice::Steps::Plan(
  const isosurface::BlockedVolume& volume, const std::vector<std::size_t>&, bool isCoarse) const
{
  isosurface::Plane plane;
  std::copy_n(this->Filter.Origin, 3, plane.Origin.begin());
  std::copy_n(this->Filter.Normal, 3, plane.Normal.begin());
  auto found = isosurface::FindLatticeWithin(volume, plane, 1e6 * this->Filter.MaximumPoints);
  if (!found)
  {
    return Status(StatusCode::InvalidArgument,
      volume.GetPath() + ": the plane is beside the volume, or its normal is 0");
  }
  if (isCoarse && found->Lattice.CountPoints() > CoarsePoints)
  {
    auto coarse = isosurface::FindLatticeWithin(
      volume, plane, CoarsePoints, std::max(found->Level, CoarseLevel));
    found = coarse ? std::move(coarse) : std::move(found);
  }
  const auto lattice = std::make_shared<const PlaneLattice>(std::move(found->Lattice));
  const auto interpolation = this->Filter.Interpolation == NEAREST
    ? isosurface::Interpolation::Nearest
    : isosurface::Interpolation::Linear;
  ImagePlan image;
  image.Level = found->Level;
  image.Grid = lattice->GetImage();
  image.HasOutside = !lattice->IsAligned();
  const isosurface::Index3 size = image.Grid.GetDimensions();
  image.Size = std::to_string(size[0]) + " x " + std::to_string(size[1]) + " points";
  image.Fill = [lattice, interpolation](const isosurface::LevelSamples& samples,
                 std::size_t variable, const isosurface::VertexBox& part, int threads, void* values,
                 std::ptrdiff_t stride, std::uint8_t* isInside,
                 isosurface::QueryStatistics& statistics, const isosurface::Progress& progress)
  {
    return lattice->Sample(samples, variable, interpolation, part, threads, values, stride,
      isInside, statistics, progress);
  };
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
