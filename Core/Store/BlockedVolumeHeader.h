// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_BlockedVolumeHeader_h
#define isosurface_BlockedVolumeHeader_h

#include "Base/Status.h"
#include "Partition/BlockDistribution.h"
#include "Store/BlockCompression.h"
#include "Volume/GridGeometry.h"
#include "Volume/ValueKey.h"
#include "Volume/ValueType.h"

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace isosurface
{

/// A named array of samples on the vertices of the grid.
struct ArrayDescription
{
  std::string Name;
  ValueType Type = ValueType::UInt8;
};

/// One store of one time step.
struct StoreDescription
{
  std::uint64_t Blocks = 0;   ///< number of blocks
  std::uint64_t Bytes = 0;    ///< size of its file of blocks
  std::uint64_t Checksum = 0; ///< of all its blocks' checksums, so that it identifies the contents
};

/// One time step: its own folder, its own distribution of blocks over the stores.
struct TimeStepDescription
{
  std::optional<double> Time;
  std::string Folder;           ///< the generation folder, six or more digits
  std::vector<KeyRange> Ranges; ///< per array: of its finite values; empty if it has none
  std::vector<StoreDescription> Stores;
};

// clang-format off
/**
 * What the file NAME.bvol says: everything about a blocked volume but its samples and indices.
 *
 * The file is one JSON object:
 *
 *   { "format": "ScalableIsosurface blocked volume", "formatVersion": 1,
 *     "grid": { "extent": [6 integers], "origin": [3], "spacing": [3],
 *               "direction": [9, row-major] },
 *     "blockSize": 16 | 32 | 64, "ghostLayers": 1, "numberOfLevels": log2(blockSize) + 1,
 *     "stores": D, "distribution": { "method": "greedy" | "random" | "slab" | "balanced",
 *                                    "seed": integer },
 *     "compression": "none" | "lz4" | "zstd", "compressionLevel": integer, if not "none",
 *     "arrays": [ { "name": string, "type": "uint8" | ..., "components": 1 }, ... ],
 *     "timeSteps": [ { "time": number | null, "folder": "000001",
 *                      "ranges": [ [minimum, maximum] | null, ... ],           per array
 *                      "stores": [ { "blocks": n, "bytes": n, "checksum": hex }, ... ] }, ... ],
 *     "checksum": hex, XXH3 of all bytes before this member's name; the last member }
 *
 * Members that are not known are ignored; a newer formatVersion is refused. Numbers round-trip
 * exactly, the values of 64-bit integer arrays included.
 */
// clang-format on
struct BlockedVolumeHeader
{
  static constexpr std::int64_t FormatVersion = 1;

  GridGeometry Grid;
  int BlockSize = 32;
  std::uint32_t NumberOfStores = 1;
  DistributionMethod Distribution = DistributionMethod::Greedy;
  std::uint64_t RandomSeed = 0;
  BlockCompression Compression; ///< what the writer was asked for; each segment says what it is
  std::vector<ArrayDescription> Arrays;
  std::vector<TimeStepDescription> TimeSteps;

  /// The index of an array, or nothing.
  std::optional<std::size_t> FindArray(const std::string& name) const;

  /// Whether the header can be written: a grid with vertices, distinct names, finite numbers, ...
  /// The message names the member that is wrong.
  Status Validate() const;
  /// The same for all but the time steps.
  Status ValidateVolume() const;

  /// The file's text.
  std::string Format() const;

  /// A header from a file's text, validated in full; `path` is named in errors (Corrupt,
  /// Unsupported).
  static Result<BlockedVolumeHeader> Parse(const std::string& text, const std::string& path);
};

/// The folder that holds the stores of all time steps of a blocked volume: path + ".stores".
std::string GetStoresFolder(const std::string& path);
/// The folder of one store: NAME.bvol.stores/000001/store-00000.
std::string GetStoreFolder(
  const std::string& path, const std::string& generation, std::uint32_t store);

} // namespace isosurface

#endif
