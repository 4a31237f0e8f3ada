// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/Source/BinaryHeader.h"

#include "Formats/Source/GzipFile.h"

#include <utility>

namespace isosurface
{

Result<BinaryHeader> BinaryHeader::Open(
  FileSystem& files, const std::string& path, std::size_t size)
{
  ISOSURFACE_ASSIGN_OR_RETURN(auto file, files.OpenForReading(path));
  BinaryHeader header;
  header.Path = path;
  header.Bytes.resize(size);
  if (file->GetSize() >= 2)
  {
    std::array<std::uint8_t, 2> magic{};
    ISOSURFACE_RETURN_IF_ERROR(file->Read(0, magic.size(), magic.data()));
    header.Gzip = magic == std::array<std::uint8_t, 2>{ 0x1f, 0x8b };
  }
  if (header.Gzip)
  {
    // One byte more: the checksum at the end of the stream is of no use here.
    const GzipFile inflated(std::move(file), 0, size + 1);
    ISOSURFACE_RETURN_IF_ERROR(inflated.Read(0, size, header.Bytes.data()));
    return header;
  }
  if (file->GetSize() < size)
  {
    return header.MakeError(StatusCode::Corrupt,
      "truncated: it has " + std::to_string(file->GetSize()) + " bytes, fewer than its header");
  }
  ISOSURFACE_RETURN_IF_ERROR(file->Read(0, size, header.Bytes.data()));
  return header;
}

} // namespace isosurface
