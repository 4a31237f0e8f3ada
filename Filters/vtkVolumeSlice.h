// SPDX-FileCopyrightText: Copyright (c) 2026, the ScalableIsosurface authors
// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkVolumeSlice
 * @brief   an image of the samples of a blocked volume on a plane, at full resolution
 *
 * Input: a blocked volume (vtkBlockedVolumeReader, vtkInPlaceVolumeReader), of which only the blocks
 * that the plane crosses are read. Output: an image of one slice with the arrays that are chosen in
 * the reader.
 *
 * A plane along two axes of the volume has the volume's own vertices on these axes, in the order y z,
 * x z or x y. Any other plane has square cells as small as the smallest spacing of the volume; points
 * beyond the volume are hidden (vtkGhostType) and have the minimum of the array. Of a rectilinear
 * grid all planes are of that kind. Second output: isolines of that image.
 *
 * All ranks of the controller execute together, each for a part of the image, and all must reach all
 * stores. All report the errors of any. A plane beside the volume is an error.
 */

#ifndef vtkVolumeSlice_h
#define vtkVolumeSlice_h

#include "IsosurfaceFiltersModule.h" // For export macro
#include "vtkContourValues.h"        // For the isovalues
#include "vtkImageAlgorithm.h"
#include "vtkNew.h" // For the isovalues

#include <array>  // For the window
#include <memory> // For the steps
#include <string> // For the name

class vtkMultiProcessController;
class vtkPolyData;

class ISOSURFACEFILTERS_EXPORT vtkVolumeSlice : public vtkImageAlgorithm
{
public:
  static vtkVolumeSlice* New();
  vtkTypeMacro(vtkVolumeSlice, vtkImageAlgorithm);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  ///@{
  /**
   * A point of the plane and its normal, in world coordinates. Default: 0 0 0, 0 0 1.
   */
  vtkSetVector3Macro(Origin, double);
  vtkGetVector3Macro(Origin, double);
  vtkSetVector3Macro(Normal, double);
  vtkGetVector3Macro(Normal, double);
  ///@}

  enum InterpolationType
  {
    NEAREST,
    LINEAR
  };

  ///@{
  /**
   * How values between vertices are made: LINEAR (the default), integers being rounded, or NEAREST.
   */
  vtkSetClampMacro(Interpolation, int, NEAREST, LINEAR);
  vtkGetMacro(Interpolation, int);
  ///@}

  ///@{
  /**
   * The maximum number of points of the image, in millions; the finest level of the volume that
   * keeps it is shown. Default 16.
   */
  vtkSetClampMacro(MaximumPoints, double, 0.01, 2000);
  vtkGetMacro(MaximumPoints, double);
  ///@}

  ///@{
  /**
   * The isovalues of the second output, isolines of the image: lines of two points. On a plane through
   * vertices they have the points that the isosurface has there. None by default.
   */
  void SetValue(int i, double value) { this->Isovalues->SetValue(i, value); }
  double GetValue(int i) { return this->Isovalues->GetValue(i); }
  void SetNumberOfContours(int number) { this->Isovalues->SetNumberOfContours(number); }
  int GetNumberOfContours() { return static_cast<int>(this->Isovalues->GetNumberOfContours()); }
  vtkPolyData* GetIsolines();
  ///@}

  ///@{
  /**
   * The array of the isolines, of which the first component counts. Empty, the default: the first
   * array.
   */
  void SetIsolineArray(const char* name);
  vtkGetCharFromStdStringMacro(IsolineArray);
  ///@}

  vtkMTimeType GetMTime() override;

  /**
   * What the last image is, in words: "2048 x 2048 points at full resolution".
   */
  const char* GetShownText();

  ///@{
  /**
   * For a window, as of vtkStabbingContour: while coarse images are allowed, a large image of
   * something new is coarse, and not final. PrepareRefinement then reads the exact one beside the
   * calling thread, and waits for it, but not longer than this. Refinement has the values of
   * Ranks/Query/Refinement.h, as the last call found them. The execution after Refine gives the exact
   * image. All ranks call these together. DropRefinement stops the reading.
   */
  void AllowCoarse(vtkTypeBool allowed);
  int GetFinal();
  void Refine();
  void PrepareRefinement(int milliseconds);
  void DropRefinement();
  double* GetRefinement() VTK_SIZEHINT(10) { return this->Refinement.data(); }
  ///@}

  ///@{
  /**
   * The ranks that execute together, the global controller by default. Null: this rank alone.
   */
  virtual void SetController(vtkMultiProcessController* controller);
  vtkGetObjectMacro(Controller, vtkMultiProcessController);
  ///@}

protected:
  vtkVolumeSlice();
  ~vtkVolumeSlice() override;

  int FillInputPortInformation(int port, vtkInformation* info) override;
  int FillOutputPortInformation(int port, vtkInformation* info) override;
  int RequestInformation(
    vtkInformation* request, vtkInformationVector** input, vtkInformationVector* output) override;
  int RequestUpdateExtent(
    vtkInformation* request, vtkInformationVector** input, vtkInformationVector* output) override;
  int RequestData(
    vtkInformation* request, vtkInformationVector** input, vtkInformationVector* output) override;

private:
  vtkVolumeSlice(const vtkVolumeSlice&) = delete;
  void operator=(const vtkVolumeSlice&) = delete;

  struct Steps; ///< of the requests

  double Origin[3] = { 0, 0, 0 };
  double Normal[3] = { 0, 0, 1 };
  int Interpolation = LINEAR;
  double MaximumPoints = 16;
  vtkNew<vtkContourValues> Isovalues;
  std::string IsolineArray;
  std::array<double, 10> Refinement;
  vtkMultiProcessController* Controller = nullptr;
  std::unique_ptr<Steps> Internals;
};

#endif
