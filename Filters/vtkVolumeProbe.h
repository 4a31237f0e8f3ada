// SPDX-FileCopyrightText: Copyright (c) 2026, the ScalableIsosurface authors
// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkVolumeProbe
 * @brief   the values of a blocked volume at the points of any other data, at full resolution
 *
 * Inputs: a blocked volume (vtkBlockedVolumeReader, vtkInPlaceVolumeReader), of which only the blocks
 * with a point are read; and a dataset with points: a line to plot over, a surface to color by
 * another volume, of another grid and place. Output: that dataset with the volume's arrays that are
 * chosen in the reader, and vtkValidPointMask: 0 at points beyond the volume, where floating-point
 * values are NaN and integers 0, else 1. An array of the dataset with the name of one of the
 * volume's is replaced.
 *
 * Of a composite dataset only the partitioned kinds and those of blocks with points are taken. All
 * ranks of the controller execute together, each for its own points, and all must reach all stores.
 * All report the errors of any. A dataset that has points, all of which on all ranks are beyond the
 * volume, is a warning.
 */

#ifndef vtkVolumeProbe_h
#define vtkVolumeProbe_h

#include "IsosurfaceFiltersModule.h" // For export macro
#include "vtkDataObjectAlgorithm.h"

class vtkMultiProcessController;

class ISOSURFACEFILTERS_EXPORT vtkVolumeProbe : public vtkDataObjectAlgorithm
{
public:
  static vtkVolumeProbe* New();
  vtkTypeMacro(vtkVolumeProbe, vtkDataObjectAlgorithm);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  ///@{
  /// The dataset with the points, the second input.
  void SetSourceConnection(vtkAlgorithmOutput* points) { this->SetInputConnection(1, points); }
  void SetSourceData(vtkDataObject* points) { this->SetInputData(1, points); }
  ///@}

  enum InterpolationType
  {
    NEAREST,
    LINEAR
  };

  ///@{
  /// How values between vertices are made: LINEAR (the default), integers being rounded, or NEAREST.
  vtkSetClampMacro(Interpolation, int, NEAREST, LINEAR);
  vtkGetMacro(Interpolation, int);
  ///@}

  ///@{
  /// The ranks that execute together, the global controller by default. Null: this rank alone.
  virtual void SetController(vtkMultiProcessController* controller);
  vtkGetObjectMacro(Controller, vtkMultiProcessController);
  ///@}

protected:
  vtkVolumeProbe();
  ~vtkVolumeProbe() override;

  /// A vtkBlockConsumerPipeline.
  vtkExecutive* CreateDefaultExecutive() override;
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
  vtkVolumeProbe(const vtkVolumeProbe&) = delete;
  void operator=(const vtkVolumeProbe&) = delete;

  int Interpolation = LINEAR;
  vtkMultiProcessController* Controller = nullptr;
};

#endif
