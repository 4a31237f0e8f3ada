// SPDX-FileCopyrightText: Copyright (c) 2026, the ScalableIsosurface authors
// SPDX-License-Identifier: BSD-3-Clause
#include "vtkIsosurfaceMapper.h"

#include "vtkIsosurfaceMapperHelper.h"

#include "vtkObjectFactory.h"

vtkStandardNewMacro(vtkIsosurfaceMapper);

//------------------------------------------------------------------------------
vtkCompositeMapperHelper2* vtkIsosurfaceMapper::CreateHelper()
{
  return vtkIsosurfaceMapperHelper::New();
}

//------------------------------------------------------------------------------
void vtkIsosurfaceMapper::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
}
