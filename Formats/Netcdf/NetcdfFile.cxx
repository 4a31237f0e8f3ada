// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/Netcdf/NetcdfFile.h"

#include "Formats/Hdf5/Hdf5File.h"
#include "Formats/Hdf5/Hdf5Handle.h"
#include "Formats/Netcdf/NetcdfClassicHeader.h"
#include "Ground/Base/FileSystem.h"

#include <netcdf.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace isosurface
{
namespace
{

/// Serialises calls of the library, which is not protected against threads. Version 4 of the format is
/// HDF5, whose library is one for both, with one lock.
using NetcdfScope = Hdf5Scope;

constexpr std::pair<int, ValueType> Types[] = { { NC_BYTE, ValueType::Int8 },
  { NC_UBYTE, ValueType::UInt8 }, { NC_SHORT, ValueType::Int16 }, { NC_USHORT, ValueType::UInt16 },
  { NC_INT, ValueType::Int32 }, { NC_UINT, ValueType::UInt32 }, { NC_INT64, ValueType::Int64 },
  { NC_UINT64, ValueType::UInt64 }, { NC_FLOAT, ValueType::Float32 },
  { NC_DOUBLE, ValueType::Float64 } };

std::optional<ValueType> FindType(nc_type type)
{
  const auto* const found = std::find_if(
    std::begin(Types), std::end(Types), [type](const auto& known) { return known.first == type; });
  return found == std::end(Types) ? std::nullopt : std::optional<ValueType>(found->second);
}

/// Integers of the classic format are signed; an attribute says that they are not.
ValueType MakeUnsigned(ValueType type)
{
  switch (type)
  {
    case ValueType::Int8:
      return ValueType::UInt8;
    case ValueType::Int16:
      return ValueType::UInt16;
    case ValueType::Int32:
      return ValueType::UInt32;
    case ValueType::Int64:
      return ValueType::UInt64;
    default:
      return type;
  }
}

std::optional<std::string> GetText(int group, int variable, const char* attribute)
{
  nc_type type = NC_NAT;
  std::size_t size = 0;
  constexpr std::size_t longest = 4096;
  if (::nc_inq_att(group, variable, attribute, &type, &size) != NC_NOERR || size > longest)
  {
    return std::nullopt;
  }
  if (type == NC_STRING && size == 1)
  {
    char* text = nullptr;
    if (::nc_get_att_string(group, variable, attribute, &text) != NC_NOERR || !text)
    {
      return std::nullopt;
    }
    std::string result(text);
    ::nc_free_string(1, &text);
    return result;
  }
  std::string text(size, '\0');
  if (type != NC_CHAR || ::nc_get_att_text(group, variable, attribute, text.data()) != NC_NOERR)
  {
    return std::nullopt;
  }
  return text.substr(0, text.find('\0'));
}

std::string DescribeStorage(int group, int variable, std::size_t rank)
{
  int storage = NC_CONTIGUOUS;
  std::vector<std::size_t> sizes(std::max<std::size_t>(1, rank));
  if (::nc_inq_var_chunking(group, variable, &storage, sizes.data()) != NC_NOERR ||
    storage != NC_CHUNKED)
  {
    return "contiguous";
  }
  int isShuffled = 0;
  int isDeflated = 0;
  int level = 0;
  ::nc_inq_var_deflate(group, variable, &isShuffled, &isDeflated, &level);
  return "chunks of " + JoinNumbers({ sizes.begin(), sizes.end() }) +
    (isDeflated != 0 ? ", deflate" : "");
}

NetcdfVariable Describe(int group, int number, const std::string& path)
{
  NetcdfVariable variable;
  variable.Group = group;
  variable.Variable = number;
  char name[NC_MAX_NAME + 1] = {};
  nc_type type = NC_NAT;
  int rank = 0;
  ::nc_inq_var(group, number, name, &type, &rank, nullptr, nullptr);
  std::vector<int> dimensions(static_cast<std::size_t>(std::max(rank, 1)));
  ::nc_inq_vardimid(group, number, dimensions.data());
  dimensions.resize(static_cast<std::size_t>(rank));
  variable.Path = path + name;
  for (const int dimension : dimensions)
  {
    char text[NC_MAX_NAME + 1] = {};
    std::size_t size = 0;
    ::nc_inq_dim(group, dimension, text, &size);
    variable.Dimensions.emplace_back(text);
    variable.Shape.push_back(static_cast<std::int64_t>(size));
  }
  variable.Type = FindType(type);
  if (variable.Type && GetText(group, number, "_Unsigned").value_or("") == "true")
  {
    variable.Type = MakeUnsigned(*variable.Type);
  }
  char typeName[NC_MAX_NAME + 1] = {};
  ::nc_inq_type(group, type, typeName, nullptr);
  variable.TypeName = variable.Type ? GetValueTypeName(*variable.Type) : typeName;
  variable.Storage = DescribeStorage(group, number, variable.Shape.size());
  return variable;
}

/// The library follows all links of version 4 as it opens a file, however deep, and looks at nothing
/// before.
Status CheckLinks(const std::string& path)
{
  const auto file = Hdf5File::Open(path);
  if (file.IsOk())
  {
    return file->CheckForOthers();
  }
  return Status::Ok(); // the library tells what is wrong
}

int ReadBox(const NetcdfVariable& of, const std::vector<std::size_t>& low,
  const std::vector<std::size_t>& size, std::uint8_t* to)
{
  const int group = of.Group;
  const int variable = of.Variable;
  // As the samples are: their type in the file, in the byte order of the machine.
  return ::nc_get_vara(group, variable, low.data(), size.data(), to);
}

} // namespace

bool NetcdfVariable::IsCoordinate() const
{
  return this->Dimensions.size() == 1 &&
    this->Path.substr(this->Path.rfind('/') + 1) == this->Dimensions[0];
}

struct NetcdfFile::Handle
{
  explicit Handle(int number)
    : Number(number)
  {
  }
  Handle(const Handle&) = delete;
  Handle& operator=(const Handle&) = delete;
  ~Handle()
  {
    const NetcdfScope scope;
    ::nc_close(this->Number);
  }

  int Number;
};

/// A variable that is read by boxes.
class NetcdfFile::Array : public StoredArray
{
public:
  Array(const NetcdfFile& file, NetcdfVariable variable, Numbers chunk, std::uint64_t cacheBytes,
    std::uint64_t heldBytes)
    : File(file)
    , Variable(std::move(variable))
    , Name(file.Path + ":" + this->Variable.Path)
    , Chunk(std::move(chunk))
    , CacheBytes(cacheBytes)
    , HeldBytes(heldBytes)
  {
  }

  const std::string& GetName() const override { return this->Name; }
  const Numbers& GetShape() const override { return this->Variable.Shape; }
  ValueType GetType() const override { return *this->Variable.Type; }
  Numbers GetChunk() const override { return this->Chunk; }
  std::uint64_t GetCacheBytes() const override { return this->CacheBytes; }
  std::uint64_t GetHeldBytes() const override { return this->HeldBytes; }

  Status Read(const Numbers& low, const Numbers& size, std::uint8_t* to) override
  {
    const NetcdfScope scope;
    const int code =
      ReadBox(this->Variable, { low.begin(), low.end() }, { size.begin(), size.end() }, to);
    return code == NC_NOERR
      ? Status::Ok()
      : this->File.MakeError(StatusCode::Corrupt, this->Variable, ::nc_strerror(code));
  }

private:
  NetcdfFile File;
  NetcdfVariable Variable;
  std::string Name;
  Numbers Chunk;
  std::uint64_t CacheBytes;
  std::uint64_t HeldBytes;
};

Result<NetcdfFile> NetcdfFile::Open(const std::string& path)
{
  ISOSURFACE_RETURN_IF_ERROR(GetLocalFileSystem().CheckRegular(path, "read"));
  ISOSURFACE_RETURN_IF_ERROR(GetLocalFileSystem().OpenForReading(path).GetStatus());
  ISOSURFACE_RETURN_IF_ERROR(CheckNetcdfClassicSize(GetLocalFileSystem(), path, ""));
  ISOSURFACE_RETURN_IF_ERROR(CheckLinks(path));
  const NetcdfScope scope;
  int number = 0;
  const int code = ::nc_open(path.c_str(), NC_NOWRITE, &number);
  if (code != NC_NOERR)
  {
    return Status(StatusCode::Corrupt,
      path + ": cannot be read as NetCDF, is damaged or truncated: " + ::nc_strerror(code));
  }
  NetcdfFile file;
  file.Path = path;
  file.File = std::make_shared<Handle>(number);
  file.AddVariables(number, "");
  return file;
}

void NetcdfFile::AddVariables(int group, const std::string& path)
{
  int count = 0;
  ::nc_inq_nvars(group, &count);
  for (int number = 0; number < count; ++number)
  {
    this->Variables.push_back(Describe(group, number, path));
  }
  int groups = 0;
  ::nc_inq_grps(group, &groups, nullptr);
  std::vector<int> numbers(static_cast<std::size_t>(std::max(groups, 1)));
  ::nc_inq_grps(group, &groups, numbers.data());
  numbers.resize(static_cast<std::size_t>(groups));
  for (const int inner : numbers)
  {
    char name[NC_MAX_NAME + 1] = {};
    ::nc_inq_grpname(inner, name);
    this->AddVariables(inner, path + name + "/");
  }
}

const NetcdfVariable* NetcdfFile::FindVariable(const std::string& path) const
{
  const std::string plain = path.substr(std::min(path.find_first_not_of('/'), path.size()));
  const auto found = std::find_if(this->Variables.begin(), this->Variables.end(),
    [&plain](const NetcdfVariable& variable) { return variable.Path == plain; });
  return found == this->Variables.end() ? nullptr : &*found;
}

const NetcdfVariable* NetcdfFile::FindCoordinate(const NetcdfVariable& of, std::size_t axis) const
{
  std::size_t slash = of.Path.rfind('/');
  while (true)
  {
    const std::string group = slash == std::string::npos ? "" : of.Path.substr(0, slash + 1);
    const NetcdfVariable* found = this->FindVariable(group + of.Dimensions[axis]);
    if (found || group.empty())
    {
      return found && found->IsCoordinate() && found != &of ? found : nullptr;
    }
    slash = slash == 0 ? std::string::npos : of.Path.rfind('/', slash - 1);
  }
}

std::optional<std::string> NetcdfFile::ReadText(
  const NetcdfVariable& variable, const std::string& attribute) const
{
  const NetcdfScope scope;
  return GetText(variable.Group, variable.Variable, attribute.c_str());
}

bool NetcdfFile::HasAttribute(const NetcdfVariable& variable, const std::string& attribute) const
{
  const NetcdfScope scope;
  return ::nc_inq_att(variable.Group, variable.Variable, attribute.c_str(), nullptr, nullptr) ==
    NC_NOERR;
}

std::optional<double> NetcdfFile::ReadNumber(
  const NetcdfVariable& variable, const std::string& attribute, ValueType* type) const
{
  const NetcdfScope scope;
  nc_type stored = NC_NAT;
  std::size_t size = 0;
  double number = 0;
  if (::nc_inq_att(variable.Group, variable.Variable, attribute.c_str(), &stored, &size) !=
      NC_NOERR ||
    size != 1 || !FindType(stored) ||
    ::nc_get_att_double(variable.Group, variable.Variable, attribute.c_str(), &number) != NC_NOERR)
  {
    return std::nullopt;
  }
  if (type)
  {
    *type = *FindType(stored);
  }
  return number;
}

Result<std::vector<double>> NetcdfFile::ReadNumbers(const NetcdfVariable& variable) const
{
  constexpr std::int64_t most = std::int64_t{ 1 } << 24;
  // A number of 64 bits has become negative.
  if (!variable.Type || variable.Shape.size() != 1 || variable.Shape[0] < 0 ||
    variable.Shape[0] > most)
  {
    return this->MakeError(StatusCode::Unsupported, variable, "it is no list of coordinates");
  }
  ISOSURFACE_RETURN_IF_ERROR(
    CheckNetcdfClassicSize(GetLocalFileSystem(), this->Path, variable.Path));
  const double scale = this->ReadNumber(variable, "scale_factor").value_or(1);
  const double offset = this->ReadNumber(variable, "add_offset").value_or(0);
  const NetcdfScope scope;
  nc_type stored = NC_NAT;
  ::nc_inq_vartype(variable.Group, variable.Variable, &stored);
  // What the library gives as negative numbers.
  const double wrap = FindType(stored) == variable.Type
    ? 0
    : std::ldexp(1.0, static_cast<int>(8 * GetValueSize(*variable.Type)));
  std::vector<double> numbers(static_cast<std::size_t>(variable.Shape[0]));
  const int code = ::nc_get_var_double(variable.Group, variable.Variable, numbers.data());
  if (code != NC_NOERR)
  {
    return this->MakeError(StatusCode::Corrupt, variable, ::nc_strerror(code));
  }
  for (double& number : numbers)
  {
    number = (number < 0 ? number + wrap : number) * scale + offset;
  }
  return numbers;
}

Status NetcdfFile::MakeError(
  StatusCode code, const NetcdfVariable& variable, const std::string& reason) const
{
  return Status(code, this->Path + ":" + variable.Path + ": cannot be read: " + reason);
}

Result<std::shared_ptr<StoredArray>> NetcdfFile::OpenArray(
  const NetcdfVariable& variable, std::uint64_t cacheBytes) const
{
  if (!variable.Type)
  {
    return this->MakeError(
      StatusCode::Unsupported, variable, "its type, " + variable.TypeName + ", is none of numbers");
  }
  ISOSURFACE_RETURN_IF_ERROR(
    CheckNetcdfClassicSize(GetLocalFileSystem(), this->Path, variable.Path));
  const NetcdfScope scope;
  int storage = NC_CONTIGUOUS;
  std::vector<std::size_t> sizes(std::max<std::size_t>(1, variable.Shape.size()));
  std::uint64_t held = std::uint64_t{ 4 } << 20; // the library's buffers
  StoredArray::Numbers chunk;
  std::uint64_t kept = 0;
  if (::nc_inq_var_chunking(variable.Group, variable.Variable, &storage, sizes.data()) ==
      NC_NOERR &&
    storage == NC_CHUNKED)
  {
    const ChunkCacheSize cache = FindChunkCacheSize(
      variable.Shape, { sizes.begin(), sizes.end() }, GetValueSize(*variable.Type), cacheBytes);
    ::nc_set_var_chunk_cache(variable.Group, variable.Variable, cache.Bytes, cache.Slots, 0.75F);
    held += cache.HeldBytes;
    kept = cache.Bytes;
    chunk.assign(sizes.begin(), sizes.end());
  }
  return std::shared_ptr<StoredArray>(
    std::make_shared<Array>(*this, variable, std::move(chunk), kept, held));
}

} // namespace isosurface
