// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_SampleQueries_h
#define isosurface_SampleQueries_h

#include "Formats/Files/VolumeFile.h"

#include "Storage/Sampling/ImagePlan.h"

#include <cstddef>
#include <cstdint>
#include <optional>

namespace isosurface
{

/// Which samples of a volume values are made of. All must be those of the volume.
struct SampledArray
{
  std::size_t Array = 0;
  std::size_t TimeStep = 0;
  int Level = 0;
  int Threads = 1;
};

/// Values at points of the world, x y z each: `values` has a tuple of the array's type for each of `count`, and
/// `inside` 1 for each point within the grid, else 0; values of points beyond it are left as they were. Cost and
/// errors: SamplePoints, GetBlocks of the file.
Status ProbePoints(VolumeFile& file, const SampledArray& of, Interpolation interpolation,
  const double* points, std::size_t count, void* values, std::uint8_t* inside,
  const Progress& progress);

/// The samples of a plane, with IsInside: of the finest level, from that of `of` on, at which the plane has at
/// most `maximumPoints` points (FindLatticeWithin); nothing if it does not meet the volume. Cost and errors:
/// SampledBox::Fill, GetBlocks of the file.
Result<std::optional<SampledBox>> CutPlane(VolumeFile& file, const SampledArray& of,
  const Plane& plane, double maximumPoints, const Progress& progress);

} // namespace isosurface

#endif
