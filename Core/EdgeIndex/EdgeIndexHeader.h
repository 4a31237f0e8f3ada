// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_EdgeIndexHeader_h
#define isosurface_EdgeIndexHeader_h

#include "Base/Status.h"
#include "Volume/GridGeometry.h"
#include "Volume/ValueType.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace isosurface
{

/// What of a surface's geometry is kept. Its connectivity is exact in every mode.
enum class EdgeIndexMode : std::uint8_t
{
  Lossless = 0,  ///< the values at the ends of crossed edges: every point, bit by bit
  Bounded = 1,   ///< where on its edge each point lies, to within MaximumError
  Quantized = 2, ///< the values at the ends of crossed edges, to QuantizationBits
  Smallest = 3   ///< the smaller of lossless and bounded, block by block
};

/// How much time is spent on it.
enum class EdgeIndexProfile : std::uint8_t
{
  Default = 0, ///< probabilities mixed of several contexts
  Fast = 1     ///< one context each
};

struct EdgeIndexSettings
{
  EdgeIndexMode Mode = EdgeIndexMode::Lossless;
  EdgeIndexProfile Profile = EdgeIndexProfile::Default;

  /// Bounded and Smallest: the most by which a point may be shifted along its edge, as a share of
  /// the edge, rounding of its structured coordinate to float included. Above 0, at most 0.5.
  double MaximumError = 0.01;

  /// Quantized: values are rounded to 2^bits (2 to 24) equal steps from the least to the greatest.
  int QuantizationBits = 12;
  double QuantizationMinimum = 0;
  double QuantizationMaximum = 255;
};

/**
 * What the blocks of an edge-index stream have in common; the first record of a stream. Layout in
 * Documentation/formats/edge-index-code.md.
 */
struct EdgeIndexHeader
{
  GridGeometry Geometry;
  ValueType Type = ValueType::UInt8; ///< of the samples that were contoured
  std::vector<double> Isovalues;
  EdgeIndexSettings Settings;

  /// InvalidArgument, with the reason, for what cannot be encoded.
  Status Check() const;

  void Append(std::vector<std::uint8_t>& bytes) const;

  /// Reads the header at the begin of `bytes`; `used` becomes its size. Errors: Corrupt,
  /// Unsupported (a newer version).
  static Result<EdgeIndexHeader> Parse(
    const std::uint8_t* bytes, std::size_t size, std::size_t& used);

  /// The intervals that an edge is cut into when Bounded; 0 if MaximumError is too small for float
  /// coordinates on this grid.
  std::uint32_t GetNumberOfBins() const;

  /// The type of decoded samples: Type, or Float32 if quantized.
  ValueType GetDecodedType() const;
};

} // namespace isosurface

#endif
