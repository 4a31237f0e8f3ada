// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/Opener/VolumeFormat.h"

#include "Formats/Plain/PlainFormats.h"
#include "Formats/Source/FolderFiles.h"
#include "Formats/Source/FormatModule.h"
#include "Formats/Source/SliceFiles.h"
#include "Formats/Zarr/ZarrVolume.h"

#include <algorithm>
#include <filesystem>
#include <system_error>

namespace isosurface
{
namespace
{

using Names = std::vector<std::string>;
using Mark = VolumeFormat::Mark;

constexpr std::string_view RawName = "raw";
constexpr std::string_view Hdf5Mark = "\x89HDF\r\n\x1a\n";
constexpr std::string_view DicomName = "DICOM";
constexpr std::string_view TiffName = "TIFF";
constexpr Mark DicomMark = { "DICM", 128 };
constexpr std::string_view AnalyzeMark("\x5c\x01\0\0", 4);
constexpr std::string_view BigEndianAnalyzeMark("\0\0\x01\x5c", 4);

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

/// Whether a file begins as DICOM: with its signature, or else with an element of group 2 or 8, explicit
/// or implicit, and short.
bool IsDicomStart(const std::string& start)
{
  if (HasMark(start, DicomMark))
  {
    return true;
  }
  if (start.size() < 132)
  {
    return false;
  }
  const auto at = [&start](std::size_t byte) { return static_cast<unsigned char>(start[byte]); };
  const auto isLetter = [&at](std::size_t byte) { return at(byte) >= 'A' && at(byte) <= 'Z'; };
  const bool isExplicit = isLetter(4) && isLetter(5);
  const bool isImplicit = at(5) == 0 && at(6) == 0 && at(7) == 0 && at(4) % 2 == 0;
  const bool isLittle = (at(0) == 2 || at(0) == 8) && at(1) == 0 && at(3) == 0;
  const bool isBig = at(0) == 0 && at(1) == 8 && at(2) == 0;
  return (isLittle && (isExplicit || isImplicit)) || (isBig && isExplicit);
}

/// Looks for a file of DICOM in a folder, or else in the folders in it. `left`: how many files may be
/// looked at.
bool HasDicomFile(
  FileSystem& files, const std::filesystem::path& folder, const Names& names, int depth, int& left)
{
  for (const std::string& name : names)
  {
    if (!IsHiddenName(name) && left-- > 0 &&
      IsDicomStart(ReadStart(files, (folder / name).string())))
    {
      return true;
    }
  }
  return depth > 0 &&
    std::any_of(names.begin(), names.end(),
      [&](const std::string& name)
      {
        const std::filesystem::path inner = folder / name;
        return !IsHiddenName(name) && left-- > 0 &&
          HasDicomFile(files, inner, ListNames(files, inner.string()), depth - 1, left);
      });
}

/// Folders of images have no folders of DICOM; a few images may be beside them.
bool HasDicom(FileSystem& files, const std::string& path, const Names& names)
{
  constexpr int fewImages = 3;
  constexpr int maximumDepth = 16;
  const bool isPattern = IsPattern(files, path);
  const std::string kind = SliceFiles::FindKind(names);
  const auto images = std::count_if(names.begin(), names.end(),
    [](const std::string& name) { return !SliceFiles::FindKind({ name }).empty(); });
  int left = 100000;
  return kind != "TIFF" &&
    HasDicomFile(files, isPattern ? FindFolder(path) : path, names,
      isPattern || images > fewImages ? 0 : maximumDepth, left);
}

/// Of folders that have nothing else, TIFF says what they lack.
bool IsStack(FileSystem& files, const std::string& path, const Names& names)
{
  const std::string kind = SliceFiles::FindKind(names);
  if (!kind.empty() || names.empty() || !IsPattern(files, path))
  {
    return kind.empty() || kind == "TIFF";
  }
  const std::string start =
    ReadStart(files, (std::filesystem::path(FindFolder(path)) / names.front()).string());
  return HasMark(start, { "II*" }) || HasMark(start, { "II+" }) || HasMark(start, { "MM" });
}

const std::vector<VolumeFormat>& GetFormats()
{
  // A folder is of the first format that takes it; TIFF, the last one of these, says what it lacks.
  static const std::vector<VolumeFormat> formats = {
    { "MetaImage", { ".mhd", ".mha" }, {}, nullptr, { OpenRawVolume } },
    { "NRRD", { ".nrrd", ".nhdr" }, {}, nullptr, { OpenRawVolume } },
    { "NIfTI", { ".nii", ".nii.gz" },
      { { "n+1", 344 }, { "ni1", 344 }, { "n+2", 4 }, { "ni2", 4 }, { AnalyzeMark },
        { BigEndianAnalyzeMark } },
      nullptr, { OpenNiftiVolume } },
    { "MRC", { ".mrc", ".mrc.gz", ".map", ".map.gz", ".ccp4", ".rec", ".ali", ".st", ".mrcs" },
      { { "MAP", 208 } }, nullptr, { OpenMrcVolume } },
    { "HDF5", { ".h5", ".hdf5", ".he5", ".vtkhdf", ".nxs", ".emd", ".ims", ".dream3d", ".mat" },
      { { Hdf5Mark } }, nullptr, {}, "Hdf5Format", true, true },
    { "NetCDF", { ".nc", ".nc4", ".cdf" }, { { "CDF\1" }, { "CDF\2" }, { "CDF\5" } }, nullptr, {},
      "NetcdfFormat", true, true },
    { "Zarr", {}, {}, IsZarr, { OpenZarrVolume, ListZarr }, nullptr, true },
    { DicomName, { ".dcm" }, { DicomMark }, HasDicom, {}, "DicomFormat", false, true },
    { TiffName, { ".tif", ".tiff" }, {}, IsStack, {}, "TiffFormat", true },
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

bool VolumeFormat::HasAnyMark(FileSystem& files, const std::string& path) const
{
  const std::string start = ReadStart(files, path);
  return std::any_of(this->Marks.begin(), this->Marks.end(),
    [&start](const Mark& mark) { return HasMark(start, mark); });
}

Result<FormatFunctions> VolumeFormat::Load(const std::string& path) const
{
  if (!this->Module)
  {
    return this->Functions;
  }
  ISOSURFACE_ASSIGN_OR_RETURN(
    const auto module, LoadFormatModule(this->Module, path + ": " + std::string(this->Name)));
  return *static_cast<const FormatFunctions*>(module);
}

std::string ListFormatNames()
{
  std::string names;
  for (const VolumeFormat& format : GetFormats())
  {
    names += (names.empty() ? "" : ", ") + std::string(format.Name);
  }
  return names;
}

const VolumeFormat* FindVolumeFormat(FileSystem& files, const VolumeName& name)
{
  const bool isPattern = IsPattern(files, name.Path);
  const Names names =
    isPattern ? FindFittingNames(files, name.Path, nullptr) : ListNames(files, name.Path);
  if (!names.empty() || isPattern)
  {
    const VolumeFormat* const folder = FindFormat([&](const VolumeFormat& format)
      { return format.IsFolder && format.IsFolder(files, name.Path, names); });
    const Names steps = folder || !isPattern ? Names() : FindStepFiles(files, name.Path);
    return steps.empty() ? folder : FindVolumeFormat(files, { steps.front(), name.Within });
  }
  const VolumeFormat* const named =
    FindFormat([&name](const VolumeFormat& format) { return format.HasExtension(name.Path); });
  if (named)
  {
    return named;
  }
  if (IsAddress(name.Path) && IsZarrFolder(files, name.Path))
  {
    return FindFormat([](const VolumeFormat& format) { return format.IsFolder == IsZarr; });
  }
  const std::string start = ReadStart(files, FindNiftiHeader(name.Path));
  const VolumeFormat* const marked = FindFormat(
    [&start](const VolumeFormat& format)
    {
      return std::any_of(format.Marks.begin(), format.Marks.end(),
               [&start](const Mark& mark) { return HasMark(start, mark); }) ||
        (format.Name == DicomName && IsDicomStart(start));
    });
  const std::string_view other = IsRawDescription(name.Within) ? RawName
    : !marked && HasHdf5Behind(files, name.Path)               ? "HDF5"
                                                               : "";
  return marked ? marked
                : FindFormat([other](const VolumeFormat& format) { return format.Name == other; });
}

Status CheckReadable(FileSystem& files, const std::string& path)
{
  if (IsAddress(path))
  {
    // By its name it is a folder or a file: so what else it may be is hardly ever asked for.
    const std::string extension = FindExtension(path);
    const bool isFolder = extension.empty() || extension == ".zarr" || extension == ".n5";
    if (isFolder && IsZarrFolder(files, path))
    {
      return Status::Ok();
    }
    const Status status = files.OpenForReading(path).GetStatus();
    if (status.IsOk() || (!isFolder && IsZarrFolder(files, path)))
    {
      return Status::Ok();
    }
    return status.GetCode() != StatusCode::NotFound || !isFolder
      ? status
      : Status(StatusCode::NotFound,
          status.GetMessage() +
            ", nor metadata of Zarr or N5 in it; nobody can list what a server has: name an array, "
            "an image or a file");
  }
  const auto names = files.List(path);
  const std::string header = FindNiftiHeader(path);
  std::error_code error;
  return names.IsOk() || !files.Exists(header)   ? Status::Ok()
    : std::filesystem::is_directory(path, error) ? names.GetStatus()
                                                 : files.OpenForReading(header).GetStatus();
}

std::vector<std::string> FindStepFiles(
  FileSystem& files, const std::string& pattern, PassedOver* over)
{
  Names paths;
  if (!IsPattern(files, pattern))
  {
    return paths;
  }
  const Names fitting = FindFittingNames(files, pattern, over);
  std::vector<NumberedName> names(fitting.begin(), fitting.end());
  std::stable_sort(names.begin(), names.end());
  const VolumeFormat* first = nullptr;
  for (const NumberedName& name : names)
  {
    const std::string path = (std::filesystem::path(FindFolder(pattern)) / name.Name).string();
    const VolumeFormat* const format = FindVolumeFormat(files, { path, "" });
    first = first ? first : format;
    if (first && (first->Name == DicomName || first->Name == TiffName))
    {
      return {}; // slices
    }
    if (format && format == first)
    {
      paths.push_back(path);
    }
    else if (over)
    {
      over->Add("of another kind", path);
    }
  }
  return paths;
}

} // namespace isosurface
