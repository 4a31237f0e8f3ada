// SPDX-FileCopyrightText: Copyright (c) 2026, the ScalableIsosurface authors
// SPDX-License-Identifier: BSD-3-Clause
#include "vtkBlockConsumerPipeline.h"

#include "vtkDistributeIsosurface.h"

#include "vtkInformation.h"
#include "vtkObjectFactory.h"

vtkStandardNewMacro(vtkBlockConsumerPipeline);

//------------------------------------------------------------------------------
vtkBlockConsumerPipeline::vtkBlockConsumerPipeline() = default;
vtkBlockConsumerPipeline::~vtkBlockConsumerPipeline() = default;

//------------------------------------------------------------------------------
int vtkBlockConsumerPipeline::ForwardUpstream(vtkInformation* request)
{
  const auto* filter = vtkDistributeIsosurface::SafeDownCast(this->Algorithm);
  const bool isAboutData = request->Has(REQUEST_DATA()) || request->Has(REQUEST_UPDATE_EXTENT()) ||
    request->Has(REQUEST_UPDATE_TIME());
  return isAboutData && filter && filter->TakesBlocks()
    ? 1
    : this->Superclass::ForwardUpstream(request);
}
