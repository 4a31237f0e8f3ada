// SPDX-FileCopyrightText: Copyright (c) 2026, the ScalableIsosurface authors
// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkInformationBlockedVolumeKey
 * @brief   carries the reader's vtkBlockedVolumeHandle down to a consumer
 *
 * The reader sets the key in REQUEST_INFORMATION. Filters that are known to hand samples on
 * unchanged pass it on (FindPassedArrays); behind any other filter the stored samples would be the
 * wrong ones. A consumer that finds the key on its input may take blocks straight from the volume.
 *
 * An output that is no more than a box is marked by the same key in the data's information. It is
 * made anew for the next consumer that needs it. Internal: not installed.
 */

#ifndef vtkInformationBlockedVolumeKey_h
#define vtkInformationBlockedVolumeKey_h

#include "IsosurfaceReadersModule.h" // For export macro
#include "vtkInformationObjectBaseKey.h"

class vtkBlockedVolumeHandle;

class ISOSURFACEREADERS_EXPORT vtkInformationBlockedVolumeKey : public vtkInformationObjectBaseKey
{
public:
  vtkTypeMacro(vtkInformationBlockedVolumeKey, vtkInformationObjectBaseKey);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  vtkInformationBlockedVolumeKey(const char* name, const char* location);
  ~vtkInformationBlockedVolumeKey() override;

  /// The handle in this pipeline information, or null.
  vtkBlockedVolumeHandle* GetHandle(vtkInformation* info);

  void CopyDefaultInformation(
    vtkInformation* request, vtkInformation* fromInfo, vtkInformation* toInfo) override;
  bool NeedToExecute(vtkInformation* pipelineInfo, vtkInformation* dobjInfo) override;
  void StoreMetaData(
    vtkInformation* request, vtkInformation* pipelineInfo, vtkInformation* dobjInfo) override;

private:
  vtkInformationBlockedVolumeKey(const vtkInformationBlockedVolumeKey&) = delete;
  void operator=(const vtkInformationBlockedVolumeKey&) = delete;
};

#endif
