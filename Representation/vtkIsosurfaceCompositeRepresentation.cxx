// SPDX-FileCopyrightText: Copyright (c) 2026, the ScalableIsosurface authors
// SPDX-License-Identifier: BSD-3-Clause
#include "vtkIsosurfaceCompositeRepresentation.h"

#include "vtkObjectFactory.h"

vtkStandardNewMacro(vtkIsosurfaceCompositeRepresentation);

void vtkIsosurfaceCompositeRepresentation::AddRepresentation(
  const char* type, vtkPVDataRepresentation* representation)
{
  this->RemoveRepresentation(type);
  this->Superclass::AddRepresentation(type, representation);
}

void vtkIsosurfaceCompositeRepresentation::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
}
