// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_VolumeStores_h
#define isosurface_VolumeStores_h

#include "Base/FileSystem.h"
#include "Base/Status.h"
#include "Store/BlockCache.h"
#include "Store/BlockReference.h"
#include "Store/BlockStore.h"
#include "Store/BlockedVolumeHeader.h"
#include "Store/VolumeSpectra.h"
#include "Volume/ArrayVariables.h"
#include "Volume/BlockGrid.h"

#include <cstddef>
#include <cstdint>
#include <list>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

namespace isosurface
{

class SourceSamples;

/// The volume itself, or one of its overviews.
struct VolumePart
{
  BlockedVolumeHeader Header;
  BlockGrid Grid;
  int FirstLevel = 0;                    ///< the finest level here, among those of the volume
  std::vector<std::uint64_t> Identities; ///< per time step: Dataset of its BlockCacheKey
};

/**
 * The stores and spectra of a blocked volume and its overviews, opened when they are first needed.
 * All functions may be called by several threads at once. Errors are those of BlockedVolume.
 */
class VolumeStores
{
public:
  /// `text`: that of the header's file. `cache`: for the chunks of a volume in place.
  VolumeStores(std::string path, FileSystem& files, std::string text,
    const BlockedVolumeHeader& header, std::shared_ptr<BlockCache> cache);
  VolumeStores(const VolumeStores&) = delete;
  VolumeStores& operator=(const VolumeStores&) = delete;

  const std::string& GetPath() const { return this->Path; }
  const BlockedVolumeHeader& GetHeader() const { return this->Parts.front().Header; }
  /// The checksum of the header's text.
  std::uint64_t GetFingerprint() const { return this->Fingerprint; }
  const ArrayVariables& GetVariables() const { return this->Variables; }

  /// The volume, then its overviews from the finest to the coarsest.
  const std::vector<VolumePart>& GetParts() const { return this->Parts; }
  int GetNumberOfLevels() const;
  /// `level` must be one of the volume's.
  StoredLevel FindLevel(int level) const;
  /// The lines of a level of a rectilinear grid; null of other grids. They stay where they are.
  const GridLines* GetLines(int level) const
  {
    return this->Lines.empty() ? nullptr : &this->Lines[static_cast<std::size_t>(level)];
  }
  /// Whether the samples of a level are in the volume's source.
  bool IsInSource(const StoredLevel& stored) const
  {
    return stored.Part == 0 && this->GetHeader().IsInPlace();
  }
  BlockCacheKey MakeKey(std::int64_t block, std::size_t timeStep, std::size_t variable,
    const StoredLevel& stored) const;

  Result<std::shared_ptr<BlockStore>> GetStore(
    std::size_t timeStep, std::uint32_t part, std::uint32_t store);
  Result<std::shared_ptr<const VolumeSpectra>> GetSpectra(std::size_t timeStep, std::uint32_t part);

  /// Ok if the header on disk still has the time step as it was when the volume was opened.
  Status CheckNotRewritten(std::size_t timeStep) const;

private:
  struct OpenStore
  {
    std::size_t TimeStep;
    std::uint32_t Part;
    std::uint32_t Index;
    std::shared_ptr<BlockStore> Store;
  };

  void AddPart(const BlockedVolumeHeader& header);
  /// What has the samples of a time step of a volume in place, opened at the first call. The mutex is
  /// held.
  Result<std::shared_ptr<SourceSamples>> GetSource(std::size_t timeStep);

  std::string Path;
  FileSystem& Files;
  std::string HeaderText;
  std::shared_ptr<BlockCache> Cache;
  std::uint64_t Fingerprint;
  ArrayVariables Variables;
  std::vector<VolumePart> Parts;
  std::vector<GridLines> Lines; ///< per level, of a rectilinear grid

  std::mutex Mutex;
  std::list<OpenStore> OpenStores;                     ///< the most recently used one first
  std::vector<std::shared_ptr<SourceSamples>> Sources; ///< per time step
  /// Per part and time step.
  std::vector<std::vector<std::shared_ptr<const VolumeSpectra>>> Spectra;
};

} // namespace isosurface

#endif
