// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/Plain/RawVolume.h"

#include "Formats/Plain/PlainFormats.h"
#include "Formats/Source/AxisUnits.h"
#include "Formats/Source/FolderFiles.h"
#include "Formats/Source/GzipFile.h"
#include "Ground/Base/FileSystem.h"
#include "Ground/Volume/BoxSource.h"
#include "Ground/Volume/PageBuffer.h"

#include <algorithm>
#include <functional>
#include <utility>

namespace isosurface
{
namespace
{

template <typename T>
void SwapBytes(std::uint8_t* bytes, std::size_t samples)
{
  for (std::size_t sample = 0; sample < samples; ++sample)
  {
    std::reverse(bytes + sample * sizeof(T), bytes + (sample + 1) * sizeof(T));
  }
}

/**
 * The samples of one array in a file, x fastest, then y, then z. Cost of a box: one read for whole
 * slices, or one for each if their size is a multiple of 4096 bytes (ChooseSlicePitch); a read for
 * each slice for whole rows, otherwise a read for each row.
 */
class RawSource : public BoxSource
{
public:
  /// The file contains all samples and nothing before them. `heldBytes`: the memory of `file`.
  RawSource(std::unique_ptr<RandomAccessFile> file, const Index3& size, ValueType type,
    bool isBigEndian, std::uint64_t heldBytes)
    : File(std::move(file))
    , Box{ { 0, 0, 0 }, size }
    , Type(type)
    , IsBigEndian(isBigEndian)
    , HeldBytes(heldBytes)
    , Pool(std::make_shared<PageBufferPool>())
  {
  }

  const VertexBox& GetBox() const override { return this->Box; }
  std::uint64_t GetReadBytes(const VertexBox& box) const override
  {
    const std::size_t valueSize = GetValueSize(this->Type);
    const Index3 size = box.GetSize();
    const std::int64_t slices = std::max<std::int64_t>(1, size[2]);
    return static_cast<std::uint64_t>(
             ChooseSlicePitch(box, valueSize) * (slices - 1) + size[0] * size[1]) *
      valueSize;
  }

  std::uint64_t GetHeldBytes() const override { return this->HeldBytes; }
  std::optional<Index3> GetChunk() const override
  {
    if (this->HeldBytes > 0)
    {
      return std::nullopt; // a stream
    }
    // Whole rows, which follow each other in the file.
    constexpr std::int64_t rows = 32;
    const Index3 size = this->Box.GetSize();
    return Index3{ size[0], std::min(rows, size[1]), std::min(rows, size[2]) };
  }

  bool HasCheapRows() const override { return this->HeldBytes == 0; } // no stream
  /// Whole slices.
  void Prefetch(const VertexBox& box) const override
  {
    const Index3 whole = this->Box.GetSize();
    const std::uint64_t slice =
      static_cast<std::uint64_t>(whole[0] * whole[1]) * GetValueSize(this->Type);
    this->File->Prefetch(static_cast<std::uint64_t>(box.Low[2]) * slice,
      static_cast<std::uint64_t>(box.GetSize()[2]) * slice);
  }

  Result<BoxSamples> Read(const VertexBox& box) override
  {
    auto samples = this->Pool->Take(this->GetReadBytes(box));
    if (!samples.IsOk())
    {
      return Status(samples.GetStatus().GetCode(),
        this->File->GetPath() + ": cannot read: " + samples.GetStatus().GetMessage());
    }
    std::uint8_t* bytes = (*samples)->GetData();
    const std::int64_t pitch = ChooseSlicePitch(box, GetValueSize(this->Type));
    const std::int64_t slice = box.GetSize()[0] * box.GetSize()[1];
    if (pitch == slice)
    {
      ISOSURFACE_RETURN_IF_ERROR(this->ReadSamples(box, bytes));
    }
    else
    {
      VertexBox part = box;
      for (part.Low[2] = box.Low[2]; part.Low[2] < box.High[2]; part.Low[2] = part.High[2])
      {
        part.High[2] = part.Low[2] + 1;
        const auto first = static_cast<std::size_t>((part.Low[2] - box.Low[2]) * pitch);
        ISOSURFACE_RETURN_IF_ERROR(
          this->ReadSamples(part, bytes + first * GetValueSize(this->Type)));
      }
    }
    return MakeBoxSamples(this->Type, box, std::move(*samples), pitch);
  }

private:
  Status ReadSamples(const VertexBox& box, std::uint8_t* to) const
  {
    const Index3 whole = this->Box.GetSize();
    const Index3 size = box.GetSize();
    const std::size_t valueSize = GetValueSize(this->Type);
    // Reads as many rows and slices at once as are contiguous in the file.
    const std::int64_t rows = size[0] == whole[0] ? size[1] : 1;
    const std::int64_t slices = rows == whole[1] ? size[2] : 1;
    const std::size_t bytes = static_cast<std::size_t>(size[0] * rows * slices) * valueSize;
    for (std::int64_t k = box.Low[2]; k < box.High[2]; k += slices)
    {
      for (std::int64_t j = box.Low[1]; j < box.High[1]; j += rows)
      {
        const auto sample = static_cast<std::uint64_t>(box.Low[0] + whole[0] * (j + whole[1] * k));
        ISOSURFACE_RETURN_IF_ERROR(this->File->Read(sample * valueSize, bytes, to));
        if (this->IsBigEndian)
        {
          DispatchValueType(
            this->Type, [&](auto zero) { SwapBytes<decltype(zero)>(to, bytes / valueSize); });
        }
        to += bytes;
      }
    }
    return Status::Ok();
  }

  std::unique_ptr<RandomAccessFile> File;
  VertexBox Box;
  ValueType Type;
  bool IsBigEndian;
  std::uint64_t HeldBytes;
  std::shared_ptr<PageBufferPool> Pool;
};

/**
 * A series of files of equal size as if they were one file. A file is opened when it is read, and
 * only the last one stays open, so there may be any number of files. One thread at a time may read.
 */
class SeriesFile : public RandomAccessFile
{
public:
  /// Opens one file of the series. The result must have `size` bytes.
  using Opener = std::function<Result<std::unique_ptr<RandomAccessFile>>(const std::string& path)>;

  SeriesFile(Opener open, std::vector<std::string> paths, std::uint64_t size)
    : Open(std::move(open))
    , Paths(std::move(paths))
    , Size(size)
  {
  }

  Status Read(std::uint64_t offset, std::size_t size, void* bytes) const override
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
      const auto count =
        static_cast<std::size_t>(std::min<std::uint64_t>(size, this->Size - within));
      ISOSURFACE_RETURN_IF_ERROR(this->OpenFile->Read(within, count, to));
      to += count;
      offset += count;
      size -= count;
    }
    return Status::Ok();
  }
  std::uint64_t GetSize() const override { return this->Paths.size() * this->Size; }
  const std::string& GetPath() const override { return this->Paths.front(); }

private:
  Opener Open;
  std::vector<std::string> Paths;
  std::uint64_t Size;
  mutable std::size_t OpenNumber = 0;
  mutable std::unique_ptr<RandomAccessFile> OpenFile;
};

/// `size` bytes of a file, from offset `begin`, as a file of their own. The file must contain them.
class SectionFile : public RandomAccessFile
{
public:
  SectionFile(std::unique_ptr<RandomAccessFile> file, std::uint64_t begin, std::uint64_t size)
    : File(std::move(file))
    , Begin(begin)
    , Size(size)
  {
  }

  Status Read(std::uint64_t offset, std::size_t size, void* bytes) const override
  {
    return this->File->Read(this->Begin + offset, size, bytes);
  }
  void Prefetch(std::uint64_t offset, std::uint64_t size) const override
  {
    this->File->Prefetch(this->Begin + offset, size);
  }
  std::uint64_t GetSize() const override { return this->Size; }
  const std::string& GetPath() const override { return this->File->GetPath(); }

private:
  std::unique_ptr<RandomAccessFile> File;
  std::uint64_t Begin;
  std::uint64_t Size;
};

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
