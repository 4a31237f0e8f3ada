// SPDX-License-Identifier: BSD-3-Clause
#include "Storage/Store/VolumeStores.h"

#include "Storage/Store/SourceSamples.h"

#include <algorithm>

namespace isosurface
{
namespace
{

/// Each has a few files open; a process may have about a thousand.
constexpr std::size_t MaximumOpenStores = 64;

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

/// Whether the header's file can be read, and is as it was. Each store that is opened asks, so only
/// its end is read: there it has the checksum of all of it.
bool HasHeader(FileSystem& files, const VolumeLayout& layout)
{
  std::string end(layout.GetHeaderEnd().size(), '\0');
  const auto file = files.OpenForReading(layout.GetPath());
  return file.IsOk() && (*file)->GetSize() == layout.GetHeaderSize() &&
    (*file)->Read(layout.GetHeaderSize() - end.size(), end.size(), end.data()).IsOk() &&
    end == layout.GetHeaderEnd();
}

} // namespace

VolumeStores::VolumeStores(const VolumeLayout& layout, FileSystem& files,
  std::shared_ptr<BlockCache> cache, VolumeOpener opener)
  : Layout(layout)
  , Files(files)
  , Cache(std::move(cache))
  , Opener(opener)
  , Sources(layout.GetHeader().TimeSteps.size())
  , Spectra(layout.GetStoredGrids().size())
{
  for (std::vector<std::shared_ptr<const VolumeSpectra>>& ofGrid : this->Spectra)
  {
    ofGrid.resize(this->Sources.size());
  }
}

Status VolumeStores::CheckNotRewritten(std::size_t timeStep) const
{
  if (HasHeader(this->Files, this->Layout))
  {
    return Status::Ok();
  }
  const auto text = BlockedVolumeHeader::ReadText(this->Files, this->Layout.GetPath());
  if (!text.IsOk() && text.GetStatus().GetCode() != StatusCode::NotFound)
  {
    // No descriptors, no permission: nobody knows whether it was rewritten.
    return text.GetStatus();
  }
  if (text.IsOk())
  {
    // Other time steps may have been appended meanwhile.
    const auto header = BlockedVolumeHeader::Parse(*text, this->Layout.GetPath());
    const TimeStepDescription& opened = this->Layout.GetHeader().TimeSteps[timeStep];
    if (header.IsOk() &&
      std::any_of(header->TimeSteps.begin(), header->TimeSteps.end(),
        [&](const TimeStepDescription& step) { return HasSameContents(step, opened); }))
    {
      return Status::Ok();
    }
  }
  return Status(StatusCode::NotFound,
    this->Layout.GetPath() + ": was rewritten or removed since it was opened; reload it");
}

void VolumeStores::ReplicaErrors::Add(
  std::uint32_t replica, std::int64_t ordinal, const Status& error)
{
  this->Errors.push_back(error);
  const BlockedVolumeHeader& header =
    this->Stores.Layout.GetStoredGrids()[this->Preferred.Overview].Header;
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
  const bool isInSource = this->Preferred.Overview == 0 && header.IsInPlace();
  this->Fault = { this->Preferred, ordinal, error.GetMessage() };
  if (!isInSource)
  {
    this->Keep();
  }
  const std::uint32_t stores = header.NumberOfStores;
  const std::uint32_t host = FindHost(this->Preferred.Store, replica, stores);
  const std::string& folder = header.TimeSteps[this->Preferred.TimeStep].Folder;
  if (!this->Stores.Files.Exists(
        GetStoreFolder(this->Stores.Files, this->Stores.Layout.GetPath(), folder, host)))
  {
    for (std::uint32_t lost = 0; lost < header.NumberOfReplicas; ++lost)
    {
      const StoreReplica where = { this->Preferred.TimeStep, this->Preferred.Overview,
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
  const std::uint32_t count =
    this->Layout.GetStoredGrids()[preferred.Overview].Header.NumberOfReplicas;
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
    const std::uint32_t overview = fault.Where.Overview;
    if (overview >= this->Layout.GetStoredGrids().size() ||
      fault.Where.Store == StoreReplica::Spectra)
    {
      // Spectra balance the work, no more.
      continue;
    }
    const std::uint32_t host = FindHost(fault.Where.Store, fault.Where.Replica,
      this->Layout.GetStoredGrids()[overview].Header.NumberOfStores);
    if (this->ToldStores.insert({ overview, host }).second)
    {
      stores += stores.empty() ? "" : ", ";
      stores += "store " + std::to_string(host);
      stores += overview > 0 ? " of overview " + std::to_string(overview) : "";
      reason = reason.empty() ? fault.Reason : reason;
    }
  }
  return stores.empty()
    ? ""
    : this->Layout.GetPath() + ": " + stores + ": lost or damaged, other stores have the blocks (" +
      reason + "); blockvolume --repair restores it";
}

Result<StoreWork> VolumeStores::FindStoreWork(const BlockQuery& query, std::uint32_t overview)
{
  const StoreReplica spectra = { static_cast<std::uint32_t>(query.TimeStep), overview,
    StoreReplica::Spectra, 0 };
  if (this->Faults.GetState(spectra, true) == ReplicaState::Sound)
  {
    auto work = this->SumTriangles(query, overview);
    if (!work.IsOk())
    {
      ISOSURFACE_RETURN_IF_ERROR(this->CheckNotRewritten(query.TimeStep));
      this->Faults.Add({ spectra, StoreFault::Whole, work.GetStatus().GetMessage() });
    }
    return work;
  }
  StoreWork work;
  for (const StoreDescription& store :
    this->Layout.GetStoredGrids()[overview].Header.TimeSteps[query.TimeStep].Stores)
  {
    work.Triangles.push_back(store.Blocks);
    work.ActiveBlocks += store.Blocks;
  }
  return work;
}

Result<StoreWork> VolumeStores::SumTriangles(const BlockQuery& query, std::uint32_t overview)
{
  ISOSURFACE_ASSIGN_OR_RETURN(const auto spectra, this->GetSpectra(query.TimeStep, overview));
  const std::lock_guard<std::mutex> lock(this->WorkMutex);
  ISOSURFACE_RETURN_IF_ERROR(this->ReadStoreWork(query, overview));
  const WorkloadSpectrum& total = *spectra->GetTotal(query.Variable);
  const std::uint32_t stores = this->Layout.GetStoredGrids()[overview].Header.NumberOfStores;
  StoreWork work;
  work.Triangles.assign(stores, 0);
  for (const double isovalue : query.Isovalues)
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
Status VolumeStores::ReadStoreWork(const BlockQuery& query, std::uint32_t overview)
{
  KeptWork& kept = this->Work;
  if (!kept.Triangles.empty() && kept.TimeStep == query.TimeStep && kept.Overview == overview &&
    kept.Variable == query.Variable)
  {
    return Status::Ok();
  }
  ISOSURFACE_ASSIGN_OR_RETURN(const auto spectra, this->GetSpectra(query.TimeStep, overview));
  std::vector<std::vector<std::uint64_t>> triangles;
  for (std::uint32_t store = 0;
       store < this->Layout.GetStoredGrids()[overview].Header.NumberOfStores; ++store)
  {
    const auto spectrum = spectra->GetStore(query.Variable, store);
    if (!spectrum.IsOk())
    {
      ISOSURFACE_RETURN_IF_ERROR(this->CheckNotRewritten(query.TimeStep));
      return spectrum.GetStatus();
    }
    triangles.push_back((*spectrum)->Triangles);
  }
  kept = { query.TimeStep, overview, query.Variable, std::move(triangles) };
  return Status::Ok();
}

Result<std::shared_ptr<BlockStore>> VolumeStores::GetStore(const StoreReplica& replica)
{
  const std::lock_guard<std::mutex> lock(this->Mutex);
  for (auto open = this->OpenStores.begin(); open != this->OpenStores.end(); ++open)
  {
    if (open->Where == replica)
    {
      this->OpenStores.splice(this->OpenStores.begin(), this->OpenStores, open);
      return open->Store;
    }
  }
  const BlockedVolumeHeader& header = this->Layout.GetStoredGrids()[replica.Overview].Header;
  const TimeStepDescription& step = header.TimeSteps[replica.TimeStep];
  std::shared_ptr<SourceSamples> source;
  if (step.Source)
  {
    ISOSURFACE_ASSIGN_OR_RETURN(source, this->GetSource(replica.TimeStep));
  }
  auto opened = BlockStore::Open(this->Files,
    GetReplicaFolder(this->Files, this->Layout.GetPath(), step.Folder, replica.Store,
      replica.Replica, header.NumberOfStores),
    header, step.Stores[replica.Store], source);
  // If the volume was rewritten, that explains any error; and a new folder of the same name would
  // go unnoticed without this check.
  ISOSURFACE_RETURN_IF_ERROR(this->CheckNotRewritten(replica.TimeStep));
  ISOSURFACE_RETURN_IF_ERROR(opened.GetStatus());
  if (this->OpenStores.size() == MaximumOpenStores)
  {
    this->OpenStores.pop_back();
  }
  this->OpenStores.push_front({ replica, *opened });
  return *opened;
}

Result<std::shared_ptr<SourceSamples>> VolumeStores::GetSource(std::size_t timeStep)
{
  std::shared_ptr<SourceSamples>& kept = this->Sources[timeStep];
  if (!kept)
  {
    const StoredGrid& stored = this->Layout.GetStoredGrids().front();
    const BlockedVolumeHeader& header = stored.Header;
    ISOSURFACE_ASSIGN_OR_RETURN(kept,
      SourceSamples::Open(this->Files, this->Opener, this->Layout.GetPath(),
        *header.TimeSteps[timeStep].Source, header.Grid, header.Arrays, this->Cache));
  }
  return kept;
}

Status VolumeStores::ReadSource(std::size_t timeStep, std::size_t variable, const VertexBox& box,
  std::uint8_t* to, QueryStatistics& statistics)
{
  std::shared_ptr<SourceSamples> source;
  {
    const std::lock_guard<std::mutex> lock(this->Mutex);
    ISOSURFACE_ASSIGN_OR_RETURN(source, this->GetSource(timeStep));
  }
  ISOSURFACE_RETURN_IF_ERROR(
    source->Decode(variable, box, ChooseReadingThreads(source->GetName(), 1)));
  return source->Read(variable, box, to, statistics);
}

Status VolumeStores::CheckSource(std::size_t timeStep)
{
  std::shared_ptr<SourceSamples> source;
  {
    const std::lock_guard<std::mutex> lock(this->Mutex);
    source = this->Sources[timeStep];
  }
  return source ? source->CheckUnchanged() : Status::Ok();
}

Result<std::shared_ptr<const VolumeSpectra>> VolumeStores::GetSpectra(
  std::size_t timeStep, std::uint32_t overview)
{
  const std::lock_guard<std::mutex> lock(this->Mutex);
  const BlockedVolumeHeader& header = this->Layout.GetStoredGrids()[overview].Header;
  std::shared_ptr<const VolumeSpectra>& kept = this->Spectra[overview][timeStep];
  if (!kept)
  {
    auto spectra = VolumeSpectra::Read(this->Files, this->Layout.GetPath(),
      header.TimeSteps[timeStep], this->Layout.GetVariables().GetCount(),
      GridScale::Find(this->Layout.GetFoundGrid(), this->Layout.GetHeader().Grid));
    ISOSURFACE_RETURN_IF_ERROR(this->CheckNotRewritten(timeStep));
    ISOSURFACE_RETURN_IF_ERROR(spectra.GetStatus());
    kept = *spectra;
  }
  return kept;
}

} // namespace isosurface
