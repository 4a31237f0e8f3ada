// SPDX-License-Identifier: BSD-3-Clause
#include "Store/VolumeSpectra.h"

#include "Store/BlockedVolumeHeader.h"
#include "Store/SpectraDocument.h"

#include <utility>

namespace isosurface
{
namespace
{

VolumeSpectra::Spectrum Share(WorkloadSpectrum&& spectrum)
{
  return std::make_shared<const WorkloadSpectrum>(std::move(spectrum));
}

} // namespace

std::string VolumeSpectra::GetPath(const std::string& volumePath, const std::string& generation)
{
  return GetStoresFolder(volumePath) + "/" + generation + "/spectra";
}

Result<std::shared_ptr<const VolumeSpectra>> VolumeSpectra::Read(FileSystem& files,
  const std::string& volumePath, const std::string& generation, std::size_t variables,
  std::size_t stores)
{
  auto result = std::make_shared<VolumeSpectra>();
  const std::string path = GetPath(volumePath, generation);
  const std::string oldPath = path + ".json";
  if (!files.Exists(path) && files.Exists(oldPath))
  {
    auto document = SpectraDocument::Read(files, oldPath, variables, stores);
    if (!document.IsOk())
    {
      return document.GetStatus();
    }
    for (std::size_t variable = 0; variable < variables; ++variable)
    {
      result->Totals.push_back(Share(std::move(document->Totals[variable])));
      result->Stores.emplace_back();
      for (WorkloadSpectrum& spectrum : document->Stores[variable])
      {
        result->Stores.back().push_back(Share(std::move(spectrum)));
      }
    }
    return std::shared_ptr<const VolumeSpectra>(std::move(result));
  }
  auto file = SpectraFile::Open(files, path, variables, stores);
  if (!file.IsOk())
  {
    return file.GetStatus();
  }
  result->File = std::move(*file);
  for (std::size_t variable = 0; variable < variables; ++variable)
  {
    auto total = result->File->ReadTotal(variable);
    if (!total.IsOk())
    {
      return total.GetStatus();
    }
    result->Totals.push_back(Share(std::move(*total)));
  }
  return std::shared_ptr<const VolumeSpectra>(std::move(result));
}

Result<VolumeSpectra::Spectrum> VolumeSpectra::GetStore(
  std::size_t variable, std::size_t store) const
{
  if (!this->File)
  {
    return this->Stores[variable][store];
  }
  auto spectrum = this->File->ReadStore(variable, store);
  if (!spectrum.IsOk())
  {
    return spectrum.GetStatus();
  }
  return Share(std::move(*spectrum));
}

} // namespace isosurface
