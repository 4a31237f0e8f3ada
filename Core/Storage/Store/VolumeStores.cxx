// SPDX-License-Identifier: BSD-3-Clause
#include "Storage/Store/VolumeStores.h"

#include "Ground/Base/Checksum.h"
#include "Storage/Store/JsonDocument.h"
#include "Storage/Store/SourceSamples.h"

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
  const BlockedVolumeHeader& header, std::shared_ptr<BlockCache> cache, VolumeOpener opener)
  : Path(std::move(path))
  , Files(files)
  , HeaderText(std::move(text))
  , Cache(std::move(cache))
  , Opener(opener)
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

void VolumeStores::ReplicaErrors::Add(
  std::uint32_t replica, std::int64_t ordinal, const Status& error)
{
  this->Errors.push_back(error);
  const BlockedVolumeHeader& header = this->Stores.Parts[this->Preferred.Part].Header;
  this->IsFinal = header.NumberOfReplicas == 1 || error.GetCode() == StatusCode::OutOfMemory ||
    error.GetCode() == StatusCode::Aborted;
  if (this->IsFinal)
  {
    return;
  }
  const Status rewritten = this->Stores.CheckNotRewritten(this->Preferred.TimeStep);
  if (!rewritten.IsOk())
  {
    this->Errors.assign(1, rewritten);
    this->IsFinal = true;
    return;
  }
  // Others may be where this rank cannot reach them.
  if (replica != this->Preferred.Replica)
  {
    return;
  }
  // The source may be to blame, unless another replica can be read.
  const bool isInSource = this->Preferred.Part == 0 && header.IsInPlace();
  this->Fault = { this->Preferred, ordinal, error.GetMessage() };
  if (!isInSource)
  {
    this->Keep();
  }
  const std::uint32_t stores = header.NumberOfStores;
  const std::uint32_t host = FindHost(this->Preferred.Store, replica, stores);
  const std::string& folder = header.TimeSteps[this->Preferred.TimeStep].Folder;
  if (!this->Stores.Files.Exists(GetStoreFolder(this->Stores.Path, folder, host)))
  {
    for (std::uint32_t lost = 0; lost < header.NumberOfReplicas; ++lost)
    {
      const StoreReplica where = { this->Preferred.TimeStep, this->Preferred.Part,
        (host + stores - lost) % stores, lost };
      this->Stores.Faults.Add({ where, StoreFault::Whole, error.GetMessage() });
    }
  }
}

void VolumeStores::ReplicaErrors::Keep()
{
  if (this->Fault)
  {
    this->Stores.Faults.Add(std::move(*this->Fault));
    this->Fault.reset();
  }
}

Status VolumeStores::ReplicaErrors::Join() const
{
  const Status& first = this->Errors.front();
  std::string message = first.GetMessage();
  std::string others;
  for (const Status& error : this->Errors)
  {
    if (error.GetMessage() != first.GetMessage())
    {
      others += (others.empty() ? ": " : "; ") + error.GetMessage();
    }
  }
  if (!others.empty())
  {
    message += "; nor can its replicas be read" + others;
  }
  return Status(first.GetCode(), message);
}

std::vector<std::uint32_t> VolumeStores::OrderReplicas(
  const StoreReplica& preferred, std::int64_t ordinal) const
{
  const std::uint32_t count = this->Parts[preferred.Part].Header.NumberOfReplicas;
  std::vector<std::uint32_t> order;
  for (std::uint32_t next = 0; next < count; ++next)
  {
    order.push_back((preferred.Replica + next) % count);
  }
  if (!this->Faults.IsEmpty())
  {
    const auto find = [&](std::uint32_t replica)
    {
      StoreReplica other = preferred;
      other.Replica = replica;
      return this->Faults.GetState(other, false, ordinal);
    };
    std::stable_sort(order.begin(), order.end(),
      [&](std::uint32_t a, std::uint32_t b) { return find(a) < find(b); });
  }
  return order;
}

std::string VolumeStores::DescribeNews(const std::vector<StoreFault>& news)
{
  std::string stores;
  std::string reason;
  for (const StoreFault& fault : news)
  {
    const std::uint32_t part = fault.Where.Part;
    if (part >= this->Parts.size() || fault.Where.Store == StoreReplica::Spectra)
    {
      // Spectra balance the work, no more.
      continue;
    }
    const std::uint32_t host =
      FindHost(fault.Where.Store, fault.Where.Replica, this->Parts[part].Header.NumberOfStores);
    if (this->ToldStores.insert({ part, host }).second)
    {
      stores += stores.empty() ? "" : ", ";
      stores += "store " + std::to_string(host);
      stores += part > 0 ? " of overview " + std::to_string(part) : "";
      reason = reason.empty() ? fault.Reason : reason;
    }
  }
  return stores.empty()
    ? ""
    : this->Path + ": " + stores + ": lost or damaged, other stores have the blocks (" + reason +
      "); blockvolume --repair restores it";
}

Result<VolumeStores::WorkOfStores> VolumeStores::FindStoreWork(std::size_t timeStep,
  std::uint32_t part, std::size_t variable, const std::vector<double>& isovalues)
{
  const auto spectra = this->GetSpectra(timeStep, part);
  ISOSURFACE_RETURN_IF_ERROR(spectra.GetStatus());
  const std::lock_guard<std::mutex> lock(this->WorkMutex);
  ISOSURFACE_RETURN_IF_ERROR(this->ReadStoreWork(timeStep, part, variable));
  const WorkloadSpectrum& total = *(*spectra)->GetTotal(variable);
  const std::uint32_t stores = this->Parts[part].Header.NumberOfStores;
  WorkOfStores work;
  work.Triangles.assign(stores, 0);
  for (const double isovalue : isovalues)
  {
    const std::size_t bin = total.FindBin(isovalue);
    for (std::uint32_t store = 0; store < stores; ++store)
    {
      const std::vector<std::uint64_t>& triangles = this->Work.Triangles[store];
      work.Triangles[store] += triangles.empty() ? 0 : triangles[bin];
    }
    work.ActiveBlocks += total.ActiveBlocks.empty() ? 0 : total.ActiveBlocks[bin];
  }
  return work;
}

/// The mutex is held.
Status VolumeStores::ReadStoreWork(std::size_t timeStep, std::uint32_t part, std::size_t variable)
{
  StoreWork& kept = this->Work;
  if (!kept.Triangles.empty() && kept.TimeStep == timeStep && kept.Part == part &&
    kept.Variable == variable)
  {
    return Status::Ok();
  }
  const auto spectra = this->GetSpectra(timeStep, part);
  ISOSURFACE_RETURN_IF_ERROR(spectra.GetStatus());
  std::vector<std::vector<std::uint64_t>> triangles;
  for (std::uint32_t store = 0; store < this->Parts[part].Header.NumberOfStores; ++store)
  {
    const auto spectrum = (*spectra)->GetStore(variable, store);
    if (!spectrum.IsOk())
    {
      ISOSURFACE_RETURN_IF_ERROR(this->CheckNotRewritten(timeStep));
      return spectrum.GetStatus();
    }
    triangles.push_back((*spectrum)->Triangles);
  }
  kept = { timeStep, part, variable, std::move(triangles) };
  return Status::Ok();
}

Result<std::shared_ptr<BlockStore>> VolumeStores::GetStore(
  std::size_t timeStep, std::uint32_t part, std::uint32_t store, std::uint32_t replica)
{
  const std::lock_guard<std::mutex> lock(this->Mutex);
  for (auto open = this->OpenStores.begin(); open != this->OpenStores.end(); ++open)
  {
    if (open->TimeStep == timeStep && open->Part == part && open->Index == store &&
      open->Replica == replica)
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
  auto opened = BlockStore::Open(this->Files,
    GetReplicaFolder(this->Path, step.Folder, store, replica, header.NumberOfStores), header,
    step.Stores[store], source);
  // If the volume was rewritten, that explains any error; and a new folder of the same name would
  // go unnoticed without this check.
  ISOSURFACE_RETURN_IF_ERROR(this->CheckNotRewritten(timeStep));
  ISOSURFACE_RETURN_IF_ERROR(opened.GetStatus());
  if (this->OpenStores.size() == MaximumOpenStores)
  {
    this->OpenStores.pop_back();
  }
  this->OpenStores.push_front({ timeStep, part, store, replica, *opened });
  return *opened;
}

Result<std::shared_ptr<SourceSamples>> VolumeStores::GetSource(std::size_t timeStep)
{
  std::shared_ptr<SourceSamples>& kept = this->Sources[timeStep];
  if (!kept)
  {
    const VolumePart& part = this->Parts.front();
    auto opened = SourceSamples::Open(this->Files, this->Opener, this->Path, part.Header, timeStep,
      part.Identities[timeStep], this->Cache);
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
    ISOSURFACE_RETURN_IF_ERROR(spectra.GetStatus());
    kept = *spectra;
  }
  return kept;
}

} // namespace isosurface
