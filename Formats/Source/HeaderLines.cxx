// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/Source/HeaderLines.h"

#include <algorithm>
#include <filesystem>

namespace isosurface
{
namespace
{

constexpr std::uint64_t MaximumHeaderSize = std::uint64_t{ 1 } << 20;

} // namespace

Result<HeaderLines> HeaderLines::Open(FileSystem& files, const std::string& path)
{
  ISOSURFACE_ASSIGN_OR_RETURN(const auto file, files.OpenForReading(path));
  HeaderLines header;
  header.Path = path;
  header.Text.resize(static_cast<std::size_t>(std::min(file->GetSize(), MaximumHeaderSize)));
  ISOSURFACE_RETURN_IF_ERROR(file->Read(0, header.Text.size(), header.Text.data()));
  return header;
}

std::optional<std::string> HeaderLines::TakeLine()
{
  const std::size_t end = this->Text.find('\n', this->Position);
  if (this->Position >= this->Text.size())
  {
    return std::nullopt;
  }
  const std::size_t next = end == std::string::npos ? this->Text.size() : end + 1;
  std::string line = this->Text.substr(this->Position, end - this->Position);
  if (!line.empty() && line.back() == '\r')
  {
    line.pop_back();
  }
  this->Position = next;
  return line;
}

std::string HeaderLines::ResolvePath(const std::string& name) const
{
  return (std::filesystem::path(this->Path).parent_path() / name).string();
}

} // namespace isosurface
