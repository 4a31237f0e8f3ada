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

#include <functional>
#include <string>
#include <vector>

class vtkDataArray;
class vtkDataObject;
class vtkImageData;
class vtkInformation;

namespace isosurface
{

/// When an image, or the one that stands for a rectilinear grid, was last modified. Filters that hand
/// samples on unchanged (FindPassedArrays) make a copy that shares them, which may be a new one each
/// time, as behind all of ParaView's sources and filters: then that of the original counts.
vtkMTimeType FindImageTime(vtkInformation* inputInfo, vtkImageData* image);

/// The images of all ranks as pieces of grids, rectilinear grids as images in structured coordinates. The
/// extent of a grid also covers the volume that the images are blocks of (FindWholeExtent).
struct ImagePieces : CollectedGrids
{
  struct Source
  {
    vtkImageData* Image = nullptr;
    vtkSmartPointer<vtkImageData> Owner; ///< of an image that stands for a rectilinear grid
    vtkMTimeType Time = 0;               ///< see FindImageTime
  };
  std::vector<Source> Sources; ///< of this rank's images (CollectedGrids::Images)
  /// Of Paths, "" without a name; the same on all ranks that have the blocks.
  std::vector<std::string> BlockNames;
};

/**
 * Collects the array of a vtkImageData or a vtkRectilinearGrid, or of all of these in a composite,
 * over all ranks. Those without points, or within a composite without the array, are left out.
 * Collective.
 *
 * `findArray` gives an image's point array to contour, or null. Errors: a dataset of another kind, an
 * array that no rank has or that cannot be contoured, lines that do not ascend. An error may be this rank's
 * alone: the caller has all ranks agree.
 */
Result<ImagePieces> CollectImagePieces(Communicator& ranks, vtkDataObject* input,
  vtkInformation* inputInfo, const std::function<Result<vtkDataArray*>(vtkImageData*)>& findArray,
  int threads);

/// Gives the pieces of this rank the arrays of these names to interpolate: point arrays, and averages of
/// cell arrays where there is no point array of the name. Errors: NotFound for an image without one of the
/// arrays; Unsupported for a type that is not one of numbers; InvalidArgument for arrays that are not of
/// the same types in all images.
Result<std::vector<InterpolatedArray>> AddAttributes(
  ImagePieces& pieces, const std::vector<std::string>& names, CellAverages& averages, int threads);

} // namespace isosurface

#endif
