// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_PipelineSource_h
#define isosurface_PipelineSource_h

#include "IsosurfaceWritersModule.h"

#include "Ground/Volume/BoxSource.h"
#include "Ground/Volume/GridGeometry.h"
#include "Storage/Store/BlockedVolumeHeader.h"

#include <vector>

class vtkAlgorithmOutput;
class vtkDataObject;
class vtkInformation;

namespace isosurface
{

struct LocalVolume;

/**
 * The samples of a pipeline's image data or rectilinear grid, of which Read() asks for a box: it updates the
 * pipeline with an extent of its own. Every rank's source has the whole grid.
 *
 * An input that delivers more than the requested extent is not updated again for samples that it has.
 */
class ISOSURFACEWRITERS_EXPORT PipelineSource : public BoxSource
{
public:
  /// `input` is updated at the time of `information` (of the input); both outlive this object.
  /// Of the input's arrays those that `arrays` names are taken, in that order.
  /// `withCells`: some may be averages of cell arrays, for which one more layer is requested.
  PipelineSource(vtkAlgorithmOutput* input, vtkInformation* information, const GridGeometry& grid,
    const std::vector<ArrayDescription>& arrays, bool withCells = false);

  /// Updates the pipeline with an extent, at the time of `information`; what it gives.
  static vtkDataObject* Update(
    vtkAlgorithmOutput* input, vtkInformation* information, const int extent[6]);

  /// Asks for the smallest piece that tells which arrays there are.
  static void AskForFirstSlice(vtkInformation* information, bool withCells = false);

  const VertexBox& GetBox() const override { return this->Box; }
  std::uint64_t GetReadBytes(const VertexBox& box) const override;
  bool CanReadAhead() const override { return false; }
  Result<BoxSamples> Read(const VertexBox& box) override;

private:
  vtkDataObject* UpdateInput(const VertexBox& box);
  /// Takes the wanted arrays of a box; false if one is missing or does not cover the box.
  bool TakeArrays(const LocalVolume& local, const VertexBox& box, BoxSamples& slab) const;

  vtkAlgorithmOutput* Input;
  vtkInformation* Information;
  GridGeometry Grid;
  std::vector<ArrayDescription> Arrays;
  VertexBox Box;
  bool WithCells;
};

} // namespace isosurface

#endif
