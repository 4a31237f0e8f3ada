// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/Source/SliceFiles.h"

#include "Formats/Source/FolderFiles.h"
#include "Formats/Source/TextFields.h"

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <regex>
#include <utility>

namespace isosurface
{
namespace
{

std::string MakePath(const std::string& folder, const std::string& name)
{
  return (std::filesystem::path(folder) / name).string();
}

std::string FindKindOfName(const std::string& name)
{
  static const std::map<std::string, std::string> kinds = { { ".tif", "TIFF" }, { ".tiff", "TIFF" },
    { ".png", "PNG" }, { ".jpg", "JPEG" }, { ".jpeg", "JPEG" }, { ".bmp", "BMP" } };
  const auto found = kinds.find(FindExtension(name));
  return found == kinds.end() || IsHiddenName(name) ? "" : found->second;
}

/// The index of the number in which the names differ, if it is only one.
std::optional<std::size_t> FindCounter(const std::vector<NumberedName>& names)
{
  std::optional<std::size_t> counter;
  for (const NumberedName& name : names)
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

/// Checks that the numbers of a series increase by equal steps. Says so if these are not 1, or if there are
/// no such numbers.
Status CheckSteps(
  const std::string& folder, const std::vector<NumberedName>& names, std::string& note)
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
  if (!counter && names.size() > 1)
  {
    note = "the names differ in more than one number (" + names.front().Name + ", " +
      names.back().Name + "): all are slices of one volume, in the order of their names";
  }
  for (std::size_t file = 2; file < numbers.size(); ++file)
  {
    if (numbers[file] - numbers[file - 1] != numbers[1] - numbers[0])
    {
      return Status(StatusCode::Corrupt,
        MakePath(folder, names[file].Name) +
          ": a slice of the series is missing, or there is one too many: number " +
          std::to_string(numbers[file]) + " follows " + std::to_string(numbers[file - 1]) +
          ", but the series begins with " + std::to_string(numbers[0]) + ", " +
          std::to_string(numbers[1]));
    }
  }
  if (numbers.size() > 1 && numbers[1] - numbers[0] > 1)
  {
    note = "the numbers in the names go up by " + std::to_string(numbers[1] - numbers[0]);
  }
  return Status::Ok();
}

/// What a name would be that says it is a copy: of "a (1).tif", "a - Copy.tif" and "a copy 2.tif" "a.tif".
std::string FindOriginal(const std::string& name)
{
  static const std::regex copy(
    "( \\([0-9]+\\)| - Copy( \\([0-9]+\\))?| copy( [0-9]+)?)(\\.[^.]*)?$", std::regex::icase);
  return std::regex_replace(name, copy, "$4");
}

Result<bool> HaveSameBytes(FileSystem& files, const std::string& one, const std::string& other)
{
  ISOSURFACE_ASSIGN_OR_RETURN(const auto a, files.OpenForReading(one));
  ISOSURFACE_ASSIGN_OR_RETURN(const auto b, files.OpenForReading(other));
  const std::uint64_t size = a->GetSize();
  constexpr std::uint64_t most = 1 << 20;
  bool areSame = size == b->GetSize();
  std::string parts[2];
  for (std::uint64_t at = 0; areSame && at < size; at += most)
  {
    const auto count = static_cast<std::size_t>(std::min(most, size - at));
    parts[0].resize(count);
    parts[1].resize(count);
    ISOSURFACE_RETURN_IF_ERROR(a->Read(at, count, parts[0].data()));
    ISOSURFACE_RETURN_IF_ERROR(b->Read(at, count, parts[1].data()));
    areSame = parts[0] == parts[1];
  }
  return areSame;
}

/// Leaves out copies of other files, by their names and bytes. Error: one differs from its original.
Status LeaveOutCopies(
  FileSystem& files, const std::string& folder, std::vector<std::string>& names, PassedOver& over)
{
  std::vector<std::string> kept;
  for (const std::string& name : names)
  {
    const std::string original = FindOriginal(name);
    if (original == name || !std::binary_search(names.begin(), names.end(), original))
    {
      kept.push_back(name);
      continue;
    }
    ISOSURFACE_ASSIGN_OR_RETURN(
      const auto isCopy, HaveSameBytes(files, MakePath(folder, name), MakePath(folder, original)));
    if (!isCopy)
    {
      return Status(StatusCode::Corrupt,
        MakePath(folder, name) + ": is named as a copy of " + MakePath(folder, original) +
          " and differs from it: remove or rename one of both");
    }
    over.Add("copied", name);
  }
  names = std::move(kept);
  return Status::Ok();
}

} // namespace

std::string SliceFiles::FindKind(const std::vector<std::string>& names)
{
  std::string most;
  std::map<std::string, std::size_t> counts;
  for (const char* kind : { "BMP", "JPEG", "PNG", "TIFF" })
  {
    counts[kind] = static_cast<std::size_t>(std::count_if(names.begin(), names.end(),
      [kind](const std::string& name) { return FindKindOfName(name) == kind; }));
    most = counts[kind] > 0 && counts[kind] >= counts[most] ? kind : most;
  }
  return most;
}

Result<SliceFiles> SliceFiles::Find(FileSystem& files, const std::string& path)
{
  PassedOver over;
  const bool isPattern = IsPattern(files, path);
  if (!isPattern && ListNames(files, path).empty())
  {
    return SliceFiles{ "TIFF", { path }, "" };
  }
  const std::string folder = isPattern ? FindFolder(path) : path;
  ISOSURFACE_ASSIGN_OR_RETURN(const auto found, files.List(folder));
  const std::vector<std::string> all = isPattern ? FindFittingNames(files, path, &over) : found;
  SliceFiles slices;
  slices.Kind = FindKind(all);
  const bool areAll = isPattern && slices.Kind.empty(); // TIFF without its extension
  slices.Kind = areAll ? "TIFF" : slices.Kind;
  std::vector<std::string> names;
  for (const std::string& name : all)
  {
    const bool isSlice = areAll || (!slices.Kind.empty() && FindKindOfName(name) == slices.Kind);
    if (!isPattern && IsHiddenName(name))
    {
      over.Add("hidden", name);
    }
    else if (!isSlice || IsAppleDouble(files, MakePath(folder, name)))
    {
      over.Add("of another kind", name);
    }
    else
    {
      names.push_back(name);
    }
  }
  ISOSURFACE_RETURN_IF_ERROR(LeaveOutCopies(files, folder, names, over));
  slices.LeftOut = over.GetText();
  if (names.empty())
  {
    return Status(StatusCode::NotFound,
      path + ": cannot be read: " +
        (isPattern ? "there are no files of this name"
                   : "there are no slices of DICOM, TIFF, PNG, JPEG or BMP in this folder") +
        (slices.LeftOut.empty() ? "" : "; " + slices.LeftOut));
  }
  std::vector<NumberedName> numbered(names.begin(), names.end());
  std::stable_sort(numbered.begin(), numbered.end());
  std::string note;
  ISOSURFACE_RETURN_IF_ERROR(CheckSteps(folder, numbered, note));
  slices.LeftOut += (slices.LeftOut.empty() || note.empty() ? "" : "; ") + note;
  for (const NumberedName& name : numbered)
  {
    slices.Paths.push_back(MakePath(folder, name.Name));
  }
  return slices;
}

} // namespace isosurface
