// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_ScalarColors_h
#define isosurface_ScalarColors_h

#include "vtkSmartPointer.h"
#include "vtkType.h"

#include <cstddef>
#include <vector>

class vtkDataArray;
class vtkPolyData;
class vtkScalarsToColors;
class vtkUnsignedCharArray;

namespace isosurface
{

// What a mapper finds out about the colors of points, for arrays of numbers that lie in memory one
// behind the other.

/// A surface that has these tuples of an array alone.
vtkSmartPointer<vtkPolyData> MakeSurfaceOf(
  vtkDataArray* array, const std::vector<vtkIdType>& tuples);

/// FindRuns of an array of one component.
std::vector<std::size_t> FindRunsOf(vtkDataArray* scalars, std::size_t most);

/// The colors of all points, of those of their runs.
vtkSmartPointer<vtkUnsignedCharArray> RepeatColors(
  vtkUnsignedCharArray* colorsOfRuns, const std::vector<std::size_t>& ends);

/// FindTextureCoordinates of tuples [first, last), two for each, in a texture of the lookup table's colors.
void WriteColorCoordinates(vtkDataArray* scalars, vtkScalarsToColors* lookupTable,
  std::size_t first, std::size_t last, float* coordinates, int threads);

} // namespace isosurface

#endif
