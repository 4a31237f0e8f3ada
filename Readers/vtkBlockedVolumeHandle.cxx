// SPDX-FileCopyrightText: Copyright (c) 2026, the ScalableIsosurface authors
// SPDX-License-Identifier: BSD-3-Clause
#include "vtkBlockedVolumeHandle.h"

#include "vtkInformation.h"
#include "vtkObjectFactory.h"
#include "vtkStreamingDemandDrivenPipeline.h"

#include "Storage/Store/BlockedVolume.h"

vtkStandardNewMacro(vtkBlockedVolumeHandle);

vtkBlockedVolumeHandle::vtkBlockedVolumeHandle()
  : Error(isosurface::StatusCode::NotFound, "No blocked volume has been opened.")
{
}

vtkBlockedVolumeHandle::~vtkBlockedVolumeHandle() = default;

void vtkBlockedVolumeHandle::SetVolume(std::shared_ptr<isosurface::BlockedVolume> volume)
{
  this->Untried = false;
  if (this->Volume != volume)
  {
    this->Volume = std::move(volume);
    this->Error = isosurface::Status::Ok();
    this->Modified();
  }
}

void vtkBlockedVolumeHandle::SetError(const isosurface::Status& error)
{
  this->Untried = false;
  this->Volume = nullptr;
  this->Error = error;
  this->Modified();
}

isosurface::CommonValue vtkBlockedVolumeHandle::MakeCommonValue() const
{
  return this->Volume
    ? isosurface::MakeCommonFile(this->Volume->GetPath(), this->Volume->GetFingerprint())
    : isosurface::CommonValue{ 0, "" };
}

std::size_t vtkBlockedVolumeHandle::FindTimeStep(vtkInformation* pipelineInfo) const
{
  std::size_t found = 0;
  if (this->Volume && pipelineInfo->Has(vtkStreamingDemandDrivenPipeline::UPDATE_TIME_STEP()))
  {
    const double time = pipelineInfo->Get(vtkStreamingDemandDrivenPipeline::UPDATE_TIME_STEP());
    const auto& steps = this->Volume->GetHeader().TimeSteps;
    for (std::size_t step = 0; step < steps.size(); ++step)
    {
      if (steps[step].Time && *steps[step].Time <= time)
      {
        found = step;
      }
    }
  }
  return found;
}

void vtkBlockedVolumeHandle::FinishOutput(bool isBox)
{
  this->IsAsked = false;
  this->IsBox = isBox;
}

void vtkBlockedVolumeHandle::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  os << indent << "Volume: " << (this->Volume ? this->Volume->GetPath() : "(none)") << "\n";
}
