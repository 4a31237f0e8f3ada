// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_LocalVolume_h
#define isosurface_LocalVolume_h

#include "IsosurfaceWritersModule.h"

#include "vtkDataArray.h"
#include "vtkSmartPointer.h"

#include "Ground/Base/Communicator.h"
#include "Ground/Base/Status.h"
#include "Ground/Volume/GridGeometry.h"
#include "Ground/Volume/GridLines.h"
#include "Ground/Volume/MemorySource.h"
#include "Storage/Store/BlockedVolumeHeader.h"

#include <array>
#include <functional>
#include <optional>
#include <string>
#include <vector>

class vtkImageData;

namespace isosurface
{

/// This rank's piece of the volume: the views of all components of `Arrays`, in order.
struct ISOSURFACEWRITERS_EXPORT LocalVolume
{
  GridGeometry Grid;
  /// Of a rectilinear grid: the lines of the extent that is given with them, Grid's after Agree.
  std::optional<LinedGrid> Lines;
  std::array<double, 2> Time{ 0, 0 }; ///< 1 and the time; or 0 and 0 without a time
  std::vector<ArrayDescription> Arrays;
  VolumePiece Piece;
  std::vector<vtkSmartPointer<vtkDataArray>> Owners;
  bool WithCells = false; ///< whether CollectArrays takes cell arrays, too

  /// Which arrays to take, by name.
  using Selection = std::function<bool(const std::string& name)>;

  /// Takes the numeric point arrays of an image that is a piece of the grid; the active scalars
  /// come first. Then, if wanted, averages at points of the cell arrays of other names.
  Status CollectArrays(vtkImageData* image, const Selection& isSelected);

  /**
   * Makes all ranks speak of the same volume: a rank without a piece of it learns grid and arrays
   * from the others, and all ranks the lines of the whole grid; ranks that have different ideas
   * of them get an error.
   */
  Status Agree(Communicator& ranks);

private:
  Status UniteLines(Communicator& ranks);
  Status AverageCellArrays(vtkImageData* image, const Selection& isSelected,
    std::vector<vtkSmartPointer<vtkDataArray>>& averages) const;
};

} // namespace isosurface

#endif
