// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_SampledImage_h
#define isosurface_SampledImage_h

#include "Ranks/Query/FieldRefinement.h"

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
#include <map>
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

/// Fills in one component of an array in a part of an image, whose vertices are counted from 0; and
/// whether they are within the volume, if some may not be. Called beside the main thread, too.
using ImageFiller = std::function<Status(const LevelSamples& samples, std::size_t variable,
  const VertexBox& part, int threads, void* values, std::ptrdiff_t stride, std::uint8_t* isInside,
  QueryStatistics& statistics, const Progress& progress)>;

/// What image a filter makes of a volume. Its vertices are those of Grid's extent.
struct ImagePlan
{
  int Level = 0; ///< of the volume, whose samples it has
  GridGeometry Grid;
  std::optional<GridLines> Lines; ///< of a rectilinear grid
  bool HasOutside = false;        ///< whether vertices may lie beyond the volume
  std::string Size;               ///< of it, for people
  std::string Note;               ///< what else people need to know; perhaps empty
  ImageFiller Fill;               ///< keeps what it uses
};

/**
 * The common steps of filters that make an image of a blocked volume's samples, each rank a part of
 * it. All ranks of the controller execute together, and all must reach all stores.
 *
 * While AllowCoarse says so, an image of something new may be coarse. Then PrepareRefinement makes
 * the exact one beside the main thread, and the execution after Refine gives it.
 */
class SampledImage
{
public:
  explicit SampledImage(vtkAlgorithm& filter);
  virtual ~SampledImage();

  /// Tells the pipeline the image's extent and place. Collective if the input's volume is made by
  /// its first update, as an index in place is: then that is done. Returns what RequestInformation
  /// returns: 0 after an error of that update.
  int TellImage(vtkInformation* inInfo, vtkInformationVector* output);

  /// RequestData: fills the first output. False if there was an error, which is reported, or a stop: then
  /// the output is empty, and the caller returns `result`. Collective.
  bool Make(
    vtkInformation* request, vtkInformation* inInfo, vtkInformationVector* output, int& result);

  /// What the image is, once the pipeline's information is up to date.
  const std::string& GetText() const { return this->Text; }

  /// Whether new images may be coarse. If the pipeline was told of one that is not made yet, it is told
  /// again: what asks for the image knows its extent from there.
  void AllowCoarse(bool isAllowed);
  /// Whether the last image was exact, or failed.
  bool IsFinal() const { return this->Final; }
  /// Begins to make the exact image, or waits for it, but not longer than this. Collective.
  Refinement PrepareRefinement(double seconds);
  /// Stops that.
  void DropRefinement();
  /// Makes the next execution exact; false if the last one was.
  bool Refine();

protected:
  virtual vtkMultiProcessController* GetController() const = 0;
  /// A checksum of the filter's properties.
  virtual std::uint64_t SumProperties() const = 0;
  /// What to make of a volume; the arrays are those that are read. `isCoarse`: at once, if the exact
  /// image takes long. Errors: nothing of the volume is wanted.
  virtual Result<ImagePlan> Plan(
    const BlockedVolume& volume, const std::vector<std::size_t>& arrays, bool isCoarse) const = 0;

private:
  struct Part;
  class Parts;

  /// What an image is made of; the filter's properties aside, the same on all ranks.
  std::uint64_t SumSource(const VolumeInput& input) const;
  /// Plans the exact image and the coarse one, and the parts that are asked for of them. Not collective.
  Status Ask(
    const VolumeInput& input, vtkInformation* request, vtkInformationVector* output, int threads);
  Status FillOutput(
    const VolumeInput& input, int level, vtkInformation* inInfo, vtkInformation* outInfo);
  /// A part to fill, with the samples of its level, if they are known.
  std::unique_ptr<Part> DescribePart(
    const VolumeInput& input, const VertexBox& box, int threads, const ImagePlan& plan) const;
  /// Keeps the samples of a level for the next time.
  void KeepSamples(const std::shared_ptr<const LevelSamples>& samples);

  vtkAlgorithm& Filter;
  std::map<int, std::shared_ptr<const LevelSamples>> Samples; ///< of one volume and time step
  std::string Text;
  bool CoarseAllowed = false;
  bool IsOnlyTold = false;  ///< whether the pipeline was told of an image that is not made yet
  std::uint64_t Source = 0; ///< of the last image
  bool Final = true;
  std::unique_ptr<Parts> Image;
  FieldRefinement Levels;
};

} // namespace isosurface

#endif
