// SPDX-FileCopyrightText: Copyright (c) 2026, the ScalableIsosurface authors
// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkBlockConsumerPipeline
 * @brief   the executive of filters that take blocks beside the pipeline
 *
 * Of a vtkDistributeIsosurface, brings the input's information up to date, but not its data, if the
 * filter takes the contour's blocks: otherwise the contour would extract a surface that no consumer
 * uses.
 *
 * Of a filter with several inputs, gives up the blocks of a volume if another input fails: the
 * volume's reader would else go on without an output for others (vtkBlockedVolumeHandle).
 */

#ifndef vtkBlockConsumerPipeline_h
#define vtkBlockConsumerPipeline_h

#include "vtkCompositeDataPipeline.h"

class vtkBlockConsumerPipeline : public vtkCompositeDataPipeline
{
public:
  static vtkBlockConsumerPipeline* New();
  vtkTypeMacro(vtkBlockConsumerPipeline, vtkCompositeDataPipeline);

protected:
  vtkBlockConsumerPipeline() = default;
  ~vtkBlockConsumerPipeline() override = default;

  using vtkCompositeDataPipeline::ForwardUpstream;
  int ForwardUpstream(vtkInformation* request) override;

private:
  vtkBlockConsumerPipeline(const vtkBlockConsumerPipeline&) = delete;
  void operator=(const vtkBlockConsumerPipeline&) = delete;
};

#endif
