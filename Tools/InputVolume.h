// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_InputVolume_h
#define isosurface_InputVolume_h

#include "BlockVolumeOptions.h"

#include "Base/Status.h"
#include "Source/SlabSource.h"
#include "Store/BlockedVolumeHeader.h"
#include "Volume/GridGeometry.h"

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

namespace isosurface
{

/// The volume that is to be written, as any rank sees it: all of it.
struct InputVolume
{
  GridGeometry Grid;
  std::vector<ArrayDescription> Arrays;
  std::optional<double> Time;
  std::uint64_t HeldBytes = 0; ///< of samples that are in memory already
  std::shared_ptr<void> Owner; ///< of what the source reads from; goes after it
  std::unique_ptr<SlabSource> Source;

  /// Opens what the options name: samples without a header, a format that Core reads part by part,
  /// or one of VTK's.
  static Result<InputVolume> Open(const BlockVolumeOptions& options);
};

/// Of the arrays that a file has, those of the names, in the names' order; all without names.
/// NotFound tells which there are.
Result<std::vector<ArrayDescription>> ChooseArrays(const std::string& path,
  const std::vector<ArrayDescription>& arrays, const std::vector<std::string>& names);

} // namespace isosurface

#endif
