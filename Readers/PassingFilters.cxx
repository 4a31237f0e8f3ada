// SPDX-License-Identifier: BSD-3-Clause
#include "PassingFilters.h"

#include "vtkAlgorithm.h"

#include <utility>

namespace isosurface
{

PassedArrays FindPassedArrays(vtkAlgorithm* algorithm)
{
  // By name: vtkPVPostFilter is ParaView's, which this module does without.
  constexpr std::pair<const char*, PassedArrays> filters[] = {
    { "vtkPVPostFilter", PassedArrays::All },
    { "vtkPassThrough", PassedArrays::All },
    { "vtkPassArrays", PassedArrays::Chosen },
    { "vtkPassSelectedArrays", PassedArrays::Chosen },
  };
  for (const auto& [name, passed] : filters)
  {
    if (algorithm && algorithm->IsA(name))
    {
      return passed;
    }
  }
  return PassedArrays::None;
}

} // namespace isosurface
