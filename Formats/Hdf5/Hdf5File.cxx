// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/Hdf5/Hdf5File.h"

#include "Formats/Hdf5/Hdf5LinkedFiles.h"
#include "Ground/Base/FileSystem.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cstddef>
#include <filesystem>
#include <functional>
#include <set>
#include <system_error>
#include <utility>

namespace isosurface
{
namespace
{

constexpr std::size_t MaximumObjectsOfList = 10000;
/// Programs may open as many within seconds.
constexpr std::size_t MaximumObjects = 100000;

/**
 * Goes through the groups of a file, by name. Each group is opened from the one around it: the
 * library would look up every path from the start, which takes minutes for thousands of groups in
 * one another. The lock is held.
 */
class Hdf5Walk
{
public:
  static constexpr std::size_t MaximumDepth = 32; ///< of groups in one another
  /// Has a dataset, and its path. An error ends the walk.
  using Visitor = std::function<Status(const Hdf5Handle& dataset, const std::string& path)>;

  /// Visits each dataset once, whatever the cycles, and no other file. What is deeper than
  /// MaximumDepth, or behind the first 10,000 objects, is left out.
  static Status VisitOnce(const Hdf5Handle& file, Hdf5LinkedFiles& links, const Visitor& visit)
  {
    Hdf5Walk walk(links, visit, true);
    H5O_info_t info = {};
    if (links.FindObject(file.Get(), "/", info))
    {
      walk.Known.insert(info.addr);
    }
    return walk.EnterGroup(links.OpenGroup(file.Get(), "/"));
  }

  /// Visits each dataset by every path, through all links: as a program does that knows no cycles.
  /// Error: what is refused, of which that program has to be kept away; it begins with a path.
  static Status VisitAll(const Hdf5Handle& file, Hdf5LinkedFiles& links, const Visitor& visit)
  {
    return Hdf5Walk(links, visit, false).EnterGroup(links.OpenGroup(file.Get(), "/"));
  }

private:
  Hdf5Walk(Hdf5LinkedFiles& links, const Visitor& visit, bool isOnce)
    : Links(links)
    , Visit(visit)
    , IsOnce(isOnce)
  {
  }

  static herr_t Enter(hid_t group, const char* name, const H5L_info_t* info, void* walk)
  {
    auto* self = static_cast<Hdf5Walk*>(walk);
    const std::size_t size = self->Path.size();
    self->Path += std::string("/") + name;
    self->Outcome = self->EnterObject(group, name, info->type);
    self->Path.resize(size);
    return !self->Outcome.IsOk() || (self->IsOnce && self->Objects > MaximumObjectsOfList) ? 1 : 0;
  }

  Status EnterGroup(const Hdf5Handle& group)
  {
    hsize_t at = 0;
    ++this->Depth;
    const herr_t code =
      ::H5Literate(group.Get(), H5_INDEX_NAME, H5_ITER_INC, &at, Hdf5Walk::Enter, this);
    --this->Depth;
    return code >= 0 ? this->Outcome : this->MakeError(StatusCode::Corrupt, FindHdf5Reason());
  }

  Status EnterObject(hid_t group, const std::string& name, H5L_type_t link)
  {
    ++this->Objects;
    if (this->IsOnce && (link != H5L_TYPE_HARD || this->Objects > MaximumObjectsOfList))
    {
      return Status::Ok();
    }
    if (this->Objects > MaximumObjects)
    {
      return this->MakeError(StatusCode::Unsupported,
        "the file has more than " + std::to_string(MaximumObjects) + " objects");
    }
    H5O_info_t info = {};
    if (!this->Links.FindObject(group, name, info))
    {
      const std::string& refusal = Hdf5LinkedFiles::GetRefusal();
      return !refusal.empty() ? this->MakeError(StatusCode::Unsupported, refusal)
        : this->IsOnce        ? this->MakeError(StatusCode::Corrupt, FindHdf5Reason())
                              : Status::Ok(); // a link to nothing
    }
    return this->IsOnce && !this->Known.insert(info.addr).second
      ? Status::Ok()
      : this->EnterKind(group, name, info.type);
  }

  Status EnterKind(hid_t group, const std::string& name, H5O_type_t kind)
  {
    if (kind == H5O_TYPE_DATASET)
    {
      const Hdf5Handle dataset = this->Links.OpenDataset(group, name);
      return dataset.IsOpen() ? this->Visit(dataset, this->Path)
                              : this->MakeError(StatusCode::Corrupt, FindHdf5Reason());
    }
    if (kind != H5O_TYPE_GROUP)
    {
      return Status::Ok();
    }
    if (this->Depth < MaximumDepth)
    {
      return this->EnterGroup(this->Links.OpenGroup(group, name));
    }
    return this->IsOnce
      ? Status::Ok()
      : this->MakeError(StatusCode::Unsupported,
          "its groups are in one another, deeper than " + std::to_string(MaximumDepth));
  }

  Status MakeError(StatusCode code, const std::string& reason) const
  {
    return Status(code, (this->Path.empty() ? "/" : this->Path) + ": cannot be read: " + reason);
  }

  Hdf5LinkedFiles& Links;
  const Visitor& Visit;
  bool IsOnce;
  std::size_t Objects = 0;
  std::size_t Depth = 0;
  std::string Path;
  std::set<haddr_t> Known; ///< addresses of objects
  Status Outcome = Status::Ok();
};

/// A number, or a list of at most 4096; null of other attributes.
nlohmann::json DescribeNumbers(const Hdf5Handle& attribute)
{
  const Hdf5Handle type(attribute.IsOpen() ? ::H5Aget_type(attribute.Get()) : -1, ::H5Tclose);
  const Hdf5Handle space(attribute.IsOpen() ? ::H5Aget_space(attribute.Get()) : -1, ::H5Sclose);
  const hssize_t count = space.IsOpen() ? ::H5Sget_simple_extent_npoints(space.Get()) : 0;
  if (!type.IsOpen() || count < 1 || count > 4096 || !FindHdf5ValueType(type.Get()))
  {
    return nullptr;
  }
  const auto read = [&](auto zero, hid_t as) -> nlohmann::json
  {
    std::vector<decltype(zero)> numbers(static_cast<std::size_t>(count));
    if (::H5Aread(attribute.Get(), as, numbers.data()) < 0)
    {
      return nullptr;
    }
    const bool isList = ::H5Sget_simple_extent_ndims(space.Get()) > 0;
    return isList ? nlohmann::json(numbers) : nlohmann::json(numbers.front());
  };
  return ::H5Tget_class(type.Get()) == H5T_FLOAT ? read(0.0, H5T_NATIVE_DOUBLE)
    : ::H5Tget_sign(type.Get()) == H5T_SGN_NONE  ? read(std::uint64_t{ 0 }, H5T_NATIVE_UINT64)
                                                 : read(std::int64_t{ 0 }, H5T_NATIVE_INT64);
}

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

Result<Hdf5File> Hdf5File::Open(const std::string& path, bool decodesChunks)
{
  ISOSURFACE_RETURN_IF_ERROR(GetLocalFileSystem().CheckRegular(path, "read"));
  // The system's own words for what cannot be opened at all.
  ISOSURFACE_ASSIGN_OR_RETURN(const auto bytes, GetLocalFileSystem().OpenForReading(path));
  const Hdf5Scope scope;
  Hdf5Handle file(::H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), ::H5Fclose);
  if (!file.IsOpen())
  {
    char start[11] = {};
    const bool isOld = bytes->GetSize() >= sizeof(start) &&
      bytes->Read(0, sizeof(start) - 1, start).IsOk() && std::string(start) == "MATLAB 5.0";
    return isOld
      ? Status(StatusCode::Unsupported,
          path + ": cannot be read: it is a MAT-file of version 5; MATLAB writes HDF5 with -v7.3")
      : Status(StatusCode::Corrupt, path + ": cannot be read as HDF5: " + FindHdf5Reason());
  }
  Hdf5File opened;
  opened.Path = path;
  opened.DecodesChunks = decodesChunks;
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

std::vector<std::string> Hdf5File::ReadTexts(
  const std::string& object, const std::string& name) const
{
  const Hdf5Scope scope;
  const Hdf5Handle attribute(::H5Aopen_by_name(this->File->Get(), object.c_str(), name.c_str(),
                               H5P_DEFAULT, this->Links->GetAccess()),
    ::H5Aclose);
  const Hdf5Handle type(attribute.IsOpen() ? ::H5Aget_type(attribute.Get()) : -1, ::H5Tclose);
  const Hdf5Handle space(attribute.IsOpen() ? ::H5Aget_space(attribute.Get()) : -1, ::H5Sclose);
  constexpr std::size_t most = 4096; // texts, and letters of each
  if (!type.IsOpen() || !space.IsOpen() || ::H5Tget_class(type.Get()) != H5T_STRING ||
    ::H5Sget_simple_extent_npoints(space.Get()) < 1 ||
    ::H5Sget_simple_extent_npoints(space.Get()) > static_cast<hssize_t>(most))
  {
    return {};
  }
  const auto count = static_cast<std::size_t>(::H5Sget_simple_extent_npoints(space.Get()));
  std::vector<std::string> texts;
  if (::H5Tis_variable_str(type.Get()) > 0)
  {
    std::vector<char*> found(count, nullptr);
    if (::H5Aread(attribute.Get(), type.Get(), found.data()) < 0)
    {
      return {};
    }
    for (const char* text : found)
    {
      texts.emplace_back(text ? text : "");
    }
    ::H5Dvlen_reclaim(type.Get(), space.Get(), H5P_DEFAULT, found.data());
    return texts;
  }
  const std::size_t size = ::H5Tget_size(type.Get());
  std::string letters(size <= most ? size * count : 0, '\0');
  if (letters.empty() || ::H5Aread(attribute.Get(), type.Get(), letters.data()) < 0)
  {
    return {};
  }
  for (std::size_t text = 0; text < count; ++text)
  {
    const std::string padded = letters.substr(text * size, size);
    texts.push_back(padded.substr(0, padded.find('\0')));
  }
  return texts;
}

std::optional<std::string> Hdf5File::ReadText(
  const std::string& object, const std::string& name) const
{
  const std::vector<std::string> texts = this->ReadTexts(object, name);
  std::string joined;
  for (const std::string& text : texts)
  {
    if (texts.size() > 1 && text.size() > 1)
    {
      return std::nullopt; // several texts
    }
    joined += text;
  }
  return texts.empty() ? std::nullopt : std::optional<std::string>(joined);
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

Result<std::vector<double>> Hdf5File::ReadList(
  const std::string& path, std::int64_t most, std::size_t axes) const
{
  ISOSURFACE_ASSIGN_OR_RETURN(const auto list, this->OpenArray(path, 0));
  const StoredArray::Numbers shape = list->GetShape();
  std::int64_t count = shape.size() == axes ? 1 : 0;
  for (const std::int64_t size : shape)
  {
    count = size >= 1 && count <= most / size ? count * size : 0;
  }
  if (count == 0)
  {
    return this->MakeError(
      StatusCode::Corrupt, path, "it is no list of 1 to " + std::to_string(most) + " numbers");
  }
  return DispatchValueType(list->GetType(),
    [&](auto zero) -> Result<std::vector<double>>
    {
      std::vector<decltype(zero)> stored(static_cast<std::size_t>(count));
      ISOSURFACE_RETURN_IF_ERROR(list->Read(
        StoredArray::Numbers(axes), shape, reinterpret_cast<std::uint8_t*>(stored.data())));
      std::vector<double> numbers(stored.size());
      std::transform(stored.begin(), stored.end(), numbers.begin(),
        [](auto number) { return static_cast<double>(number); });
      return numbers;
    });
}

std::vector<std::string> Hdf5File::FindScales(const std::string& path) const
{
  const Hdf5Scope scope;
  const Hdf5Handle attribute(::H5Aopen_by_name(this->File->Get(), path.c_str(), "DIMENSION_LIST",
                               H5P_DEFAULT, this->Links->GetAccess()),
    ::H5Aclose);
  const Hdf5Handle type(attribute.IsOpen() ? ::H5Aget_type(attribute.Get()) : -1, ::H5Tclose);
  const Hdf5Handle space(attribute.IsOpen() ? ::H5Aget_space(attribute.Get()) : -1, ::H5Sclose);
  const Hdf5Handle base(type.IsOpen() ? ::H5Tget_super(type.Get()) : -1, ::H5Tclose);
  const hssize_t count = space.IsOpen() ? ::H5Sget_simple_extent_npoints(space.Get()) : 0;
  if (count < 1 || count > H5S_MAX_RANK || ::H5Tget_class(type.Get()) != H5T_VLEN ||
    !base.IsOpen() || ::H5Tequal(base.Get(), H5T_STD_REF_OBJ) <= 0)
  {
    return {};
  }
  std::vector<hvl_t> lists(static_cast<std::size_t>(count));
  if (::H5Aread(attribute.Get(), type.Get(), lists.data()) < 0)
  {
    return {};
  }
  std::vector<std::string> paths;
  for (const hvl_t& list : lists)
  {
    char name[1024] = {};
    const ssize_t size = list.len > 0 && list.p
      ? ::H5Rget_name(attribute.Get(), H5R_OBJECT, list.p, name, sizeof(name))
      : 0;
    paths.push_back(size > 0 && static_cast<std::size_t>(size) < sizeof(name) ? name : "");
  }
  ::H5Dvlen_reclaim(type.Get(), space.Get(), H5P_DEFAULT, lists.data());
  return paths;
}

std::string Hdf5File::FindNumberNames(const std::string& path) const
{
  const Hdf5Scope scope;
  const Hdf5Handle dataset = this->Links->OpenDataset(this->File->Get(), path);
  const Hdf5Handle type(dataset.IsOpen() ? ::H5Dget_type(dataset.Get()) : -1, ::H5Tclose);
  return type.IsOpen() ? DescribeHdf5Names(type.Get()) : "";
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

std::string Hdf5File::DescribeAttributes(const std::string& object) const
{
  const Hdf5Scope scope;
  nlohmann::json attributes = nlohmann::json::object();
  for (const std::string& name : this->FindAttributes(object))
  {
    const std::vector<std::string> texts = this->ReadTexts(object, name);
    const Hdf5Handle attribute(::H5Aopen_by_name(this->File->Get(), object.c_str(), name.c_str(),
                                 H5P_DEFAULT, this->Links->GetAccess()),
      ::H5Aclose);
    attributes[name] = texts.empty() ? DescribeNumbers(attribute)
      : texts.size() > 1             ? nlohmann::json(texts)
                                     : nlohmann::json(texts.front());
  }
  return attributes.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
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
