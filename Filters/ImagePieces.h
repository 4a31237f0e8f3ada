// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_ImagePieces_h
#define isosurface_ImagePieces_h

#include "vtkSmartPointer.h"

#include "Base/Communicator.h"
#include "Base/Status.h"
#include "CellArrays.h"
#include "ImageSamples.h"
#include "SurfacePolyData.h"
#include "Volume/BlockSource.h"
#include "Volume/GridGeometry.h"

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

class vtkDataArray;
class vtkDataObject;
class vtkImageData;
class vtkInformation;

namespace isosurface
{

/// The samples of one image of a rank, in the coordinates of the grid it is a piece of.
struct ImagePiece
{
  vtkImageData* Image = nullptr;
  ImageSamples Samples;
  std::size_t Grid = 0; ///< into ImagePieces::Grids
};

/**
 * The images of all ranks as pieces of grids (UniteGrids). The extent of a grid also covers the
 * volume that the images are blocks of (FindWholeExtent).
 */
struct ImagePieces
{
  std::vector<GridGeometry> Grids; ///< equal on all ranks
  std::vector<ImagePiece> Pieces;  ///< this rank's
};

/**
 * Collects the array of a vtkImageData, or of all images in a composite, over all ranks. Images
 * without points, or within a composite without the array, are left out. Collective.
 *
 * `findArray` gives an image's point array to contour, or null. Errors: a dataset that is no
 * vtkImageData, an array that no rank has or that cannot be contoured.
 */
Result<ImagePieces> CollectImagePieces(Communicator& ranks, vtkDataObject* input,
  vtkInformation* inputInfo, const std::function<Result<vtkDataArray*>(vtkImageData*)>& findArray);

/// The arrays of these names on all vertices of a piece's image, to interpolate.
struct PieceAttributes
{
  std::vector<InterpolatedArray> Arrays;
  std::vector<AttributeView> Views;
  std::vector<vtkSmartPointer<vtkDataArray>> Owners; ///< keep the samples alive
};

/// Point arrays, and averages of cell arrays where there is no point array of the name. Errors:
/// NotFound for an image without one of the arrays; Unsupported for a type that is not one of
/// numbers.
Result<PieceAttributes> FindAttributes(const ImagePiece& piece,
  const std::vector<std::string>& names, CellAverages& averages, int threads);

} // namespace isosurface

#endif
