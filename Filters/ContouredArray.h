// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_ContouredArray_h
#define isosurface_ContouredArray_h

#include "CellArrays.h"
#include "Ground/Base/Communicator.h"
#include "Ground/Base/Status.h"
#include "ImagePieces.h"

#include <functional>
#include <string>

class vtkDataArray;
class vtkDataObject;
class vtkDataSet;
class vtkImageData;
class vtkInformation;

namespace isosurface
{

/// Gives the array of an image that is to be contoured, or null, and its association, as
/// vtkAlgorithm::GetInputArrayToProcess does.
using ArrayChooser = std::function<vtkDataArray*(vtkImageData* image, int& association)>;

/**
 * Collects the array to contour of the input's images over all ranks: point arrays themselves, and
 * the averages of cell arrays. Collective.
 *
 * Errors: those of CollectImagePieces and AverageToPoints; InvalidArgument, which names the array,
 * for one without the chosen component, or one of neither points nor cells; NotFound if no image
 * has the array `name`, or any array if it is empty, which tells what cell arrays there are instead. An
 * error may be this rank's alone.
 */
Result<ImagePieces> CollectContouredPieces(Communicator& ranks, vtkInformation* inInfo,
  const ArrayChooser& choose, const std::string& name, int component, CellAverages& averages,
  int threads);

/// Whether the array that is to be contoured is one of cells, as far as this can be told before
/// there is data. `array` is the filter's GetInputArrayInformation().
bool IsCellArrayChosen(vtkInformation* array, vtkInformation* inInfo);

/// The unit of an array's values: vtkDataArray::UNITS_LABEL, else "HU" (Hounsfield) if that is the array's
/// name; empty if it is not known.
std::string FindUnit(vtkDataArray* array);
/// That of the array that a filter contours, as the first dataset of its input tells it.
std::string FindContouredUnit(
  vtkDataObject* input, const std::function<vtkDataArray*(vtkDataSet*)>& choose);

} // namespace isosurface

#endif
