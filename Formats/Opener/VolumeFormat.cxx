// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/Opener/VolumeFormat.h"

#include "Formats/Plain/RawVolume.h"
#include "Formats/Source/HeaderText.h"
#include "Formats/Zarr/ZarrVolume.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <initializer_list>
#include <string_view>

namespace isosurface
{
namespace
{

bool IsOneOf(const std::string& text, std::initializer_list<const char*> names)
{
  return std::any_of(
    names.begin(), names.end(), [&text](const char* name) { return text == name; });
}

/// The first bytes of a file; fewer, or none, if it does not have them.
std::string ReadStart(FileSystem& files, const std::string& path)
{
  const auto file = files.OpenForReading(path);
  if (!file.IsOk())
  {
    return {};
  }
  constexpr std::uint64_t most = 512;
  std::string start(static_cast<std::size_t>(std::min((*file)->GetSize(), most)), '\0');
  return (*file)->Read(0, start.size(), start.data()).IsOk() ? start : std::string();
}

bool Begins(const std::string& start, std::string_view magic, std::size_t at = 0)
{
  return start.size() >= at + magic.size() && start.compare(at, magic.size(), magic) == 0;
}

VolumeFormat FindByContent(FileSystem& files, const std::string& path)
{
  using namespace std::string_view_literals;
  const std::string start = ReadStart(files, path);
  if (Begins(start, "\x89HDF\r\n\x1a\n"sv))
  {
    return VolumeFormat::Hdf5;
  }
  if (Begins(start, "CDF\1"sv) || Begins(start, "CDF\2"sv) || Begins(start, "CDF\5"sv))
  {
    return VolumeFormat::Netcdf;
  }
  if (Begins(start, "DICM"sv, 128))
  {
    return VolumeFormat::Dicom;
  }
  if (Begins(start, "MAP"sv, 208))
  {
    return VolumeFormat::Mrc;
  }
  return VolumeFormat::None;
}

VolumeFormat FindByExtension(const std::string& extension)
{
  if (IsOneOf(extension, { ".h5", ".hdf5", ".he5", ".vtkhdf", ".nxs", ".emd", ".ims" }))
  {
    return VolumeFormat::Hdf5;
  }
  if (IsOneOf(extension, { ".nc", ".nc4", ".cdf" }))
  {
    return VolumeFormat::Netcdf;
  }
  if (extension == ".dcm")
  {
    return VolumeFormat::Dicom;
  }
  if (IsOneOf(extension, { ".nii", ".nii.gz" }))
  {
    return VolumeFormat::Nifti;
  }
  if (IsOneOf(extension,
        { ".mrc", ".mrc.gz", ".map", ".map.gz", ".ccp4", ".rec", ".ali", ".st", ".mrcs" }))
  {
    return VolumeFormat::Mrc;
  }
  return VolumeFormat::None;
}

/// The format of a folder that is none of Zarr: TIFF, if nothing tells.
VolumeFormat FindOfFolder(FileSystem& files, const std::string& path)
{
  constexpr std::size_t most = 64;
  const auto names = files.List(path);
  if (!names.IsOk() || std::any_of(names->begin(), names->end(), IsTiffName))
  {
    return VolumeFormat::Tiff;
  }
  for (std::size_t name = 0; name < std::min(most, names->size()); ++name)
  {
    const std::string file = (std::filesystem::path(path) / (*names)[name]).string();
    if (FindByContent(files, file) == VolumeFormat::Dicom)
    {
      return VolumeFormat::Dicom;
    }
  }
  return VolumeFormat::Tiff;
}

} // namespace

bool IsTiffName(const std::string& path)
{
  return IsOneOf(
    HeaderText::Lower(std::filesystem::path(path).extension().string()), { ".tif", ".tiff" });
}

bool IsNamePattern(const std::string& path)
{
  return std::filesystem::path(path).filename().string().find_first_of("*?") != std::string::npos;
}

bool HasFiles(FileSystem& files, const std::string& path)
{
  const auto names = files.List(path);
  return names.IsOk() && !names->empty();
}

VolumeFormat FindVolumeFormat(FileSystem& files, const VolumeName& name)
{
  if (RawVolume::HasHeader(name.Path))
  {
    return VolumeFormat::Header;
  }
  if (IsZarrFolder(files, name.Path))
  {
    return VolumeFormat::Zarr;
  }
  if (IsTiffName(name.Path) || IsNamePattern(name.Path))
  {
    return VolumeFormat::Tiff;
  }
  if (HasFiles(files, name.Path))
  {
    return FindOfFolder(files, name.Path);
  }
  const VolumeFormat byExtension = FindByExtension(name.GetExtension());
  return byExtension != VolumeFormat::None ? byExtension : FindByContent(files, name.Path);
}

bool HasSeveralVolumes(VolumeFormat format)
{
  return format == VolumeFormat::Hdf5 || format == VolumeFormat::Netcdf ||
    format == VolumeFormat::Zarr || format == VolumeFormat::Dicom;
}

} // namespace isosurface
