// SPDX-FileCopyrightText: Copyright (c) 2026, the ScalableIsosurface authors
// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkSMVolumeSliceRepresentationProxy
 * @brief   shows the slices of a CT in grey
 *
 * When a slice is shown for the first time, by an array in Hounsfield units, the color map of the array
 * becomes grey, with the usual window of soft tissue, unless somebody has fixed its range. It stays as
 * it is from then on: whoever changes it later is not disturbed.
 */

#ifndef vtkSMVolumeSliceRepresentationProxy_h
#define vtkSMVolumeSliceRepresentationProxy_h

#include "IsosurfaceRepresentationModule.h" // For export macro
#include "vtkSMPVRepresentationProxy.h"

class ISOSURFACEREPRESENTATION_EXPORT vtkSMVolumeSliceRepresentationProxy
  : public vtkSMPVRepresentationProxy
{
public:
  static vtkSMVolumeSliceRepresentationProxy* New();
  vtkTypeMacro(vtkSMVolumeSliceRepresentationProxy, vtkSMPVRepresentationProxy);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  void ViewUpdated(vtkSMProxy* view) override;

protected:
  vtkSMVolumeSliceRepresentationProxy() = default;
  ~vtkSMVolumeSliceRepresentationProxy() override = default;

private:
  vtkSMVolumeSliceRepresentationProxy(const vtkSMVolumeSliceRepresentationProxy&) = delete;
  void operator=(const vtkSMVolumeSliceRepresentationProxy&) = delete;

  /// Whether the slice is colored by an array in Hounsfield units that has values in the window.
  bool IsOfCT();
};

#endif
