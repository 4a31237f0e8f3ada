// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_SampledImage_h
#define isosurface_SampledImage_h

#include "Ground/Base/Communicator.h"
#include "Ground/Base/Progress.h"
#include "Ground/Base/Status.h"
#include "Ground/Volume/GridGeometry.h"
#include "Ground/Volume/GridLines.h"
#include "Ground/Volume/VertexBox.h"
#include "Storage/Sampling/LevelSamples.h"
#include "Storage/Store/QueryStatistics.h"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

class vtkAlgorithm;
class vtkInformation;
class vtkInformationVector;
class vtkMultiProcessController;

namespace isosurface
{

class BlockedVolume;
class VolumeInput;

/// What image a filter makes of a volume. Its vertices are those of Grid's extent.
struct ImagePlan
{
  int Level = 0; ///< of the volume, whose samples it has
  GridGeometry Grid;
  std::optional<GridLines> Lines; ///< of a rectilinear grid
  bool HasOutside = false;        ///< whether vertices may lie beyond the volume
  std::string Size;               ///< of it, for people
  std::string Note;               ///< what else people need to know; perhaps empty
};

/**
 * The common steps of filters that make an image of a blocked volume's samples, each rank a part of
 * it. All ranks of the controller execute together, and all must reach all stores.
 */
class SampledImage
{
public:
  /// What to make of a volume; the arrays are those that are read. Errors: nothing of the volume is
  /// wanted.
  using Planner =
    std::function<Result<ImagePlan>(const BlockedVolume&, const std::vector<std::size_t>& arrays)>;
  /// Fills in one component of an array in a part of the image, whose vertices are counted from 0;
  /// and whether they are within the volume, if some may not be.
  using Filler = std::function<Status(const LevelSamples& samples, std::size_t variable,
    const VertexBox& part, int threads, void* values, std::ptrdiff_t stride, std::uint8_t* isInside,
    QueryStatistics& statistics, const Progress& progress)>;

  explicit SampledImage(vtkAlgorithm& filter)
    : Filter(filter)
  {
  }

  /// Tells the pipeline the image's extent and place. Collective if the input's volume is made by
  /// its first update, as an index in place is: then that is done.
  void TellImage(vtkInformation* inInfo, vtkInformation* outInfo,
    vtkMultiProcessController* controller, const Planner& plan);

  /// RequestData: fills the first output. `properties`: a checksum of those of the filter. False if
  /// there was an error, which is reported, or a stop: then the output is empty, and the caller
  /// returns `result`. Collective.
  bool Make(vtkInformation* request, vtkInformation* inInfo, vtkInformationVector* output,
    vtkMultiProcessController* controller, std::uint64_t properties, const Planner& plan,
    const Filler& fill, int& result);

  /// What the image is, once the pipeline's information is up to date.
  const std::string& GetText() const { return this->Text; }

private:
  Status FillPart(const VolumeInput& input, const VertexBox& part, vtkInformation* outInfo,
    int threads, const ImagePlan& plan, const Filler& fill);
  /// The samples of a level, kept for the next time.
  Result<std::shared_ptr<const LevelSamples>> OpenSamples(const VolumeInput& input, int level);

  vtkAlgorithm& Filter;
  std::shared_ptr<const LevelSamples> Samples;
  std::string Text;
};

} // namespace isosurface

#endif
