// SPDX-License-Identifier: BSD-3-Clause
#include "Storage/Store/VolumeSpectra.h"

#include "Ground/Base/Checksum.h"
#include "Ground/Base/Coding.h"

#include <utility>

namespace isosurface
{

std::string VolumeSpectra::GetPath(
  FileSystem& files, const std::string& volumePath, const std::string& generation)
{
  return GetStoresFolder(files, volumePath) + "/" + generation + "/spectra";
}

std::uint64_t VolumeSpectra::GetIdentity(const TimeStepDescription& step)
{
  std::vector<std::uint8_t> checksums;
  for (const StoreDescription& store : step.Stores)
  {
    AppendLittleEndian(checksums, store.Checksum);
  }
  return ComputeChecksum(checksums.data(), checksums.size());
}

VolumeSpectra::Spectrum VolumeSpectra::Share(WorkloadSpectrum&& spectrum) const
{
  spectrum.AreaUnit *= this->Scale.Area;
  spectrum.VolumeUnit *= this->Scale.Volume;
  if (this->Scale.Area == 0)
  {
    spectrum.Area.clear();
  }
  return std::make_shared<const WorkloadSpectrum>(std::move(spectrum));
}

Result<std::shared_ptr<const VolumeSpectra>> VolumeSpectra::Read(FileSystem& files,
  const std::string& volumePath, const TimeStepDescription& step, std::size_t variables,
  const GridScale& scale)
{
  auto result = std::make_shared<VolumeSpectra>();
  result->Scale = scale;
  ISOSURFACE_ASSIGN_OR_RETURN(result->File,
    SpectraFile::Open(files, GetPath(files, volumePath, step.Folder), GetIdentity(step), variables,
      step.Stores.size()));
  for (std::size_t variable = 0; variable < variables; ++variable)
  {
    ISOSURFACE_ASSIGN_OR_RETURN(auto total, result->File->ReadTotal(variable));
    result->Totals.push_back(result->Share(std::move(total)));
  }
  return std::shared_ptr<const VolumeSpectra>(std::move(result));
}

Result<VolumeSpectra::Spectrum> VolumeSpectra::GetStore(
  std::size_t variable, std::size_t store) const
{
  ISOSURFACE_ASSIGN_OR_RETURN(auto spectrum, this->File->ReadStore(variable, store));
  return this->Share(std::move(spectrum));
}

} // namespace isosurface
