// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_SegmentFilter_h
#define isosurface_SegmentFilter_h

#include "Volume/ValueType.h"

#include <cstddef>
#include <cstdint>

namespace isosurface
{

/// What a sample is predicted from; its residual is stored instead of it.
enum class SamplePredictor : std::uint8_t
{
  None = 0,     ///< nothing: samples are stored
  Previous = 1, ///< the sample before it in the segment
  Coarser = 2   ///< the samples of the next coarser level around it (SegmentPrediction.h)
};

/// In which order the bits of the samples or residuals are stored.
enum class SampleLayout : std::uint8_t
{
  Samples = 0,    ///< one after another
  BytePlanes = 1, ///< the least significant bytes of all, then the next ones, ...
  BitPlanes = 2   ///< the least significant bits of all, eight in a byte, then the next ones, ...
};

/**
 * A reversible change of a segment's n samples, of S bytes each, that leaves as many bytes which
 * compress better. In the file it is one byte: Predictor + 16 * Layout.
 *
 * With a predictor, samples x are first made unsigned integers u(x) of the same order:
 * an unsigned x is u; of a signed integer the highest bit is inverted; of a float's bits the
 * highest bit is inverted if it is 0, and all bits if it is 1. Then the residual r = u(x) -
 * u(prediction) modulo 2^(8 S), taken as a signed number, becomes z = 2 r if r >= 0, and -2 r - 1
 * if r < 0, which is what is laid out. All of this is exact for any bits, NaN included. The first
 * sample's Previous is u = 2^(8 S - 1).
 *
 *     Samples       z(0) z(1) ... z(n - 1), each little-endian
 *     BytePlanes    byte 0 of z(0), ..., of z(n - 1); byte 1 of z(0), ...
 *     BitPlanes     with m = n / 8 rounded down: bit 0 of z(0) ... z(8 m - 1), m bytes, the first
 * of eight in the lowest bit; bit 1 ...; then z(8 m) ... z(n - 1) as in Samples
 */
struct SegmentFilter
{
  SamplePredictor Predictor = SamplePredictor::None;
  SampleLayout Layout = SampleLayout::Samples;

  std::uint8_t GetCode() const
  {
    return static_cast<std::uint8_t>(
      static_cast<unsigned>(this->Predictor) + 16 * static_cast<unsigned>(this->Layout));
  }
  /// Whether a byte of a file names a filter.
  static bool IsCode(std::uint8_t code) { return (code & 15) <= 2 && (code >> 4) <= 2; }
  static SegmentFilter FromCode(std::uint8_t code)
  {
    return { static_cast<SamplePredictor>(code & 15), static_cast<SampleLayout>(code >> 4) };
  }
};

/**
 * Filters the samples of a segment: count * GetValueSize(type) bytes from `samples` to `to`, at any
 * addresses that do not overlap. `predictions`: u of each sample's prediction, if the predictor is
 * Coarser; unsigned integers of the samples' size.
 */
void ApplyFilter(SegmentFilter filter, ValueType type, const std::uint8_t* samples,
  std::size_t count, const void* predictions, std::uint8_t* to);

/// Gives the samples back from what ApplyFilter made.
void RevertFilter(SegmentFilter filter, ValueType type, const std::uint8_t* from, std::size_t count,
  const void* predictions, std::uint8_t* samples);

} // namespace isosurface

#endif
