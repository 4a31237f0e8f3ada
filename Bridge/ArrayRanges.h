// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_ArrayRanges_h
#define isosurface_ArrayRanges_h

#include "IsosurfaceBridgeModule.h"

class vtkDataArray;
class vtkPolyData;

namespace isosurface
{

/**
 * Stores the ranges of a surface's points and point arrays, of each component and of the norm, in
 * the arrays, where VTK keeps those that it has computed (vtkDataArray::COMPONENT_RANGE,
 * L2_NORM_RANGE and their finite counterparts), and the bounds in vtkPoints. ParaView asks for all
 * of them after each update, and VTK computes each alone, value by value, which takes five times as
 * long as the extraction.
 *
 * Arrays of other types than float, double and vtkIdType, and arrays with values that are not
 * finite, are left to VTK. Call it last: an array that is modified forgets its ranges. Cost: one
 * pass over the arrays, on `threads` threads.
 */
ISOSURFACEBRIDGE_EXPORT void StoreRanges(vtkPolyData* surface, int threads);

/**
 * Stores the range of an array of one component whose maker knows it. Other arrays than those of
 * MakeRangedArray tell it only where they are asked themselves.
 */
ISOSURFACEBRIDGE_EXPORT void StoreRange(vtkDataArray* array, double minimum, double maximum);

} // namespace isosurface

#endif
