// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_StoredVolume_h
#define isosurface_StoredVolume_h

#include "Formats/Files/VolumeFile.h"

#include "Storage/Sampling/LevelSamples.h"
#include "Storage/Store/BlockedVolume.h"

namespace isosurface
{

/// A blocked volume, or the index of one in place.
class StoredVolume : public VolumeFile
{
public:
  /// Errors and cost: BlockedVolume::Open.
  static Result<std::shared_ptr<StoredVolume>> Open(
    const std::string& path, const OpeningChoice& choice = {});
  /// Of one that is open, with a time step.
  explicit StoredVolume(std::shared_ptr<BlockedVolume> volume, bool hasLocalStores = false);

  const std::string& GetPath() const override { return this->Volume->GetPath(); }
  const std::vector<ArrayDescription>& GetArrays() const override
  {
    return this->Volume->GetHeader().Arrays;
  }
  const std::vector<std::optional<double>>& GetTimes() const override { return this->Times; }
  int GetNumberOfLevels() const override { return this->Volume->GetNumberOfLevels(); }
  LevelDescription Describe(int level) const override;
  /// Cost: LevelSamples::Read for each component; LevelSamples::Open for the first of a level.
  Status Read(const SampleRequest& request, void* samples, const Progress& progress) override;
  Result<std::unique_ptr<BoxSource>> OpenSource(
    std::size_t timeStep, int threads, std::uint64_t memoryBytes) override;
  Result<std::shared_ptr<BlockedVolume>> GetBlocks(
    std::size_t timeStep, const Progress& progress, std::size_t& stepThere) override;

private:
  std::shared_ptr<BlockedVolume> Volume;
  std::vector<std::optional<double>> Times;
  LevelsOfVolume Levels;
};

} // namespace isosurface

#endif
