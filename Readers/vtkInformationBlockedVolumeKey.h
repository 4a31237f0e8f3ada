// SPDX-FileCopyrightText: Copyright (c) 2026, the ScalableIsosurface authors
// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkInformationBlockedVolumeKey
 * @brief   carries the reader's vtkBlockedVolumeHandle down to a consumer
 *
 * Set by the reader in REQUEST_INFORMATION; passed on only by vtkPVPostFilter, which ParaView puts
 * behind every source. A consumer that finds it on its input may take blocks straight from the
 * blocked volume, in waves and through its cache, instead of the materialised blocks of the output.
 */

#ifndef vtkInformationBlockedVolumeKey_h
#define vtkInformationBlockedVolumeKey_h

#include "IsosurfaceReadersModule.h" // For export macro
#include "vtkInformationObjectBaseKey.h"

class ISOSURFACEREADERS_EXPORT vtkInformationBlockedVolumeKey : public vtkInformationObjectBaseKey
{
public:
  vtkTypeMacro(vtkInformationBlockedVolumeKey, vtkInformationObjectBaseKey);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  vtkInformationBlockedVolumeKey(const char* name, const char* location);
  ~vtkInformationBlockedVolumeKey() override;

  void CopyDefaultInformation(
    vtkInformation* request, vtkInformation* fromInfo, vtkInformation* toInfo) override;

private:
  vtkInformationBlockedVolumeKey(const vtkInformationBlockedVolumeKey&) = delete;
  void operator=(const vtkInformationBlockedVolumeKey&) = delete;
};

#endif
