// SPDX-License-Identifier: BSD-3-Clause
#include "PipelineFiles.h"

#include "Formats/Source/FolderFiles.h"
#include "Formats/Source/SliceFiles.h"

#include <algorithm>
#include <filesystem>
#include <system_error>
#include <utility>

namespace isosurface
{

Result<PipelineFiles> PipelineFiles::Find(const std::string& path, std::size_t step)
{
  FileSystem& files = GetLocalFileSystem();
  const bool isPattern = IsPattern(files, path);
  std::error_code error;
  if (!isPattern && !std::filesystem::is_directory(path, error))
  {
    return PipelineFiles{ { path }, 1, "" };
  }
  if (!isPattern && ListNames(files, path).empty())
  {
    return Status(StatusCode::NotFound, path + ": cannot be read: the folder is empty");
  }
  PassedOver over;
  const std::vector<std::string> fitting =
    isPattern ? FindFittingNames(files, path, &over) : ListNames(files, path);
  if (!isPattern || fitting.empty() || !SliceFiles::FindKind(fitting).empty())
  {
    ISOSURFACE_ASSIGN_OR_RETURN(auto slices, SliceFiles::Find(files, path));
    return PipelineFiles{ std::move(slices.Paths), 1, std::move(slices.LeftOut) };
  }
  std::vector<NumberedName> names(fitting.begin(), fitting.end());
  std::stable_sort(names.begin(), names.end());
  std::vector<std::string> steps;
  for (const NumberedName& name : names)
  {
    if (FindExtension(name.Name) == FindExtension(names.front().Name))
    {
      steps.push_back((std::filesystem::path(FindFolder(path)) / name.Name).string());
    }
    else
    {
      over.Add("of another kind", name.Name);
    }
  }
  if (step >= steps.size())
  {
    return Status(StatusCode::InvalidArgument,
      path + ": has " + std::to_string(steps.size()) + " time steps, and none of number " +
        std::to_string(step));
  }
  const std::string passed = over.GetText();
  return PipelineFiles{ { steps[step] }, steps.size(),
    passed + (passed.empty() ? "" : "; ") + "the " + std::to_string(steps.size()) +
      " files are time steps, numbered from 0" };
}

} // namespace isosurface
