// SPDX-FileCopyrightText: Copyright (c) 2026, the ScalableIsosurface authors
// SPDX-License-Identifier: BSD-3-Clause
#include "vtkIsosurfaceMapper.h"

#include "vtkIsosurfaceMapperHelper.h"

#include "vtkObjectFactory.h"

vtkStandardNewMacro(vtkIsosurfaceMapper);

//------------------------------------------------------------------------------
vtkIsosurfaceMapper::vtkIsosurfaceMapper()
  : Triangles(std::make_shared<isosurface::MeasuredTriangles>())
{
}

//------------------------------------------------------------------------------
vtkIsosurfaceMapper::~vtkIsosurfaceMapper() = default;

//------------------------------------------------------------------------------
vtkCompositeMapperHelper2* vtkIsosurfaceMapper::CreateHelper()
{
  vtkIsosurfaceMapperHelper* helper = vtkIsosurfaceMapperHelper::New();
  helper->SetTriangles(this->Triangles);
  return helper;
}

//------------------------------------------------------------------------------
void vtkIsosurfaceMapper::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
}
