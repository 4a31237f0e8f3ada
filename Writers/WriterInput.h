// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_WriterInput_h
#define isosurface_WriterInput_h

#include "IsosurfaceWritersModule.h"

#include "vtkSmartPointer.h"

#include "Ground/Base/Status.h"
#include "Ground/Volume/GridLines.h"

#include <optional>

class vtkAlgorithmOutput;
class vtkDataObject;
class vtkImageData;
class vtkInformation;

namespace isosurface
{

/// A piece of a volume: an image, or a rectilinear grid as an image in structured coordinates.
struct ISOSURFACEWRITERS_EXPORT WriterInput
{
  vtkSmartPointer<vtkImageData> Image; ///< null if there is nothing
  std::optional<GridLines> Lines; ///< of the image's extent, of a rectilinear grid; they ascend

  /// Of image data or a rectilinear grid; nothing of other data. Errors: lines that do not ascend.
  static Result<WriterInput> Take(vtkDataObject* data);

  /// The same of the only part of a composite. Errors: several parts.
  static Result<WriterInput> Find(vtkDataObject* input);

  /// The lines of a whole extent of which this is the first slice. Asks the pipeline for a column
  /// along z, at the time of `information`. Errors: it does not deliver that.
  Result<GridLines> FindWholeLines(
    vtkAlgorithmOutput* input, vtkInformation* information, const int whole[6]) const;
};

} // namespace isosurface

#endif
