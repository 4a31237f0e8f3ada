// SPDX-License-Identifier: BSD-3-Clause
#include "Storage/Store/StoreLists.h"

#include "Ground/Base/Checksum.h"

#include <charconv>
#include <cstddef>
#include <cstring>
#include <string_view>
#include <system_error>
#include <utility>

namespace isosurface
{
namespace
{

constexpr std::size_t ChecksumDigits = 16;

/// Reads a list from its first bracket on. Each function returns whether it has found what it is
/// named after.
class ListScanner
{
public:
  ListScanner(const char* begin, const char* end)
    : At(begin)
    , End(end)
  {
  }

  bool TakeList(std::vector<StoreDescription>& stores)
  {
    if (!this->Take("["))
    {
      return false;
    }
    if (this->Take("]"))
    {
      return true;
    }
    do
    {
      if (!this->TakeStore(stores.emplace_back()))
      {
        return false;
      }
    } while (this->Take(","));
    return this->Take("]");
  }

  const char* GetPlace() const { return this->At; }

private:
  bool TakeStore(StoreDescription& store)
  {
    return this->Take("{") && this->Take("\"blocks\":") && this->TakeNumber(store.Blocks) &&
      this->Take(",") && this->Take("\"bytes\":") && this->TakeNumber(store.Bytes) &&
      this->Take(",") && this->Take("\"checksum\":") && this->Take("\"") &&
      this->TakeChecksum(store.Checksum) && this->Take("\"") &&
      (!this->Take(",") || this->TakeSeals(store.Seals)) && this->Take("}");
  }

  bool TakeSeals(std::vector<std::uint64_t>& seals)
  {
    if (!this->Take("\"seals\":") || !this->Take("\""))
    {
      return false;
    }
    const char* digits = this->At;
    while (digits != this->End && *digits != '"')
    {
      ++digits;
    }
    seals.resize(static_cast<std::size_t>(digits - this->At) / ChecksumDigits);
    for (std::uint64_t& seal : seals)
    {
      if (!this->TakeChecksum(seal))
      {
        return false;
      }
    }
    return !seals.empty() && this->Take("\"");
  }

  void SkipSpaces()
  {
    while (this->At != this->End &&
      (*this->At == ' ' || *this->At == '\n' || *this->At == '\t' || *this->At == '\r'))
    {
      ++this->At;
    }
  }

  /// After spaces. A literal, so that the comparison is not a call.
  template <std::size_t Size>
  bool Take(const char (&expected)[Size])
  {
    constexpr std::size_t length = Size - 1;
    this->SkipSpaces();
    const bool isThere = static_cast<std::size_t>(this->End - this->At) >= length &&
      std::memcmp(this->At, expected, length) == 0;
    this->At += isThere ? length : 0;
    return isThere;
  }

  /// A whole number as JSON has it. What follows it is looked at by the next step.
  bool TakeNumber(std::uint64_t& number)
  {
    this->SkipSpaces();
    const char* const first = this->At;
    const auto parsed = std::from_chars(first, this->End, number);
    this->At = parsed.ptr;
    return parsed.ec == std::errc() && (*first != '0' || parsed.ptr == first + 1);
  }

  bool TakeChecksum(std::uint64_t& checksum)
  {
    const auto size = static_cast<std::size_t>(this->End - this->At);
    const bool isThere = size >= ChecksumDigits && ParseChecksum(this->At, checksum);
    this->At += isThere ? ChecksumDigits : 0;
    return isThere;
  }

  const char* At;
  const char* const End;
};

} // namespace

std::optional<StoreLists> CutStoreLists(const std::string& text)
{
  constexpr std::string_view name = "\"stores\"";
  constexpr std::string_view beforeList = ": [";
  StoreLists cut;
  std::size_t kept = 0; // the text up to here is in the rest
  for (std::size_t at = text.find(name); at != std::string::npos; at = text.find(name, at))
  {
    at += name.size();
    const bool isNumber =
      text.compare(at, 2, ": ") == 0 && text[at + 2] >= '0' && text[at + 2] <= '9';
    if (isNumber)
    {
      continue;
    }
    if (text.compare(at, beforeList.size(), beforeList) != 0)
    {
      return std::nullopt;
    }
    const std::size_t first = at + beforeList.size() - 1;
    ListScanner scanner(text.data() + first, text.data() + text.size());
    if (!scanner.TakeList(cut.Lists.emplace_back()))
    {
      return std::nullopt;
    }
    cut.Rest.append(text, kept, first - kept);
    cut.Rest += "[" + std::to_string(cut.Lists.size() - 1) + "]";
    at = kept = static_cast<std::size_t>(scanner.GetPlace() - text.data());
  }
  cut.Rest.append(text, kept);
  // Names with escaped characters might be those of lists, too.
  return cut.Rest.find('\\') == std::string::npos ? std::optional<StoreLists>(std::move(cut))
                                                  : std::nullopt;
}

} // namespace isosurface
