// SPDX-FileCopyrightText: Copyright (c) 2026, the ScalableIsosurface authors
// SPDX-License-Identifier: BSD-3-Clause
#include "vtkIsosurfaceGeometryFilter.h"

#include "vtkCellArray.h"
#include "vtkInformationVector.h"
#include "vtkObjectFactory.h"
#include "vtkPolyData.h"

vtkStandardNewMacro(vtkIsosurfaceGeometryFilter);

namespace
{

// Polygons alone, as many points a polygon as triangles have, and no ghosts to be left out.
bool LooksLikeTriangles(vtkPolyData* surface)
{
  const vtkIdType cells = surface->GetNumberOfPolys();
  return cells > 0 && surface->GetNumberOfCells() == cells &&
    surface->GetPolys()->GetNumberOfConnectivityIds() == 3 * cells &&
    !surface->GetCellGhostArray() && !surface->GetPointGhostArray();
}

} // namespace

//------------------------------------------------------------------------------
int vtkIsosurfaceGeometryFilter::RequestData(
  vtkInformation* request, vtkInformationVector** input, vtkInformationVector* output)
{
  vtkPolyData* surface = vtkPolyData::GetData(input[0]);
  const bool plain = !this->UseOutline && !this->Triangulate && !this->GenerateFeatureEdges &&
    !this->GenerateCellNormals && !this->GenerateProcessIds;
  if (!surface || !plain || !LooksLikeTriangles(surface))
  {
    return this->Superclass::RequestData(request, input, output);
  }
  this->OutlineFlag = 0;
  vtkPolyData::GetData(output)->ShallowCopy(surface);
  return 1;
}

//------------------------------------------------------------------------------
void vtkIsosurfaceGeometryFilter::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
}
