// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_SegmentFilter_h
#define isosurface_SegmentFilter_h

#include "Ground/Volume/ValueType.h"

#include <cstddef>
#include <cstdint>

namespace isosurface
{

/// What a sample is predicted from; the residual is stored instead of the sample. The numbers are
/// part of the file format.
enum class SamplePredictor : std::uint8_t
{
  None = 0,     ///< nothing: the samples are stored
  Previous = 1, ///< the sample before it in the segment
  Coarser = 2   ///< the samples of the next coarser level around it (SegmentPrediction.h)
};

/// Whether a byte of a file is the number of a predictor.
bool IsPredictor(std::uint8_t number);

/**
 * Filters the samples of a segment: count * GetValueSize(type) bytes from `samples` to as many
 * bytes in `to`, which compress better. Neither need be aligned; they must not overlap.
 * `predictions`, for Coarser only: u of each sample's prediction, integers of the samples' size.
 *
 * Without a predictor, z is the sample's bits. Otherwise samples become unsigned integers u of the
 * same order (OrderedSample.h); the residual r = u - u(prediction), modulo 2^(8 S) for samples of
 * S bytes, read as a signed number, becomes z = 2 r if r >= 0, else -2 r - 1. The prediction of
 * the first sample by Previous is u = 2^(8 S - 1). Exact for any bits, NaN included.
 *
 *     +-----------------------+-----------------------+-----+---------------------------+
 *     | byte 0 (lowest) of    | byte 1 of             | ... | byte S - 1 of             |
 *     | z(0), z(1) ... z(n-1) | z(0), z(1) ... z(n-1) |     | z(0), z(1) ... z(n-1)     |
 *     +-----------------------+-----------------------+-----+---------------------------+
 */
void ApplyFilter(SamplePredictor predictor, ValueType type, const std::uint8_t* samples,
  std::size_t count, const void* predictions, std::uint8_t* to);

/// Restores the samples from the output of ApplyFilter.
void RevertFilter(SamplePredictor predictor, ValueType type, const std::uint8_t* from,
  std::size_t count, const void* predictions, std::uint8_t* samples);

} // namespace isosurface

#endif
