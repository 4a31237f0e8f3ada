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
#include "vtkInformationDoubleVectorKey.h"
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

using namespace isosurface;

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
  for (vtkInformationDoubleVectorKey* key : { Keys::TIME_STEPS(), Keys::TIME_RANGE() })
  {
    std::set<double> united;
    for (int port = 0; port < 2; ++port)
    {
      vtkInformation* inInfo = input[port]->GetInformationObject(0);
      const double* own = inInfo->Get(key);
      united.insert(own, own + inInfo->Length(key));
    }
    std::vector<double> times(united.begin(), united.end());
    if (!times.empty())
    {
      times = key == Keys::TIME_RANGE() ? std::vector{ times.front(), times.back() } : times;
      outInfo->Set(key, times.data(), static_cast<int>(times.size()));
    }
  }
}

// Adds an array of the volume for the points of a dataset, filled with what points beyond the volume have.
void* AddPointArray(vtkDataSet* points, const ArrayDescription& description)
{
  auto values = vtkSmartPointer<vtkDataArray>::Take(
    vtkDataArray::CreateDataArray(GetVTKType(description.Type)));
  values->SetName(description.Name.c_str());
  values->SetNumberOfComponents(description.Components);
  AllocateTuples(values, points->GetNumberOfPoints());
  values->Fill(IsFloatingType(description.Type) ? std::numeric_limits<double>::quiet_NaN() : 0.0);
  points->GetPointData()->AddArray(values);
  return values->GetVoidPointer(0);
}

/// Whether an algorithm, or one that it has its input from, is the reader of a volume.
bool IsBehind(vtkAlgorithm* algorithm, const vtkBlockedVolumeHandle& handle)
{
  for (int port = 0; port < algorithm->GetNumberOfOutputPorts(); ++port)
  {
    const VolumeInput output(algorithm->GetOutputInformation(port));
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

/// Adds the arrays of the volume to a dataset that has its own already, and its points to `counts`, all and those
/// inside.
Status Probe(const LevelSamples& samples, const std::vector<std::size_t>& arrays,
  Interpolation interpolation, int threads, vtkDataSet* dataset, const Progress& progress,
  std::vector<std::uint64_t>& counts)
{
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
  vtkNew<vtkCharArray> mask;
  mask->SetName("vtkValidPointMask");
  AllocateTuples(mask, points);
  mask->FillValue(0);
  auto* isInside = reinterpret_cast<std::uint8_t*>(mask->GetPointer(0));
  std::vector<void*> values;
  for (const std::size_t array : arrays)
  {
    values.push_back(AddPointArray(dataset, samples.GetVolume().GetHeader().Arrays[array]));
  }
  ISOSURFACE_RETURN_IF_ERROR(SampleArrays(
    samples, arrays, interpolation, points, find, threads, values, isInside, progress));
  dataset->GetPointData()->AddArray(mask);
  counts[0] += static_cast<std::uint64_t>(points);
  counts[1] +=
    static_cast<std::uint64_t>(std::count(isInside, isInside + points, std::uint8_t{ 1 }));
  return Status::Ok();
}

} // namespace

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
  AskVolume(*this, inInfo, output->GetInformationObject(0));
  const VolumeInput volume(inInfo);
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
  const VolumeInput volume(input[0]->GetInformationObject(0));
  vtkDataObject* made = vtkDataObject::GetData(output, 0);
  made->Initialize();
  ControllerCommunicator ranks(this->Controller);
  Fingerprint properties;
  properties.AddNumber(static_cast<std::uint64_t>(this->Interpolation));
  std::vector<std::uint64_t> counts(2, 0); // points, and those inside
  Status status = AgreeOnVolume(*this, ranks, volume, properties.Get());
  if (status.IsOk())
  {
    const int threads = ranks.ChooseThreads(0);
    const auto probe = [&]() -> Status
    {
      CopyPoints(vtkDataObject::GetData(input[1], 0), made);
      ISOSURFACE_ASSIGN_OR_RETURN(
        const auto samples, LevelSamples::Open(volume.GetVolume(), volume.GetTimeStep(), 0));
      const auto datasets = vtkCompositeDataSet::GetDataSets<vtkDataSet>(made);
      const double share = 1.0 / static_cast<double>(datasets.size());
      for (std::size_t number = 0; number < datasets.size(); ++number)
      {
        const double begin = static_cast<double>(number) * share;
        ISOSURFACE_RETURN_IF_ERROR(Probe(*samples, volume.GetHandle().GetArrays(),
          static_cast<isosurface::Interpolation>(this->Interpolation), threads, datasets[number],
          MakeProgress(*this, begin, begin + share), counts));
      }
      return Status::Ok();
    };
    status = ReadVolume(*this, ranks, volume, probe);
  }
  if (status.IsOk())
  {
    ranks.ReduceSum(counts);
    const bool areOutside = counts[0] > 0 && counts[1] == 0;
    ReportWarning(this, ranks, status,
      areOutside ? volume.GetVolume()->GetPath() + ": all " + std::to_string(counts[0]) +
          " points are beyond the volume"
                 : "");
  }
  return EndExecution(this, output, status);
}

void vtkVolumeProbe::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  os << indent << "Interpolation: " << this->Interpolation << "\n";
  os << indent << "Controller: " << this->Controller << "\n";
}
