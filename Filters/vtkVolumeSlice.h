// SPDX-FileCopyrightText: Copyright (c) 2026, the ScalableIsosurface authors
// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkVolumeSlice
 * @brief   an image of the samples of a blocked volume on a plane, at full resolution
 *
 * Only the blocks that the plane crosses are read. Output: an image of one slice with the arrays that are
 * chosen in the reader.
 *
 * A plane along two axes of the volume has the volume's own vertices on these axes, in the order y z,
 * x z or x y. Any other plane has square cells as small as the smallest spacing of the volume; points
 * beyond the volume are hidden (vtkGhostType) and have the minimum of the array. Of a rectilinear
 * grid all planes are of that kind. Second output: isolines of that image. A plane beside the volume is
 * an error. What is not said here is said of vtkVolumeImageAlgorithm.
 */

#ifndef vtkVolumeSlice_h
#define vtkVolumeSlice_h

#include "IsosurfaceFiltersModule.h" // For export macro
#include "vtkContourValues.h"        // For the isovalues
#include "vtkNew.h"                  // For the isovalues
#include "vtkVolumeImageAlgorithm.h"

#include <string> // For the name

class vtkImageData;
class vtkPolyData;

class ISOSURFACEFILTERS_EXPORT vtkVolumeSlice : public vtkVolumeImageAlgorithm
{
public:
  static vtkVolumeSlice* New();
  vtkTypeMacro(vtkVolumeSlice, vtkVolumeImageAlgorithm);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  ///@{
  /// A point of the plane and its normal, in world coordinates. Default: 0 0 0, 0 0 1.
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
  /// How values between vertices are made: LINEAR (the default), integers being rounded, or NEAREST.
  vtkSetClampMacro(Interpolation, int, NEAREST, LINEAR);
  vtkGetMacro(Interpolation, int);
  ///@}

  ///@{
  /// The maximum number of points of the image, in millions; the finest level of the volume that
  /// keeps it is shown. Default 16.
  vtkSetClampMacro(MaximumPoints, double, 0.01, 2000);
  vtkGetMacro(MaximumPoints, double);
  ///@}

  ///@{
  /// The isovalues of the second output, isolines of the image: lines of two points. On a plane through
  /// vertices they have the points that the isosurface has there. None by default.
  void SetValue(int i, double value) { this->Isovalues->SetValue(i, value); }
  double GetValue(int i) { return this->Isovalues->GetValue(i); }
  void SetNumberOfContours(int number) { this->Isovalues->SetNumberOfContours(number); }
  int GetNumberOfContours() { return static_cast<int>(this->Isovalues->GetNumberOfContours()); }
  vtkPolyData* GetIsolines();
  vtkImageData* GetOutput() { return this->GetImageDataOutput(); }
  ///@}

  ///@{
  /// The array of the isolines, of which the first component counts. Empty, the default: the first
  /// array.
  vtkSetStdStringFromCharMacro(IsolineArray);
  vtkGetCharFromStdStringMacro(IsolineArray);
  ///@}

  vtkMTimeType GetMTime() override;

protected:
  vtkVolumeSlice();
  ~vtkVolumeSlice() override = default;

  std::uint64_t SumProperties() override;
  /// The plane at the finest level that has few enough points.
  isosurface::Status Plan(const isosurface::BlockedVolume& volume,
    const std::vector<std::size_t>& arrays, bool isCoarse, isosurface::ImagePlan& plan) override;
  int FillOutputPortInformation(int port, vtkInformation* info) override;
  int RequestData(
    vtkInformation* request, vtkInformationVector** input, vtkInformationVector* output) override;

private:
  vtkVolumeSlice(const vtkVolumeSlice&) = delete;
  void operator=(const vtkVolumeSlice&) = delete;

  /// The isolines of an array of the image, without those in cells with a hidden point.
  void MakeIsolines(vtkImageData* image, vtkPolyData* isolines);

  double Origin[3] = { 0, 0, 0 };
  double Normal[3] = { 0, 0, 1 };
  int Interpolation = LINEAR;
  double MaximumPoints = 16;
  vtkNew<vtkContourValues> Isovalues;
  std::string IsolineArray;
};

#endif
