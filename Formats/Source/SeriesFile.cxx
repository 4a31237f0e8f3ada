// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/Source/SeriesFile.h"

#include <algorithm>
#include <utility>

namespace isosurface
{

SeriesFile::SeriesFile(Opener open, std::vector<std::string> paths, std::uint64_t size)
  : Open(std::move(open))
  , Paths(std::move(paths))
  , Size(size)
{
}

Status SeriesFile::Read(std::uint64_t offset, std::size_t size, void* bytes) const
{
  auto* to = static_cast<std::uint8_t*>(bytes);
  while (size > 0)
  {
    const auto number = static_cast<std::size_t>(offset / this->Size);
    const std::uint64_t within = offset % this->Size;
    if (number >= this->Paths.size())
    {
      return Status(
        StatusCode::Corrupt, this->Paths.back() + ": truncated: the series of files ends here");
    }
    if (!this->OpenFile || this->OpenNumber != number)
    {
      ISOSURFACE_ASSIGN_OR_RETURN(this->OpenFile, this->Open(this->Paths[number]));
      this->OpenNumber = number;
    }
    const auto count = static_cast<std::size_t>(std::min<std::uint64_t>(size, this->Size - within));
    ISOSURFACE_RETURN_IF_ERROR(this->OpenFile->Read(within, count, to));
    to += count;
    offset += count;
    size -= count;
  }
  return Status::Ok();
}

} // namespace isosurface
