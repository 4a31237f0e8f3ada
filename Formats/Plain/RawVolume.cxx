// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/Plain/RawVolume.h"

#include "Formats/Plain/MetaImageHeader.h"
#include "Formats/Plain/NrrdHeader.h"
#include "Formats/Source/AxisUnits.h"
#include "Formats/Source/FileNames.h"
#include "Formats/Source/GzipFile.h"
#include "Formats/Source/RawSource.h"
#include "Formats/Source/SectionFile.h"
#include "Formats/Source/SeriesFile.h"

#include <algorithm>
#include <utility>

namespace isosurface
{
namespace
{

/// The offset after `lines` lines of text that begin at `begin`.
Result<std::uint64_t> SkipLines(
  const RandomAccessFile& file, std::uint64_t begin, std::uint64_t lines)
{
  std::vector<char> text(std::size_t{ 1 } << 16);
  std::uint64_t position = begin;
  while (lines > 0)
  {
    const std::uint64_t left = position < file.GetSize() ? file.GetSize() - position : 0;
    const auto size = static_cast<std::size_t>(std::min<std::uint64_t>(text.size(), left));
    if (size == 0)
    {
      return Status(StatusCode::Corrupt,
        file.GetPath() + ": truncated: " + std::to_string(lines) +
          " more lines are expected before the samples");
    }
    ISOSURFACE_RETURN_IF_ERROR(file.Read(position, size, text.data()));
    std::size_t at = 0;
    for (; at < size && lines > 0; ++at)
    {
      lines -= text[at] == '\n' ? 1 : 0;
    }
    position += at;
  }
  return position;
}

} // namespace

std::optional<std::uint64_t> RawVolume::CountBytes() const
{
  std::uint64_t bytes = GetValueSize(this->Type);
  for (const std::int64_t size : this->Grid.GetDimensions())
  {
    if (size < 1 || bytes > (std::uint64_t{ 1 } << 62) / static_cast<std::uint64_t>(size))
    {
      return std::nullopt;
    }
    bytes *= static_cast<std::uint64_t>(size);
  }
  return bytes;
}

Result<RawVolume> RawVolume::ReadHeader(FileSystem& files, const std::string& path)
{
  const std::string extension = FindExtension(path);
  if (extension == ".mhd" || extension == ".mha")
  {
    return ReadMetaImageHeader(files, path);
  }
  if (extension == ".nrrd" || extension == ".nhdr")
  {
    return ReadNrrdHeader(files, path);
  }
  return Status(StatusCode::Unsupported,
    path + ": cannot be read: the supported headers are .mhd, .mha, .nrrd and .nhdr");
}

Result<std::unique_ptr<RandomAccessFile>> RawVolume::OpenPart(
  FileSystem& files, const std::string& path, std::uint64_t bytes) const
{
  ISOSURFACE_ASSIGN_OR_RETURN(auto file, files.OpenForReading(path));
  ISOSURFACE_ASSIGN_OR_RETURN(const auto behindLines, SkipLines(*file, this->Offset, this->Lines));
  if (this->IsGzip)
  {
    // Reading shows whether the stream has so many bytes.
    auto inflated =
      std::make_unique<GzipFile>(std::move(file), behindLines, this->Skip + bytes, this->IsWhole);
    return std::unique_ptr<RandomAccessFile>(
      std::make_unique<SectionFile>(std::move(inflated), this->Skip, bytes));
  }
  std::uint64_t begin = behindLines + this->Skip;
  const std::uint64_t available = file->GetSize();
  if (this->EndsWithSamples && available >= bytes)
  {
    begin = available - bytes;
  }
  if (begin > available || available - begin < bytes)
  {
    return Status(StatusCode::Corrupt,
      path + ": truncated: it has " + std::to_string(available) + " bytes, but its samples are " +
        std::to_string(bytes) + " bytes from byte " + std::to_string(begin) + " on");
  }
  if (this->IsWhole && available - begin > bytes)
  {
    return Status(StatusCode::Corrupt,
      path + ": it has " + std::to_string(available - begin - bytes) +
        " bytes more than the samples that its header tells: their size, type or place is another");
  }
  return std::unique_ptr<RandomAccessFile>(
    std::make_unique<SectionFile>(std::move(file), begin, bytes));
}

std::string RawVolume::DescribeSurplus(FileSystem& files, std::uint64_t known) const
{
  const auto file = files.OpenForReading(this->Paths.front());
  const auto bytes = this->CountBytes();
  if (this->IsGzip || this->EndsWithSamples || this->Lines > 0 || !file.IsOk() || !bytes)
  {
    return {};
  }
  const std::uint64_t end = this->Offset + this->Skip + *bytes / this->Paths.size() + known;
  const std::uint64_t size = (*file)->GetSize();
  return size <= end ? std::string()
                     : std::to_string(size - end) + " bytes behind the samples are not read";
}

Result<std::unique_ptr<BoxSource>> RawVolume::Open(FileSystem& files) const
{
  const auto bytes = this->CountBytes();
  if (this->Paths.empty() || !bytes || this->Skip > (std::uint64_t{ 1 } << 62))
  {
    return Status(StatusCode::InvalidArgument,
      (this->Paths.empty() ? std::string("a volume without files") : this->Paths.front()) +
        ": its dimensions are impossible");
  }
  const Index3 size = this->Grid.GetDimensions();
  const auto count = static_cast<std::uint64_t>(this->Paths.size());
  if (static_cast<std::uint64_t>(size[2]) % count != 0)
  {
    return Status(StatusCode::Unsupported,
      this->Paths.front() + ": " + std::to_string(count) + " files cannot hold equal parts of " +
        std::to_string(size[2]) + " slices");
  }
  const std::uint64_t ofFile = *bytes / count;
  auto samples = this->OpenPart(files, this->Paths.front(), ofFile);
  ISOSURFACE_RETURN_IF_ERROR(samples.GetStatus());
  if (count > 1)
  {
    const auto openPart = [&files, volume = *this, ofFile](const std::string& path)
    { return volume.OpenPart(files, path, ofFile); };
    *samples = std::make_unique<SeriesFile>(openPart, this->Paths, ofFile);
  }
  const std::uint64_t held = this->IsGzip ? GzipFile::GetHeldBytes(this->Skip + ofFile) : 0;
  return std::unique_ptr<BoxSource>(
    std::make_unique<RawSource>(std::move(*samples), size, this->Type, this->IsBigEndian, held));
}

Result<OpenedVolume> RawVolume::OpenVolume(FileSystem& files) const
{
  ISOSURFACE_ASSIGN_OR_RETURN(auto source, this->Open(files));
  OpenedVolume volume;
  volume.Grid = this->Grid;
  volume.Arrays = { { this->ArrayName, this->Type, 1, this->SampleUnit } };
  volume.LeftOut = this->LeftOut;
  if (const std::string surplus = this->DescribeSurplus(files); !surplus.empty())
  {
    AddNote(volume.LeftOut, surplus);
  }
  volume.Source = std::move(source);
  volume.Files = this->Paths;
  return volume;
}

Result<OpenedVolume> OpenRawVolume(
  FileSystem& files, const VolumeName& name, const VolumeChoice& /*choice*/)
{
  ISOSURFACE_ASSIGN_OR_RETURN(const auto raw, RawVolume::ReadHeader(files, name.Path));
  auto volume = raw.OpenVolume(files);
  if (volume.IsOk() &&
    std::find(volume->Files.begin(), volume->Files.end(), name.Path) == volume->Files.end())
  {
    volume->Files.push_back(name.Path);
  }
  return volume;
}

} // namespace isosurface
