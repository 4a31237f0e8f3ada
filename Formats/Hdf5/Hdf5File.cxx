// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/Hdf5/Hdf5File.h"

#include "Formats/Hdf5/Hdf5LinkedFiles.h"
#include "Formats/Hdf5/Hdf5Walk.h"
#include "Ground/Base/FileSystem.h"

#include <algorithm>
#include <filesystem>
#include <system_error>
#include <utility>

namespace isosurface
{
namespace
{

std::string DescribeFilters(hid_t plist)
{
  std::string text;
  const int count = ::H5Pget_nfilters(plist);
  for (int number = 0; number < count; ++number)
  {
    char name[64] = {};
    unsigned flags = 0;
    unsigned config = 0;
    std::size_t values = 0;
    const H5Z_filter_t filter = ::H5Pget_filter2(
      plist, static_cast<unsigned>(number), &flags, &values, nullptr, sizeof(name), name, &config);
    text += std::string(", ") + (name[0] ? name : "filter " + std::to_string(filter));
    if (::H5Zfilter_avail(filter) <= 0)
    {
      text += " (which this library lacks)";
    }
  }
  return text;
}

} // namespace

Result<Hdf5File> Hdf5File::Open(const std::string& path)
{
  ISOSURFACE_RETURN_IF_ERROR(GetLocalFileSystem().CheckRegular(path, "read"));
  // The system's own words for what cannot be opened at all.
  const auto bytes = GetLocalFileSystem().OpenForReading(path);
  ISOSURFACE_RETURN_IF_ERROR(bytes.GetStatus());
  const Hdf5Scope scope;
  Hdf5Handle file(::H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), ::H5Fclose);
  if (!file.IsOpen())
  {
    return Status(StatusCode::Corrupt, path + ": cannot be read as HDF5: " + FindHdf5Reason());
  }
  Hdf5File opened;
  opened.Path = path;
  opened.Links = std::make_shared<Hdf5LinkedFiles>();
  opened.File = std::make_shared<Hdf5Handle>(std::move(file));
  return opened;
}

Status Hdf5File::MakeError(
  StatusCode code, const std::string& object, const std::string& reason) const
{
  return Status(code, this->Path + ":" + object + ": cannot be read: " + reason);
}

Result<std::vector<Hdf5Dataset>> Hdf5File::FindDatasets() const
{
  const Hdf5Scope scope;
  std::vector<Hdf5Dataset> datasets;
  Hdf5LinkedFiles links; // of datasets that are not opened for reading
  const auto note = [&](const Hdf5Handle& dataset, const std::string& path)
  {
    datasets.push_back(this->Describe(dataset, path, links));
    return Status::Ok();
  };
  const Status status = Hdf5Walk::VisitOnce(*this->File, links, note);
  return status.IsOk() ? Result<std::vector<Hdf5Dataset>>(std::move(datasets))
                       : Status(status.GetCode(), this->Path + ":" + status.GetMessage());
}

Hdf5Dataset Hdf5File::Describe(
  const Hdf5Handle& dataset, const std::string& path, Hdf5LinkedFiles& links) const
{
  const Hdf5Handle type(::H5Dget_type(dataset.Get()), ::H5Tclose);
  const Hdf5Handle plist(::H5Dget_create_plist(dataset.Get()), ::H5Pclose);
  Hdf5Dataset entry;
  entry.Path = path;
  entry.Type = DescribeHdf5Type(type.Get());
  entry.IsNumeric = FindHdf5ValueType(type.Get()).has_value();
  const bool isVirtual = ::H5Pget_layout(plist.Get()) == H5D_VIRTUAL;
  // The shape may be that of other files, which the library then opens.
  const Status status = isVirtual ? links.Check(dataset) : Status::Ok();
  if (!status.IsOk())
  {
    entry.Refusal = this->MakeError(status.GetCode(), path, status.GetMessage()).GetMessage();
    entry.Storage = "virtual, refused";
    return entry;
  }
  entry.Shape = FindHdf5Shape(dataset);
  const StoredArray::Numbers chunk = FindHdf5Chunk(plist, entry.Shape.size());
  entry.Storage = isVirtual                    ? "virtual"
    : ::H5Pget_external_count(plist.Get()) > 0 ? "in files of their own"
    : chunk.empty()                            ? "contiguous"
                                               : "chunks of " + JoinNumbers(chunk);
  entry.Storage += DescribeFilters(plist.Get());
  return entry;
}

Status Hdf5File::CheckForOthers() const
{
  const Hdf5Scope scope;
  Hdf5LinkedFiles links;
  const auto check = [&links](const Hdf5Handle& dataset, const std::string& path)
  {
    // They would look for external storage elsewhere than OpenArray() does.
    const Status status = links.Check(dataset, 1);
    return status.IsOk()
      ? status
      : Status(status.GetCode(), path + ": cannot be read: " + status.GetMessage());
  };
  const Status status = Hdf5Walk::VisitAll(*this->File, links, check);
  return status.IsOk() ? status : Status(status.GetCode(), this->Path + ":" + status.GetMessage());
}

std::vector<std::string> Hdf5File::FindFiles() const
{
  const Hdf5Scope scope;
  std::vector<std::string> files = { this->Path };
  std::error_code error;
  const std::string own = std::filesystem::weakly_canonical(this->Path, error).string();
  for (const std::string& file : this->Links->GetFiles())
  {
    if (file != own)
    {
      files.push_back(file);
    }
  }
  return files;
}

bool Hdf5File::Has(const std::string& path) const
{
  const Hdf5Scope scope;
  H5O_info_t info = {};
  return this->Links->FindObject(this->File->Get(), path, info);
}

bool Hdf5File::IsDataset(const std::string& path) const
{
  const Hdf5Scope scope;
  H5O_info_t info = {};
  return this->Links->FindObject(this->File->Get(), path, info) && info.type == H5O_TYPE_DATASET;
}

std::optional<std::string> Hdf5File::ReadText(
  const std::string& object, const std::string& name) const
{
  const Hdf5Scope scope;
  const Hdf5Handle attribute(::H5Aopen_by_name(this->File->Get(), object.c_str(), name.c_str(),
                               H5P_DEFAULT, this->Links->GetAccess()),
    ::H5Aclose);
  const Hdf5Handle type(attribute.IsOpen() ? ::H5Aget_type(attribute.Get()) : -1, ::H5Tclose);
  const Hdf5Handle space(attribute.IsOpen() ? ::H5Aget_space(attribute.Get()) : -1, ::H5Sclose);
  if (!type.IsOpen() || !space.IsOpen() || ::H5Tget_class(type.Get()) != H5T_STRING ||
    ::H5Sget_simple_extent_npoints(space.Get()) != 1)
  {
    return std::nullopt;
  }
  if (::H5Tis_variable_str(type.Get()) > 0)
  {
    char* text = nullptr;
    if (::H5Aread(attribute.Get(), type.Get(), &text) < 0 || !text)
    {
      return std::nullopt;
    }
    std::string result(text);
    ::H5free_memory(text);
    return result;
  }
  constexpr std::size_t longest = 4096;
  std::string text(std::min(::H5Tget_size(type.Get()), longest), '\0');
  if (::H5Tget_size(type.Get()) > longest ||
    ::H5Aread(attribute.Get(), type.Get(), text.data()) < 0)
  {
    return std::nullopt;
  }
  return text.substr(0, text.find('\0'));
}

std::optional<std::vector<double>> Hdf5File::ReadNumbers(
  const std::string& object, const std::string& name, std::size_t count) const
{
  const Hdf5Scope scope;
  const Hdf5Handle attribute(::H5Aopen_by_name(this->File->Get(), object.c_str(), name.c_str(),
                               H5P_DEFAULT, this->Links->GetAccess()),
    ::H5Aclose);
  const Hdf5Handle type(attribute.IsOpen() ? ::H5Aget_type(attribute.Get()) : -1, ::H5Tclose);
  const Hdf5Handle space(attribute.IsOpen() ? ::H5Aget_space(attribute.Get()) : -1, ::H5Sclose);
  if (!type.IsOpen() || !space.IsOpen() || !FindHdf5ValueType(type.Get()) ||
    ::H5Sget_simple_extent_npoints(space.Get()) != static_cast<hssize_t>(count))
  {
    return std::nullopt;
  }
  std::vector<double> numbers(count);
  if (::H5Aread(attribute.Get(), H5T_NATIVE_DOUBLE, numbers.data()) < 0)
  {
    return std::nullopt;
  }
  return numbers;
}

std::vector<std::string> Hdf5File::FindAttributes(const std::string& object) const
{
  const Hdf5Scope scope;
  std::vector<std::string> names;
  const auto note = [](hid_t, const char* name, const H5A_info_t*, void* to) -> herr_t
  {
    static_cast<std::vector<std::string>*>(to)->push_back(name);
    return 0;
  };
  hsize_t at = 0;
  ::H5Aiterate_by_name(this->File->Get(), object.c_str(), H5_INDEX_NAME, H5_ITER_INC, &at, note,
    &names, this->Links->GetAccess());
  return names;
}

std::vector<std::string> Hdf5File::FindNames(const std::string& group) const
{
  const Hdf5Scope scope;
  std::vector<std::string> names;
  const auto note = [](hid_t, const char* name, const H5L_info_t*, void* to) -> herr_t
  {
    static_cast<std::vector<std::string>*>(to)->push_back(name);
    return 0;
  };
  hsize_t at = 0;
  ::H5Literate_by_name(this->File->Get(), group.c_str(), H5_INDEX_NAME, H5_ITER_INC, &at, note,
    &names, this->Links->GetAccess());
  return names;
}

} // namespace isosurface
