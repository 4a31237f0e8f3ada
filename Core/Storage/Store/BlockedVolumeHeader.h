// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_BlockedVolumeHeader_h
#define isosurface_BlockedVolumeHeader_h

#include "Ground/Base/FileSystem.h"
#include "Ground/Base/Status.h"
#include "Ground/Volume/ArrayVariables.h"
#include "Ground/Volume/BlockGrid.h"
#include "Ground/Volume/GridGeometry.h"
#include "Ground/Volume/GridLines.h"
#include "Ground/Volume/ValueKey.h"
#include "Ground/Volume/ValueType.h"
#include "Storage/Distribution/BlockDistribution.h"
#include "Storage/Record/BlockCompression.h"
#include "Storage/Store/SourceRecord.h"

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
  std::uint64_t Checksum = 0; ///< of all its blocks' checksums; it identifies the contents
  /// Of its directory, then of the tree of each variable (PagedFile.h); none in volumes of early writers.
  std::vector<std::uint64_t> Seals = {};
};

/**
 * A coarser copy of the volume. The records of the volume's blocks hold its levels 0 to
 * numberOfLevels - 1; level 0 of the first overview is the next level, and so on. Each overview is
 * a blocked volume of its own, made of the one before it, subsampled by 2^(the levels of that).
 */
struct OverviewDescription
{
  int NumberOfLevels = 0; ///< in the records of its blocks
  std::uint32_t NumberOfStores = 1;
};

/// One time step. It has a folder and a distribution of blocks over stores of its own.
struct TimeStepDescription
{
  std::optional<double> Time;
  std::string Folder;           ///< six or more digits
  std::vector<KeyRange> Ranges; ///< per variable: range of its finite values, or empty
  std::vector<StoreDescription> Stores;
  std::vector<std::vector<StoreDescription>> Overviews; ///< per overview: its stores
  std::optional<SourceRecord> Source; ///< of the samples at level 0, if the stores have none
  std::optional<SourceRecord> CopyOf; ///< what the samples were copied from, if that is recorded
};

// clang-format off
/**
 * The contents of the file NAME.bvol: everything about a blocked volume but its samples and
 * indices. Documentation/formats/blocked-volume.md defines each member.
 *
 *   { "format": "ScalableIsosurface blocked volume", "formatVersion": 1,
 *     "grid": { "extent": [6], "origin": [3], "spacing": [3], "direction": [9],
 *               "unit": string, if it is known,
 *               "coordinates": [ [x, ...], [y, ...], [z, ...] ], of a rectilinear grid alone },
 *     "blockSize": 16 | 32 | 64, "ghostLayers": 1, "numberOfLevels": L, "stores": D,
 *     "replicas": R, if it is above 1,
 *     "overviews": [ { "numberOfLevels": L, "stores": D }, ... ],
 *     "distribution": { "method": string, "seed": integer },
 *     "compression": "none" | "lz4" | "zstd", "compressionLevel": integer, unless "none",
 *     "arrays": [ { "name": string, "type": "uint8" | ..., "components": n,
 *                   "unit": string, if it is known }, ... ],
 *     "timeSteps": [ { "time": number | null, "folder": "000001",
 *                      "ranges": [ [minimum, maximum] | null, ... ],            per variable
 *                      "stores": [ { "blocks": n, "bytes": n, "checksum": hex,
 *                                    "seals": hex of directory and trees }, ... ],
 *                      "overviews": [ { "stores": as above }, ... ],
 *                      "source": { ... },                        in place alone (SourceRecord.h)
 *                      "copyOf": { ... } }, ... ],               of copies of streams (SourceIndex.h)
 *     "checksum": hex }
 */
// clang-format on
struct BlockedVolumeHeader
{
  static constexpr std::int64_t FormatVersion = 1;
  static constexpr std::uint64_t MaximumSize = std::uint64_t{ 1 } << 28;
  static constexpr std::int64_t MaximumStores = 1 << 20;
  /// The number of stores that every volume may have, even with fewer blocks.
  static constexpr std::int64_t StoresOfAnyVolume = 4096;
  static constexpr std::uint32_t MaximumReplicas = 16;
  static constexpr std::int64_t MaximumCoordinate = std::int64_t{ 1 } << 40;

  /// Of a rectilinear grid the regular one of the same extent in the same box (FrameGrid).
  GridGeometry Grid;
  std::optional<GridLines> Lines; ///< of a rectilinear grid
  int BlockSize = 32;
  int NumberOfLevels = 0; ///< in the records; 0: as many as a block can have
  std::uint32_t NumberOfStores = 1;
  /// The number of stores that have each block: replica r of store d is in the folder of store
  /// (d + r) mod NumberOfStores. Replica 0 is the store itself.
  std::uint32_t NumberOfReplicas = 1;
  DistributionMethod Distribution = DistributionMethod::Greedy;
  std::uint64_t RandomSeed = 0;
  BlockCompression Compression; ///< the writer's setting; each segment states its own coding
  std::vector<ArrayDescription> Arrays;
  std::vector<OverviewDescription> Overviews; ///< from the finest to the coarsest
  std::vector<TimeStepDescription> TimeSteps;

  /// The index of an array, or nothing.
  std::optional<std::size_t> FindArray(const std::string& name) const;

  /// Whether a time step has this folder.
  bool HasFolder(const std::string& folder) const;

  /// Whether the samples at level 0 stay in the files that the volume was made of. Then the stores
  /// have the headers of segments alone, and the volume's own blocks have that level alone.
  bool IsInPlace() const { return !this->TimeSteps.empty() && this->TimeSteps.back().Source; }

  /// The components and magnitudes that can be contoured.
  ArrayVariables GetVariables() const { return ArrayVariables(this->Arrays); }

  /// Makes the grid that of the box of the lines. Lines that have a fault are left to Validate().
  void FrameGrid();

  /// The blocks of the volume, with the levels that their records hold.
  BlockGrid GetBlockGrid() const;

  /// The maximum of NumberOfStores: MaximumStores, and either one for each block or
  /// StoresOfAnyVolume. Each costs files and memory, so that a small volume in many stores is a
  /// mistake, or meant to do harm.
  static std::int64_t GetStoreLimit(const GridGeometry& grid, int blockSize);

  /// The header of an overview (from 0) as a volume of its own. The folders of its time steps are
  /// those of the overview; it has no overviews itself.
  BlockedVolumeHeader MakeOverview(std::size_t overview) const;

  /// Checks all rules of the format. The message of an error names the wrong member.
  Status Validate() const;
  /// The same without time steps and overviews.
  Status ValidateVolume() const;

  /// The file's text.
  std::string Format() const;

  /// Parses and validates a file's text. Errors name `path`: Corrupt, Unsupported.
  static Result<BlockedVolumeHeader> Parse(const std::string& text, const std::string& path);
  /// The text of a file of at most MaximumSize bytes.
  static Result<std::string> ReadText(FileSystem& files, const std::string& path);
  /// Reads, parses and validates a file.
  static Result<BlockedVolumeHeader> Read(FileSystem& files, const std::string& path);
};

/// The folder that holds the stores of all time steps of a blocked volume: .NAME.bvol.stores, which file
/// dialogs hide; NAME.bvol.stores if there is one, as of all volumes of version 1.0.0.
std::string GetStoresFolder(FileSystem& files, const std::string& path);
/// The folder of an overview (from 0) in a time step's folder: 000001/overview-1.
std::string GetOverviewFolder(const std::string& generation, std::size_t overview);
/// The folder of one store: .NAME.bvol.stores/000001/store-00000; generation: that of the time step.
std::string GetStoreFolder(
  FileSystem& files, const std::string& path, const std::string& generation, std::uint32_t store);
/// The store whose folder has a replica of a store.
inline std::uint32_t FindHost(std::uint32_t store, std::uint32_t replica, std::uint32_t stores)
{
  return static_cast<std::uint32_t>((std::uint64_t{ store } + replica) % stores);
}
/// The folder of a replica of a store: that of the store for replica 0, else replica-1 ... in the
/// folder of FindHost().
std::string GetReplicaFolder(FileSystem& files, const std::string& path,
  const std::string& generation, std::uint32_t store, std::uint32_t replica, std::uint32_t stores);

} // namespace isosurface

#endif
