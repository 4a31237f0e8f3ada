// SPDX-FileCopyrightText: Copyright (c) 2026, the ScalableIsosurface authors
// SPDX-License-Identifier: BSD-3-Clause
#include "vtkInformationBlockedVolumeKey.h"

#include "PassingFilters.h"
#include "vtkBlockedVolumeHandle.h"

#include "vtkAlgorithm.h"
#include "vtkDemandDrivenPipeline.h"
#include "vtkExecutive.h"
#include "vtkInformation.h"
#include "vtkInformationExecutivePortKey.h"

vtkInformationBlockedVolumeKey::vtkInformationBlockedVolumeKey(
  const char* name, const char* location)
  : vtkInformationObjectBaseKey(name, location, "vtkBlockedVolumeHandle")
{
}

vtkInformationBlockedVolumeKey::~vtkInformationBlockedVolumeKey() = default;

vtkBlockedVolumeHandle* vtkInformationBlockedVolumeKey::GetHandle(vtkInformation* info)
{
  return static_cast<vtkBlockedVolumeHandle*>(this->Get(info));
}

void vtkInformationBlockedVolumeKey::CopyDefaultInformation(
  vtkInformation* request, vtkInformation* fromInfo, vtkInformation* toInfo)
{
  if (!request->Has(vtkDemandDrivenPipeline::REQUEST_INFORMATION()))
  {
    return;
  }
  vtkExecutive* executive = vtkExecutive::PRODUCER()->GetExecutive(toInfo);
  if (executive &&
    isosurface::FindPassedArrays(executive->GetAlgorithm()) != isosurface::PassedArrays::None)
  {
    this->ShallowCopy(fromInfo, toInfo);
  }
}

bool vtkInformationBlockedVolumeKey::NeedToExecute(
  vtkInformation* pipelineInfo, vtkInformation* dobjInfo)
{
  return this->Has(dobjInfo) && this->GetHandle(pipelineInfo)->IsOutputNeeded();
}

void vtkInformationBlockedVolumeKey::StoreMetaData(
  vtkInformation*, vtkInformation* pipelineInfo, vtkInformation* dobjInfo)
{
  if (this->GetHandle(pipelineInfo)->IsOutputBox())
  {
    this->ShallowCopy(pipelineInfo, dobjInfo);
  }
  else
  {
    this->Remove(dobjInfo);
  }
}

void vtkInformationBlockedVolumeKey::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
}
