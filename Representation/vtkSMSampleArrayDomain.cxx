// SPDX-FileCopyrightText: Copyright (c) 2026, the ScalableIsosurface authors
// SPDX-License-Identifier: BSD-3-Clause
#include "vtkSMSampleArrayDomain.h"

#include "vtkDataSetAttributes.h"
#include "vtkObjectFactory.h"

#include <cstring>

vtkStandardNewMacro(vtkSMSampleArrayDomain);

bool vtkSMSampleArrayDomain::IsFilteredArray(vtkPVDataInformation*, int, const char* name)
{
  return name && std::strcmp(name, vtkDataSetAttributes::GhostArrayName()) == 0;
}

void vtkSMSampleArrayDomain::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
}
