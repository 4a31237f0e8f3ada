// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_SourceSampler_h
#define isosurface_SourceSampler_h

#include "Formats/Indexing/SourceIndex.h"
#include "Formats/Indexing/SourceSample.h"
#include "Ground/Base/Communicator.h"
#include "Ground/Base/FileSystem.h"
#include "Ground/Base/Progress.h"
#include "Ground/Base/Status.h"

#include <cstddef>
#include <cstdint>

namespace isosurface
{

/// What a sample may cost, and what it is of.
struct SampleLimits
{
  double Seconds = 1; ///< of reading; a first part of the file is read however long it takes
  std::int64_t Vertices = std::int64_t{ 1 } << 21;
  std::size_t Step = 0; ///< the time step
  int CoarserThan =
    0; ///< if not 0: of a pyramid, a level that is finer than this one, all of it, or no sample
};

/**
 * Reads a sample of a time step of a file, and makes a blocked volume of it in the memory of
 * each rank; the same on all ranks. What is read, whatever the size of the file:
 *
 *     its own coarse level   of a pyramid (OME-Zarr); its samples are averages
 *     every n-th row of every m-th slice     of files whose rows can be read alone
 *     every m-th slice       of files whose slices are decoded one by one
 *     a box of whole chunks  of other files, which grows from the middle
 *     the first slices       of streams, which can only be read in order
 *
 * Of an address, as many chunks are read at once as there are requests at the same time, and rows far apart first.
 * Slices are read in such an order, m from large to small, that they can end at any time; so can
 * boxes. Collective. Errors: those of the source; Aborted. Memory: some times the sample; and a chunk, or a slice, for each thread.
 */
Result<SourceSample> ReadSourceSample(Communicator& ranks, FileSystem& files,
  const SourceIndex& index, const SampleLimits& limits, const Progress& progress = {});

} // namespace isosurface

#endif
