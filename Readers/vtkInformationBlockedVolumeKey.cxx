// SPDX-FileCopyrightText: Copyright (c) 2026, the ScalableIsosurface authors
// SPDX-License-Identifier: BSD-3-Clause
#include "vtkInformationBlockedVolumeKey.h"

#include "vtkAlgorithm.h"
#include "vtkDemandDrivenPipeline.h"
#include "vtkExecutive.h"
#include "vtkInformation.h"
#include "vtkInformationExecutivePortKey.h"

//------------------------------------------------------------------------------
vtkInformationBlockedVolumeKey::vtkInformationBlockedVolumeKey(
  const char* name, const char* location)
  : vtkInformationObjectBaseKey(name, location, "vtkBlockedVolumeHandle")
{
}

//------------------------------------------------------------------------------
vtkInformationBlockedVolumeKey::~vtkInformationBlockedVolumeKey() = default;

//------------------------------------------------------------------------------
void vtkInformationBlockedVolumeKey::CopyDefaultInformation(
  vtkInformation* request, vtkInformation* fromInfo, vtkInformation* toInfo)
{
  if (!request->Has(vtkDemandDrivenPipeline::REQUEST_INFORMATION()))
  {
    return;
  }
  vtkExecutive* executive = vtkExecutive::PRODUCER()->GetExecutive(toInfo);
  if (executive && executive->GetAlgorithm()->IsA("vtkPVPostFilter"))
  {
    this->ShallowCopy(fromInfo, toInfo);
  }
}

//------------------------------------------------------------------------------
void vtkInformationBlockedVolumeKey::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
}
