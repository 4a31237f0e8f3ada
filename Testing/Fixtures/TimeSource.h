// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_TimeSource_h
#define isosurface_TimeSource_h

#include "TestImages.h"

#include "vtkImageAlgorithm.h"

#include <vector>

namespace isosurface
{

/// An image of waves that changes with time; it has time steps, and any part can be asked for.
class TimeSource : public vtkImageAlgorithm
{
public:
  static TimeSource* New();
  vtkTypeMacro(TimeSource, vtkImageAlgorithm);

  void SetTimes(const std::vector<double>& times);

  /// What the source gives at a time.
  static vtkSmartPointer<vtkImageData> MakeImageAt(double time);

protected:
  TimeSource();

  int RequestInformation(
    vtkInformation* request, vtkInformationVector** input, vtkInformationVector* output) override;
  int RequestData(
    vtkInformation* request, vtkInformationVector** input, vtkInformationVector* output) override;

private:
  std::vector<double> Times;
};

} // namespace isosurface

#endif
