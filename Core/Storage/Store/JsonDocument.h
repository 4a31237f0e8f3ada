// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_JsonDocument_h
#define isosurface_JsonDocument_h

#include "Ground/Base/Status.h"

#include <nlohmann/json_fwd.hpp>

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace isosurface
{

/// Complete only where <nlohmann/json.hpp> is included: in the sources that format or parse a
/// document, since it is slow to compile.
using Json = nlohmann::json;

/// Whether a text is UTF-8, so that a document can hold it.
bool IsUtf8(const std::string& text);

/**
 * The text of an object with the member "checksum" appended: XXH3-64 of all bytes of the text
 * before the opening quote of that member's name. So it does not depend on how numbers are written,
 * and any language can check it without parsing.
 */
std::string FormatDocument(Json object);

/**
 * Reads what FormatDocument wrote. The depth of nesting is checked before anything recursive sees
 * the document. Errors name `path`: Corrupt (no JSON object, another "format", a wrong checksum),
 * Unsupported (a "formatVersion" above `version`). `shortened`: the text without some parts that
 * the caller has read, but for which it says the same; may be null.
 */
Result<Json> ParseDocument(const std::string& text, const std::string& path,
  const std::string& format, std::int64_t version, const std::string* shortened = nullptr);

/// Reads the members of an object whose contents are not trusted. After the first error every
/// function returns a harmless value; the error (Corrupt) names file and member.
class JsonMembers
{
public:
  /// `object` and `status` must outlive this; `where` is the object's name, as in "grid.", or "".
  JsonMembers(const Json& object, std::string path, std::string where, Status& status);

  bool IsOk() const { return this->Error.IsOk(); }
  void Fail(const std::string& member, const std::string& reason);

  bool Has(const char* member) const;
  /// The members of a member that is an object.
  JsonMembers GetObject(const char* member);
  std::int64_t GetInteger(const char* member, std::int64_t minimum, std::int64_t maximum);
  std::uint64_t GetUnsigned(const char* member);
  double GetNumber(const char* member);
  std::string GetString(const char* member);
  std::uint64_t GetChecksum(const char* member);
  /// `count` checksums, the digits of which follow each other.
  std::vector<std::uint64_t> GetChecksums(const char* member, std::size_t count);
  /// An array of `size` elements, or of any number if size is AnySize.
  const Json& GetArray(const char* member, std::size_t size);
  /// Any value; an error if the member is missing.
  const Json& GetAny(const char* member);
  /// Calls read(members) for each element of an array member, until an error.
  void Visit(const char* member, std::size_t size, const std::function<void(JsonMembers&)>& read);

  static constexpr std::size_t AnySize = static_cast<std::size_t>(-1);

private:
  const Json& Object;
  std::string Path;
  std::string Where;
  Status& Error;
};

} // namespace isosurface

#endif
