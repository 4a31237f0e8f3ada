// SPDX-License-Identifier: BSD-3-Clause
#include "Storage/Store/VolumeLayout.h"

#include "Ground/Base/Checksum.h"

#include <filesystem>
#include <system_error>
#include <utility>

namespace isosurface
{
namespace
{

/// Identifies the contents of a time step.
std::uint64_t ComputeIdentity(const std::string& path, const TimeStepDescription& step)
{
  std::error_code error;
  const std::filesystem::path canonical = std::filesystem::weakly_canonical(path, error);
  std::string text = (error ? path : canonical.string()) + "\n" + step.Folder;
  for (const StoreDescription& store : step.Stores)
  {
    text += FormatChecksum(store.Checksum);
  }
  return ComputeChecksum(text.data(), text.size());
}

} // namespace

VolumeLayout::VolumeLayout(std::string path, std::string text, const BlockedVolumeHeader& header)
  : Path(std::move(path))
  , HeaderText(std::move(text))
  , Fingerprint(ComputeChecksum(HeaderText.data(), HeaderText.size()))
  , Variables(header.GetVariables())
{
  this->AddPart(header);
  for (std::size_t overview = 0; overview < header.Overviews.size(); ++overview)
  {
    this->AddPart(header.MakeOverview(overview));
  }
  for (int level = 0; header.Lines && level < this->GetNumberOfLevels(); ++level)
  {
    this->Lines.push_back(header.Lines->Coarsen(level));
  }
}

void VolumeLayout::AddPart(const BlockedVolumeHeader& header)
{
  VolumePart part;
  part.FirstLevel = this->Parts.empty() ? 0 : this->GetNumberOfLevels();
  part.Header = header;
  part.Grid = header.GetBlockGrid();
  for (const TimeStepDescription& step : header.TimeSteps)
  {
    part.Identities.push_back(ComputeIdentity(this->Path, step));
  }
  this->Parts.push_back(std::move(part));
}

int VolumeLayout::GetNumberOfLevels() const
{
  return this->Parts.back().FirstLevel + this->Parts.back().Grid.GetNumberOfLevels();
}

StoredLevel VolumeLayout::FindLevel(int level) const
{
  std::uint32_t part = 0;
  while (part + 1 < this->Parts.size() && this->Parts[part + 1].FirstLevel <= level)
  {
    ++part;
  }
  return { part, level - this->Parts[part].FirstLevel, &this->Parts[part].Grid };
}

BlockCacheKey VolumeLayout::MakeKey(
  std::int64_t block, std::size_t timeStep, std::size_t variable, const StoredLevel& stored) const
{
  return { this->Parts[stored.Part].Identities[timeStep], block,
    static_cast<std::uint32_t>(variable), static_cast<std::uint32_t>(stored.Level) };
}

} // namespace isosurface
