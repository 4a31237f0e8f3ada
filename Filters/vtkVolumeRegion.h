// SPDX-FileCopyrightText: Copyright (c) 2026, the ScalableIsosurface authors
// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkVolumeRegion
 * @brief   the samples of a blocked volume in a box, at full resolution if they fit a memory limit
 *
 * Only the blocks in the box are read. Output: an image, or a rectilinear grid if the volume has one,
 * with the arrays that are chosen in the reader, for any filter, representation or writer. It has all
 * samples in the box and, between samples, the next ones beyond its faces. There is no coarse image. A
 * box beside the volume is an error. What is not said here is said of vtkVolumeImageAlgorithm.
 */

#ifndef vtkVolumeRegion_h
#define vtkVolumeRegion_h

#include "IsosurfaceFiltersModule.h" // For export macro
#include "vtkVolumeImageAlgorithm.h"

class ISOSURFACEFILTERS_EXPORT vtkVolumeRegion : public vtkVolumeImageAlgorithm
{
public:
  static vtkVolumeRegion* New();
  vtkTypeMacro(vtkVolumeRegion, vtkVolumeImageAlgorithm);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  ///@{
  /// The low corner of the box and its lengths, in world coordinates. Default: 0 0 0, 1 1 1. Of a
  /// volume whose axes are not those of the world, all samples around the box are taken.
  vtkSetVector3Macro(Position, double);
  vtkGetVector3Macro(Position, double);
  vtkSetVector3Macro(Length, double);
  vtkGetVector3Macro(Length, double);
  ///@}

  ///@{
  /// Mebibytes that the output may take on each rank: the finest level of the volume that keeps it is
  /// given. Default 1024.
  vtkSetClampMacro(MemoryLimit, int, 1, VTK_INT_MAX);
  vtkGetMacro(MemoryLimit, int);
  ///@}

protected:
  vtkVolumeRegion() = default;
  ~vtkVolumeRegion() override = default;

  std::uint64_t SumProperties() override;
  /// The finest level that keeps the memory limit.
  isosurface::Status Plan(const isosurface::BlockedVolume& volume,
    const std::vector<std::size_t>& arrays, bool isCoarse, isosurface::ImagePlan& plan) override;

private:
  vtkVolumeRegion(const vtkVolumeRegion&) = delete;
  void operator=(const vtkVolumeRegion&) = delete;

  double Position[3] = { 0, 0, 0 };
  double Length[3] = { 1, 1, 1 };
  int MemoryLimit = 1024;
};

#endif
