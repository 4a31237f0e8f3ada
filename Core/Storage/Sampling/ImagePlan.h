// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_ImagePlan_h
#define isosurface_ImagePlan_h

#include "Ground/Base/Buffer.h"
#include "Ground/Base/Progress.h"
#include "Ground/Base/Status.h"
#include "Ground/Volume/GridGeometry.h"
#include "Ground/Volume/GridLines.h"
#include "Ground/Volume/VertexBox.h"
#include "Storage/Sampling/LevelSamples.h"
#include "Storage/Sampling/PlaneLattice.h"
#include "Storage/Sampling/PointSampling.h"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace isosurface
{

/// Fills in one variable in a part of an image, whose vertices are counted from 0, and whether they are
/// within the volume, if some may not be: as PlaneLattice::Sample. Called beside the main thread, too.
using ImageFiller = std::function<Status(const LevelSamples& samples, std::size_t variable,
  const VertexBox& part, int threads, void* values, std::ptrdiff_t stride, std::uint8_t* isInside,
  QueryStatistics& statistics, const Progress& progress)>;

/// An image of samples of one level of a volume. Its vertices are those of Grid's extent.
struct ImagePlan
{
  int Level = 0;
  GridGeometry Grid;
  std::optional<GridLines> Lines; ///< of a rectilinear grid
  bool HasOutside = false;        ///< whether vertices may lie beyond the volume
  ImageFiller Fill;               ///< keeps what it uses
  std::string Size;               ///< for people
  std::string Note; ///< behind the size and the level; empty if there is nothing to say

  double CountPoints() const { return static_cast<double>(this->Grid.GetNumberOfVertices()); }
};

/// An image of a plane: FindLatticeWithin says which; nothing if that has none.
std::optional<ImagePlan> PlanSlice(const BlockedVolume& volume, const Plane& plane,
  Interpolation interpolation, double maximumPoints, int firstLevel = 0);

/// The same; but of many points one that two cores read and draw within some 0.1 s.
std::optional<ImagePlan> PlanCoarseSlice(const BlockedVolume& volume, const Plane& plane,
  Interpolation interpolation, double maximumPoints);

/// All samples around a box of vertices of full resolution, at the finest level at which they are at most
/// `maximumPoints`; nothing if they are more at all levels. The last samples of a level may lie before the box.
std::optional<ImagePlan> PlanBox(
  const BlockedVolume& volume, const VertexBox& finest, double maximumPoints);

/// What values beyond the volume are.
enum class ValueBeyond
{
  NotANumber, ///< 0 of integers
  Minimum     ///< of the array's component
};

/// A box of an image, with some of a volume's arrays.
struct SampledBox
{
  ImagePlan Plan;
  VertexBox Box; ///< vertices of the image, counted from 0
  std::shared_ptr<BlockedVolume> Volume;
  std::size_t TimeStep = 0;
  std::vector<std::size_t> Arrays;
  ValueBeyond Beyond = ValueBeyond::NotANumber;
  int Threads = 1;

  std::vector<Buffer<std::uint8_t>> Values; ///< of Arrays: tuples, x fastest; none of an empty box
  std::vector<std::uint8_t> IsInside;       ///< 1 for vertices within the volume; empty if all are

  /// Fills in Values and IsInside. Cost: Plan.Fill for each component. Errors: those, and of the opening of
  /// the level. Throws std::bad_alloc.
  Status Fill(LevelsOfVolume& levels, const Progress& progress);
};

} // namespace isosurface

#endif
