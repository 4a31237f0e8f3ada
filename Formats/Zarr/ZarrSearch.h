// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_ZarrSearch_h
#define isosurface_ZarrSearch_h

#include "Formats/Zarr/ZarrMetadata.h"

#include <nlohmann/json.hpp>

#include <cstddef>
#include <string>
#include <vector>

namespace isosurface
{

constexpr int MaximumZarrDepth = 8;
constexpr std::size_t MaximumZarrArrays = 10000;

/// An array in a hierarchy.
struct FoundArray
{
  std::string Path; ///< below the folder
  ZarrMetadata Metadata;
  Status Fault; ///< why it cannot be read
  std::size_t Levels =
    0; ///< of the multiscales of OME-Zarr, of which Metadata are the finest one's

  bool IsImage() const { return this->Levels > 0; }
};

/// The last name of a path.
std::string GetLastPart(const std::string& path);
/// What OME-Zarr says of a folder: since 0.5 in a member of its own.
const nlohmann::json& FindOme(const ZarrNode& node);
/// The first image of multiscales; null if there is none.
const nlohmann::json& FindImage(const nlohmann::json& ome);
/// The path of a level, the finest one first; empty if there is none.
std::string GetLevelPath(const nlohmann::json& datasets, std::size_t level);
/// The paths in a list, or in a member of its objects, without those that lead out of the folder.
std::vector<std::string> ListPaths(const nlohmann::json& list, const char* member = nullptr);
/// "a, b, c": the first hundred.
std::string JoinTexts(const std::vector<std::string>& texts);

/// Adds the arrays in a folder, by name, and the images that they are of.
Status FindArrays(FileSystem& files, const std::string& folder, const std::string& path, int depth,
  std::vector<FoundArray>& arrays);
/// Takes the levels s1, s2 ... away that stand beside an s0.
void DropLevels(std::vector<FoundArray>& arrays);

} // namespace isosurface

#endif
