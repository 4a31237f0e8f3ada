// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_CellArrays_h
#define isosurface_CellArrays_h

#include "IsosurfaceBridgeModule.h"

#include "vtkSmartPointer.h"

#include "Ground/Base/Status.h"

#include <string>
#include <vector>

class vtkDataArray;
class vtkDataSetAttributes;
class vtkImageData;

namespace isosurface
{

/**
 * A cell array of an image as a point array of the same name and type: what vtkCellDataToPointData
 * makes of it, bit for bit. Hidden cells (FindBlanking), and those at hidden points, have no part in
 * it. At a border between pieces it is that of the whole if the image has a layer of ghost cells there.
 *
 * Errors, which name the array: Unsupported for a type that is not one of numbers; InvalidArgument
 * for an array of another length.
 */
ISOSURFACEBRIDGE_EXPORT Result<vtkSmartPointer<vtkDataArray>> AverageToPoints(
  vtkImageData* image, vtkDataArray* cells, int threads);

/// Such averages, kept from one execution to the next while cells and image stay the same.
class ISOSURFACEBRIDGE_EXPORT CellAverages
{
public:
  /// See AverageToPoints. The array belongs to this. `imageTime`: when the image was last modified.
  Result<vtkDataArray*> Find(
    vtkImageData* image, vtkMTimeType imageTime, vtkDataArray* cells, int threads);

  /// Forgets the arrays that no execution has used since the last call.
  void DropUnused();

private:
  struct Entry
  {
    vtkSmartPointer<vtkDataArray> Cells;
    vtkMTimeType Time = 0;
    vtkSmartPointer<vtkDataArray> Points;
    bool IsUsed = true;
  };

  std::vector<Entry> Entries;
};

/// The names of numeric arrays, each in quotes, with commas between; without vtkGhostType.
ISOSURFACEBRIDGE_EXPORT std::string ListArrays(vtkDataSetAttributes* attributes);

} // namespace isosurface

#endif
