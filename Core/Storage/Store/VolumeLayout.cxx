// SPDX-License-Identifier: BSD-3-Clause
#include "Storage/Store/VolumeLayout.h"

#include "Ground/Base/Checksum.h"
#include "Ground/Base/Fingerprint.h"

#include <algorithm>
#include <filesystem>
#include <optional>
#include <system_error>
#include <utility>

namespace isosurface
{
namespace
{

constexpr std::size_t EndSize = 64;

std::string FindCanonicalPath(const std::string& path)
{
  std::error_code error;
  const std::filesystem::path canonical = std::filesystem::weakly_canonical(path, error);
  return error ? path : canonical.string();
}

std::uint64_t ComputeFingerprint(
  const std::string& headerEnd, std::uint64_t headerSize, const GridGeometry& grid)
{
  isosurface::Fingerprint fingerprint;
  fingerprint.AddText(headerEnd);
  fingerprint.AddNumber(headerSize);
  fingerprint.AddReals(grid.Spacing);
  fingerprint.AddReals(grid.Origin);
  fingerprint.AddNumber(static_cast<std::uint64_t>(grid.Unit));
  return fingerprint.Get();
}

/// Identifies the contents of a time step of the volume at a canonical path.
std::uint64_t ComputeIdentity(const std::string& place, const TimeStepDescription& step)
{
  const std::string text = place + "\n" + step.Folder;
  std::vector<std::uint64_t> parts = { ComputeChecksum(text.data(), text.size()) };
  for (const StoreDescription& store : step.Stores)
  {
    parts.push_back(store.Checksum);
  }
  return ComputeChecksum(parts.data(), parts.size() * sizeof(std::uint64_t));
}

} // namespace

VolumeLayout::VolumeLayout(
  std::string path, const std::string& text, BlockedVolumeHeader header, const GridGeometry& found)
  : Path(std::move(path))
  , HeaderSize(text.size())
  , HeaderEnd(text.substr(text.size() - std::min(text.size(), EndSize)))
  , FoundGrid(found)
  , Fingerprint(ComputeFingerprint(HeaderEnd, HeaderSize, header.Grid))
  , Variables(header.GetVariables())
{
  const std::string place = FindCanonicalPath(this->Path);
  this->AddPart(std::move(header), place);
  for (std::size_t overview = 0; overview < this->GetHeader().Overviews.size(); ++overview)
  {
    this->AddPart(this->GetHeader().MakeOverview(overview), place);
  }
  const std::optional<GridLines>& lines = this->GetHeader().Lines;
  for (int level = 0; lines && level < this->GetNumberOfLevels(); ++level)
  {
    this->Lines.push_back(lines->Coarsen(level));
  }
}

void VolumeLayout::AddPart(BlockedVolumeHeader header, const std::string& place)
{
  StoredGrid part;
  part.FirstLevel = this->StoredGrids.empty() ? 0 : this->GetNumberOfLevels();
  part.Header = std::move(header);
  part.Grid = part.Header.GetBlockGrid();
  for (const TimeStepDescription& step : part.Header.TimeSteps)
  {
    part.Identities.push_back(ComputeIdentity(place, step));
  }
  this->StoredGrids.push_back(std::move(part));
}

int VolumeLayout::GetNumberOfLevels() const
{
  return this->StoredGrids.back().FirstLevel + this->StoredGrids.back().Grid.GetNumberOfLevels();
}

StoredLevel VolumeLayout::FindLevel(int level) const
{
  std::uint32_t part = 0;
  while (part + 1 < this->StoredGrids.size() && this->StoredGrids[part + 1].FirstLevel <= level)
  {
    ++part;
  }
  return { part, level - this->StoredGrids[part].FirstLevel, &this->StoredGrids[part].Grid };
}

std::vector<std::uint64_t> VolumeLayout::ListDatasets() const
{
  std::vector<std::uint64_t> datasets;
  for (const StoredGrid& part : this->StoredGrids)
  {
    datasets.insert(datasets.end(), part.Identities.begin(), part.Identities.end());
  }
  for (const TimeStepDescription& step : this->GetHeader().TimeSteps)
  {
    if (step.Source)
    {
      datasets.push_back(step.Source->ComputeDataset());
    }
  }
  return datasets;
}

BlockCacheKey VolumeLayout::MakeKey(
  std::int64_t block, std::size_t timeStep, std::size_t variable, const StoredLevel& stored) const
{
  return { this->StoredGrids[stored.Part].Identities[timeStep], block,
    static_cast<std::uint32_t>(variable), static_cast<std::uint32_t>(stored.Level) };
}

} // namespace isosurface
