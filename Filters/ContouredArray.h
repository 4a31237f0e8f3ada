// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_ContouredArray_h
#define isosurface_ContouredArray_h

#include "CellArrays.h"
#include "Ground/Base/Status.h"

#include <string>

class vtkDataArray;
class vtkDataObject;
class vtkImageData;
class vtkInformation;

namespace isosurface
{

/**
 * The array of an image that a filter is to contour, at the points: `array` itself, or the average
 * of a cell array. `association` is what vtkAlgorithm::GetInputArrayToProcess gave with it. A null
 * array stays one. Errors, which name the array: InvalidArgument for an array without the chosen
 * component, or one of neither points nor cells; those of AverageToPoints.
 */
Result<vtkDataArray*> TakeContouredArray(vtkImageData* image, vtkDataArray* array, int association,
  int component, CellAverages& averages, int threads);

/// Whether the array that is to be contoured is one of cells, as far as this can be told before
/// there is data. `array` is the filter's GetInputArrayInformation().
bool IsCellArrayChosen(vtkInformation* array, vtkInformation* inInfo);

/// NotFound: no image of the input has the point array `name`, or any if it is empty. Tells which
/// cell arrays there are instead.
Status MakeMissingArrayError(vtkDataObject* input, const std::string& name);

} // namespace isosurface

#endif
