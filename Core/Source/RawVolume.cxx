// SPDX-License-Identifier: BSD-3-Clause
#include "Source/RawVolume.h"

#include "Source/GzipFile.h"
#include "Source/HeaderText.h"
#include "Source/MetaImageHeader.h"
#include "Source/NrrdHeader.h"
#include "Source/RawSource.h"
#include "Source/SeriesFile.h"

#include <filesystem>
#include <optional>
#include <utility>

namespace isosurface
{
namespace
{

/// The bytes of all samples; nothing if there are none, or more than any file has.
std::optional<std::uint64_t> CountBytes(const GridGeometry& grid, ValueType type)
{
  std::uint64_t bytes = GetValueSize(type);
  for (const std::int64_t size : grid.GetDimensions())
  {
    if (size < 1 || bytes > (std::uint64_t{ 1 } << 62) / static_cast<std::uint64_t>(size))
    {
      return std::nullopt;
    }
    bytes *= static_cast<std::uint64_t>(size);
  }
  return bytes;
}

} // namespace

Result<RawVolume> RawVolume::ReadHeader(FileSystem& files, const std::string& path)
{
  const std::string extension = HeaderText::Lower(std::filesystem::path(path).extension().string());
  if (extension == ".mhd" || extension == ".mha")
  {
    return ReadMetaImageHeader(files, path);
  }
  if (extension == ".nrrd" || extension == ".nhdr")
  {
    return ReadNrrdHeader(files, path);
  }
  return Status(StatusCode::Unsupported,
    path + ": cannot be read: only .mhd, .mha, .nrrd and .nhdr tell what they hold");
}

Result<std::unique_ptr<SlabSource>> RawVolume::Open(FileSystem& files) const
{
  const auto bytes = CountBytes(this->Grid, this->Type);
  if (this->Paths.empty() || !bytes)
  {
    return Status(StatusCode::InvalidArgument,
      (this->Paths.empty() ? std::string("a volume without files") : this->Paths.front()) +
        ": its dimensions are impossible");
  }
  const Index3 size = this->Grid.GetDimensions();
  const auto count = static_cast<std::uint64_t>(this->Paths.size());
  if (static_cast<std::uint64_t>(size[2]) % count != 0 || (count > 1 && this->IsGzip))
  {
    return Status(StatusCode::Unsupported,
      this->Paths.front() + ": " + std::to_string(count) + " files cannot hold equal parts of " +
        std::to_string(size[2]) + " slices" + (this->IsGzip ? " in one compressed stream" : ""));
  }
  auto file = files.OpenForReading(this->Paths.front());
  if (!file.IsOk())
  {
    return file.GetStatus();
  }
  const std::uint64_t available = (*file)->GetSize();
  std::unique_ptr<RandomAccessFile> samples = std::move(*file);
  std::uint64_t held = 0;
  if (this->IsGzip)
  {
    auto inflated =
      std::make_unique<GzipFile>(std::move(samples), this->Offset, this->Skip + *bytes);
    held = inflated->GetHeldBytes();
    return std::unique_ptr<SlabSource>(std::make_unique<RawSource>(
      std::move(inflated), this->Skip, size, this->Type, this->IsBigEndian, held));
  }
  const std::uint64_t ofFile = *bytes / count;
  std::uint64_t offset = this->Offset;
  if (this->EndsWithSamples && available >= ofFile)
  {
    offset = available - ofFile;
  }
  if (offset > available || available - offset < ofFile)
  {
    return Status(StatusCode::Corrupt,
      this->Paths.front() + ": truncated: it has " + std::to_string(available) + " bytes where " +
        std::to_string(offset) + " and " + std::to_string(ofFile) + " of samples are expected");
  }
  if (count > 1)
  {
    samples = std::make_unique<SeriesFile>(files, this->Paths, offset, ofFile);
    offset = 0;
  }
  return std::unique_ptr<SlabSource>(std::make_unique<RawSource>(
    std::move(samples), offset, size, this->Type, this->IsBigEndian, held));
}

} // namespace isosurface
