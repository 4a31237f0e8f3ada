// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/Tiff/TiffStack.h"

#include "Formats/Source/TextFields.h"

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <optional>
#include <utility>

namespace isosurface
{
namespace
{

/// "*" stands for any characters, "?" for one.
bool FitsPattern(const std::string& name, const std::string& pattern)
{
  std::size_t at = 0;
  std::size_t of = 0;
  std::size_t star = std::string::npos;
  std::size_t afterStar = 0;
  while (at < name.size())
  {
    if (of < pattern.size() && pattern[of] == '*')
    {
      star = of++;
      afterStar = at;
    }
    else if (of < pattern.size() && (pattern[of] == '?' || pattern[of] == name[at]))
    {
      ++of;
      ++at;
    }
    else if (star != std::string::npos)
    {
      of = star + 1;
      at = ++afterStar;
    }
    else
    {
      return false;
    }
  }
  return pattern.find_first_not_of('*', of) == std::string::npos;
}

bool IsDigit(char letter)
{
  return std::isdigit(static_cast<unsigned char>(letter)) != 0;
}

/// A name cut into text, number, text, number, ...
struct NameParts
{
  std::vector<std::string> Texts;
  std::vector<std::string> Numbers; ///< without leading zeros

  explicit NameParts(const std::string& name)
  {
    std::size_t at = 0;
    while (at < name.size())
    {
      const std::size_t digits = static_cast<std::size_t>(
        std::find_if(name.begin() + static_cast<std::ptrdiff_t>(at), name.end(), IsDigit) -
        name.begin());
      std::size_t end = digits;
      while (end < name.size() && IsDigit(name[end]))
      {
        ++end;
      }
      this->Texts.push_back(name.substr(at, digits - at));
      const std::string number = name.substr(digits, end - digits);
      const std::size_t zeros = std::min(number.find_first_not_of('0'), number.size());
      this->Numbers.push_back(number.substr(zeros));
      at = end;
    }
  }

  bool operator<(const NameParts& other) const
  {
    const std::size_t count = std::min(this->Texts.size(), other.Texts.size());
    for (std::size_t part = 0; part < count; ++part)
    {
      const std::string& a = this->Numbers[part];
      const std::string& b = other.Numbers[part];
      if (this->Texts[part] != other.Texts[part])
      {
        return this->Texts[part] < other.Texts[part];
      }
      if (a != b)
      {
        return a.size() != b.size() ? a.size() < b.size() : a < b;
      }
    }
    return this->Texts.size() < other.Texts.size();
  }
};

/// The index of the number in which the names differ, if it is only one.
std::optional<std::size_t> FindCounter(const std::vector<NameParts>& names)
{
  std::optional<std::size_t> counter;
  for (const NameParts& name : names)
  {
    if (name.Texts != names.front().Texts)
    {
      return std::nullopt;
    }
    for (std::size_t part = 0; part < name.Numbers.size(); ++part)
    {
      if (name.Numbers[part] != names.front().Numbers[part] && counter.value_or(part) != part)
      {
        return std::nullopt;
      }
      if (name.Numbers[part] != names.front().Numbers[part])
      {
        counter = part;
      }
    }
  }
  return counter;
}

/// Checks that the numbers of a series increase by equal steps.
Status CheckSteps(const std::vector<std::string>& paths, const std::vector<NameParts>& names)
{
  const auto counter = FindCounter(names);
  std::vector<std::int64_t> numbers;
  for (std::size_t file = 0; counter && file < names.size(); ++file)
  {
    const std::string& text = names[file].Numbers[*counter];
    const auto number = ParseInteger(text.empty() ? "0" : text);
    if (!number)
    {
      return Status::Ok(); // a time or a hash instead of the number of a slice
    }
    numbers.push_back(*number);
  }
  for (std::size_t file = 2; file < numbers.size(); ++file)
  {
    if (numbers[file] - numbers[file - 1] != numbers[1] - numbers[0])
    {
      return Status(StatusCode::Corrupt,
        paths[file] + ": a slice of the series is missing, or there is one too many: number " +
          std::to_string(numbers[file]) + " follows " + std::to_string(numbers[file - 1]) +
          ", but the series begins with " + std::to_string(numbers[0]) + ", " +
          std::to_string(numbers[1]));
    }
  }
  return Status::Ok();
}

} // namespace

Result<std::vector<std::string>> FindTiffStack(FileSystem& files, const std::string& path)
{
  const bool isPattern = IsNamePattern(path);
  if (!isPattern && ListNames(files, path).empty())
  {
    return std::vector<std::string>{ path };
  }
  const std::filesystem::path whole(path);
  const std::string folder = !isPattern ? path
    : whole.has_parent_path()           ? whole.parent_path().string()
                                        : ".";
  const auto found = files.List(folder);
  ISOSURFACE_RETURN_IF_ERROR(found.GetStatus());
  std::vector<std::pair<NameParts, std::string>> names;
  for (const std::string& name : *found)
  {
    if (isPattern ? FitsPattern(name, whole.filename().string()) : IsTiffName(name))
    {
      names.emplace_back(NameParts(name), name);
    }
  }
  if (names.empty())
  {
    return Status(
      StatusCode::NotFound, path + ": there are no TIFF files of this name, or in this folder");
  }
  std::stable_sort(
    names.begin(), names.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<std::string> paths;
  std::vector<NameParts> parts;
  for (auto& name : names)
  {
    paths.push_back((std::filesystem::path(folder) / name.second).string());
    parts.push_back(std::move(name.first));
  }
  ISOSURFACE_RETURN_IF_ERROR(CheckSteps(paths, parts));
  return paths;
}

} // namespace isosurface
