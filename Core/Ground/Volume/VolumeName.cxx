// SPDX-License-Identifier: BSD-3-Clause
#include "Ground/Volume/VolumeName.h"

namespace isosurface
{
namespace
{

bool IsThere(FileSystem& files, const std::string& path)
{
  const auto names = files.List(path);
  return files.Exists(path) || (names.IsOk() && !names->empty());
}

/// Whether the last part of the path has * or ?, which stand for characters, in a folder that is there.
bool IsPatternThere(FileSystem& files, const std::string& path)
{
  const std::size_t slash = path.rfind('/');
  const std::size_t last = slash == std::string::npos ? 0 : slash + 1;
  return path.find_first_of("*?", last) != std::string::npos &&
    IsThere(files, last == 0 ? "." : path.substr(0, last));
}

} // namespace

VolumeName VolumeName::Parse(FileSystem& files, const std::string& text)
{
  std::size_t colon = text.rfind(':');
  if (IsAddress(text))
  {
    const std::size_t host = text.find("://") + 3;
    VolumeName name = colon < text.find('/', host) || colon < host || colon == std::string::npos
      ? VolumeName{ text, "" }
      : VolumeName{ text.substr(0, colon), text.substr(colon + 1) };
    // A slash at the end would be a part of a key of S3.
    name.Path.erase(name.Path.find_last_not_of('/') + 1);
    return name;
  }
  if (colon == std::string::npos || IsThere(files, text))
  {
    return { text, "" };
  }
  for (; colon != std::string::npos && colon > 0; colon = text.rfind(':', colon - 1))
  {
    const std::string path = text.substr(0, colon);
    if (IsThere(files, path) || IsPatternThere(files, path))
    {
      return { path, text.substr(colon + 1) };
    }
  }
  return { text, "" };
}

} // namespace isosurface
