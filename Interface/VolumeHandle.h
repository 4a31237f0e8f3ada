// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_VolumeHandle_h
#define isosurface_VolumeHandle_h

#include "Interface/Call.h"

#include "Formats/Files/SurfaceQueries.h"
#include "Formats/Files/VolumeFile.h"

#include <memory>
#include <mutex>
#include <string>
#include <vector>

/// A level as C sees it.
struct OwnedGrid : si_grid
{
  explicit OwnedGrid(isosurface::LevelDescription description);
  OwnedGrid(const OwnedGrid&) = delete;
  OwnedGrid& operator=(const OwnedGrid&) = delete;

  const isosurface::LevelDescription Owned;
};

struct si_volume
{
  explicit si_volume(std::shared_ptr<isosurface::VolumeFile> file);
  si_volume(const si_volume&) = delete;
  si_volume& operator=(const si_volume&) = delete;

  /// InvalidArgument unless it has them.
  isosurface::Status Check(std::size_t array, std::size_t step, std::size_t level) const;
  isosurface::Result<isosurface::ContouredSamples> Find(const si_scalar& scalar) const;

  const std::shared_ptr<isosurface::VolumeFile> File;
  const std::string LeftOut;
  std::vector<si_array> Arrays;
  std::vector<double> Times;
  si_volume_info Info{};
  std::mutex Mutex; ///< guards Grids
  std::vector<std::unique_ptr<OwnedGrid>> Grids;
};

namespace isosurface
{

/// The unit of a name; Unknown of NULL and "". Error: InvalidArgument.
Result<LengthUnit> TakeUnit(const char* name);
/// The grid of a volume to be written, at which the samples begin.
Result<LevelDescription> TakeGrid(const si_grid* given);
/// The choice of how a file is opened.
Result<OpeningChoice> TakeOpening(const si_opening* given);

/// RunCall for a volume.
template <typename Work>
si_result RunOn(si_volume* volume, const si_run* run, const Work& work)
{
  return volume ? RunCall(volume->File->GetPath(), run, work)
                : EndCall({ StatusCode::InvalidArgument, "the volume is NULL" });
}

} // namespace isosurface

#endif
