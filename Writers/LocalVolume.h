// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_LocalVolume_h
#define isosurface_LocalVolume_h

#include "IsosurfaceWritersModule.h"

#include "vtkDataArray.h"
#include "vtkSmartPointer.h"

#include "Base/Communicator.h"
#include "Base/Status.h"
#include "Source/MemorySource.h"
#include "Store/BlockedVolumeHeader.h"
#include "Volume/GridGeometry.h"

#include <array>
#include <vector>

class vtkImageData;

namespace isosurface
{

/// What this rank has of the volume; arrays in the order of `Arrays`, all of one component.
struct ISOSURFACEWRITERS_EXPORT LocalVolume
{
  GridGeometry Grid;
  std::array<double, 2> Time{ 0, 0 }; ///< 1 and the time, if there is one
  std::vector<ArrayDescription> Arrays;
  VolumePiece Piece;
  std::vector<vtkSmartPointer<vtkDataArray>> Owners;

  /// Takes all point arrays of one component of an image that is a part of the grid; the active
  /// scalars come first. The others are left out, with a warning if `isFirst`.
  Status CollectArrays(vtkImageData* image, bool isFirst);

  /**
   * Makes all ranks speak of the same volume: a rank without any part of it learns grid and arrays
   * from the others; ranks that have different ideas of them get an error.
   */
  Status Agree(Communicator& ranks);
};

} // namespace isosurface

#endif
