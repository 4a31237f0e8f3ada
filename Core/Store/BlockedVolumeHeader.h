// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_BlockedVolumeHeader_h
#define isosurface_BlockedVolumeHeader_h

#include "Base/FileSystem.h"
#include "Base/Status.h"
#include "Partition/BlockDistribution.h"
#include "Record/BlockCompression.h"
#include "Volume/ArrayVariables.h"
#include "Volume/BlockGrid.h"
#include "Volume/GridGeometry.h"
#include "Volume/ValueKey.h"
#include "Volume/ValueType.h"

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace isosurface
{

/// One store of one time step.
struct StoreDescription
{
  std::uint64_t Blocks = 0;   ///< number of blocks
  std::uint64_t Bytes = 0;    ///< size of its file of blocks
  std::uint64_t Checksum = 0; ///< of all its blocks' checksums, so that it identifies the contents
};

/// A coarser copy of the volume, which holds the levels that follow those of the volume before it.
struct OverviewDescription
{
  int NumberOfLevels = 0; ///< that the records of its blocks hold
  std::uint32_t NumberOfStores = 1;
};

/// One time step: its own folder, its own distribution of blocks over the stores.
struct TimeStepDescription
{
  std::optional<double> Time;
  std::string Folder;           ///< the generation folder, six or more digits
  std::vector<KeyRange> Ranges; ///< per variable: of its finite values; empty if it has none
  std::vector<StoreDescription> Stores;
  std::vector<std::vector<StoreDescription>> Overviews; ///< per overview: its stores
};

// clang-format off
/**
 * What the file NAME.bvol says: everything about a blocked volume but its samples and indices.
 *
 * The file is one JSON object:
 *
 *   { "format": "ScalableIsosurface blocked volume", "formatVersion": 1 | 2,
 *     "grid": { "extent": [6 integers], "origin": [3], "spacing": [3],
 *               "direction": [9, row-major] },
 *     "blockSize": 16 | 32 | 64, "ghostLayers": 1,
 *     "numberOfLevels": 1 ... log2(blockSize) + 1; just this in version 1,
 *     "overviews": [ { "numberOfLevels": as above, "stores": D }, ... ],       since version 2
 *     "stores": D, "distribution": { "method": "greedy" | "random" | "slab" | "balanced",
 *                                    "seed": integer },
 *     "compression": "none" | "lz4" | "zstd", "compressionLevel": integer, if not "none",
 *     "arrays": [ { "name": string, "type": "uint8" | ..., "components": n }, ... ],
 *     "timeSteps": [ { "time": number | null, "folder": "000001",
 *                      "ranges": [ [minimum, maximum] | null, ... ],           per variable
 *                      "stores": [ { "blocks": n, "bytes": n, "checksum": hex }, ... ],
 *                      "overviews": [ { "stores": as above }, ... ] }, ... ],  since version 2
 *     "checksum": hex, XXH3 of all bytes before this member's name; the last member }
 *
 * Members that are not known are ignored; a newer formatVersion is refused. A header gets the
 * lowest version that can say what it says. Numbers round-trip exactly, the values of 64-bit integer
 * arrays included.
 *
 * Overviews. The records of the volume's blocks hold its levels 0 ... numberOfLevels - 1. The first
 * overview's level 0 is the next level, and so on: overview n is a blocked volume of its own, made
 * of the volume before it subsampled by 2^(numberOfLevels of that). Its grid follows from there.
 */
// clang-format on
struct BlockedVolumeHeader
{
  static constexpr std::int64_t FormatVersion = 2;
  static constexpr std::uint64_t MaximumSize = std::uint64_t{ 1 } << 30;

  GridGeometry Grid;
  int BlockSize = 32;
  int NumberOfLevels = 0; ///< that the records hold; 0: as many as a block can have
  std::uint32_t NumberOfStores = 1;
  DistributionMethod Distribution = DistributionMethod::Greedy;
  std::uint64_t RandomSeed = 0;
  BlockCompression Compression; ///< what the writer was asked for; each segment says what it is
  std::vector<ArrayDescription> Arrays;
  std::vector<OverviewDescription> Overviews; ///< from the finest to the coarsest
  std::vector<TimeStepDescription> TimeSteps;

  /// The index of an array, or nothing.
  std::optional<std::size_t> FindArray(const std::string& name) const;

  /// Whether a time step has this folder.
  bool HasFolder(const std::string& folder) const;

  /// What can be contoured.
  ArrayVariables GetVariables() const { return ArrayVariables(this->Arrays); }

  /// The blocks of the volume, with the levels that their records hold.
  BlockGrid GetBlockGrid() const;

  /// An overview (from 0) as a volume of its own: what its stores need to be read. The folders of
  /// its time steps lead into it; it has no overviews.
  BlockedVolumeHeader MakeOverview(std::size_t overview) const;

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
  /// The same for a file of at most MaximumSize bytes.
  static Result<BlockedVolumeHeader> Read(FileSystem& files, const std::string& path);
};

/// The folder that holds the stores of all time steps of a blocked volume: path + ".stores".
std::string GetStoresFolder(const std::string& path);
/// The folder of an overview (from 0) in a time step's folder: 000001/overview-1.
std::string GetOverviewFolder(const std::string& generation, std::size_t overview);
/// The folder of one store: NAME.bvol.stores/000001/store-00000.
std::string GetStoreFolder(
  const std::string& path, const std::string& generation, std::uint32_t store);

} // namespace isosurface

#endif
