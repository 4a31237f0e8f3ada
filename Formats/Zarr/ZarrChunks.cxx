// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/Source/AxisUnits.h"
#include "Formats/Source/FolderFiles.h"
#include "Formats/Zarr/ZarrMetadata.h"
#include "Formats/Zarr/ZarrVolume.h"

#include <algorithm>
#include <cstddef>

namespace isosurface
{
namespace
{

bool IsNumber(const std::string& text)
{
  return !text.empty() && text.find_first_not_of("0123456789") == std::string::npos;
}

/// Whether a name is that of `rank` numbers with points between, behind a prefix.
bool IsChunkName(const std::string& name, const std::string& prefix, std::size_t rank)
{
  if (name.compare(0, prefix.size(), prefix) != 0)
  {
    return false;
  }
  std::size_t begin = prefix.size();
  for (std::size_t axis = 0; axis < rank; ++axis)
  {
    const std::size_t end = axis + 1 < rank ? name.find('.', begin) : name.size();
    if (end == std::string::npos || !IsNumber(name.substr(begin, end - begin)))
    {
      return false;
    }
    begin = end + 1;
  }
  return true;
}

/// Whether an array of some rank has a chunk whose numbers are separated in this way.
bool HasChunk(FileSystem& files, const std::string& folder, const std::string& separator,
  bool hasPrefix, std::size_t rank)
{
  if (separator == ".")
  {
    const auto names = ListNames(files, folder);
    return std::any_of(names.begin(), names.end(),
      [&](const std::string& name) { return IsChunkName(name, hasPrefix ? "c." : "", rank); });
  }
  std::string path = folder + (hasPrefix ? "/c" : "");
  for (std::size_t axis = 0; axis < rank; ++axis)
  {
    const auto names = ListNames(files, path);
    const auto number = std::find_if(names.begin(), names.end(), IsNumber);
    if (number == names.end())
    {
      return false;
    }
    path += "/" + *number;
  }
  return files.Exists(path);
}

/// "0.0.0", "c/0/0/0": the name of the first chunk.
std::string MakeFirstName(const std::string& separator, bool hasPrefix, std::size_t rank)
{
  std::string name = hasPrefix ? "c" + separator : std::string();
  for (std::size_t axis = 0; axis < rank; ++axis)
  {
    name += (axis == 0 ? "" : separator) + "0";
  }
  return name;
}

} // namespace

void FindChunks(
  FileSystem& files, const std::string& folder, ZarrMetadata& metadata, std::string& told)
{
  const std::size_t rank = metadata.Shape.size();
  const bool hasPrefix = !metadata.KeyPrefix.empty();
  const std::string first = MakeFirstName(metadata.Separator, hasPrefix, rank);
  if (IsAddress(folder))
  {
    // Nobody lists the chunks, and the first one may be missing as any other.
    const std::string otherwise = metadata.Separator == "." ? "/" : ".";
    const bool isOther = !metadata.HasSeparator && rank > 1 &&
      !files.Exists(folder + "/" + first) &&
      files.Exists(folder + "/" + MakeFirstName(otherwise, hasPrefix, rank));
    metadata.Separator = isOther ? otherwise : metadata.Separator;
    return;
  }
  if (files.Exists(folder + "/" + first) ||
    HasChunk(files, folder, metadata.Separator, hasPrefix, rank))
  {
    return;
  }
  const std::string other = metadata.Separator == "." ? "/" : ".";
  const bool hasOther = rank > 1 && HasChunk(files, folder, other, hasPrefix, rank);
  if (hasOther && !metadata.HasSeparator)
  {
    metadata.Separator = other;
    return;
  }
  AddNote(told,
    "it has no chunk of a name as " + first + ", so all samples have the fill value" +
      (hasOther ? "; there are names as " + MakeFirstName(other, hasPrefix, rank) : std::string()));
}

} // namespace isosurface
