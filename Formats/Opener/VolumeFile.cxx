// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/Opener/VolumeFile.h"

#include "Formats/Dicom/DicomVolume.h"
#include "Formats/Hdf5/Hdf5Volume.h"
#include "Formats/Netcdf/NetcdfVolume.h"
#include "Formats/Opener/VolumeFormat.h"
#include "Formats/Opener/VolumeName.h"
#include "Formats/Plain/MrcVolume.h"
#include "Formats/Plain/NiftiVolume.h"
#include "Formats/Plain/RawVolume.h"
#include "Formats/Source/HeaderText.h"
#include "Formats/Tiff/TiffSource.h"
#include "Formats/Zarr/ZarrVolume.h"

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <optional>
#include <utility>

namespace isosurface
{
namespace
{

/// "*" stands for any characters, "?" for one.
bool FitsPattern(const std::string& name, const std::string& pattern)
{
  std::size_t at = 0;
  std::size_t of = 0;
  std::size_t star = std::string::npos;
  std::size_t afterStar = 0;
  while (at < name.size())
  {
    if (of < pattern.size() && pattern[of] == '*')
    {
      star = of++;
      afterStar = at;
    }
    else if (of < pattern.size() && (pattern[of] == '?' || pattern[of] == name[at]))
    {
      ++of;
      ++at;
    }
    else if (star != std::string::npos)
    {
      of = star + 1;
      at = ++afterStar;
    }
    else
    {
      return false;
    }
  }
  return pattern.find_first_not_of('*', of) == std::string::npos;
}

bool IsDigit(char letter)
{
  return std::isdigit(static_cast<unsigned char>(letter)) != 0;
}

/// A name cut into text, number, text, number, ...
struct NameParts
{
  std::vector<std::string> Texts;
  std::vector<std::string> Numbers; ///< without leading zeros

  explicit NameParts(const std::string& name)
  {
    std::size_t at = 0;
    while (at < name.size())
    {
      const std::size_t digits = static_cast<std::size_t>(
        std::find_if(name.begin() + static_cast<std::ptrdiff_t>(at), name.end(), IsDigit) -
        name.begin());
      std::size_t end = digits;
      while (end < name.size() && IsDigit(name[end]))
      {
        ++end;
      }
      this->Texts.push_back(name.substr(at, digits - at));
      const std::string number = name.substr(digits, end - digits);
      const std::size_t zeros = std::min(number.find_first_not_of('0'), number.size());
      this->Numbers.push_back(number.substr(zeros));
      at = end;
    }
  }

  bool operator<(const NameParts& other) const
  {
    const std::size_t count = std::min(this->Texts.size(), other.Texts.size());
    for (std::size_t part = 0; part < count; ++part)
    {
      const std::string& a = this->Numbers[part];
      const std::string& b = other.Numbers[part];
      if (this->Texts[part] != other.Texts[part])
      {
        return this->Texts[part] < other.Texts[part];
      }
      if (a != b)
      {
        return a.size() != b.size() ? a.size() < b.size() : a < b;
      }
    }
    return this->Texts.size() < other.Texts.size();
  }
};

/// The index of the number in which the names differ, if it is only one.
std::optional<std::size_t> FindCounter(const std::vector<NameParts>& names)
{
  std::optional<std::size_t> counter;
  for (const NameParts& name : names)
  {
    if (name.Texts != names.front().Texts)
    {
      return std::nullopt;
    }
    for (std::size_t part = 0; part < name.Numbers.size(); ++part)
    {
      if (name.Numbers[part] != names.front().Numbers[part] && counter.value_or(part) != part)
      {
        return std::nullopt;
      }
      if (name.Numbers[part] != names.front().Numbers[part])
      {
        counter = part;
      }
    }
  }
  return counter;
}

/// Checks that the numbers of a series increase by equal steps.
Status CheckSteps(const std::vector<std::string>& paths, const std::vector<NameParts>& names)
{
  const auto counter = FindCounter(names);
  std::vector<std::int64_t> numbers;
  for (std::size_t file = 0; counter && file < names.size(); ++file)
  {
    const std::string& text = names[file].Numbers[*counter];
    const auto number = HeaderText::ParseInteger(text.empty() ? "0" : text);
    if (!number)
    {
      return Status::Ok(); // a time or a hash instead of the number of a slice
    }
    numbers.push_back(*number);
  }
  for (std::size_t file = 2; file < numbers.size(); ++file)
  {
    if (numbers[file] - numbers[file - 1] != numbers[1] - numbers[0])
    {
      return Status(StatusCode::Corrupt,
        paths[file] + ": a slice of the series is missing, or there is one too many: number " +
          std::to_string(numbers[file]) + " follows " + std::to_string(numbers[file - 1]) +
          ", but the series begins with " + std::to_string(numbers[0]) + ", " +
          std::to_string(numbers[1]));
    }
  }
  return Status::Ok();
}

Result<VolumeFile> OpenTiff(FileSystem& files, const std::string& path)
{
  const auto paths = VolumeFile::FindStack(files, path);
  ISOSURFACE_RETURN_IF_ERROR(paths.GetStatus());
  auto source = TiffSource::Open(files, *paths);
  ISOSURFACE_RETURN_IF_ERROR(source.GetStatus());
  VolumeFile volume;
  const Index3 size = (*source)->GetBox().GetSize();
  volume.Grid.Extent = { 0, size[0] - 1, 0, size[1] - 1, 0, size[2] - 1 };
  volume.Arrays = { { "Tiff Scalars", (*source)->GetType(), 1 } };
  volume.Source = std::move(*source);
  return volume;
}

/// A raw file with a header, of MetaImage or NRRD.
Result<VolumeFile> OpenRaw(FileSystem& files, const std::string& path)
{
  const auto raw = RawVolume::ReadHeader(files, path);
  ISOSURFACE_RETURN_IF_ERROR(raw.GetStatus());
  auto source = raw->Open(files);
  ISOSURFACE_RETURN_IF_ERROR(source.GetStatus());
  VolumeFile volume;
  volume.Grid = raw->Grid;
  volume.Arrays = { { raw->ArrayName, raw->Type, 1 } };
  volume.Source = std::move(*source);
  volume.Files = raw->Paths;
  if (std::find(volume.Files.begin(), volume.Files.end(), path) == volume.Files.end())
  {
    volume.Files.push_back(path);
  }
  return volume;
}

[[maybe_unused]] Status MakeMissing(const VolumeName& name, const char* format, const char* package)
{
  return Status(StatusCode::Unsupported,
    name.Path + ": cannot be read: this build has no " + format + " (it lacked the library " +
      package + ")");
}

Result<VolumeFile> OpenFormat(
  FileSystem& files, VolumeFormat format, const VolumeName& name, const VolumeChoice& choice)
{
  switch (format)
  {
    case VolumeFormat::Header:
      return OpenRaw(files, name.Path);
    case VolumeFormat::Tiff:
      return OpenTiff(files, name.Path);
    case VolumeFormat::Nifti:
      return OpenNiftiVolume(files, name.Path, choice);
    case VolumeFormat::Mrc:
      return OpenMrcVolume(files, name.Path, choice);
    case VolumeFormat::Hdf5:
#if ISOSURFACE_HDF5
      return OpenHdf5Volume(name, choice);
#else
      return MakeMissing(name, "HDF5", "libhdf5");
#endif
    case VolumeFormat::Netcdf:
#if ISOSURFACE_NETCDF
      return OpenNetcdfVolume(name, choice);
#else
      return MakeMissing(name, "NetCDF", "libnetcdf");
#endif
    case VolumeFormat::Zarr:
      return OpenZarrVolume(files, name, choice);
    case VolumeFormat::Dicom:
#if ISOSURFACE_DICOM
      return OpenDicomVolume(name, choice);
#else
      return MakeMissing(name, "DICOM", "libgdcm");
#endif
    case VolumeFormat::None:
      break;
  }
  return Status(StatusCode::Unsupported,
    name.Path +
      ": cannot be read: it is neither MetaImage, NRRD, TIFF, nor of another format by "
      "its name or first bytes");
}

Result<std::vector<VolumeListing>> ListFormat(
  FileSystem& files, const VolumeName& name, const std::string& text)
{
  switch (FindVolumeFormat(files, name))
  {
    case VolumeFormat::Hdf5:
#if ISOSURFACE_HDF5
      return ListHdf5(name);
#else
      return MakeMissing(name, "HDF5", "libhdf5");
#endif
    case VolumeFormat::Netcdf:
#if ISOSURFACE_NETCDF
      return ListNetcdf(name);
#else
      return MakeMissing(name, "NetCDF", "libnetcdf");
#endif
    case VolumeFormat::Zarr:
      return ListZarr(files, name);
    case VolumeFormat::Dicom:
#if ISOSURFACE_DICOM
      return ListDicom(name);
#else
      return MakeMissing(name, "DICOM", "libgdcm");
#endif
    default:
      return Status(StatusCode::Unsupported,
        text + ": cannot be listed: it is a file of one volume, or of an unknown format");
  }
}

} // namespace

Result<std::vector<std::string>> VolumeFile::FindStack(FileSystem& files, const std::string& path)
{
  const bool isPattern = IsNamePattern(path);
  if (!isPattern && !HasFiles(files, path))
  {
    return std::vector<std::string>{ path };
  }
  const std::filesystem::path whole(path);
  const std::string folder = !isPattern ? path
    : whole.has_parent_path()           ? whole.parent_path().string()
                                        : ".";
  const auto found = files.List(folder);
  ISOSURFACE_RETURN_IF_ERROR(found.GetStatus());
  std::vector<std::pair<NameParts, std::string>> names;
  for (const std::string& name : *found)
  {
    if (isPattern ? FitsPattern(name, whole.filename().string()) : IsTiffName(name))
    {
      names.emplace_back(NameParts(name), name);
    }
  }
  if (names.empty())
  {
    return Status(
      StatusCode::NotFound, path + ": there are no TIFF files of this name, or in this folder");
  }
  std::stable_sort(
    names.begin(), names.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<std::string> paths;
  std::vector<NameParts> parts;
  for (auto& name : names)
  {
    paths.push_back((std::filesystem::path(folder) / name.second).string());
    parts.push_back(std::move(name.first));
  }
  ISOSURFACE_RETURN_IF_ERROR(CheckSteps(paths, parts));
  return paths;
}

bool VolumeFile::IsKnown(FileSystem& files, const std::string& name)
{
  return FindVolumeFormat(files, VolumeName::Parse(files, name)) != VolumeFormat::None;
}

Result<VolumeFile> VolumeFile::Open(
  FileSystem& files, const std::string& text, const VolumeChoice& choice)
{
  const VolumeName name = VolumeName::Parse(files, text);
  const VolumeFormat format = FindVolumeFormat(files, name);
  if (!name.Within.empty() && !HasSeveralVolumes(format))
  {
    return Status(StatusCode::InvalidArgument,
      text + ": cannot be read: a file of this format has one volume, and no \"" + name.Within +
        "\"");
  }
  // What a file asks for may be more than there is, and libraries throw.
  auto volume = Attempt(text, [&] { return OpenFormat(files, format, name, choice); });
  if (volume.IsOk() && choice.Step >= std::max<std::size_t>(1, volume->Times.size()))
  {
    return Status(StatusCode::InvalidArgument,
      text + ": has " + std::to_string(std::max<std::size_t>(1, volume->Times.size())) +
        " time steps, and none of number " + std::to_string(choice.Step));
  }
  if (volume.IsOk() && volume->Files.empty())
  {
    volume->Files = { name.Path };
  }
  return volume;
}

Result<std::vector<VolumeListing>> VolumeFile::List(FileSystem& files, const std::string& text)
{
  return Attempt(text, [&] { return ListFormat(files, VolumeName::Parse(files, text), text); });
}

} // namespace isosurface
