// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_VolumeVerification_h
#define isosurface_VolumeVerification_h

#include "Ground/Base/FileSystem.h"
#include "Ground/Base/Progress.h"
#include "Ground/Base/Status.h"
#include "Ground/Volume/VolumeOpener.h"
#include "Storage/Store/BlockedVolumeHeader.h"

#include <cstdint>
#include <string>
#include <vector>

namespace isosurface
{

/// The result of checking a blocked volume's files.
struct VolumeVerification
{
  /// Further faults are counted, but not kept.
  static constexpr std::size_t MaximumFaults = 10000;

  /// Each names a file and what is wrong with it; in the order of time steps, overviews, stores and
  /// blocks.
  std::vector<Status> Faults;
  std::uint64_t FaultCount = 0;
  /// Of a volume with replicas: a sentence for each damaged store, whether it can be repaired, and
  /// why not.
  std::vector<std::string> Repairs;
  std::uint64_t Files = 0;  ///< that were checked
  std::uint64_t Blocks = 0; ///< of all time steps, overviews included
  std::uint64_t Bytes = 0;  ///< of records
};

/**
 * Reads every byte of a blocked volume that its header leads to, overviews included, and checks:
 * the checksums of header, spectra, directories, trees and segments; that every segment decodes;
 * that the padding after records is zero; that each store has the contents that the header states;
 * that the stores together have each block once; that each tree has the range of each block's
 * samples; and that the stores' spectra add up to the volume's.
 *
 * Of a volume in place the samples at full resolution are read from its source and compared with
 * those that were indexed, for which `opener` is needed. That the source is missing is a fault; the
 * rest is checked all the same.
 *
 * Replicas of stores are checked like these.
 *
 * `header`: checked instead of the header at the path.
 *
 * After a fault it continues with the files that do not depend on the faulty one. The result does
 * not depend on the number of threads. Aborted if `progress` asked to stop.
 *
 * Cost: one pass over the files. Memory: 8 bytes a segment and 24 bytes a block and variable, of
 * one time step, and a record and its samples for each thread.
 */
Result<VolumeVerification> VerifyBlockedVolume(const std::string& path, FileSystem& files,
  int threads, const Progress& progress = {}, VolumeOpener opener = nullptr,
  const BlockedVolumeHeader* header = nullptr);

} // namespace isosurface

#endif
