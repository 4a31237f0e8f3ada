// SPDX-License-Identifier: BSD-3-Clause
#include "BlockData.h"

#include "ImageContour.h"

#include "vtkFieldData.h"
#include "vtkIdTypeArray.h"
#include "vtkIntArray.h"
#include "vtkNew.h"
#include "vtkPointData.h"
#include "vtkPolyData.h"
#include "vtkSmartPointer.h"
#include "vtkStringArray.h"

#include <algorithm>
#include <cstddef>
#include <string>

namespace isosurface
{

void AddBlocks(const SurfaceBlocks& blocks, vtkPolyData* surface)
{
  const vtkSmartPointer<vtkIdTypeArray> ids =
    vtkIdTypeArray::SafeDownCast(surface->GetPointData()->GetGlobalIds());
  if (blocks.Names.empty() || !ids)
  {
    return;
  }
  vtkNew<vtkIntArray> numbers;
  numbers->SetName("BlockIds");
  numbers->SetNumberOfTuples(ids->GetNumberOfTuples());
  for (vtkIdType point = 0; point < ids->GetNumberOfTuples(); ++point)
  {
    const auto next =
      std::upper_bound(blocks.FirstIds.begin(), blocks.FirstIds.end(), ids->GetValue(point));
    const auto grid = static_cast<std::size_t>(next - blocks.FirstIds.begin() - 1);
    numbers->SetValue(point, static_cast<int>(blocks.Numbers[grid]));
  }
  // Ids stay the last array: see MoveToPolyData.
  surface->GetPointData()->RemoveArray(ids->GetName());
  surface->GetPointData()->AddArray(numbers);
  surface->GetPointData()->SetGlobalIds(ids);
  vtkNew<vtkStringArray> names;
  names->SetName("BlockNames");
  for (const std::string& name : blocks.Names)
  {
    names->InsertNextValue(name);
  }
  surface->GetFieldData()->AddArray(names);
}

} // namespace isosurface
