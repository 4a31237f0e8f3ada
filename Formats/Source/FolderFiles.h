// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_FolderFiles_h
#define isosurface_FolderFiles_h

#include "Ground/Base/FileSystem.h"

#include <cstddef>
#include <string>
#include <vector>

// What folders and patterns of names have: which files are meant, in which order, and which are not.

namespace isosurface
{

/// The extension of a file or folder in lower case, ".gz" together with the one before it.
std::string FindExtension(const std::string& path);
/// Whether the last part of the path has * or ?, which stand for characters.
bool IsNamePattern(const std::string& path);
/// The names in a folder; none if the path is no folder.
std::vector<std::string> ListNames(FileSystem& files, const std::string& folder);

/// Files that are passed over, and why.
class PassedOver
{
public:
  /// `reason` goes on from a number: "hidden", "of another kind".
  void Add(const std::string& reason, const std::string& path);
  /// "passed over: 7 hidden (._a.tif, ...), 1 of another kind (notes.txt)"; empty if there are none.
  std::string GetText() const;

private:
  struct Group
  {
    std::string Reason;
    std::size_t Count = 0;
    std::string First; ///< the name of a file
  };
  std::vector<Group> Groups;
};

/// Whether systems keep a file or folder of this name for themselves: ".DS_Store", "._a.tif", "Thumbs.db".
bool IsHiddenName(const std::string& name);

/// Whether a file has the magic of AppleSingle or AppleDouble, in which macOS keeps what another file
/// system has no place for. Source: RFC 1740.
bool IsAppleDouble(FileSystem& files, const std::string& path);

/// The folder of a file or pattern.
std::string FindFolder(const std::string& path);

/// Whether the path is a pattern: its last part has * or ?, and no file has that name.
bool IsPattern(FileSystem& files, const std::string& path);

/// The names in the folder of a pattern that fit it: "*" stands for any characters, "?" for one. Hidden
/// ones only if the pattern begins with a point; `over` gets the others, if there is one.
std::vector<std::string> FindFittingNames(
  FileSystem& files, const std::string& pattern, PassedOver* over);

/// A name cut into text, number, text, number, ...
struct NumberedName
{
  std::string Name;
  std::vector<std::string> Texts;
  std::vector<std::string> Numbers; ///< without leading zeros

  explicit NumberedName(std::string name);
  /// By the numbers: "slice9.tif" before "slice10.tif".
  bool operator<(const NumberedName& other) const;
};

} // namespace isosurface

#endif
