// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_ZarrMetadata_h
#define isosurface_ZarrMetadata_h

#include "Formats/Source/StoredArray.h"
#include "Formats/Zarr/ZarrCodec.h"
#include "Ground/Base/FileSystem.h"

#include <nlohmann/json.hpp>

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace isosurface
{

/// How the samples of a chunk become bytes.
struct ZarrEncoding
{
  std::vector<std::size_t> Order; ///< axes as they are stored, the slowest first
  bool IsBigEndian = false;
  std::vector<ZarrCodec> Codecs; ///< in the order of encoding
};

/// An array of Zarr 2, Zarr 3 or N5. All axes are counted from the slowest one; N5 counts from the
/// fastest.
struct ZarrMetadata
{
  StoredArray::Numbers Shape;
  StoredArray::Numbers Chunk; ///< samples that are decoded together
  StoredArray::Numbers Shard; ///< samples of a file; Chunk, if there are no shards
  bool HasShards = false;     ///< also if a shard has a single chunk: there is an index
  ValueType Type = ValueType::UInt8;
  bool IsHalf = false;                ///< float16, which Type float32 stands for
  std::array<std::uint8_t, 8> Fill{}; ///< a sample of Type, in the byte order of the machine
  ZarrEncoding Encoding;              ///< of a chunk
  std::vector<ZarrCodec> IndexCodecs; ///< of the index of a shard
  bool IsIndexBigEndian = false;
  bool IsIndexAtStart = false;
  bool IsN5 = false;
  std::string KeyPrefix;                   ///< of the names of files
  std::string Separator;                   ///< between the numbers of a name
  bool HasSeparator = true;                ///< whether the metadata say it; old Zarr 2 does not
  std::vector<std::string> DimensionNames; ///< empty if there are none
  std::string Storage;                     ///< for a list: chunks and codecs
};

/// A folder in a hierarchy of Zarr or N5.
// NOLINTNEXTLINE(bugprone-exception-escape): what JSON values may throw when moved are assertions.
struct ZarrNode
{
  bool IsArray = false;
  nlohmann::json Array;      ///< the metadata of an array
  nlohmann::json Attributes; ///< of the user; an object
  int Version = 0;           ///< 2 or 3; 5 for N5; 0 if the folder is none

  /// Reads the JSON files of a folder. Errors: Corrupt, which names the file. `around`: the version of the group
  /// that it is in, if that is known: of an address, files of others are not asked for.
  static Result<ZarrNode> Read(FileSystem& files, const std::string& folder, int around = 0);
};

/**
 * Sees to it that the chunks of an array are found: where the metadata do not say how the numbers of
 * their names are separated, the chunks that are there do. Tells in `told` if there are none, which may
 * be meant, as all samples have the fill value then. Cost: a look for the first chunk, if it is there.
 */
void FindChunks(
  FileSystem& files, const std::string& folder, ZarrMetadata& metadata, std::string& told);

/// The metadata of an array. Errors name the folder: Unsupported for types, codecs, filters and
/// chunk grids that are not read, by name; Corrupt.
Result<ZarrMetadata> ParseZarrMetadata(const ZarrNode& node, const std::string& folder);

} // namespace isosurface

#endif
