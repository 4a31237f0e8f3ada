// SPDX-License-Identifier: BSD-3-Clause
#include "Storage/Verification/VolumeVerification.h"

#include "Ground/Base/ParallelFor.h"
#include "Storage/Store/SourceSamples.h"
#include "Storage/Store/SpectraFile.h"
#include "Storage/Verification/MergedStore.h"
#include "Storage/Verification/StoreVerification.h"

#include <algorithm>
#include <memory>
#include <utility>

namespace isosurface
{
namespace
{

bool HaveEqualCounts(const WorkloadSpectrum& a, const WorkloadSpectrum& b)
{
  const auto ofA = a.GetQuantities();
  const auto ofB = b.GetQuantities();
  return std::equal(ofA.begin(), ofA.end(), ofB.begin(),
    [](const auto* countsOfA, const auto* countsOfB) { return *countsOfA == *countsOfB; });
}

/// Checks the volume and its overviews, one time step after the other.
class VolumeCheck
{
public:
  VolumeCheck(const std::string& path, FileSystem& files, int threads, const Progress& progress,
    VolumeOpener opener, const BlockedVolumeHeader* header)
    : Path(path)
    , Files(files)
    , Threads(threads)
    , Tell(progress)
    , Opener(opener)
    , Header(header)
  {
  }

  Result<VolumeVerification> Run()
  {
    this->Found.Files = 1;
    const auto header = this->Header ? Result<BlockedVolumeHeader>(*this->Header)
                                     : BlockedVolumeHeader::Read(this->Files, this->Path);
    if (!header.IsOk())
    {
      this->AddFault(header.GetStatus());
      return std::move(this->Found);
    }
    std::vector<BlockedVolumeHeader> parts = { *header };
    std::uint64_t blocks = this->CountBlocks(*header);
    for (std::size_t overview = 0; overview < header->Overviews.size(); ++overview)
    {
      parts.push_back(header->MakeOverview(overview));
      blocks += this->CountBlocks(parts.back());
    }
    const double shares =
      static_cast<double>(blocks) * static_cast<double>(header->TimeSteps.size());
    for (std::size_t step = 0; step < header->TimeSteps.size(); ++step)
    {
      for (const BlockedVolumeHeader& part : parts)
      {
        this->PartShare = static_cast<double>(this->CountBlocks(part)) / shares;
        if (!this->CheckTimeStep(part, part.TimeSteps[step]))
        {
          return Status(StatusCode::Aborted, this->Path + ": the check was aborted");
        }
        this->PartBegin += this->PartShare;
      }
    }
    return std::move(this->Found);
  }

private:
  void AddFault(const Status& fault)
  {
    ++this->Found.FaultCount;
    if (this->Found.Faults.size() < VolumeVerification::MaximumFaults)
    {
      this->Found.Faults.push_back(fault);
    }
  }

  static std::uint64_t CountBlocks(const BlockedVolumeHeader& header)
  {
    return static_cast<std::uint64_t>(header.GetBlockGrid().GetNumberOfBlocks());
  }

  /// Reads all spectra and checks that those of the stores add up to that of the volume.
  Status CheckSpectra(const BlockedVolumeHeader& header, const TimeStepDescription& step)
  {
    const std::size_t variables = header.GetVariables().GetCount();
    ISOSURFACE_ASSIGN_OR_RETURN(
      const auto spectra, VolumeSpectra::Read(this->Files, this->Path, step, variables));
    for (std::size_t variable = 0; variable < variables; ++variable)
    {
      const WorkloadSpectrum& total = *spectra->GetTotal(variable);
      WorkloadSpectrum sum(total.Bins);
      bool hasSum = true;
      for (std::uint32_t store = 0; store < header.NumberOfStores; ++store)
      {
        ISOSURFACE_ASSIGN_OR_RETURN(const auto spectrum, spectra->GetStore(variable, store));
        hasSum = sum.Add(*spectrum) && hasSum;
      }
      if (!hasSum || !HaveEqualCounts(sum, total))
      {
        return Status(StatusCode::Corrupt,
          VolumeSpectra::GetPath(this->Files, this->Path, step.Folder) +
            ": the stores' spectra do not add up to the volume's");
      }
    }
    return Status::Ok();
  }

  /// What has the samples of a time step in place. That it is missing or was changed is a fault.
  std::shared_ptr<SourceSamples> OpenSource(
    const BlockedVolumeHeader& header, const TimeStepDescription& step)
  {
    if (!step.Source)
    {
      return nullptr;
    }
    constexpr std::uint64_t cacheBytes = std::uint64_t{ 1 } << 28;
    const auto source = SourceSamples::Open(this->Files, this->Opener, this->Path, *step.Source,
      header.Grid, header.Arrays, std::make_shared<BlockCache>(cacheBytes));
    if (!source.IsOk())
    {
      this->AddFault(Status(source.GetStatus().GetCode(),
        source.GetStatus().GetMessage() + " (the samples at full resolution were not checked)"));
      return nullptr;
    }
    return *source;
  }

  /// Checks the volume itself, or an overview. Returns false if `Tell` asked to stop.
  bool CheckTimeStep(const BlockedVolumeHeader& header, const TimeStepDescription& step)
  {
    const BlockGrid grid = header.GetBlockGrid();
    const ArrayVariables variables = header.GetVariables();
    const Status spectra = this->CheckSpectra(header, step);
    this->Found.Files += 1;
    if (!spectra.IsOk())
    {
      this->AddFault(spectra);
    }
    const auto source = this->OpenSource(header, step);
    // All stores, then the first replicas of all stores, ...
    std::vector<std::unique_ptr<StoreVerification>> stores;
    for (std::uint32_t replica = 0; replica < header.NumberOfReplicas; ++replica)
    {
      for (std::uint32_t store = 0; store < header.NumberOfStores; ++store)
      {
        stores.push_back(std::make_unique<StoreVerification>(this->Files, variables, grid,
          step.Stores[store],
          GetReplicaFolder(
            this->Files, this->Path, step.Folder, store, replica, header.NumberOfStores),
          step.Source ? SamplePlace::Source : SamplePlace::Store, replica == 0 ? source : nullptr));
      }
    }
    if (!ParallelFor(
          stores.size(), this->Threads, [&](std::size_t store, int) { stores[store]->Open(); },
          this->MakeProgress(0, 0.05)))
    {
      return false;
    }
    std::vector<std::pair<std::uint32_t, std::uint64_t>> runs;
    for (std::uint32_t store = 0; store < stores.size(); ++store)
    {
      for (std::uint64_t run = 0; run < stores[store]->GetNumberOfRuns(); ++run)
      {
        runs.emplace_back(store, run);
      }
    }
    if (!ParallelFor(
          runs.size(), this->Threads,
          [&](std::size_t index, int) { stores[runs[index].first]->CheckRun(runs[index].second); },
          this->MakeProgress(0.05, 1)))
    {
      return false;
    }
    this->Join(header, step, stores);
    return true;
  }

  void Join(const BlockedVolumeHeader& header, const TimeStepDescription& step,
    const std::vector<std::unique_ptr<StoreVerification>>& stores)
  {
    const BlockGrid grid = header.GetBlockGrid();
    std::uint64_t promised = 0;
    for (const StoreDescription& store : step.Stores)
    {
      promised += store.Blocks;
    }
    // Memory is only allocated for as many blocks as the stores have.
    const bool areOpen = std::all_of(stores.begin(),
      stores.begin() + static_cast<std::ptrdiff_t>(header.NumberOfStores),
      [](const auto& store) { return store->IsOpen(); });
    const std::size_t count = areOpen ? static_cast<std::size_t>(grid.GetNumberOfBlocks()) : 0;
    const std::uint64_t before = this->Found.FaultCount;
    std::vector<std::uint8_t> seen(count, 0);
    std::vector<std::uint8_t> unused;
    std::vector<bool> areSound;
    for (std::size_t index = 0; index < stores.size(); ++index)
    {
      StoreVerification& store = *stores[index];
      store.Finish(index < header.NumberOfStores ? seen : unused);
      const std::vector<Status> faults = store.TakeFaults();
      areSound.push_back(faults.empty());
      for (const Status& fault : faults)
      {
        this->AddFault(fault);
      }
      this->Found.Files += store.GetFiles();
      this->Found.Bytes += store.GetBytes();
    }
    if (header.NumberOfReplicas > 1)
    {
      this->FindRepairs(header, step, areSound);
    }
    this->Found.Blocks += promised;
    const bool hasEachOnce =
      std::all_of(seen.begin(), seen.end(), [](std::uint8_t times) { return times == 1; });
    if (this->Found.FaultCount == before && !hasEachOnce)
    {
      this->AddFault(Status(StatusCode::Corrupt,
        this->Path + ": the stores of time step " + step.Folder + " do not have each block once"));
    }
  }

  /// Which stores have damaged replicas, and whether what they had is elsewhere. `areSound`: in the
  /// order of CheckTimeStep.
  void FindRepairs(const BlockedVolumeHeader& header, const TimeStepDescription& step,
    const std::vector<bool>& areSound)
  {
    const std::uint32_t stores = header.NumberOfStores;
    std::vector<bool> isDamaged(stores, false);
    std::vector<std::string> obstacles(stores);
    for (std::uint32_t store = 0; store < stores; ++store)
    {
      std::vector<std::string> folders;
      bool isAnySound = false;
      for (std::uint32_t replica = 0; replica < header.NumberOfReplicas; ++replica)
      {
        isAnySound = isAnySound || areSound[replica * stores + store];
        folders.push_back(
          GetReplicaFolder(this->Files, this->Path, step.Folder, store, replica, stores));
      }
      const Status whole = isAnySound
        ? Status::Ok()
        : CheckReplicas(this->Files, header, step, store, folders, this->Threads);
      for (std::uint32_t replica = 0; replica < header.NumberOfReplicas; ++replica)
      {
        if (!areSound[replica * stores + store])
        {
          const std::uint32_t host = FindHost(store, replica, stores);
          isDamaged[host] = true;
          obstacles[host] = whole.IsOk() ? obstacles[host] : whole.GetMessage();
        }
      }
    }
    for (std::uint32_t host = 0; host < stores; ++host)
    {
      if (isDamaged[host])
      {
        this->Found.Repairs.push_back(GetStoreFolder(this->Files, this->Path, step.Folder, host) +
          (obstacles[host].empty()
              ? ": is damaged; --repair can restore it"
              : ": is damaged; --repair cannot restore all of it: " + obstacles[host]));
      }
    }
  }

  Progress MakeProgress(double begin, double end) const
  {
    return [this, begin, end](double share)
    {
      return !this->Tell ||
        this->Tell(this->PartBegin + this->PartShare * (begin + (end - begin) * share));
    };
  }

  std::string Path;
  FileSystem& Files;
  int Threads;
  const Progress& Tell;
  VolumeOpener Opener;
  const BlockedVolumeHeader* Header;
  double PartBegin = 0;
  double PartShare = 1;
  VolumeVerification Found;
};

} // namespace

Result<VolumeVerification> VerifyBlockedVolume(const std::string& path, FileSystem& files,
  int threads, const Progress& progress, VolumeOpener opener, const BlockedVolumeHeader* header)
{
  return VolumeCheck(path, files, threads, progress, opener, header).Run();
}

} // namespace isosurface
