// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_NetcdfFile_h
#define isosurface_NetcdfFile_h

#include "Formats/Source/StoredArray.h"

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace isosurface
{

/// A variable in a NetCDF file.
struct NetcdfVariable
{
  std::string Path; ///< with the names of its groups, without a leading slash
  int Group = 0;    ///< the library's numbers
  int Variable = 0;
  StoredArray::Numbers Shape;
  std::vector<std::string> Dimensions; ///< names
  std::optional<ValueType> Type;       ///< none: text, or a type of the user
  std::string TypeName;
  std::string Storage;

  /// Whether it gives the coordinates of a dimension.
  bool IsCoordinate() const;
};

/// A NetCDF file, classic or version 4, open for reading on the local file system. Errors name the
/// file, the variable and the reason, with the library's words.
class NetcdfFile
{
public:
  static Result<NetcdfFile> Open(const std::string& path);

  /// All variables of all groups, those of a group before those of the groups in it.
  const std::vector<NetcdfVariable>& GetVariables() const { return this->Variables; }
  const NetcdfVariable* FindVariable(const std::string& path) const;
  /// The variable that has the name of a dimension, in the group of `of` or in one around it.
  const NetcdfVariable* FindCoordinate(const NetcdfVariable& of, std::size_t axis) const;

  std::optional<std::string> ReadText(
    const NetcdfVariable& variable, const std::string& attribute) const;
  bool HasAttribute(const NetcdfVariable& variable, const std::string& attribute) const;
  /// A lone number. `type`, if not null, is set to its type.
  std::optional<double> ReadNumber(
    const NetcdfVariable& variable, const std::string& attribute, ValueType* type = nullptr) const;
  /// The samples of a variable of one axis, unpacked: "_Unsigned", "scale_factor", "add_offset".
  Result<std::vector<double>> ReadNumbers(const NetcdfVariable& variable) const;

  /// The samples of a variable with a type. At most `cacheBytes` keep decoded chunks.
  Result<std::shared_ptr<StoredArray>> OpenArray(
    const NetcdfVariable& variable, std::uint64_t cacheBytes) const;

  Status MakeError(
    StatusCode code, const NetcdfVariable& variable, const std::string& reason) const;

private:
  class Array;
  struct Handle;

  void AddVariables(int group, const std::string& path);

  std::string Path;
  std::shared_ptr<Handle> File;
  std::vector<NetcdfVariable> Variables;
};

} // namespace isosurface

#endif
