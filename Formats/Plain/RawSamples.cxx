// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/Plain/PlainFormats.h"

#include "Formats/Plain/RawVolume.h"
#include "Formats/Source/FolderFiles.h"
#include "Formats/Source/TextFields.h"
#include "Ground/Base/Coding.h"

#include <algorithm>
#include <filesystem>
#include <optional>
#include <utility>
#include <vector>

namespace isosurface
{
namespace
{

constexpr const char* BigEndian = "big-endian";
constexpr const char* HeaderBytes = "header-bytes=";
constexpr std::int64_t MaximumRawSize = 2147483647;

std::vector<std::string> SplitText(const std::string& text, char separator)
{
  std::vector<std::string> words;
  std::size_t begin = 0;
  for (std::size_t end = 0; end != std::string::npos; begin = end + 1)
  {
    end = text.find(separator, begin);
    words.push_back(TrimText(text.substr(begin, end - begin)));
  }
  return words;
}

/// Takes "512x512x300".
bool TakeDimensions(const std::string& text, RawVolume& raw)
{
  const std::vector<std::string> words = SplitText(text, 'x');
  for (std::size_t axis = 0; words.size() == 3 && axis < 3; ++axis)
  {
    const auto size = ParseInteger(words[axis]);
    if (!size || *size < 1 || *size > MaximumRawSize)
    {
      return false;
    }
    raw.Grid.Extent[2 * axis] = 0;
    raw.Grid.Extent[2 * axis + 1] = *size - 1;
  }
  return words.size() == 3;
}

std::optional<RawVolume> ParseDescription(const std::string& text)
{
  const std::vector<std::string> words = SplitText(text, ',');
  const auto type = words.size() < 2 ? std::nullopt : FindValueType(words[1]);
  RawVolume raw;
  if (!type || !TakeDimensions(words[0], raw))
  {
    return std::nullopt;
  }
  raw.Type = *type;
  for (std::size_t word = 2; word < words.size(); ++word)
  {
    const std::string head = HeaderBytes;
    const bool hasBytes = words[word].compare(0, head.size(), head) == 0;
    const auto bytes = hasBytes ? ParseInteger(words[word].substr(head.size())) : std::nullopt;
    if (words[word] != BigEndian && (!bytes || *bytes < 0))
    {
      return std::nullopt;
    }
    raw.IsBigEndian = raw.IsBigEndian || words[word] == BigEndian;
    raw.Offset = bytes ? static_cast<std::uint64_t>(*bytes) : raw.Offset;
  }
  return raw;
}

bool IsGzipName(const std::string& path)
{
  const std::string extension = FindExtension(path);
  return extension.size() >= 3 && extension.compare(extension.size() - 3, 3, ".gz") == 0;
}

std::string MakeAdvice(const std::string& path)
{
  return "; say what its samples are, as in " + path +
    ":512x512x300,uint16 and perhaps ,big-endian or ,header-bytes=128";
}

/// Ok if a file has as many bytes as its name says. A gzip stream ends with the last 32 bits of their number.
Status CheckSize(FileSystem& files, const std::string& path, const RawVolume& raw)
{
  ISOSURFACE_ASSIGN_OR_RETURN(const auto file, files.OpenForReading(path));
  const std::uint64_t wanted = raw.CountBytes().value_or(0);
  const std::uint64_t size = file->GetSize();
  std::uint8_t end[4] = {};
  if (IsGzipName(path))
  {
    ISOSURFACE_RETURN_IF_ERROR(
      file->Read(size - std::min<std::uint64_t>(size, sizeof(end)), sizeof(end), end));
    return LoadLittleEndian<std::uint32_t>(end) == static_cast<std::uint32_t>(wanted)
      ? Status::Ok()
      : Status(StatusCode::Corrupt,
          path + ": its stream has not the " + std::to_string(wanted) +
            " bytes that its name says" + MakeAdvice(path));
  }
  return size == wanted
    ? Status::Ok()
    : Status(StatusCode::Corrupt,
        path + (size < wanted ? ": truncated: has " : ": has ") + std::to_string(size) +
          " bytes, and its name says " + std::to_string(wanted) + MakeAdvice(path));
}

/// The description that a file's name has; "" if it has none.
std::string FindDescription(const std::string& path)
{
  RawVolume raw;
  std::string dimensions;
  std::string type;
  const std::filesystem::path name(path);
  const std::filesystem::path stem = IsGzipName(path) ? name.stem().stem() : name.stem();
  for (const std::string& word : SplitText(stem.string(), '_'))
  {
    dimensions = TakeDimensions(word, raw) ? word : dimensions;
    type = FindValueType(word) ? word : type;
  }
  const std::string description = dimensions + "," + type;
  const auto parsed = ParseDescription(description);
  return parsed && parsed->CountBytes() ? description : "";
}

Result<OpenedVolume> OpenRawSamples(
  FileSystem& files, const VolumeName& name, const VolumeChoice& /*choice*/)
{
  auto raw = ParseDescription(name.Within.empty() ? FindDescription(name.Path) : name.Within);
  if (!raw)
  {
    return Status(
      StatusCode::InvalidArgument, name.GetText() + ": cannot be read" + MakeAdvice(name.Path));
  }
  if (name.Within.empty())
  {
    ISOSURFACE_RETURN_IF_ERROR(CheckSize(files, name.Path, *raw));
  }
  raw->Paths = { name.Path };
  raw->IsGzip = IsGzipName(name.Path);
  if (raw->IsGzip)
  {
    std::swap(raw->Offset, raw->Skip); // what is before the samples is in the stream
  }
  return raw->OpenVolume(files);
}

Result<std::vector<VolumeListing>> ListRawSamples(FileSystem& files, const VolumeName& name)
{
  const std::string description = FindDescription(name.Path);
  std::vector<VolumeListing> list;
  if (const auto raw = ParseDescription(description))
  {
    ISOSURFACE_RETURN_IF_ERROR(CheckSize(files, name.Path, *raw));
    const Index3 size = raw->Grid.GetDimensions();
    list.push_back({ description,
      std::to_string(size[2]) + " x " + std::to_string(size[1]) + " x " + std::to_string(size[0]),
      GetValueTypeName(raw->Type), "raw" });
  }
  return list;
}

} // namespace

bool IsRawDescription(const std::string& text)
{
  return ParseDescription(text).has_value();
}

const FormatFunctions RawSamplesFormat = { OpenRawSamples, ListRawSamples };

} // namespace isosurface
