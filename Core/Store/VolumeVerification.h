// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_VolumeVerification_h
#define isosurface_VolumeVerification_h

#include "Base/FileSystem.h"
#include "Base/Progress.h"
#include "Base/Status.h"

#include <cstdint>
#include <string>
#include <vector>

namespace isosurface
{

/// What a blocked volume's files were found to be.
struct VolumeVerification
{
  /// More faults than this are counted, but not kept.
  static constexpr std::size_t MostFaults = 10000;

  /// Each names a file and what is wrong with it; in the order of time steps, overviews, stores and
  /// blocks.
  std::vector<Status> Faults;
  std::uint64_t FaultCount = 0;
  std::uint64_t Files = 0;  ///< that were looked at
  std::uint64_t Blocks = 0; ///< of all time steps, overviews included
  std::uint64_t Bytes = 0;  ///< of records
};

/**
 * Reads every byte of a blocked volume that its header leads to, and checks all that can be known:
 * the checksums of header, spectra, directories, trees and segments; that every segment decodes;
 * that what is behind a record is zero; that each store's contents are those that the header
 * knows; that the stores together have each block once; that each tree has each block of its
 * store with the range of its values, and that of magnitudes with theirs; and that the stores'
 * spectra add up to the volume's. The same of overviews.
 *
 * Goes on behind a fault, with whatever does not depend on it. The result does not depend on the
 * number of threads. Aborted if `progress` asked to stop.
 *
 * Cost: one pass over the files. Memory: 8 bytes a segment and 24 bytes a block and variable, of
 * one time step, and a record and its samples a thread.
 */
Result<VolumeVerification> VerifyBlockedVolume(
  const std::string& path, FileSystem& files, int threads, const Progress& progress = {});

} // namespace isosurface

#endif
