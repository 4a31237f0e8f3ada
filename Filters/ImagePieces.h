// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_ImagePieces_h
#define isosurface_ImagePieces_h

#include "vtkSmartPointer.h"
#include "vtkType.h"

#include "CellArrays.h"
#include "Ground/Base/Communicator.h"
#include "Ground/Base/Status.h"
#include "Surface/Pieces/CollectedGrids.h"
#include "SurfacePolyData.h"

#include <string>
#include <vector>

class vtkAlgorithm;
class vtkImageData;
class vtkInformation;

namespace isosurface
{

/// The images of all ranks as pieces of grids, rectilinear grids as images in structured coordinates. The
/// extent of a grid also covers the volume that the images are blocks of (FindWholeExtent).
struct ImagePieces : CollectedGrids
{
  struct Source
  {
    vtkImageData* Image = nullptr;
    vtkSmartPointer<vtkImageData> Owner; ///< of an image that stands for a rectilinear grid
    /// When it was last modified, or what filters that hand samples on unchanged (FindPassedArrays) have made
    /// it of: such a copy may be a new one each time, as behind all of ParaView's sources and filters.
    vtkMTimeType Time = 0;
  };
  std::vector<Source> Sources; ///< of this rank's images (CollectedGrids::Images)
  /// Of Paths, "" without a name; the same on all ranks that have the blocks.
  std::vector<std::string> BlockNames;
  std::string ArrayName; ///< of the contoured array, if this rank has one with a name
};

/**
 * Collects the array that a filter contours of a vtkImageData or a vtkRectilinearGrid, or of all of these in a
 * composite, over all ranks: point arrays themselves, and the averages of cell arrays. Images without points, or
 * within a composite without the array, are left out. Collective.
 *
 * Errors: those of AverageToPoints; InvalidArgument for a dataset of another kind, lines that do not ascend,
 * an array without the chosen component, or of neither points nor cells; NotFound if no image has the array,
 * which tells what cell arrays there are instead. An error may be this rank's alone.
 */
Result<ImagePieces> CollectContouredPieces(Communicator& ranks, vtkAlgorithm& filter,
  vtkInformation* inInfo, int component, CellAverages& averages, int threads);

/// Gives the pieces of this rank the arrays of these names to interpolate: point arrays, and averages of
/// cell arrays where there is no point array of the name. Errors: NotFound for an image without one of the
/// arrays; Unsupported for a type that is not one of numbers; InvalidArgument for arrays that are not of
/// the same types in all images.
Result<std::vector<InterpolatedArray>> AddAttributes(
  ImagePieces& pieces, const std::vector<std::string>& names, CellAverages& averages, int threads);

/// The name of the array that a filter is to contour; empty for the active scalars.
std::string FindContouredName(vtkAlgorithm& filter);

/// Whether that array is one of cells, as far as this can be told before there is data.
bool IsCellArrayChosen(vtkAlgorithm& filter, vtkInformation* inInfo);

/// The unit of its values, of the first dataset of the input that tells one: vtkDataArray::UNITS_LABEL, else "HU"
/// (Hounsfield) if that is the array's name; empty if it is not known.
std::string FindContouredUnit(vtkAlgorithm& filter);

} // namespace isosurface

#endif
