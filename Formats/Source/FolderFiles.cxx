// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/Source/FolderFiles.h"

#include "Formats/Source/TextFields.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cstdint>
#include <filesystem>
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

} // namespace

void PassedOver::Add(const std::string& reason, const std::string& path)
{
  auto found = std::find_if(this->Groups.begin(), this->Groups.end(),
    [&reason](const Group& group) { return group.Reason == reason; });
  if (found == this->Groups.end())
  {
    const std::string name = std::filesystem::path(path).filename().string();
    found = this->Groups.insert(found, { reason, 0, name });
  }
  ++found->Count;
}

std::string PassedOver::GetText() const
{
  std::string text;
  for (const Group& group : this->Groups)
  {
    text += (text.empty() ? "passed over: " : ", ") + std::to_string(group.Count) + " " +
      group.Reason + " (" + group.First + (group.Count > 1 ? ", ...)" : ")");
  }
  return text;
}

bool IsHiddenName(const std::string& name)
{
  const std::string lower = LowerText(name);
  return name.rfind('.', 0) == 0 || lower == "thumbs.db" || lower == "desktop.ini" ||
    lower == "__macosx";
}

bool IsAppleDouble(FileSystem& files, const std::string& path)
{
  const auto file = files.OpenForReading(path);
  std::array<std::uint8_t, 4> start{};
  return file.IsOk() && (*file)->GetSize() >= start.size() &&
    (*file)->Read(0, start.size(), start.data()).IsOk() && start[0] == 0 && start[1] == 5 &&
    start[2] == 0x16 && (start[3] == 0 || start[3] == 7);
}

std::string FindFolder(const std::string& path)
{
  const std::filesystem::path folder = std::filesystem::path(path).parent_path();
  return folder.empty() ? "." : folder.string();
}

bool IsPattern(FileSystem& files, const std::string& path)
{
  return IsNamePattern(path) && !files.Exists(path);
}

std::vector<std::string> FindFittingNames(
  FileSystem& files, const std::string& pattern, PassedOver* over)
{
  const std::string last = std::filesystem::path(pattern).filename().string();
  std::vector<std::string> names;
  for (std::string& name : ListNames(files, FindFolder(pattern)))
  {
    if (!FitsPattern(name, last))
    {
      continue;
    }
    if (!IsHiddenName(name) || last[0] == '.')
    {
      names.push_back(std::move(name));
    }
    else if (over)
    {
      over->Add("hidden", name);
    }
  }
  return names;
}

NumberedName::NumberedName(std::string name)
  : Name(std::move(name))
{
  std::size_t at = 0;
  while (at < this->Name.size())
  {
    const std::size_t digits =
      static_cast<std::size_t>(std::find_if(this->Name.begin() + static_cast<std::ptrdiff_t>(at),
                                 this->Name.end(), IsDigit) -
        this->Name.begin());
    std::size_t end = digits;
    while (end < this->Name.size() && IsDigit(this->Name[end]))
    {
      ++end;
    }
    this->Texts.push_back(this->Name.substr(at, digits - at));
    const std::string number = this->Name.substr(digits, end - digits);
    const std::size_t zeros = std::min(number.find_first_not_of('0'), number.size());
    this->Numbers.push_back(number.substr(zeros));
    at = end;
  }
}

bool NumberedName::operator<(const NumberedName& other) const
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

std::string FindExtension(const std::string& path)
{
  const std::size_t end = path.find_last_not_of('/');
  const std::filesystem::path file(path.substr(0, end == std::string::npos ? 0 : end + 1));
  const std::string extension = LowerText(file.extension().string());
  return extension == ".gz" ? LowerText(file.stem().extension().string()) + extension : extension;
}

bool IsNamePattern(const std::string& path)
{
  return !IsAddress(path) &&
    std::filesystem::path(path).filename().string().find_first_of("*?") != std::string::npos;
}

std::vector<std::string> ListNames(FileSystem& files, const std::string& folder)
{
  auto names = files.List(folder);
  return names.IsOk() ? std::move(*names) : std::vector<std::string>();
}

} // namespace isosurface
