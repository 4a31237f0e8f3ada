// SPDX-FileCopyrightText: Copyright (c) 2026, the ScalableIsosurface authors
// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkSMVolumeSliceRepresentationProxy
 * @brief   shows volumes and slices of them, those of a CT in grey
 *
 * When an array is shown for the first time that has a window of its file, or is in Hounsfield units, its
 * color map becomes grey, with that window, or the usual one of soft tissue, unless somebody has fixed its
 * range. It stays as it is from then on: whoever changes it later is not disturbed. The legend tells the
 * unit of the array.
 */

#ifndef vtkSMVolumeSliceRepresentationProxy_h
#define vtkSMVolumeSliceRepresentationProxy_h

#include "IsosurfaceRepresentationModule.h" // For export macro
#include "vtkSMPVRepresentationProxy.h"

#include <string> // For the array's name

class ISOSURFACEREPRESENTATION_EXPORT vtkSMVolumeSliceRepresentationProxy
  : public vtkSMPVRepresentationProxy
{
public:
  static vtkSMVolumeSliceRepresentationProxy* New();
  vtkTypeMacro(vtkSMVolumeSliceRepresentationProxy, vtkSMPVRepresentationProxy);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  bool SetRepresentationType(const char* type) override;
  void ViewUpdated(vtkSMProxy* view) override;

protected:
  vtkSMVolumeSliceRepresentationProxy() = default;
  ~vtkSMVolumeSliceRepresentationProxy() override = default;

private:
  vtkSMVolumeSliceRepresentationProxy(const vtkSMVolumeSliceRepresentationProxy&) = delete;
  void operator=(const vtkSMVolumeSliceRepresentationProxy&) = delete;

  /// Makes the map of an array grey, if it has values in a window.
  void ShowWindow(vtkSMProxy* map, const std::string& array, bool isHounsfield);
};

#endif
