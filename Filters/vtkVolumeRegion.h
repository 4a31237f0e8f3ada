// SPDX-FileCopyrightText: Copyright (c) 2026, the ScalableIsosurface authors
// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkVolumeRegion
 * @brief   the samples of a blocked volume in a box, at full resolution if they fit a memory limit
 *
 * Input: a blocked volume (vtkBlockedVolumeReader, vtkInPlaceVolumeReader), of which only the blocks
 * in the box are read. Output: an image, or a rectilinear grid if the volume has one, with the arrays
 * that are chosen in the reader, for any filter, representation or writer. It has all samples in the
 * box and, between samples, the next ones beyond its faces.
 *
 * All ranks of the controller execute together, each for a part of the image, and all must reach all
 * stores. All report the errors of any. A box beside the volume is an error.
 */

#ifndef vtkVolumeRegion_h
#define vtkVolumeRegion_h

#include "IsosurfaceFiltersModule.h" // For export macro
#include "vtkDataSetAlgorithm.h"

#include <memory> // For the steps

class vtkMultiProcessController;

class ISOSURFACEFILTERS_EXPORT vtkVolumeRegion : public vtkDataSetAlgorithm
{
public:
  static vtkVolumeRegion* New();
  vtkTypeMacro(vtkVolumeRegion, vtkDataSetAlgorithm);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  ///@{
  /**
   * The low corner of the box and its lengths, in world coordinates. Default: 0 0 0, 1 1 1. Of a
   * volume whose axes are not those of the world, all samples around the box are taken.
   */
  vtkSetVector3Macro(Position, double);
  vtkGetVector3Macro(Position, double);
  vtkSetVector3Macro(Length, double);
  vtkGetVector3Macro(Length, double);
  ///@}

  ///@{
  /**
   * Mebibytes that the output may take on each rank: the finest level of the volume that keeps it is
   * given. Default 1024.
   */
  vtkSetClampMacro(MemoryLimit, int, 1, VTK_INT_MAX);
  vtkGetMacro(MemoryLimit, int);
  ///@}

  /**
   * What the image is and what memory it takes, in words; known when the information of the pipeline
   * is up to date, before samples are read.
   */
  const char* GetShownText();

  ///@{
  /**
   * The ranks that execute together, the global controller by default. Null: this rank alone.
   */
  virtual void SetController(vtkMultiProcessController* controller);
  vtkGetObjectMacro(Controller, vtkMultiProcessController);
  ///@}

protected:
  vtkVolumeRegion();
  ~vtkVolumeRegion() override;

  int FillInputPortInformation(int port, vtkInformation* info) override;
  int RequestDataObject(
    vtkInformation* request, vtkInformationVector** input, vtkInformationVector* output) override;
  int RequestInformation(
    vtkInformation* request, vtkInformationVector** input, vtkInformationVector* output) override;
  int RequestUpdateExtent(
    vtkInformation* request, vtkInformationVector** input, vtkInformationVector* output) override;
  int RequestData(
    vtkInformation* request, vtkInformationVector** input, vtkInformationVector* output) override;

private:
  vtkVolumeRegion(const vtkVolumeRegion&) = delete;
  void operator=(const vtkVolumeRegion&) = delete;

  struct Steps; ///< of the requests

  double Position[3] = { 0, 0, 0 };
  double Length[3] = { 1, 1, 1 };
  int MemoryLimit = 1024;
  vtkMultiProcessController* Controller = nullptr;
  std::unique_ptr<Steps> Internals;
};

#endif
