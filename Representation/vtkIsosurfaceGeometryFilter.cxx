// SPDX-FileCopyrightText: Copyright (c) 2026, the ScalableIsosurface authors
// SPDX-License-Identifier: BSD-3-Clause
#include "vtkIsosurfaceGeometryFilter.h"

#include "MeasuredTriangles.h"

#include "vtkCellArray.h"
#include "vtkCellData.h"
#include "vtkIdTypeArray.h"
#include "vtkInformationVector.h"
#include "vtkMultiProcessController.h"
#include "vtkNew.h"
#include "vtkObjectFactory.h"
#include "vtkPointData.h"
#include "vtkPolyData.h"
#include "vtkUnsignedIntArray.h"

#include "Base/HugePages.h"
#include "Base/ParallelFor.h"

#include <algorithm>
#include <cstddef>
#include <numeric>

vtkStandardNewMacro(vtkIsosurfaceGeometryFilter);

namespace
{

// Polygons alone, three points for each on average, and no ghosts, which would have to be left out.
bool LooksLikeTriangles(vtkPolyData* surface)
{
  const vtkIdType cells = surface->GetNumberOfPolys();
  return cells > 0 && surface->GetNumberOfCells() == cells &&
    surface->GetPolys()->GetNumberOfConnectivityIds() == 3 * cells &&
    !surface->GetCellGhostArray() && !surface->GetPointGhostArray();
}

// Calls body(first, last) for runs of [0, count), by several threads at once.
template <typename BodyT>
void ForRuns(vtkIdType count, BodyT&& body)
{
  constexpr vtkIdType run = vtkIdType{ 1 } << 18;
  isosurface::ParallelFor(static_cast<std::size_t>((count + run - 1) / run),
    isosurface::ChooseDrawingThreads(),
    [&](std::size_t index, int)
    {
      const vtkIdType first = static_cast<vtkIdType>(index) * run;
      body(first, std::min(count, first + run));
    });
}

// Numbers 0, 1, 2 ... as an array.
void AddNumbers(vtkDataSetAttributes* attributes, const char* name, vtkIdType count)
{
  vtkNew<vtkIdTypeArray> numbers;
  numbers->SetName(name);
  numbers->SetNumberOfValues(count);
  vtkIdType* values = numbers->GetPointer(0);
  isosurface::AdviseHugePages(values, static_cast<std::size_t>(count) * sizeof(vtkIdType));
  ForRuns(count,
    [&](vtkIdType first, vtkIdType last) { std::iota(values + first, values + last, first); });
  attributes->AddArray(numbers);
}

void AddRank(vtkDataSetAttributes* attributes, vtkIdType count, int rank)
{
  vtkNew<vtkUnsignedIntArray> ranks;
  ranks->SetName("vtkProcessId");
  ranks->SetNumberOfValues(count);
  unsigned int* values = ranks->GetPointer(0);
  isosurface::AdviseHugePages(values, static_cast<std::size_t>(count) * sizeof(unsigned int));
  ForRuns(count,
    [&](vtkIdType first, vtkIdType last)
    { std::fill(values + first, values + last, static_cast<unsigned int>(rank)); });
  attributes->AddArray(ranks);
}

} // namespace

//------------------------------------------------------------------------------
int vtkIsosurfaceGeometryFilter::RequestData(
  vtkInformation* request, vtkInformationVector** input, vtkInformationVector* output)
{
  vtkPolyData* surface = vtkPolyData::GetData(input[0]);
  const bool plain = !this->UseOutline && !this->Triangulate && !this->GenerateFeatureEdges &&
    !this->GenerateCellNormals && this->PassThroughCellIds && this->PassThroughPointIds;
  if (!surface || !plain || !LooksLikeTriangles(surface))
  {
    return this->Superclass::RequestData(request, input, output);
  }
  this->OutlineFlag = 0;
  vtkPolyData* passed = vtkPolyData::GetData(output);
  passed->ShallowCopy(surface);
  if (this->GenerateProcessIds)
  {
    const int rank = this->Controller ? this->Controller->GetLocalProcessId() : 0;
    AddNumbers(passed->GetCellData(), "vtkOriginalCellIds", surface->GetNumberOfCells());
    AddNumbers(passed->GetPointData(), "vtkOriginalPointIds", surface->GetNumberOfPoints());
    AddRank(passed->GetPointData(), surface->GetNumberOfPoints(), rank);
    AddRank(passed->GetCellData(), surface->GetNumberOfCells(), rank);
  }
  return 1;
}

//------------------------------------------------------------------------------
void vtkIsosurfaceGeometryFilter::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
}
