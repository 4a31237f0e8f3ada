// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_ArrayChoice_h
#define isosurface_ArrayChoice_h

#include "IsosurfaceWritersModule.h"

#include "Ground/Base/Status.h"

#include <set>
#include <string>

class vtkDataArray;
class vtkDataArraySelection;
class vtkImageData;

namespace isosurface
{

/// The arrays of an image that are written.
struct ISOSURFACEWRITERS_EXPORT ArrayChoice
{
  std::set<std::string> Names;
  std::string LeftOut; ///< says which arrays cannot be written, and why; empty if all can

  bool Has(const std::string& name) const { return this->Names.count(name) != 0; }

  /**
   * All numeric point arrays but vtkGhostType, and with `withCells` all such cell arrays; with
   * `chosen`, those that it enables. Errors
   * (InvalidArgument, Unsupported) name the array that is chosen but cannot be written, or tell
   * what to do with an input that has cell arrays alone.
   */
  static Result<ArrayChoice> Make(
    vtkImageData* image, vtkDataArraySelection* chosen, bool withCells);
};

/// The name of an array, or "scalars" if it has none.
std::string GetNameOf(vtkDataArray* array);

} // namespace isosurface

#endif
