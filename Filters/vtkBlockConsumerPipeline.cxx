// SPDX-FileCopyrightText: Copyright (c) 2026, the ScalableIsosurface authors
// SPDX-License-Identifier: BSD-3-Clause
#include "vtkBlockConsumerPipeline.h"

#include "VolumeInput.h"
#include "vtkDistributeIsosurface.h"

#include "vtkAlgorithm.h"
#include "vtkInformation.h"
#include "vtkObjectFactory.h"

vtkStandardNewMacro(vtkBlockConsumerPipeline);

int vtkBlockConsumerPipeline::ForwardUpstream(vtkInformation* request)
{
  const auto* filter = vtkDistributeIsosurface::SafeDownCast(this->Algorithm);
  const bool isAboutData = request->Has(REQUEST_DATA()) || request->Has(REQUEST_UPDATE_EXTENT()) ||
    request->Has(REQUEST_UPDATE_TIME());
  if (isAboutData && filter && filter->TakesBlocks())
  {
    return 1;
  }
  const int isDone = this->Superclass::ForwardUpstream(request);
  if (!isDone && isAboutData)
  {
    // The filter will not be executed, so it takes nothing.
    for (int port = 0; port < this->GetNumberOfInputPorts(); ++port)
    {
      for (int input = 0; input < this->GetNumberOfInputConnections(port); ++input)
      {
        isosurface::ReleaseVolume(*this->Algorithm, this->GetInputInformation(port, input));
      }
    }
  }
  return isDone;
}
