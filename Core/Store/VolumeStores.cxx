// SPDX-License-Identifier: BSD-3-Clause
#include "Store/VolumeStores.h"

#include "Base/Checksum.h"
#include "Store/JsonDocument.h"
#include "Store/SourceSamples.h"

#include <algorithm>
#include <filesystem>
#include <system_error>
#include <utility>

namespace isosurface
{
namespace
{

/// Each has a few files open; a process may have about a thousand.
constexpr std::size_t MaximumOpenStores = 64;

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

bool HasSameContents(const TimeStepDescription& a, const TimeStepDescription& b)
{
  bool equal = a.Folder == b.Folder && a.Stores.size() == b.Stores.size();
  for (std::size_t store = 0; equal && store < a.Stores.size(); ++store)
  {
    equal = a.Stores[store].Checksum == b.Stores[store].Checksum &&
      a.Stores[store].Bytes == b.Stores[store].Bytes;
  }
  return equal;
}

} // namespace

VolumeStores::VolumeStores(std::string path, FileSystem& files, std::string text,
  const BlockedVolumeHeader& header, std::shared_ptr<BlockCache> cache)
  : Path(std::move(path))
  , Files(files)
  , HeaderText(std::move(text))
  , Cache(std::move(cache))
  , Fingerprint(ComputeChecksum(HeaderText.data(), HeaderText.size()))
  , Variables(header.GetVariables())
  , Sources(header.TimeSteps.size())
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

void VolumeStores::AddPart(const BlockedVolumeHeader& header)
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
  this->Spectra.emplace_back(header.TimeSteps.size());
}

int VolumeStores::GetNumberOfLevels() const
{
  return this->Parts.back().FirstLevel + this->Parts.back().Grid.GetNumberOfLevels();
}

StoredLevel VolumeStores::FindLevel(int level) const
{
  std::uint32_t part = 0;
  while (part + 1 < this->Parts.size() && this->Parts[part + 1].FirstLevel <= level)
  {
    ++part;
  }
  return { part, level - this->Parts[part].FirstLevel, &this->Parts[part].Grid };
}

BlockCacheKey VolumeStores::MakeKey(
  std::int64_t block, std::size_t timeStep, std::size_t variable, const StoredLevel& stored) const
{
  return { this->Parts[stored.Part].Identities[timeStep], block,
    static_cast<std::uint32_t>(variable), static_cast<std::uint32_t>(stored.Level) };
}

Status VolumeStores::CheckNotRewritten(std::size_t timeStep) const
{
  const auto text = BlockedVolumeHeader::ReadText(this->Files, this->Path);
  if (text.IsOk() && *text == this->HeaderText)
  {
    return Status::Ok();
  }
  if (!text.IsOk() && text.GetStatus().GetCode() != StatusCode::NotFound)
  {
    // No descriptors, no permission: nobody knows whether it was rewritten.
    return text.GetStatus();
  }
  if (text.IsOk())
  {
    // Other time steps may have been appended meanwhile.
    const auto header = BlockedVolumeHeader::Parse(*text, this->Path);
    const TimeStepDescription& opened = this->GetHeader().TimeSteps[timeStep];
    if (header.IsOk() &&
      std::any_of(header->TimeSteps.begin(), header->TimeSteps.end(),
        [&](const TimeStepDescription& step) { return HasSameContents(step, opened); }))
    {
      return Status::Ok();
    }
  }
  return Status(
    StatusCode::NotFound, this->Path + ": was rewritten or removed since it was opened; reload it");
}

Result<std::shared_ptr<BlockStore>> VolumeStores::GetStore(
  std::size_t timeStep, std::uint32_t part, std::uint32_t store)
{
  const std::lock_guard<std::mutex> lock(this->Mutex);
  for (auto open = this->OpenStores.begin(); open != this->OpenStores.end(); ++open)
  {
    if (open->TimeStep == timeStep && open->Part == part && open->Index == store)
    {
      this->OpenStores.splice(this->OpenStores.begin(), this->OpenStores, open);
      return open->Store;
    }
  }
  const BlockedVolumeHeader& header = this->Parts[part].Header;
  const TimeStepDescription& step = header.TimeSteps[timeStep];
  std::shared_ptr<SourceSamples> source;
  if (step.Source)
  {
    const auto samples = this->GetSource(timeStep);
    ISOSURFACE_RETURN_IF_ERROR(samples.GetStatus());
    source = *samples;
  }
  auto opened = BlockStore::Open(this->Files, GetStoreFolder(this->Path, step.Folder, store),
    header, step.Stores[store], source);
  // If the volume was rewritten, that explains any error; and a new folder of the same name would
  // go unnoticed without this check.
  ISOSURFACE_RETURN_IF_ERROR(this->CheckNotRewritten(timeStep));
  if (!opened.IsOk())
  {
    return opened.GetStatus();
  }
  if (this->OpenStores.size() == MaximumOpenStores)
  {
    this->OpenStores.pop_back();
  }
  this->OpenStores.push_front({ timeStep, part, store, *opened });
  return *opened;
}

Result<std::shared_ptr<SourceSamples>> VolumeStores::GetSource(std::size_t timeStep)
{
  std::shared_ptr<SourceSamples>& kept = this->Sources[timeStep];
  if (!kept)
  {
    const VolumePart& part = this->Parts.front();
    auto opened = SourceSamples::Open(
      this->Files, this->Path, part.Header, timeStep, part.Identities[timeStep], this->Cache);
    ISOSURFACE_RETURN_IF_ERROR(opened.GetStatus());
    kept = *opened;
  }
  return kept;
}

Result<std::shared_ptr<const VolumeSpectra>> VolumeStores::GetSpectra(
  std::size_t timeStep, std::uint32_t part)
{
  const std::lock_guard<std::mutex> lock(this->Mutex);
  const BlockedVolumeHeader& header = this->Parts[part].Header;
  std::shared_ptr<const VolumeSpectra>& kept = this->Spectra[part][timeStep];
  if (!kept)
  {
    auto spectra = VolumeSpectra::Read(
      this->Files, this->Path, header.TimeSteps[timeStep], this->Variables.GetCount());
    ISOSURFACE_RETURN_IF_ERROR(this->CheckNotRewritten(timeStep));
    if (!spectra.IsOk())
    {
      return spectra.GetStatus();
    }
    kept = *spectra;
  }
  return kept;
}

} // namespace isosurface
