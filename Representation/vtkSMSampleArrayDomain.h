// SPDX-FileCopyrightText: Copyright (c) 2026, the ScalableIsosurface authors
// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkSMSampleArrayDomain
 * @brief   the arrays of a filter's input that have samples: all but vtkGhostType
 */

#ifndef vtkSMSampleArrayDomain_h
#define vtkSMSampleArrayDomain_h

#include "IsosurfaceRepresentationModule.h" // For export macro
#include "vtkSMArrayListDomain.h"

class ISOSURFACEREPRESENTATION_EXPORT vtkSMSampleArrayDomain : public vtkSMArrayListDomain
{
public:
  static vtkSMSampleArrayDomain* New();
  vtkTypeMacro(vtkSMSampleArrayDomain, vtkSMArrayListDomain);
  void PrintSelf(ostream& os, vtkIndent indent) override;

protected:
  vtkSMSampleArrayDomain() = default;
  ~vtkSMSampleArrayDomain() override = default;

  bool IsFilteredArray(vtkPVDataInformation* info, int association, const char* name) override;

private:
  vtkSMSampleArrayDomain(const vtkSMSampleArrayDomain&) = delete;
  void operator=(const vtkSMSampleArrayDomain&) = delete;
};

#endif
