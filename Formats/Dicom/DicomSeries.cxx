// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/Dicom/DicomSeries.h"

#include "Formats/Source/TextFields.h"
#include "Ground/Base/FileSystem.h"

#include <algorithm>
#include <cstddef>
#include <filesystem>
#include <system_error>
#include <utility>

namespace isosurface
{
namespace
{

using AllSeries = std::map<std::string, DicomSeries>;

constexpr int MaximumFolderDepth = 16;

/// Whether there is a folder; not if the system does not tell.
bool IsFolder(const std::string& path)
{
  std::error_code error;
  return std::filesystem::is_directory(path, error);
}

bool IsDirectoryFile(const std::string& path)
{
  return LowerText(std::filesystem::path(path).filename().string()) == "dicomdir";
}

/// Adds the image of a file to its series. False if it has none.
Result<bool> AddImage(const std::string& path, AllSeries& all)
{
  std::string uid;
  auto slice = DicomSlice::Read(path, &uid);
  if (slice.IsOk())
  {
    all[uid].Slices.push_back(std::move(*slice));
    return true;
  }
  if (slice.GetStatus().GetCode() == StatusCode::NotFound)
  {
    return false;
  }
  if (uid.empty())
  {
    return slice.GetStatus();
  }
  Status& fault = all[uid].Fault;
  fault = fault.IsOk() ? slice.GetStatus() : fault;
  return true;
}

/// Adds the images of a folder, or else those of the folders in it.
Status AddFolder(const std::string& folder, const std::vector<std::string>& names, int depth,
  AllSeries& all, PassedOver& over)
{
  std::vector<std::string> folders;
  bool hasImages = false;
  for (const std::string& name : names)
  {
    const std::string path = (std::filesystem::path(folder) / name).string();
    std::error_code error;
    if (IsHiddenName(name))
    {
      over.Add("hidden", path);
    }
    else if (IsFolder(path))
    {
      folders.push_back(path);
    }
    else if (std::filesystem::is_regular_file(path, error))
    {
      ISOSURFACE_ASSIGN_OR_RETURN(const auto isImage, AddImage(path, all));
      hasImages = hasImages || isImage;
      if (!isImage)
      {
        over.Add("without an image of DICOM", path);
      }
    }
  }
  for (const std::string& inner : folders)
  {
    if (hasImages || depth == 0)
    {
      over.Add(hasImages ? "a folder beside images" : "a folder that is too deep", inner);
      continue;
    }
    ISOSURFACE_ASSIGN_OR_RETURN(const auto within, GetLocalFileSystem().List(inner));
    ISOSURFACE_RETURN_IF_ERROR(AddFolder(inner, within, depth - 1, all, over));
  }
  return Status::Ok();
}

/// `distinction`: 0 of a series that reads like no other, up to 3 of those that do.
std::string MakeName(const std::string& uid, const DicomSeries& series, int distinction)
{
  if (series.Slices.empty())
  {
    return uid;
  }
  const DicomSlice& first = series.Slices[0];
  const std::string& number = first.SeriesNumber;
  const std::size_t count = series.Slices.size();
  const std::size_t end = distinction > 2 ? 0 : uid.size() - std::min<std::size_t>(uid.size(), 8);
  std::string name = (first.Description.empty() ? "no description" : first.Description) + " (" +
    (first.Modality.empty() ? "" : first.Modality + ", ") + std::to_string(count) +
    (count == 1 ? " slice of " : " slices of ") + std::to_string(first.Columns) + " x " +
    std::to_string(first.Rows) + (distinction > 0 && !number.empty() ? ", series " + number : "") +
    (distinction > 1 ? ", UID ..." + uid.substr(end) : "") + ")";
  // Of any character set; a colon is what a name of a volume is split at.
  std::replace_if(
    name.begin(), name.end(), [](char c) { return c < ' ' || c > '~' || c == ':'; }, '_');
  return name;
}

void MakeNames(AllSeries& all)
{
  for (int distinction = 0; distinction <= 3; ++distinction)
  {
    std::map<std::string, int> uses;
    for (const auto& [uid, series] : all)
    {
      ++uses[series.Name];
    }
    for (auto& [uid, series] : all)
    {
      series.Name = distinction == 0 || uses[series.Name] > 1 ? MakeName(uid, series, distinction)
                                                              : series.Name;
    }
  }
}

} // namespace

Result<AllSeries> FindDicomSeries(const std::string& path, PassedOver& over)
{
  FileSystem& files = GetLocalFileSystem();
  AllSeries all;
  const std::string folder = IsFolder(path) ? path : FindFolder(path);
  Result<std::vector<std::string>> names = std::vector<std::string>();
  if (IsPattern(files, path))
  {
    names = FindFittingNames(files, path, &over);
  }
  else
  {
    names = files.List(folder);
  }
  ISOSURFACE_RETURN_IF_ERROR(names.GetStatus());
  const bool isTree = IsFolder(path) || IsDirectoryFile(path);
  PassedOver ofFile; // nobody has asked for the other files
  ISOSURFACE_RETURN_IF_ERROR(AddFolder(folder, *names, isTree ? MaximumFolderDepth : 0, all,
    isTree || IsPattern(files, path) ? over : ofFile));
  if (all.empty())
  {
    const std::string passed = over.GetText();
    return Status(StatusCode::NotFound,
      path + ": cannot be read: there are no images of DICOM" +
        (passed.empty() ? "" : "; " + passed));
  }
  MakeNames(all);
  return all;
}

Result<std::vector<DicomSlice>> ChooseDicomSeries(const VolumeName& name, PassedOver& over)
{
  std::string wanted = name.Within;
  const bool isImage = !IsFolder(name.Path) && !IsDirectoryFile(name.Path) &&
    !IsPattern(GetLocalFileSystem(), name.Path);
  if (isImage)
  {
    ISOSURFACE_ASSIGN_OR_RETURN(const auto slice, DicomSlice::Read(name.Path));
    wanted = slice.Series;
  }
  ISOSURFACE_ASSIGN_OR_RETURN(auto all, FindDicomSeries(name.Path, over));
  const auto take = [](DicomSeries& series) -> Result<std::vector<DicomSlice>>
  {
    ISOSURFACE_RETURN_IF_ERROR(series.Fault);
    return std::move(series.Slices);
  };
  std::vector<DicomSeries*> fitting;
  Status fault;
  std::string known;
  for (auto& [uid, series] : all)
  {
    if (uid == wanted || series.Name == wanted)
    {
      return take(series);
    }
    const std::vector<DicomSlice>& slices = series.Slices;
    const bool isEnd = uid.size() >= wanted.size() &&
      uid.compare(uid.size() - wanted.size(), wanted.size(), wanted) == 0;
    if (isEnd && slices.empty())
    {
      fault = fault.IsOk() ? series.Fault : fault;
    }
    else if (isEnd)
    {
      fitting.push_back(&series);
    }
    if (!slices.empty())
    {
      known += (known.empty() ? " as in \"" + name.Path + ":" : ", \"") + series.Name + "\"";
    }
  }
  if (fitting.empty())
  {
    ISOSURFACE_RETURN_IF_ERROR(fault);
  }
  if (fitting.size() != 1)
  {
    return Status(
      StatusCode::NotFound, name.GetText() + ": cannot be read: name one of its series," + known);
  }
  return take(*fitting[0]);
}

} // namespace isosurface
