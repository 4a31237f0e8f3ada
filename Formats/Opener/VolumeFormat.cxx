// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/Opener/VolumeFormat.h"

#include "Formats/Plain/MrcVolume.h"
#include "Formats/Plain/NiftiVolume.h"
#include "Formats/Plain/RawSamples.h"
#include "Formats/Plain/RawVolume.h"
#include "Formats/Source/FileNames.h"
#include "Formats/Source/FormatModule.h"
#include "Formats/Tiff/TiffStack.h"
#include "Formats/Zarr/ZarrVolume.h"

#include <algorithm>
#include <filesystem>

namespace isosurface
{
namespace
{

using Names = std::vector<std::string>;
using Mark = VolumeFormat::Mark;

constexpr std::string_view RawName = "raw";
constexpr std::string_view Hdf5Mark = "\x89HDF\r\n\x1a\n";
constexpr Mark DicomMark = { "DICM", 128 };

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

bool HasMark(const std::string& start, const Mark& mark)
{
  return start.size() >= mark.Offset + mark.Text.size() &&
    start.compare(mark.Offset, mark.Text.size(), mark.Text) == 0;
}

/// Whether HDF5 begins behind bytes of another program, as in MATLAB's files: at 512, 1024, 2048, ...
bool HasHdf5Behind(FileSystem& files, const std::string& path)
{
  const auto file = files.OpenForReading(path);
  const std::uint64_t size = file.IsOk() ? (*file)->GetSize() : 0;
  std::string start(Hdf5Mark.size(), '\0');
  for (std::uint64_t at = 512; at < size && size - at >= start.size(); at *= 2)
  {
    if (!(*file)->Read(at, start.size(), start.data()).IsOk() || start == Hdf5Mark)
    {
      return start == Hdf5Mark;
    }
  }
  return false;
}

bool IsZarr(FileSystem& files, const std::string& path, const Names& /*names*/)
{
  return IsZarrFolder(files, path);
}

bool HasDicom(FileSystem& files, const std::string& path, const Names& names)
{
  constexpr std::size_t most = 64;
  const bool hasTiff = std::any_of(names.begin(), names.end(), IsTiffName);
  return !hasTiff &&
    std::any_of(names.begin(),
      names.begin() + static_cast<std::ptrdiff_t>(std::min(most, names.size())),
      [&](const std::string& name) {
        return HasMark(ReadStart(files, (std::filesystem::path(path) / name).string()), DicomMark);
      });
}

bool IsStack(FileSystem& /*files*/, const std::string& /*path*/, const Names& /*names*/)
{
  return true;
}

const std::vector<VolumeFormat>& GetFormats()
{
  // A folder is of the first format that takes it; TIFF, the last one of these, says what it lacks.
  static const std::vector<VolumeFormat> formats = {
    { "MetaImage", { ".mhd", ".mha" }, {}, nullptr, { OpenRawVolume } },
    { "NRRD", { ".nrrd", ".nhdr" }, {}, nullptr, { OpenRawVolume } },
    { "NIfTI", { ".nii", ".nii.gz" }, {}, nullptr, { OpenNiftiVolume } },
    { "MRC", { ".mrc", ".mrc.gz", ".map", ".map.gz", ".ccp4", ".rec", ".ali", ".st", ".mrcs" },
      { { "MAP", 208 } }, nullptr, { OpenMrcVolume } },
    { "HDF5", { ".h5", ".hdf5", ".he5", ".vtkhdf", ".nxs", ".emd", ".ims", ".dream3d", ".mat" },
      { { Hdf5Mark } }, nullptr, {}, "Hdf5Format", true },
    { "NetCDF", { ".nc", ".nc4", ".cdf" }, { { "CDF\1" }, { "CDF\2" }, { "CDF\5" } }, nullptr, {},
      "NetcdfFormat", true },
    { "Zarr", {}, {}, IsZarr, { OpenZarrVolume, ListZarr }, nullptr, true },
    { "DICOM", { ".dcm" }, { DicomMark }, HasDicom, {}, "DicomFormat" },
    { "TIFF", { ".tif", ".tiff" }, {}, IsStack, {}, "TiffFormat", true },
    { RawName, { ".raw", ".raw.gz" }, {}, nullptr, RawSamplesFormat },
  };
  return formats;
}

template <typename Fits>
const VolumeFormat* FindFormat(const Fits& fits)
{
  const std::vector<VolumeFormat>& formats = GetFormats();
  const auto found = std::find_if(formats.begin(), formats.end(), fits);
  return found == formats.end() ? nullptr : &*found;
}

} // namespace

bool VolumeFormat::HasExtension(const std::string& path) const
{
  return std::find(this->Extensions.begin(), this->Extensions.end(), FindExtension(path)) !=
    this->Extensions.end();
}

Result<FormatFunctions> VolumeFormat::Load(const std::string& path) const
{
  if (!this->Module)
  {
    return this->Functions;
  }
  const auto module = LoadFormatModule(this->Module, path + ": " + std::string(this->Name));
  ISOSURFACE_RETURN_IF_ERROR(module.GetStatus());
  return *static_cast<const FormatFunctions*>(*module);
}

const VolumeFormat* FindVolumeFormat(FileSystem& files, const VolumeName& name)
{
  const Names names = ListNames(files, name.Path);
  if (!names.empty() || IsNamePattern(name.Path))
  {
    return FindFormat([&](const VolumeFormat& format)
      { return format.IsFolder && format.IsFolder(files, name.Path, names); });
  }
  const VolumeFormat* const named =
    FindFormat([&name](const VolumeFormat& format) { return format.HasExtension(name.Path); });
  if (named)
  {
    return named;
  }
  const std::string start = ReadStart(files, name.Path);
  const VolumeFormat* const marked = FindFormat(
    [&start](const VolumeFormat& format)
    {
      return std::any_of(format.Marks.begin(), format.Marks.end(),
        [&start](const Mark& mark) { return HasMark(start, mark); });
    });
  const std::string_view other = IsRawDescription(name.Within) ? RawName
    : !marked && HasHdf5Behind(files, name.Path)               ? "HDF5"
                                                               : "";
  return marked ? marked
                : FindFormat([other](const VolumeFormat& format) { return format.Name == other; });
}

} // namespace isosurface
