// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_EdgeIndexHeader_h
#define isosurface_EdgeIndexHeader_h

#include "Coding/BlockCoding/CrossingIntervals.h"
#include "Coding/BlockCoding/EdgeIndexProfile.h"
#include "Coding/BlockCoding/Quantizer.h"
#include "Ground/Base/Status.h"
#include "Ground/Volume/GridGeometry.h"
#include "Ground/Volume/GridSides.h"
#include "Ground/Volume/ValueType.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace isosurface
{

// Maxima of the format.
constexpr std::size_t MaximumIsovalues = 65536;
constexpr std::size_t MaximumAttributes = 256;
constexpr std::size_t MaximumTextSize = 65535;
constexpr int MaximumPreviewLevel = 6;
constexpr int MaximumTupleSize = 64;
constexpr int MaximumComponents = 256; ///< of all attributes together

/// How exactly points are kept. The connectivity is exact in every mode. The numbers are those of
/// the file format.
enum class EdgeIndexMode : std::uint8_t
{
  Lossless = 0,  ///< the values at the ends of crossed edges: every point, bit by bit
  Bounded = 1,   ///< where on its edge each point lies, to within MaximumError
  Quantized = 2, ///< the values at the ends of crossed edges, to QuantizationBits
  Smallest = 3   ///< the smaller of lossless and bounded, block by block; see RoundsFaces
};

struct EdgeIndexSettings
{
  EdgeIndexMode Mode = EdgeIndexMode::Lossless;
  EdgeIndexProfile Profile = EdgeIndexProfile::Small;

  /// Bounded and Smallest: the maximum shift of a point along its edge, in lengths of the edge,
  /// including the rounding of its structured coordinate to float. Above 0, at most 0.5.
  double MaximumError = 0.01;

  /// Quantized: values are rounded to 2^bits (2 to 24) levels from minimum to maximum; Quantizer.h.
  int QuantizationBits = 12;
  double QuantizationMinimum = 0;
  double QuantizationMaximum = 255;
  /// That of the samples, NaN without any; some above the minimum if they are all the same.
  void SetQuantizationRange(double minimum, double maximum)
  {
    const bool areThere = minimum <= maximum;
    this->QuantizationMinimum = areThere ? minimum : 0;
    this->QuantizationMaximum = minimum < maximum
      ? maximum
      : this->QuantizationMinimum + std::max(1.0, std::abs(this->QuantizationMinimum));
  }

  /// For values of a type.
  Quantizer MakeQuantizer(ValueType type, double isovalue) const
  {
    return { this->QuantizationMinimum, this->QuantizationMaximum, this->QuantizationBits, isovalue,
      IsFloatingType(type) };
  }
};

/// An array on the points of the surface.
struct EdgeIndexAttribute
{
  std::string Name;
  /// The type of the points' values, Float32 or Float64; see GetInterpolatedType.
  ValueType Type = ValueType::Float32;
  int NumberOfComponents = 1; ///< 1 to 64
  /// The maximum change of a component; 0 keeps every bit.
  double MaximumError = 0;
  /// These are the normals of the surface: three float32.
  bool IsNormals = false;
  /// How the encoder computes normals, as in ContourRequest; not stored.
  bool NormalsRoundedOnce = false;
  bool NormalsByDirection = false;
};

/// What all blocks of an edge-index stream have in common; the first bytes of a stream or file.
/// Layout: EdgeIndexHeaderFormat.cxx and Documentation/formats/edge-index.md.
struct EdgeIndexHeader
{
  GridGeometry Geometry;
  ValueType Type = ValueType::UInt8; ///< of the samples that were contoured
  std::vector<double> Isovalues;
  EdgeIndexSettings Settings;

  /// In mode Smallest: points on the faces of blocks lie in the middle of intervals, also where the
  /// values of a block are coded, so that a point has one place in all blocks that have it. Only files
  /// of version 1 do not do this.
  bool RoundsFaces = true;

  /// All sides of the grid, if the surface is closed there, else none; the preview is open. Blocks at these
  /// sides that are entirely within the body have records without points. Degenerate triangles are dropped then,
  /// and there are no attributes, which caps do not have.
  GridSides ClosedSides;

  /// Whether islands of the surface are left out: of blocks that have some, records tell which of their parts are
  /// kept. A closed surface is lossless then, since degenerate triangles depend on the places of points.
  bool LacksIslands = false;
  /// Of an encoder, and not stored: the global ids of all points of this rank's blocks that are kept, ascending,
  /// and those of the preview. Null: all.
  std::shared_ptr<const std::vector<std::int64_t>> KeptIds;
  std::shared_ptr<const std::vector<std::int64_t>> KeptIdsOfPreview;

  // For information.
  std::string Array;          ///< the name of the samples that were contoured
  std::string Source;         ///< where they came from, in the writer's words
  std::optional<double> Time; ///< of the samples, if they belong to a time step

  std::vector<EdgeIndexAttribute> Attributes;

  /// Blocks that the writer visits; each has at most one record for each isovalue. 0: unknown.
  std::uint64_t NumberOfBlocks = 0;

  /// If not 0 (at most 6), the stream also has a preview: the surface of every 2^PreviewLevel-th
  /// vertex, bounded by PreviewMaximumError in edges of that coarse grid.
  /// Blocks that do not begin at such a vertex are missing from it.
  int PreviewLevel = 0;
  double PreviewMaximumError = 0.05;

  /// InvalidArgument, with the reason, for what cannot be encoded.
  Status Check() const;

  /// Mode Smallest becomes Lossless if no intervals are as fine as MaximumError: all blocks would be.
  void TakeLosslessIfBoundIsTooFine();

  void Append(std::vector<std::uint8_t>& bytes) const;

  /// Reads the header at the start of `bytes`; `used` becomes its size. Errors: Corrupt,
  /// Unsupported (a newer version).
  static Result<EdgeIndexHeader> Parse(
    const std::uint8_t* bytes, std::size_t size, std::size_t& used);

  /// Bounds of a header's size in bytes.
  static constexpr std::size_t MinimumSize = 264;
  static constexpr std::size_t MaximumSize = std::size_t{ 64 } << 20;

  /// Whether the 8 bytes are the magic number of a header.
  static bool HasMagic(const std::uint8_t* bytes);

  /// The size of a header, given its first MinimumSize bytes. Errors: Corrupt, Unsupported.
  static Result<std::size_t> ParseSize(const std::uint8_t* bytes);

  /// The header of a stream that consists of the preview alone.
  EdgeIndexHeader MakePreview() const;

  /// The intervals of an edge in bounded mode; none if MaximumError is too small for float
  /// coordinates on this grid, or above half an edge, as it may be in other modes.
  CrossingIntervals GetIntervals() const;

  /// The type of decoded samples: Type, or Float32 if quantized.
  ValueType GetDecodedType() const;
};

} // namespace isosurface

#endif
