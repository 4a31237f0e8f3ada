// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_MeasuredVolume_h
#define isosurface_MeasuredVolume_h

#include "Volumes/BlockSpectra.h"

#include "Ground/Base/Status.h"
#include "Ground/Volume/ValueKey.h"
#include "Storage/Distribution/BlockDistribution.h"
#include "Storage/Distribution/BlockProfile.h"

#include <cstdint>
#include <string>
#include <vector>

namespace isosurface
{

/// The input and the results of distributions of a volume's blocks: the volume is read once, then
/// any distribution over any number of stores can be computed without writing it.
struct MeasuredVolume
{
  ValueType Type = ValueType::UInt8;
  std::vector<KeyRange> Ranges;       ///< by block
  std::vector<BlockProfile> Profiles; ///< by block
  BlockSpectra Spectra;

  /// Measures the first array of a blocked volume. Bytes are those of the array in the records.
  static Result<MeasuredVolume> Read(const std::string& path, int threads);

  /// The distribution that the writer would choose.
  std::vector<std::uint32_t> Distribute(DistributionMethod method, std::uint32_t stores) const
  {
    return DistributeBlocks(method, this->Type, this->Ranges, stores, 0, this->Profiles);
  }
};

/// Writes a .mhd, .mha, .nrrd or .nhdr file as a blocked volume: balanced, lz4.
Status WriteVolume(
  const std::string& from, const std::string& to, int blockSize, std::uint32_t stores, int threads);

} // namespace isosurface

#endif
