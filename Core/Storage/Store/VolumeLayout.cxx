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
  std::vector<std::uint64_t> checksums = { ComputeChecksum(text.data(), text.size()) };
  for (const StoreDescription& store : step.Stores)
  {
    checksums.push_back(store.Checksum);
  }
  return ComputeChecksum(checksums.data(), checksums.size() * sizeof(std::uint64_t));
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
  this->AddGrid(std::move(header), place);
  for (std::size_t overview = 0; overview < this->GetHeader().Overviews.size(); ++overview)
  {
    this->AddGrid(this->GetHeader().MakeOverview(overview), place);
  }
  const std::optional<GridLines>& lines = this->GetHeader().Lines;
  for (int level = 0; lines && level < this->GetNumberOfLevels(); ++level)
  {
    this->Lines.push_back(lines->Coarsen(level));
  }
}

void VolumeLayout::AddGrid(BlockedVolumeHeader header, const std::string& place)
{
  StoredGrid stored;
  stored.FirstLevel = this->StoredGrids.empty() ? 0 : this->GetNumberOfLevels();
  stored.Header = std::move(header);
  stored.Grid = stored.Header.GetBlockGrid();
  for (const TimeStepDescription& step : stored.Header.TimeSteps)
  {
    stored.Identities.push_back(ComputeIdentity(place, step));
  }
  this->StoredGrids.push_back(std::move(stored));
}

int VolumeLayout::GetNumberOfLevels() const
{
  return this->StoredGrids.back().FirstLevel + this->StoredGrids.back().Grid.GetNumberOfLevels();
}

StoredLevel VolumeLayout::FindLevel(int level) const
{
  std::uint32_t overview = 0;
  while (
    overview + 1 < this->StoredGrids.size() && this->StoredGrids[overview + 1].FirstLevel <= level)
  {
    ++overview;
  }
  return { overview, level - this->StoredGrids[overview].FirstLevel,
    &this->StoredGrids[overview].Grid };
}

std::vector<std::uint64_t> VolumeLayout::ListDatasets() const
{
  std::vector<std::uint64_t> datasets;
  for (const StoredGrid& stored : this->StoredGrids)
  {
    datasets.insert(datasets.end(), stored.Identities.begin(), stored.Identities.end());
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
  return { this->StoredGrids[stored.Overview].Identities[timeStep], block,
    static_cast<std::uint32_t>(variable), static_cast<std::uint32_t>(stored.Level) };
}

} // namespace isosurface
