// SPDX-License-Identifier: BSD-3-Clause
#include "Storage/Store/JsonDocument.h"

#include "Ground/Base/Checksum.h"
#include "Ground/Base/JsonDepth.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

namespace isosurface
{
namespace
{

constexpr int MaximumDepth = 16;
constexpr const char* ChecksumMember = "checksum";
constexpr const char* ChecksumName = "\"checksum\"";

const Json Nothing;
const Json EmptyArray = Json::array();

/// Whether the last member of the text is the checksum of the bytes before it.
bool HasChecksum(const std::string& text)
{
  const std::size_t covered = text.rfind(ChecksumName);
  const std::size_t quote =
    covered == std::string::npos ? covered : text.find('"', covered + std::strlen(ChecksumName));
  return quote != std::string::npos &&
    text.compare(quote + 1, 16, FormatChecksum(ComputeChecksum(text.data(), covered))) == 0;
}

/// Whether the text from `covered` on is the last member and the end of the object, and nothing
/// else: what the checksum does not cover must not say anything.
bool IsPlainEnd(const std::string& text, std::size_t covered)
{
  std::size_t at = covered;
  const auto take = [&](const std::string& expected)
  {
    const bool isThere = text.compare(at, expected.size(), expected) == 0;
    at += isThere ? expected.size() : 0;
    return isThere;
  };
  const auto skip = [&](const char* characters)
  { at = std::min(text.find_first_not_of(characters, at), text.size()); };
  constexpr const char* space = " \t\r\n";
  bool isPlain = take(ChecksumName);
  skip(space);
  isPlain = isPlain && take(":");
  skip(space);
  isPlain = isPlain && take("\"");
  skip("0123456789abcdef");
  isPlain = isPlain && take("\"");
  skip(space);
  isPlain = isPlain && take("}");
  take("\r");
  take("\n");
  return isPlain && at == text.size();
}

} // namespace

bool IsUtf8(const std::string& text)
{
  // Formatting leaves out the bytes that are not UTF-8, so only UTF-8 is read back unchanged.
  return Json::parse(Json(text).dump(-1, ' ', false, Json::error_handler_t::ignore)) == Json(text);
}

std::string FormatDocument(Json object)
{
  object.erase(ChecksumMember);
  std::string text = object.dump(1, ' ', false, Json::error_handler_t::replace);
  // Replace the final line break and brace by one more member.
  text.resize(text.size() - 2);
  text += ",\n ";
  const std::uint64_t checksum = ComputeChecksum(text.data(), text.size());
  return text + ChecksumName + ": \"" + FormatChecksum(checksum) + "\"\n}\n";
}

Result<Json> ParseDocument(const std::string& text, const std::string& path,
  const std::string& format, std::int64_t version, const std::string* shortened)
{
  // A large text is not worth the work of parsing unless its checksum is right; of a small one,
  // what is wrong can be said more clearly.
  constexpr std::size_t small = std::size_t{ 1 } << 20;
  if (text.size() > small && !HasChecksum(text))
  {
    return Status(StatusCode::Corrupt, path + ": has a wrong checksum");
  }
  const std::string& parsed = shortened ? *shortened : text;
  Json document =
    IsJsonDeeperThan(parsed, MaximumDepth) ? Json() : Json::parse(parsed, nullptr, false);
  if (document.is_discarded() || !document.is_object())
  {
    return Status(StatusCode::Corrupt, path + ": was cut off, or is not a " + format);
  }
  Status status;
  JsonMembers members(document, path, "", status);
  const std::string found = members.GetString("format");
  if (members.IsOk() && found != format)
  {
    members.Fail("format", "is not \"" + format + "\"");
  }
  const std::int64_t foundVersion =
    members.GetInteger("formatVersion", 1, std::numeric_limits<std::int64_t>::max());
  if (members.IsOk() && foundVersion > version)
  {
    return Status(StatusCode::Unsupported,
      path + ": has format version " + std::to_string(foundVersion) + ", this program knows " +
        std::to_string(version) + " at most; please update it");
  }
  const std::uint64_t expected = members.GetChecksum(ChecksumMember);
  ISOSURFACE_RETURN_IF_ERROR(status);
  // The member is there, and quotes inside strings are escaped, so this finds its name.
  const std::size_t covered = text.rfind(ChecksumName);
  if (covered == std::string::npos || ComputeChecksum(text.data(), covered) != expected)
  {
    return Status(StatusCode::Corrupt, path + ": has a wrong checksum");
  }
  if (!IsPlainEnd(text, covered))
  {
    return Status(StatusCode::Corrupt, path + ": has something behind its checksum");
  }
  document.erase(ChecksumMember);
  return document;
}

JsonMembers::JsonMembers(const Json& object, std::string path, std::string where, Status& status)
  : Object(object)
  , Path(std::move(path))
  , Where(std::move(where))
  , Error(status)
{
}

void JsonMembers::Fail(const std::string& member, const std::string& reason)
{
  if (this->Error.IsOk())
  {
    this->Error =
      Status(StatusCode::Corrupt, this->Path + ": member " + this->Where + member + " " + reason);
  }
}

const Json& JsonMembers::GetAny(const char* member)
{
  if (!this->Has(member))
  {
    this->Fail(member, "is missing");
    return Nothing;
  }
  return *this->Object.find(member);
}

bool JsonMembers::Has(const char* member) const
{
  return this->Object.is_object() && this->Object.find(member) != this->Object.end();
}

JsonMembers JsonMembers::GetObject(const char* member)
{
  return JsonMembers(this->GetAny(member), this->Path, this->Where + member + ".", this->Error);
}

std::int64_t JsonMembers::GetInteger(const char* member, std::int64_t minimum, std::int64_t maximum)
{
  const Json& value = this->GetAny(member);
  const bool isTooLarge = value.is_number_unsigned() &&
    value.get<std::uint64_t>() >
      static_cast<std::uint64_t>(std::numeric_limits<std::int64_t>::max());
  const std::int64_t number =
    value.is_number_integer() && !isTooLarge ? value.get<std::int64_t>() : 0;
  if (!value.is_number_integer() || isTooLarge || number < minimum || number > maximum)
  {
    this->Fail(member,
      "is not an integer from " + std::to_string(minimum) + " to " + std::to_string(maximum));
    return minimum;
  }
  return number;
}

std::uint64_t JsonMembers::GetUnsigned(const char* member)
{
  const Json& value = this->GetAny(member);
  if (!value.is_number_unsigned())
  {
    this->Fail(member, "is not a whole number of at most 64 bits");
    return 0;
  }
  return value.get<std::uint64_t>();
}

double JsonMembers::GetNumber(const char* member)
{
  const Json& value = this->GetAny(member);
  if (!value.is_number() || !std::isfinite(value.get<double>()))
  {
    this->Fail(member, "is not a number");
    return 0;
  }
  return value.get<double>();
}

std::string JsonMembers::GetString(const char* member)
{
  const Json& value = this->GetAny(member);
  if (!value.is_string())
  {
    this->Fail(member, "is not a string");
    return {};
  }
  return value.get<std::string>();
}

std::uint64_t JsonMembers::GetChecksum(const char* member)
{
  return this->GetChecksums(member, 1).front();
}

std::vector<std::uint64_t> JsonMembers::GetChecksums(const char* member, std::size_t count)
{
  constexpr std::size_t digits = 16;
  const std::string text = this->GetString(member);
  std::vector<std::uint64_t> checksums(count);
  bool areDigits = text.size() == count * digits;
  for (std::size_t index = 0; areDigits && index < count; ++index)
  {
    areDigits = ParseChecksum(text.data() + index * digits, checksums[index]);
  }
  if (!areDigits)
  {
    this->Fail(member,
      (count == 1 ? "is not a number of " : "is not " + std::to_string(count) + " numbers of ") +
        std::to_string(digits) + " hexadecimal digits");
  }
  return checksums;
}

const Json& JsonMembers::GetArray(const char* member, std::size_t size)
{
  const Json& value = this->GetAny(member);
  if (!value.is_array() || (size != AnySize && value.size() != size))
  {
    this->Fail(
      member, size == AnySize ? "is not an array" : "is not an array of " + std::to_string(size));
    return EmptyArray;
  }
  return value;
}

void JsonMembers::Visit(
  const char* member, std::size_t size, const std::function<void(JsonMembers&)>& read)
{
  const Json& array = this->GetArray(member, size);
  for (std::size_t index = 0; index < array.size() && this->IsOk(); ++index)
  {
    JsonMembers element(array[index], this->Path,
      this->Where + member + "[" + std::to_string(index) + "].", this->Error);
    read(element);
  }
}

} // namespace isosurface
