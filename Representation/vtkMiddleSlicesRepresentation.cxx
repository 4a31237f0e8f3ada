// SPDX-FileCopyrightText: Copyright (c) 2026, the ScalableIsosurface authors
// SPDX-License-Identifier: BSD-3-Clause
#include "vtkMiddleSlicesRepresentation.h"

#include "ImageSamples.h"

#include "vtkCellData.h"
#include "vtkCommand.h"
#include "vtkCompositeDataSet.h"
#include "vtkDataSet.h"
#include "vtkDataSetAttributes.h"
#include "vtkFieldData.h"
#include "vtkImageData.h"
#include "vtkInformation.h"
#include "vtkInformationVector.h"
#include "vtkNew.h"
#include "vtkObjectFactory.h"
#include "vtkPVGeometryFilter.h"
#include "vtkPartitionedDataSet.h"
#include "vtkPointData.h"
#include "vtkProperty.h"
#include "vtkRectilinearGrid.h"
#include "vtkSmartPointer.h"

#include <algorithm>

vtkStandardNewMacro(vtkMiddleSlicesRepresentation);

namespace
{

/// Adds the slices through the middle of the volume that a piece of it has, from partition `first` on: one
/// for each axis, or null.
void AddSlices(vtkDataSet* piece, unsigned int first, vtkPartitionedDataSet* slices)
{
  auto* image = vtkImageData::SafeDownCast(piece);
  auto* lined = vtkRectilinearGrid::SafeDownCast(piece);
  if (!image && !lined)
  {
    return;
  }
  const int* extent = image ? image->GetExtent() : lined->GetExtent();
  vtkNew<vtkImageData> box; // of the piece, in that of the volume
  box->SetExtent(const_cast<int*>(extent));
  box->SetFieldData(piece->GetFieldData());
  int whole[6];
  if (!isosurface::FindWholeExtent(box, whole))
  {
    std::copy(extent, extent + 6, whole);
  }
  for (int axis = 0; axis < 3; ++axis)
  {
    const int middle = whole[2 * axis] + (whole[2 * axis + 1] - whole[2 * axis]) / 2;
    if (middle < extent[2 * axis] || middle > extent[2 * axis + 1])
    {
      continue;
    }
    int part[6];
    std::copy(extent, extent + 6, part);
    part[2 * axis] = part[2 * axis + 1] = middle;
    auto slice = vtkSmartPointer<vtkDataSet>::Take(piece->NewInstance());
    slice->ShallowCopy(piece);
    slice->GetCellData()->Initialize();
    // Where ranks overlap, both draw the same.
    slice->GetPointData()->RemoveArray(vtkDataSetAttributes::GhostArrayName());
    slice->Crop(part);
    slices->SetPartition(first + static_cast<unsigned int>(axis), slice);
  }
}

/// The surface of the slices in place of that of the volume.
class MiddleSlicesFilter : public vtkPVGeometryFilter
{
public:
  static MiddleSlicesFilter* New();
  vtkTypeMacro(MiddleSlicesFilter, vtkPVGeometryFilter);

protected:
  int RequestData(
    vtkInformation* request, vtkInformationVector** input, vtkInformationVector* output) override
  {
    auto* volume = vtkPartitionedDataSet::GetData(input[0]);
    if (!volume)
    {
      return this->Superclass::RequestData(request, input, output);
    }
    // The filter compares the partitions of all ranks, so each rank has as many.
    vtkNew<vtkPartitionedDataSet> slices;
    slices->SetNumberOfPartitions(3 * std::max(volume->GetNumberOfPartitions(), 1U));
    unsigned int first = 0;
    for (vtkDataSet* piece : vtkCompositeDataSet::GetDataSets<vtkDataSet>(volume))
    {
      AddSlices(piece, first, slices);
      first += 3;
    }
    vtkNew<vtkInformation> information;
    information->Copy(input[0]->GetInformationObject(0));
    information->Set(vtkDataObject::DATA_OBJECT(), slices);
    vtkNew<vtkInformationVector> replaced;
    replaced->Append(information);
    vtkInformationVector* inputs[] = { replaced };
    return this->Superclass::RequestData(request, inputs, output);
  }
};

vtkStandardNewMacro(MiddleSlicesFilter);

} // namespace

vtkMiddleSlicesRepresentation::vtkMiddleSlicesRepresentation()
{
  this->GeometryFilter->Delete();
  this->GeometryFilter = MiddleSlicesFilter::New();
  this->GeometryFilter->AddObserver(vtkCommand::ProgressEvent, this,
    &vtkMiddleSlicesRepresentation::HandleGeometryRepresentationProgress);
  this->SetupDefaults();
}

int vtkMiddleSlicesRepresentation::ProcessViewRequest(
  vtkInformationRequestKey* request, vtkInformation* input, vtkInformation* output)
{
  this->Property->SetLighting(false); // some versions have a property that switches it on
  return this->Superclass::ProcessViewRequest(request, input, output);
}

void vtkMiddleSlicesRepresentation::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
}
