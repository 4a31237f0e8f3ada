// SPDX-FileCopyrightText: Copyright (c) 2026, the ScalableIsosurface authors
// SPDX-License-Identifier: BSD-3-Clause
#include "vtkVolumeProbe.h"

#include "vtkBlockConsumerPipeline.h"

#include "VolumeInput.h"
#include "vtkBlockedVolumeHandle.h"

#include "vtkCharArray.h"
#include "vtkCompositeDataIterator.h"
#include "vtkCompositeDataSet.h"
#include "vtkDataSet.h"
#include "vtkInformation.h"
#include "vtkInformationVector.h"
#include "vtkMultiProcessController.h"
#include "vtkNew.h"
#include "vtkObjectFactory.h"
#include "vtkPointData.h"
#include "vtkSmartPointer.h"
#include "vtkStreamingDemandDrivenPipeline.h"

#include "ControllerCommunicator.h"
#include "ErrorReport.h"
#include "Ground/Base/Fingerprint.h"
#include "Ground/Volume/VertexPlaces.h"
#include "ImageSamples.h"
#include "RangedArray.h"
#include "Storage/Sampling/PointSampling.h"
#include "Storage/Store/BlockedVolume.h"

#include <algorithm>
#include <array>
#include <limits>
#include <set>
#include <vector>

vtkStandardNewMacro(vtkVolumeProbe);
vtkCxxSetObjectMacro(vtkVolumeProbe, Controller, vtkMultiProcessController);

using isosurface::Status;

namespace
{

// Copies a dataset without its samples: arrays that are added to the copy are not added to it.
void CopyPoints(vtkDataObject* from, vtkDataObject* to)
{
  auto* composite = vtkCompositeDataSet::SafeDownCast(from);
  if (!composite)
  {
    to->ShallowCopy(from);
    return;
  }
  auto* copies = vtkCompositeDataSet::SafeDownCast(to);
  copies->CopyStructure(composite);
  const auto iterator = vtkSmartPointer<vtkCompositeDataIterator>::Take(composite->NewIterator());
  for (iterator->InitTraversal(); !iterator->IsDoneWithTraversal(); iterator->GoToNextItem())
  {
    vtkDataObject* leaf = iterator->GetCurrentDataObject();
    const auto copy = vtkSmartPointer<vtkDataObject>::Take(leaf->NewInstance());
    copy->ShallowCopy(leaf);
    copies->SetDataSet(iterator, copy);
  }
}

// The times of the volume and those of the points: at each of them the values may be others.
void TellTimes(vtkInformationVector** input, vtkInformation* outInfo)
{
  using Keys = vtkStreamingDemandDrivenPipeline;
  std::set<double> steps;
  std::set<double> ends;
  for (int port = 0; port < 2; ++port)
  {
    vtkInformation* inInfo = input[port]->GetInformationObject(0);
    const double* own = inInfo->Get(Keys::TIME_STEPS());
    steps.insert(own, own + inInfo->Length(Keys::TIME_STEPS()));
    const double* range = inInfo->Get(Keys::TIME_RANGE());
    ends.insert(range, range + inInfo->Length(Keys::TIME_RANGE()));
  }
  if (!steps.empty())
  {
    const std::vector<double> all(steps.begin(), steps.end());
    outInfo->Set(Keys::TIME_STEPS(), all.data(), static_cast<int>(all.size()));
  }
  if (!ends.empty())
  {
    const double range[2] = { *ends.begin(), *ends.rbegin() };
    outInfo->Set(Keys::TIME_RANGE(), range, 2);
  }
}

// Adds an array of the volume for the points of a dataset, filled with what points beyond the volume have.
void* AddPointArray(vtkDataSet* points, const isosurface::ArrayDescription& description)
{
  auto values = vtkSmartPointer<vtkDataArray>::Take(
    vtkDataArray::CreateDataArray(isosurface::GetVTKType(description.Type)));
  values->SetName(description.Name.c_str());
  values->SetNumberOfComponents(description.Components);
  isosurface::AllocateTuples(values, points->GetNumberOfPoints());
  values->Fill(
    isosurface::IsFloatingType(description.Type) ? std::numeric_limits<double>::quiet_NaN() : 0.0);
  points->GetPointData()->AddArray(values);
  return values->GetVoidPointer(0);
}

/// Whether an algorithm, or one that it has its input from, is the reader of a volume.
bool IsBehind(vtkAlgorithm* algorithm, const vtkBlockedVolumeHandle& handle)
{
  for (int port = 0; port < algorithm->GetNumberOfOutputPorts(); ++port)
  {
    const isosurface::VolumeInput output(algorithm->GetOutputInformation(port));
    if (output && &output.GetHandle() == &handle)
    {
      return true;
    }
  }
  for (int port = 0; port < algorithm->GetNumberOfInputPorts(); ++port)
  {
    for (int input = 0; input < algorithm->GetNumberOfInputConnections(port); ++input)
    {
      if (IsBehind(algorithm->GetInputAlgorithm(port, input), handle))
      {
        return true;
      }
    }
  }
  return false;
}

} // namespace

struct vtkVolumeProbe::Steps
{
  vtkVolumeProbe& Filter;
  const isosurface::VolumeInput& Input;
  int Threads;
  std::uint64_t Points = 0;
  std::uint64_t PointsInside = 0;

  /// Adds the arrays of the volume to datasets that have their own already.
  Status Probe(const std::vector<vtkDataSet*>& datasets);
  Status ProbeOne(const isosurface::LevelSamples& samples, vtkDataSet* dataset,
    const isosurface::Progress& progress);
};

vtkVolumeProbe::vtkVolumeProbe()
{
  this->SetNumberOfInputPorts(2);
  this->SetController(vtkMultiProcessController::GetGlobalController());
}

vtkVolumeProbe::~vtkVolumeProbe()
{
  this->SetController(nullptr);
}

vtkExecutive* vtkVolumeProbe::CreateDefaultExecutive()
{
  return vtkBlockConsumerPipeline::New();
}

void vtkVolumeProbe::SetSourceConnection(vtkAlgorithmOutput* points)
{
  this->SetInputConnection(1, points);
}

void vtkVolumeProbe::SetSourceData(vtkDataObject* points)
{
  this->SetInputData(1, points);
}

int vtkVolumeProbe::FillInputPortInformation(int port, vtkInformation* info)
{
  if (port == 0)
  {
    info->Set(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE(), "vtkDataObject");
    return 1;
  }
  info->Set(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE(), "vtkDataSet");
  info->Append(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE(), "vtkCompositeDataSet");
  return 1;
}

int vtkVolumeProbe::RequestDataObject(
  vtkInformation*, vtkInformationVector** input, vtkInformationVector* output)
{
  vtkDataObject* points = vtkDataObject::GetData(input[1], 0);
  vtkInformation* outInfo = output->GetInformationObject(0);
  vtkDataObject* made = vtkDataObject::GetData(outInfo);
  if (points && (!made || !made->IsA(points->GetClassName())))
  {
    const auto empty = vtkSmartPointer<vtkDataObject>::Take(points->NewInstance());
    outInfo->Set(vtkDataObject::DATA_OBJECT(), empty);
  }
  return 1;
}

int vtkVolumeProbe::RequestInformation(
  vtkInformation*, vtkInformationVector** input, vtkInformationVector* output)
{
  // The extent and the place are those of the points.
  vtkInformation* outInfo = output->GetInformationObject(0);
  vtkInformation* points = input[1]->GetInformationObject(0);
  outInfo->CopyEntry(points, vtkStreamingDemandDrivenPipeline::WHOLE_EXTENT());
  outInfo->CopyEntry(points, vtkDataObject::ORIGIN());
  outInfo->CopyEntry(points, vtkDataObject::SPACING());
  outInfo->CopyEntry(points, vtkDataObject::DIRECTION());
  TellTimes(input, outInfo);
  return 1;
}

int vtkVolumeProbe::RequestUpdateExtent(
  vtkInformation*, vtkInformationVector** input, vtkInformationVector* output)
{
  vtkInformation* inInfo = input[0]->GetInformationObject(0);
  isosurface::AskVolume(*this, inInfo, output->GetInformationObject(0));
  const isosurface::VolumeInput volume(inInfo);
  if (volume && IsBehind(this->GetInputAlgorithm(1, 0), volume.GetHandle()))
  {
    // What makes the points needs the output of the same reader, in this same update.
    volume.GetHandle().EndTaking(this);
  }
  return 1;
}

int vtkVolumeProbe::RequestData(
  vtkInformation*, vtkInformationVector** input, vtkInformationVector* output)
{
  const isosurface::VolumeInput volume(input[0]->GetInformationObject(0));
  vtkDataObject* made = vtkDataObject::GetData(output, 0);
  made->Initialize();
  isosurface::ControllerCommunicator ranks(this->Controller);
  isosurface::Fingerprint properties;
  properties.AddNumber(static_cast<std::uint64_t>(this->Interpolation));
  std::vector<std::uint64_t> counts(2, 0); // points, and those inside
  Status status = isosurface::AgreeOnVolume(*this, ranks, volume, properties.Get());
  if (status.IsOk())
  {
    Steps steps = { *this, volume, ranks.ChooseThreads(0) };
    status = isosurface::ReadVolume(*this, ranks, volume,
      [&]
      {
        CopyPoints(vtkDataObject::GetData(input[1], 0), made);
        return steps.Probe(vtkCompositeDataSet::GetDataSets<vtkDataSet>(made));
      });
    counts = { steps.Points, steps.PointsInside };
  }
  if (status.IsOk())
  {
    ranks.ReduceSum(counts);
    const bool areOutside = counts[0] > 0 && counts[1] == 0;
    isosurface::ReportWarning(this, ranks, status,
      areOutside ? volume.GetVolume()->GetPath() + ": all " + std::to_string(counts[0]) +
          " points are beyond the volume"
                 : "");
  }
  if (!status.IsOk())
  {
    made->Initialize();
  }
  return isosurface::EndExecution(this, output, status);
}

Status vtkVolumeProbe::Steps::Probe(const std::vector<vtkDataSet*>& datasets)
{
  ISOSURFACE_ASSIGN_OR_RETURN(const auto samples,
    isosurface::LevelSamples::Open(this->Input.GetVolume(), this->Input.GetTimeStep(), 0));
  const auto all = static_cast<double>(datasets.size());
  for (std::size_t number = 0; number < datasets.size(); ++number)
  {
    const auto begin = static_cast<double>(number);
    ISOSURFACE_RETURN_IF_ERROR(this->ProbeOne(*samples, datasets[number],
      isosurface::MakeProgress(this->Filter, begin / all, (begin + 1) / all)));
  }
  return Status::Ok();
}

Status vtkVolumeProbe::Steps::ProbeOne(const isosurface::LevelSamples& samples, vtkDataSet* dataset,
  const isosurface::Progress& progress)
{
  const isosurface::BlockedVolume& volume = samples.GetVolume();
  const isosurface::VertexPlaces places(volume.GetHeader().Grid, volume.GetLines(0));
  const auto find = [dataset](std::int64_t point)
  {
    std::array<double, 3> place{};
    dataset->GetPoint(point, place.data());
    return place;
  };
  const vtkIdType points = dataset->GetNumberOfPoints();
  if (points > 0)
  {
    find(0); // from then on several threads may ask for points
  }
  const auto interpolation = this->Filter.Interpolation == NEAREST
    ? isosurface::Interpolation::Nearest
    : isosurface::Interpolation::Linear;
  vtkNew<vtkCharArray> mask;
  mask->SetName("vtkValidPointMask");
  isosurface::AllocateTuples(mask, points);
  mask->FillValue(0);
  auto* isInside = reinterpret_cast<std::uint8_t*>(mask->GetPointer(0));
  const std::vector<std::size_t>& arrays = this->Input.GetHandle().GetArrays();
  std::vector<void*> values;
  for (const std::size_t array : arrays)
  {
    values.push_back(AddPointArray(dataset, volume.GetHeader().Arrays[array]));
  }
  isosurface::QueryStatistics statistics;
  ISOSURFACE_RETURN_IF_ERROR(
    isosurface::SampleComponents(volume.GetVariables(), arrays, values, progress,
      [&](std::size_t variable, void* first, int stride, const isosurface::Progress& advance)
      {
        return isosurface::SamplePoints(samples, variable, interpolation,
          isosurface::MakePointPortions(points, places, find), this->Threads, first, stride,
          isInside, statistics, advance);
      }));
  dataset->GetPointData()->AddArray(mask);
  this->Points += static_cast<std::uint64_t>(points);
  this->PointsInside +=
    static_cast<std::uint64_t>(std::count(isInside, isInside + points, std::uint8_t{ 1 }));
  return Status::Ok();
}

void vtkVolumeProbe::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  os << indent << "Interpolation: " << this->Interpolation << "\n";
  os << indent << "Controller: " << this->Controller << "\n";
}
