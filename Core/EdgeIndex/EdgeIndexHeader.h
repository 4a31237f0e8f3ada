// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_EdgeIndexHeader_h
#define isosurface_EdgeIndexHeader_h

#include "Base/Status.h"
#include "EdgeIndex/BlockScheme.h"
#include "EdgeIndex/CrossingIntervals.h"
#include "Volume/GridGeometry.h"
#include "Volume/ValueType.h"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
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
  Fast = 1,    ///< one context each
  Compact = 2  ///< as Default, with predictions that are fitted to what is around
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

/// An array on the points of the surface, as an extraction gives it.
struct EdgeIndexAttribute
{
  std::string Name;
  /// Float32 or Float64: that of the points, see GetInterpolatedType, not that of the samples.
  ValueType Type = ValueType::Float32;
  int NumberOfComponents = 1; ///< 1 to 64
  /// The most by which a component may change; 0 keeps every bit.
  double MaximumError = 0;
  /// The normals of the surface: three float32.
  bool IsNormals = false;
};

/**
 * What the blocks of an edge-index stream have in common; the first part of a stream or file.
 * Layout in Documentation/formats/edge-index.md. Values are told for provenance only where nothing
 * else is said.
 */
struct EdgeIndexHeader
{
  GridGeometry Geometry;
  ValueType Type = ValueType::UInt8; ///< of the samples that were contoured
  std::vector<double> Isovalues;
  EdgeIndexSettings Settings;

  std::string Array;          ///< the name of the samples that were contoured
  std::string Source;         ///< where they came from, in the words of the writer
  std::optional<double> Time; ///< of the samples, if they are of a time step
  std::vector<EdgeIndexAttribute> Attributes;

  /// Blocks that the writer means to look at; each has at most one record an isovalue. 0: unknown.
  std::uint64_t NumberOfBlocks = 0;

  /// Of the format, with the profile compact: 2, which is read only, or 3. Of the others it is 1.
  std::uint32_t CompactVersion = 3;

  /// If not 0 (at most 6), the surface of every 2^PreviewLevel-th vertex is there as well, bounded
  /// by PreviewMaximumError, in edges of that grid, in the fast profile. It misses blocks that do
  /// not begin at such a vertex.
  int PreviewLevel = 0;
  double PreviewMaximumError = 0.05;

  /// InvalidArgument, with the reason, for what cannot be encoded.
  Status Check() const;

  void Append(std::vector<std::uint8_t>& bytes) const;

  /// Reads the header at the begin of `bytes`; `used` becomes its size. Errors: Corrupt,
  /// Unsupported (a newer version).
  static Result<EdgeIndexHeader> Parse(
    const std::uint8_t* bytes, std::size_t size, std::size_t& used);

  /// The bytes of the least and the greatest header.
  static constexpr std::size_t LeastSize = 264;
  static constexpr std::size_t GreatestSize = std::size_t{ 64 } << 20;

  /// Whether these are the 8 bytes that every header begins with.
  static bool IsBegin(const std::uint8_t* bytes);

  /// The size of the header of which `bytes` has the first LeastSize bytes. Errors: Corrupt,
  /// Unsupported.
  static Result<std::size_t> ParseSize(const std::uint8_t* bytes);

  /// The header that the preview's blocks would have in a stream of their own.
  EdgeIndexHeader MakePreview() const;

  /// The intervals that an edge is cut into when Bounded; none if MaximumError is too small for
  /// float coordinates on this grid.
  CrossingIntervals GetIntervals() const;

  /// How the blocks are coded, but for the preview's.
  BlockScheme GetScheme() const;

  /// The type of decoded samples: Type, or Float32 if quantized.
  ValueType GetDecodedType() const;
};

} // namespace isosurface

#endif
