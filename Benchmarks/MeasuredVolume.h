// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_MeasuredVolume_h
#define isosurface_MeasuredVolume_h

#include "BlockSpectra.h"

#include "Base/Status.h"
#include "Partition/BlockDistribution.h"
#include "Partition/BlockProfile.h"
#include "Volume/ValueKey.h"

#include <cstdint>
#include <string>
#include <vector>

namespace isosurface
{

/// All that distributions of a volume's blocks are made from and judged by: the volume is read
/// once, then any distribution over any number of stores follows without writing it.
struct MeasuredVolume
{
  ValueType Type = ValueType::UInt8;
  std::vector<KeyRange> Ranges;       ///< per block
  std::vector<BlockProfile> Profiles; ///< per block
  BlockSpectra Spectra;

  /// Of the first array of a blocked volume; bytes are those of the array in the blocks' records.
  static Result<MeasuredVolume> Read(const std::string& path, int threads);

  /// What the writer does with these blocks.
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
