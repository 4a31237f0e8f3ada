// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/Tiff/TiffFiles.h"

#include <algorithm>
#include <filesystem>
#include <iterator>

namespace isosurface
{

std::string TiffFiles::FindPath(const std::string& name) const
{
  return name.empty() ? this->Own
                      : (std::filesystem::path(this->Own).parent_path() / name).string();
}

Result<TiffFiles::ReadFile*> TiffFiles::Open(const std::string& path)
{
  auto found = this->Read.find(path);
  if (found == this->Read.end())
  {
    ISOSURFACE_ASSIGN_OR_RETURN(auto file, TiffFile::Open(this->Files, path));
    ISOSURFACE_ASSIGN_OR_RETURN(auto contents, file->FindPages());
    constexpr std::size_t most = 256;
    for (auto at = this->Read.begin(); this->Read.size() >= most && at != this->Read.end();)
    {
      at = at->first == this->Own ? std::next(at) : this->Read.erase(at);
    }
    found = this->Read.emplace(path, ReadFile{ std::move(file), std::move(contents) }).first;
  }
  return &found->second;
}

Status TiffFiles::CheckStack(ReadFile& read)
{
  std::vector<TiffPage>& pages = read.Contents.Pages;
  const int format = pages.front().Format;
  pages.erase(
    std::remove_if(pages.begin(), pages.end(),
      [format](const TiffPage& page) { return page.IsOfAnother && page.Format != format; }),
    pages.end());
  for (const TiffPage& page : pages)
  {
    if (page.Format != format)
    {
      const Status status = page.Format < 0 ? read.File->TakeFormat(page) : Status::Ok();
      return !status.IsOk() ? status
                            : read.File->MakeErrorOf(page, StatusCode::Unsupported,
                                "its size or type differs from that of the pages before");
    }
  }
  return read.Contents.PageNumbers;
}

} // namespace isosurface
