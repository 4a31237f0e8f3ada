// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/Hdf5/Hdf5LinkedFiles.h"

#include "Ground/Base/FileSystem.h"

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <sstream>
#include <system_error>

namespace isosurface
{
namespace
{

constexpr int MaximumDepth = 8;
constexpr std::size_t MaximumSources = 65536;
/// No system has longer paths.
constexpr std::size_t MaximumName = 4096;

std::filesystem::path MakeAbsolute(const std::filesystem::path& path)
{
  std::error_code error;
  const std::filesystem::path absolute = std::filesystem::absolute(path, error);
  return error ? path : absolute;
}

std::filesystem::path MakeCanonical(const std::filesystem::path& path)
{
  std::error_code error;
  const std::filesystem::path canonical = std::filesystem::weakly_canonical(path, error);
  return error ? path : canonical;
}

/// The file that has an object, by the name with which the library opened it.
std::filesystem::path FindFileName(const Hdf5Handle& object)
{
  std::string name(MaximumName, '\0');
  const ssize_t size = ::H5Fget_name(object.Get(), name.data(), name.size());
  name.resize(static_cast<std::size_t>(std::clamp<ssize_t>(size, 0, MaximumName - 1)));
  return MakeAbsolute(name);
}

/// What the user's environment says of where files are.
std::string FindPrefix(const char* variable, const std::filesystem::path& folder)
{
  const char* const value = std::getenv(variable); // NOLINT(concurrency-mt-unsafe): nobody sets it
  const std::string prefix = value ? value : "";
  const std::string origin = "${ORIGIN}";
  return prefix.compare(0, origin.size(), origin) == 0
    ? folder.string() + prefix.substr(origin.size())
    : prefix;
}

/// Where the library looks for a file that another one names, in its order: H5F_prefix_open_file.
std::vector<std::string> FindPlaces(const std::filesystem::path& parent, const std::string& child)
{
  std::filesystem::path name(child);
  std::vector<std::filesystem::path> places;
  if (name.is_absolute())
  {
    places.push_back(name);
    name = name.filename();
  }
  const std::filesystem::path folder = parent.parent_path();
  for (const char* variable : { "HDF5_EXT_PREFIX", "HDF5_VDS_PREFIX" })
  {
    const std::string prefix = FindPrefix(variable, folder);
    std::istringstream prefixes(prefix);
    for (std::string one; std::getline(prefixes, one, ':');)
    {
      places.push_back(one / name);
    }
    if (!prefix.empty())
    {
      places.push_back(prefix / name);
    }
  }
  places.push_back(folder / name);
  places.push_back(name);
  places.push_back(MakeCanonical(parent).parent_path() / name);
  std::vector<std::string> paths;
  for (const std::filesystem::path& place : places)
  {
    std::error_code error;
    if (!std::filesystem::is_directory(place, error)) // which the library cannot open
    {
      paths.push_back(place.string());
    }
  }
  return paths;
}

Status CheckPlaces(const std::vector<std::string>& places)
{
  for (const std::string& place : places)
  {
    ISOSURFACE_RETURN_IF_ERROR(GetLocalFileSystem().CheckRegular(place, "read"));
  }
  return Status::Ok();
}

/// Of the thread: an open dataset keeps the callback, perhaps for longer than who opened it first.
std::string& GetLastRefusal()
{
  thread_local std::string refusal;
  return refusal;
}

/// The library's callback before it follows an external link.
herr_t FollowLink(
  const char* parent, const char*, const char* child, const char*, unsigned*, hid_t, void*)
{
  const Status status =
    CheckPlaces(FindPlaces(MakeAbsolute(parent ? parent : ""), child ? child : ""));
  GetLastRefusal() = status.GetMessage();
  return status.IsOk() ? 0 : -1;
}

/// A name in the list of properties of a virtual dataset.
std::string FindName(ssize_t (*find)(hid_t, std::size_t, char*, std::size_t),
  const Hdf5Handle& plist, std::size_t number)
{
  const ssize_t size = find(plist.Get(), number, nullptr, 0);
  std::string name(static_cast<std::size_t>(std::max<ssize_t>(size, 0)) + 1, '\0');
  find(plist.Get(), number, name.data(), name.size());
  name.pop_back();
  return name;
}

/// "%b" in the name stands for a number, "%%" for a percent sign.
std::string FillPattern(const std::string& name, std::size_t number)
{
  std::string filled;
  for (std::size_t at = 0; at < name.size(); ++at)
  {
    const char next = name[at] == '%' && at + 1 < name.size() ? name[at + 1] : ' ';
    filled += next == 'b' ? std::to_string(number) : std::string(1, name[at]);
    at += next == 'b' || next == '%' ? 1 : 0;
  }
  return filled;
}

/// Whether the name stands for several: the "b" of "%%b" is a letter.
bool IsPattern(const std::string& name)
{
  return FillPattern(name, 0) != FillPattern(name, 1);
}

bool IsWithin(const std::filesystem::path& path, const std::filesystem::path& folder)
{
  const std::filesystem::path relative = path.lexically_relative(folder);
  return !relative.empty() && *relative.begin() != "..";
}

} // namespace

Hdf5LinkedFiles::Hdf5LinkedFiles()
  : Access(::H5Pcreate(H5P_DATASET_ACCESS), ::H5Pclose)
{
  ::H5Pset_elink_cb(this->Access.Get(), FollowLink, nullptr);
  this->ExternalAccess = Hdf5Handle(::H5Pcopy(this->Access.Get()), ::H5Pclose);
  ::H5Pset_efile_prefix(this->ExternalAccess.Get(), "${ORIGIN}");
}

const std::string& Hdf5LinkedFiles::GetRefusal()
{
  return GetLastRefusal();
}

bool Hdf5LinkedFiles::FindObject(hid_t at, const std::string& path, H5O_info_t& info)
{
  GetLastRefusal().clear();
  // Anything else would count the chunks.
  return ::H5Oget_info_by_name2(at, path.c_str(), &info, H5O_INFO_BASIC, this->Access.Get()) >= 0;
}

Hdf5Handle Hdf5LinkedFiles::OpenGroup(hid_t at, const std::string& path)
{
  GetLastRefusal().clear();
  return { ::H5Oopen(at, path.c_str(), this->Access.Get()), ::H5Oclose };
}

Hdf5Handle Hdf5LinkedFiles::OpenDataset(hid_t at, const std::string& path)
{
  GetLastRefusal().clear();
  Hdf5Handle dataset(::H5Dopen2(at, path.c_str(), this->Access.Get()), ::H5Dclose);
  bool isExternal = !dataset.IsOpen() && GetLastRefusal().empty(); // or missing
  if (dataset.IsOpen())
  {
    const Hdf5Handle plist(::H5Dget_create_plist(dataset.Get()), ::H5Pclose);
    isExternal = ::H5Pget_external_count(plist.Get()) > 0;
  }
  if (isExternal)
  {
    dataset = Hdf5Handle();
    dataset = Hdf5Handle(::H5Dopen2(at, path.c_str(), this->ExternalAccess.Get()), ::H5Dclose);
  }
  return dataset;
}

Status Hdf5LinkedFiles::Check(const Hdf5Handle& dataset, int depth)
{
  const Hdf5Handle plist(::H5Dget_create_plist(dataset.Get()), ::H5Pclose);
  const int count = ::H5Pget_external_count(plist.Get());
  if (count > 0 && depth > 0)
  {
    return Status(StatusCode::Unsupported,
      "its samples are in files without a format, which are not read of NetCDF, nor through "
      "virtual datasets");
  }
  std::uint64_t missingBytes = count > 0 ? ::H5Dget_storage_size(dataset.Get()) : 0;
  for (int number = 0; number < count; ++number)
  {
    ISOSURFACE_RETURN_IF_ERROR(
      this->CheckExternal(dataset, plist, static_cast<unsigned>(number), missingBytes));
  }
  if (::H5Pget_layout(plist.Get()) == H5D_VIRTUAL)
  {
    ISOSURFACE_RETURN_IF_ERROR(this->CheckVirtual(dataset, plist, depth));
  }
  this->Files.insert(MakeCanonical(FindFileName(dataset)).string());
  return Status::Ok();
}

Status Hdf5LinkedFiles::CheckExternal(
  const Hdf5Handle& dataset, const Hdf5Handle& plist, unsigned number, std::uint64_t& missingBytes)
{
  std::string name(MaximumName, '\0');
  off_t offset = 0;
  hsize_t size = 0;
  if (::H5Pget_external(plist.Get(), number, name.size(), name.data(), &offset, &size) < 0 ||
    name.back() != '\0' || offset < 0)
  {
    return Status(StatusCode::Corrupt, "it names an impossible external file");
  }
  name.resize(name.find('\0'));
  const std::filesystem::path folder = FindFileName(dataset).parent_path();
  const std::string prefix = FindPrefix("HDF5_EXTFILE_PREFIX", folder);
  const std::filesystem::path path =
    (prefix.empty() ? folder : std::filesystem::path(prefix)) / name;
  if (!IsWithin(MakeCanonical(path), MakeCanonical(folder)))
  {
    return Status(StatusCode::Unsupported,
      path.string() + ": its samples are outside of the folder of the file that names it");
  }
  ISOSURFACE_ASSIGN_OR_RETURN(const auto file, GetLocalFileSystem().OpenForReading(path.string()));
  // The library reads zeros where a truncated file has no bytes.
  const std::uint64_t bytes = std::min<std::uint64_t>(size, missingBytes);
  const std::uint64_t available =
    file->GetSize() - std::min(file->GetSize(), static_cast<std::uint64_t>(offset));
  if (available < bytes)
  {
    return Status(StatusCode::Corrupt,
      path.string() + ": is truncated: it has " + std::to_string(available) + " of " +
        std::to_string(bytes) + " bytes of samples");
  }
  missingBytes -= bytes;
  this->Files.insert(MakeCanonical(path).string());
  return Status::Ok();
}

Status Hdf5LinkedFiles::CheckVirtual(const Hdf5Handle& dataset, const Hdf5Handle& plist, int depth)
{
  if (depth == MaximumDepth)
  {
    return Status(StatusCode::Unsupported,
      "it is made of virtual datasets of virtual datasets, more than " +
        std::to_string(MaximumDepth) + " in one another");
  }
  std::size_t count = 0;
  ::H5Pget_virtual_count(plist.Get(), &count);
  for (std::size_t number = 0; number < count; ++number)
  {
    const std::string file = FindName(::H5Pget_virtual_filename, plist, number);
    const std::string object = FindName(::H5Pget_virtual_dsetname, plist, number);
    bool isFound = true;
    for (std::size_t block = 0; isFound; ++block)
    {
      ISOSURFACE_ASSIGN_OR_RETURN(const auto found,
        this->CheckSource(
          dataset, FillPattern(file, block), FillPattern(object, block), depth + 1));
      isFound = found && (IsPattern(file) || IsPattern(object));
    }
  }
  return Status::Ok();
}

/// Whether there is such a dataset: without it, the library takes the fill value.
Result<bool> Hdf5LinkedFiles::CheckSource(
  const Hdf5Handle& dataset, const std::string& file, const std::string& object, int depth)
{
  const std::filesystem::path parent = FindFileName(dataset);
  if (file == ".")
  {
    const Hdf5Handle same(::H5Iget_file_id(dataset.Get()), ::H5Fclose);
    return this->CheckSourceAt(same, parent.string(), object, depth);
  }
  const std::vector<std::string> places = FindPlaces(parent, file);
  ISOSURFACE_RETURN_IF_ERROR(CheckPlaces(places));
  for (const std::string& place : places)
  {
    const Hdf5Handle opened(::H5Fopen(place.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), ::H5Fclose);
    if (opened.IsOpen())
    {
      return this->CheckSourceAt(opened, place, object, depth);
    }
  }
  return false;
}

Result<bool> Hdf5LinkedFiles::CheckSourceAt(
  const Hdf5Handle& file, const std::string& place, const std::string& object, int depth)
{
  const std::string key = place + "\n" + object;
  const auto checked = this->Checked.find(key);
  if (checked != this->Checked.end() && checked->second >= depth)
  {
    return true;
  }
  if (this->Checked.size() == MaximumSources)
  {
    return Status(StatusCode::Unsupported,
      "it is a virtual dataset of more than " + std::to_string(MaximumSources) + " others");
  }
  const Hdf5Handle source = this->OpenDataset(file.Get(), object);
  if (!source.IsOpen())
  {
    return GetRefusal().empty() ? Result<bool>(false)
                                : Status(StatusCode::Unsupported, GetRefusal());
  }
  ISOSURFACE_RETURN_IF_ERROR(this->Check(source, depth));
  this->Checked[key] = depth;
  return true;
}

} // namespace isosurface
