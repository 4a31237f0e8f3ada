// SPDX-FileCopyrightText: Copyright (c) 2026, the ScalableIsosurface authors
// SPDX-License-Identifier: BSD-3-Clause
#include "vtkInformationStabbingRequestKey.h"

#include "vtkAlgorithm.h"
#include "vtkExecutive.h"
#include "vtkInformation.h"
#include "vtkInformationExecutivePortKey.h"
#include "vtkInformationVector.h"
#include "vtkNew.h"
#include "vtkStabbingRequest.h"
#include "vtkStreamingDemandDrivenPipeline.h"

//------------------------------------------------------------------------------
vtkInformationStabbingRequestKey::vtkInformationStabbingRequestKey(
  const char* name, const char* location)
  : vtkInformationObjectBaseKey(name, location, "vtkStabbingRequest")
{
}

//------------------------------------------------------------------------------
vtkInformationStabbingRequestKey::~vtkInformationStabbingRequestKey() = default;

//------------------------------------------------------------------------------
vtkStabbingRequest* vtkInformationStabbingRequestKey::GetRequest(vtkInformation* info)
{
  return vtkStabbingRequest::SafeDownCast(this->Get(info));
}

//------------------------------------------------------------------------------
bool vtkInformationStabbingRequestKey::IsTransparent(vtkInformation* outputInfo)
{
  vtkExecutive* executive = vtkExecutive::PRODUCER()->GetExecutive(outputInfo);
  vtkAlgorithm* algorithm = executive ? executive->GetAlgorithm() : nullptr;
  // ParaView puts a vtkPVPostFilter behind every source.
  return algorithm &&
    (algorithm->IsA("vtkPVPostFilter") || algorithm->IsA("vtkPassThrough") ||
      algorithm->IsA("vtkPassArrays"));
}

//------------------------------------------------------------------------------
void vtkInformationStabbingRequestKey::CopyDefaultInformation(
  vtkInformation* request, vtkInformation* fromInfo, vtkInformation* toInfo)
{
  if (!request->Has(vtkStreamingDemandDrivenPipeline::REQUEST_UPDATE_EXTENT()))
  {
    return;
  }
  if (IsTransparent(fromInfo))
  {
    this->ShallowCopy(fromInfo, toInfo);
  }
  else if (this->Has(toInfo))
  {
    vtkNew<vtkStabbingRequest> nothing;
    this->Set(toInfo, nothing);
  }
}

//------------------------------------------------------------------------------
void vtkInformationStabbingRequestKey::Withdraw(vtkInformation* info)
{
  if (!info || !this->Has(info))
  {
    return;
  }
  // Present but empty: an absent key would not be asked whether to execute.
  vtkNew<vtkStabbingRequest> nothing;
  this->Set(info, nothing);

  vtkExecutive* executive = vtkExecutive::PRODUCER()->GetExecutive(info);
  for (int port = 0; executive && port < executive->GetNumberOfInputPorts(); ++port)
  {
    vtkInformationVector* connections = executive->GetInputInformation(port);
    for (int index = 0; index < connections->GetNumberOfInformationObjects(); ++index)
    {
      this->Withdraw(connections->GetInformationObject(index));
    }
  }
}

//------------------------------------------------------------------------------
bool vtkInformationStabbingRequestKey::NeedToExecute(
  vtkInformation* pipelineInfo, vtkInformation* dobjInfo)
{
  return !vtkStabbingRequest::Serves(this->GetRequest(dobjInfo), this->GetRequest(pipelineInfo));
}

//------------------------------------------------------------------------------
void vtkInformationStabbingRequestKey::StoreMetaData(
  vtkInformation*, vtkInformation* pipelineInfo, vtkInformation* dobjInfo)
{
  this->ShallowCopy(pipelineInfo, dobjInfo);
}

//------------------------------------------------------------------------------
void vtkInformationStabbingRequestKey::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
}
