// SPDX-License-Identifier: BSD-3-Clause
#include "TimeSource.h"

#include "vtkDataObject.h"
#include "vtkInformation.h"
#include "vtkInformationVector.h"
#include "vtkObjectFactory.h"
#include "vtkStreamingDemandDrivenPipeline.h"

namespace isosurface
{
namespace
{

constexpr Extent Grid{ 0, 36, -4, 30, 0, 33 };

} // namespace

vtkStandardNewMacro(TimeSource);

TimeSource::TimeSource()
{
  this->SetNumberOfInputPorts(0);
}

void TimeSource::SetTimes(const std::vector<double>& times)
{
  this->Times = times;
  this->Modified();
}

vtkSmartPointer<vtkImageData> TimeSource::MakeImageAt(double time)
{
  return MakeImage(Grid, VTK_FLOAT,
    [time, waves = MakeWaves(100)](int i, int j, int k) { return waves(i, j, k) + 10 * time; });
}

int TimeSource::RequestInformation(
  vtkInformation*, vtkInformationVector**, vtkInformationVector* output)
{
  vtkInformation* info = output->GetInformationObject(0);
  using Pipeline = vtkStreamingDemandDrivenPipeline;
  info->Set(Pipeline::WHOLE_EXTENT(), Grid.data(), 6);
  info->Set(vtkAlgorithm::CAN_PRODUCE_SUB_EXTENT(), 1);
  if (!this->Times.empty())
  {
    const double range[2] = { this->Times.front(), this->Times.back() };
    info->Set(Pipeline::TIME_STEPS(), this->Times.data(), static_cast<int>(this->Times.size()));
    info->Set(Pipeline::TIME_RANGE(), range, 2);
  }
  return 1;
}

int TimeSource::RequestData(vtkInformation*, vtkInformationVector**, vtkInformationVector* output)
{
  vtkInformation* info = output->GetInformationObject(0);
  using Pipeline = vtkStreamingDemandDrivenPipeline;
  const double time =
    info->Has(Pipeline::UPDATE_TIME_STEP()) ? info->Get(Pipeline::UPDATE_TIME_STEP()) : 0;
  Extent extent;
  info->Get(Pipeline::UPDATE_EXTENT(), extent.data());
  vtkImageData* image = vtkImageData::GetData(output, 0);
  image->ShallowCopy(CutImage(MakeImageAt(time), extent));
  if (!this->Times.empty())
  {
    image->GetInformation()->Set(vtkDataObject::DATA_TIME_STEP(), time);
  }
  return 1;
}

} // namespace isosurface
