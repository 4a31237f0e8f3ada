// SPDX-FileCopyrightText: Copyright (c) 2026, the ScalableIsosurface authors
// SPDX-License-Identifier: BSD-3-Clause
#include "vtkVolumeSlice.h"

#include "vtkCellArray.h"
#include "vtkDataArray.h"
#include "vtkFlyingEdges2D.h"
#include "vtkIdList.h"
#include "vtkImageData.h"
#include "vtkInformation.h"
#include "vtkInformationVector.h"
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
#include "Storage/Sampling/ImagePlan.h"
#include "Storage/Sampling/SampledLines.h"
#include "Storage/Store/BlockedVolume.h"

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

vtkStandardNewMacro(vtkVolumeSlice);

using namespace isosurface;

namespace
{

// Leaves out the lines with a place without samples, and their points.
void RemoveLinesWithoutSamples(vtkImageData* image, vtkPolyData* lines)
{
  if (lines->GetNumberOfLines() == 0)
  {
    return;
  }
  const int* extent = image->GetExtent();
  ImageLines all;
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
  const KeptLines kept = KeepSampledLines(all, extent[1] - extent[0] + 1, extent[3] - extent[2] + 1,
    hidden ? hidden->GetPointer(0) : nullptr);

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

vtkVolumeSlice::vtkVolumeSlice()
{
  this->SetNumberOfOutputPorts(2);
}

int vtkVolumeSlice::FillOutputPortInformation(int port, vtkInformation* info)
{
  info->Set(vtkDataObject::DATA_TYPE_NAME(), port == 0 ? "vtkImageData" : "vtkPolyData");
  return 1;
}

vtkPolyData* vtkVolumeSlice::GetIsolines()
{
  return vtkPolyData::SafeDownCast(this->GetOutputDataObject(1));
}

vtkMTimeType vtkVolumeSlice::GetMTime()
{
  return std::max(this->Superclass::GetMTime(), this->Isovalues->GetMTime());
}

int vtkVolumeSlice::RequestData(
  vtkInformation* request, vtkInformationVector** input, vtkInformationVector* output)
{
  auto* isolines = vtkPolyData::GetData(output, 1);
  isolines->Initialize();
  Status status = this->MakeImage(request, input[0]->GetInformationObject(0), output);
  if (status.IsOk() && this->Isovalues->GetNumberOfContours() > 0)
  {
    auto* image = vtkImageData::GetData(output, 0);
    ControllerCommunicator ranks(this->GetController());
    status = AttemptOnAll(ranks, "the isolines cannot be made",
      [&]
      {
        this->MakeIsolines(image, isolines);
        return Status::Ok();
      });
  }
  return EndExecution(this, output, status);
}

void vtkVolumeSlice::MakeIsolines(vtkImageData* image, vtkPolyData* isolines)
{
  const int* size = image->GetDimensions();
  vtkContourValues* values = this->Isovalues;
  const std::string& name = this->IsolineArray;
  vtkDataArray* array = name.empty() ? image->GetPointData()->GetScalars()
                                     : image->GetPointData()->GetArray(name.c_str());
  if (size[0] < 2 || size[1] < 2)
  {
    return;
  }
  if (!array)
  {
    ReportWarning(this, ControllerCommunicator(this->GetController()), Status::Ok(),
      "there are no isolines: the slice has no array \"" + name + "\"");
    return;
  }
  vtkNew<vtkImageData> scalars;
  scalars->CopyStructure(image);
  scalars->GetPointData()->SetScalars(array);
  const GridGeometry grid = MakeGridGeometry(image, image->GetExtent());
  const bool areDouble = NeedsDoublePoints(grid, nullptr);
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

std::uint64_t vtkVolumeSlice::SumProperties()
{
  Fingerprint properties;
  properties.AddReals(this->Origin);
  properties.AddReals(this->Normal);
  properties.AddNumber(static_cast<std::uint64_t>(this->Interpolation));
  properties.AddReal(this->MaximumPoints);
  properties.AddText(this->IsolineArray);
  for (int number = 0; number < this->GetNumberOfContours(); ++number)
  {
    properties.AddReal(this->GetValue(number));
  }
  return properties.Get();
}

Status vtkVolumeSlice::Plan(
  const BlockedVolume& volume, const std::vector<std::size_t>&, bool isCoarse, ImagePlan& plan)
{
  const double* origin = this->Origin;
  const double* normal = this->Normal;
  const Plane plane{ { origin[0], origin[1], origin[2] }, { normal[0], normal[1], normal[2] } };
  const auto interpolation = static_cast<isosurface::Interpolation>(this->Interpolation);
  auto found = isCoarse ? PlanCoarseSlice(volume, plane, interpolation, 1e6 * this->MaximumPoints)
                        : PlanSlice(volume, plane, interpolation, 1e6 * this->MaximumPoints);
  if (!found)
  {
    return { StatusCode::InvalidArgument,
      volume.GetPath() + ": the plane is beside the volume, or its normal is 0" };
  }
  plan = std::move(*found);
  return Status::Ok();
}

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
}
