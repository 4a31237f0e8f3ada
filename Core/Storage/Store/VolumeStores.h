// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_VolumeStores_h
#define isosurface_VolumeStores_h

#include "Ground/Base/FileSystem.h"
#include "Ground/Base/Status.h"
#include "Ground/Volume/VolumeOpener.h"
#include "Storage/Store/BlockCache.h"
#include "Storage/Store/BlockStore.h"
#include "Storage/Store/SpectraFile.h"
#include "Storage/Store/StoreFaults.h"
#include "Storage/Store/StoreSearch.h"
#include "Storage/Store/VolumeLayout.h"

#include <cstddef>
#include <cstdint>
#include <list>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace isosurface
{

class SourceSamples;

/**
 * The stores and spectra of a blocked volume and its overviews, opened when they are first needed.
 * All functions may be called by several threads at once. Errors are those of BlockedVolume.
 */
class VolumeStores
{
public:
  /// `layout` must outlive this object. `cache`, `opener`: for the source of a volume in
  /// place.
  VolumeStores(const VolumeLayout& layout, FileSystem& files, std::shared_ptr<BlockCache> cache,
    VolumeOpener opener);
  VolumeStores(const VolumeStores&) = delete;
  VolumeStores& operator=(const VolumeStores&) = delete;

  const VolumeLayout& GetLayout() const { return this->Layout; }

  Result<std::shared_ptr<BlockStore>> GetStore(const StoreReplica& replica);

  /**
   * Calls `read` with a replica of a store: the preferred one, or, if it is known to be lost or
   * turns out to be, the others, until one succeeds. The fault of the preferred replica is
   * kept in GetFaults(). `ordinal`: the block that is read, if only that is. Errors: that of the
   * first replica, with those of the others; if memory is short or the volume was rewritten, no
   * other one is tried.
   */
  template <typename Read>
  auto ReadReplicas(const StoreReplica& preferred, std::int64_t ordinal, const Read& read)
    -> decltype(read(std::declval<BlockStore&>()))
  {
    ReplicaErrors errors(*this, preferred);
    for (const std::uint32_t replica : this->OrderReplicas(preferred, ordinal))
    {
      StoreReplica where = preferred;
      where.Replica = replica;
      const auto store = this->GetStore(where);
      if (store.IsOk())
      {
        auto result = read(**store);
        if (result.IsOk())
        {
          errors.Keep();
          return result;
        }
        errors.Add(replica, ordinal, result.GetStatus());
      }
      else
      {
        errors.Add(replica, StoreFault::Whole, store.GetStatus());
      }
      if (errors.AreFinal())
      {
        break;
      }
    }
    return errors.Join();
  }

  /// The replica that ReadReplicas would try first.
  std::uint32_t FindReplica(const StoreReplica& preferred, std::int64_t ordinal) const
  {
    return this->OrderReplicas(preferred, ordinal).front();
  }

  StoreFaults& GetFaults() { return this->Faults; }

  /// One sentence about the stores with faults in `news` that were not told before; "" if none.
  std::string DescribeNews(const std::vector<StoreFault>& news);

  /// What isosurfaces take of each store, the same on all ranks: the triangles, or, if the ranks
  /// know that one cannot read the spectra, all blocks in place of triangles. In a part, at the
  /// finest level there. The counts of stores are kept until another variable is asked for.
  Result<StoreWork> FindStoreWork(const BlockQuery& query, std::uint32_t overview);
  Result<std::shared_ptr<const VolumeSpectra>> GetSpectra(
    std::size_t timeStep, std::uint32_t overview);

  /// Ok if the header on disk still has the time step as it was when the volume was opened.
  Status CheckNotRewritten(std::size_t timeStep) const;
  /// BlockedVolume::ReadSource.
  Status ReadSource(std::size_t timeStep, std::size_t variable, const VertexBox& box,
    std::uint8_t* to, QueryStatistics& statistics);
  /// Ok unless the source of a time step is open, and its files were changed since it was indexed.
  Status CheckSource(std::size_t timeStep);

private:
  struct OpenStore
  {
    StoreReplica Where;
    std::shared_ptr<BlockStore> Store;
  };

  /// Why the replicas of a store, or a block in them, could not be read.
  class ReplicaErrors
  {
  public:
    ReplicaErrors(VolumeStores& stores, const StoreReplica& preferred)
      : Stores(stores)
      , Preferred(preferred)
    {
    }
    /// `ordinal`: of the block, if other blocks of the replica may be read.
    void Add(std::uint32_t replica, std::int64_t ordinal, const Status& error);
    /// Whether other replicas would not help.
    bool AreFinal() const { return this->IsFinal; }
    /// Keeps the fault of the preferred replica, now that another one could be read.
    void Keep();
    Status Join() const;

  private:
    VolumeStores& Stores;
    StoreReplica Preferred;
    std::vector<Status> Errors;
    std::optional<StoreFault> Fault;
    bool IsFinal = false;
  };

  /// The triangles of isosurfaces of one variable, by store and bin.
  struct KeptWork
  {
    std::size_t TimeStep = 0;
    std::uint32_t Overview = 0;
    std::size_t Variable = 0;
    std::vector<std::vector<std::uint64_t>> Triangles;
  };

  /// All replicas: sound ones from the preferred one on, then damaged ones, then lost ones.
  std::vector<std::uint32_t> OrderReplicas(
    const StoreReplica& preferred, std::int64_t ordinal) const;
  /// The same by the spectra alone.
  Result<StoreWork> SumTriangles(const BlockQuery& query, std::uint32_t overview);
  Status ReadStoreWork(const BlockQuery& query, std::uint32_t overview);

  /// What has the samples of a time step of a volume in place, opened at the first call. The mutex
  /// is held.
  Result<std::shared_ptr<SourceSamples>> GetSource(std::size_t timeStep);

  const VolumeLayout& Layout;
  FileSystem& Files;
  std::shared_ptr<BlockCache> Cache;
  VolumeOpener Opener;

  StoreFaults Faults;
  std::set<std::pair<std::uint32_t, std::uint32_t>> ToldStores; ///< overview and number
  std::mutex WorkMutex;
  KeptWork Work;

  std::mutex Mutex;
  std::list<OpenStore> OpenStores;                     ///< the most recently used one first
  std::vector<std::shared_ptr<SourceSamples>> Sources; ///< per time step
  /// Per overview and time step.
  std::vector<std::vector<std::shared_ptr<const VolumeSpectra>>> Spectra;
};

} // namespace isosurface

#endif
