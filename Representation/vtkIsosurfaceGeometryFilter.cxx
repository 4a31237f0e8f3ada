// SPDX-FileCopyrightText: Copyright (c) 2026, the ScalableIsosurface authors
// SPDX-License-Identifier: BSD-3-Clause
#include "vtkIsosurfaceGeometryFilter.h"

#include "ArrayRanges.h"
#include "MeasuredTriangles.h"
#include "RangedArray.h"

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

#include "Ground/Base/HugePages.h"
#include "Ground/Base/ParallelFor.h"

#include <algorithm>
#include <array>
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

// Adds an array of one component. fill(values, first, last) sets values[first] to values[last - 1]. The
// range of the values is known, so ParaView, which asks for it, needs no pass over them.
template <typename ArrayT, typename FillT>
void AddArray(vtkDataSetAttributes* attributes, const char* name, vtkIdType count,
  const std::array<double, 2>& range, FillT&& fill)
{
  const auto array = isosurface::MakeRangedArray(vtkNew<ArrayT>()->GetDataType());
  array->SetName(name);
  array->SetNumberOfTuples(count);
  auto* values = ArrayT::FastDownCast(array)->GetPointer(0);
  isosurface::AdviseHugePages(values, static_cast<std::size_t>(count) * sizeof(*values));
  ForRuns(count, [&](vtkIdType first, vtkIdType last) { fill(values, first, last); });
  if (count > 0)
  {
    isosurface::StoreRange(array, range[0], range[1]);
  }
  attributes->AddArray(array);
}

// Numbers 0, 1, 2 ... as an array.
void AddNumbers(vtkDataSetAttributes* attributes, const char* name, vtkIdType count)
{
  AddArray<vtkIdTypeArray>(attributes, name, count, { 0, static_cast<double>(count - 1) },
    [](vtkIdType* values, vtkIdType first, vtkIdType last)
    { std::iota(values + first, values + last, first); });
}

void AddRank(vtkDataSetAttributes* attributes, vtkIdType count, unsigned int rank)
{
  const auto value = static_cast<double>(rank);
  AddArray<vtkUnsignedIntArray>(attributes, "vtkProcessId", count, { value, value },
    [rank](unsigned int* values, vtkIdType first, vtkIdType last)
    { std::fill(values + first, values + last, rank); });
}

} // namespace

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
    const auto rank =
      static_cast<unsigned int>(this->Controller ? this->Controller->GetLocalProcessId() : 0);
    AddNumbers(passed->GetCellData(), "vtkOriginalCellIds", surface->GetNumberOfCells());
    AddNumbers(passed->GetPointData(), "vtkOriginalPointIds", surface->GetNumberOfPoints());
    AddRank(passed->GetPointData(), surface->GetNumberOfPoints(), rank);
    AddRank(passed->GetCellData(), surface->GetNumberOfCells(), rank);
  }
  return 1;
}

void vtkIsosurfaceGeometryFilter::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
}
