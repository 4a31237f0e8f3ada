// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/Source/FileNames.h"

#include "Formats/Source/TextFields.h"

#include <filesystem>
#include <utility>

namespace isosurface
{

std::string FindExtension(const std::string& path)
{
  const std::size_t end = path.find_last_not_of('/');
  const std::filesystem::path file(path.substr(0, end == std::string::npos ? 0 : end + 1));
  const std::string extension = LowerText(file.extension().string());
  return extension == ".gz" ? LowerText(file.stem().extension().string()) + extension : extension;
}

bool IsNamePattern(const std::string& path)
{
  return std::filesystem::path(path).filename().string().find_first_of("*?") != std::string::npos;
}

std::vector<std::string> ListNames(FileSystem& files, const std::string& folder)
{
  auto names = files.List(folder);
  return names.IsOk() ? std::move(*names) : std::vector<std::string>();
}

} // namespace isosurface
