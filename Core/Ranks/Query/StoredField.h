// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_StoredField_h
#define isosurface_StoredField_h

#include "Ranks/Query/Field.h"
#include "Ranks/Query/VolumeContour.h"

#include <chrono>
#include <memory>

namespace isosurface
{

/// A blocked volume, whose spectra tell what each level costs; or the sample of one that is being
/// written, with its exact layers (FinishedLayers).
class StoredField : public Field
{
public:
  /// Begins an execution. Of the task, the volume is not kept alive. `sampled`: the path of the volume
  /// that it is a sample of, or empty.
  void Ask(const ExtractionTask& task, const ExtractionBudget& budget, const std::string& sampled);
  const ExtractionRate& GetRate() const { return this->Contour.GetRate(); }

  std::string GetName() const override { return this->GetVolume()->GetPath(); }
  bool IsSame() const override { return this->Same; }
  bool IsThere() const override { return !this->Volume.expired(); }
  int FindFinestLevel(int level) const override;
  Result<First> FindFirst(Communicator& ranks, int finest) override;
  int GetNextLevel(int level, int finest) const override;
  Result<int> FitLevel(Communicator& ranks, int level) override;
  Result<double> EstimateTriangles(int level) override;
  double EstimateBytes(double triangles) const override;
  Status Extract(Communicator& ranks, int level, ExtractionOutcome& outcome) override;
  Status Prepare(Communicator& ranks, int level) override;
  CollectiveTask* GetPrepared() override { return this->Contour.GetPrepared(); }
  void DropPrepared() override { this->Contour.DropPrepared(); }
  void Forget() override;

  bool IsOfLastSample() const override { return this->OfLastSample; }
  bool BeginSample(bool isWanted) override;
  bool Grows() const override { return this->Layers && !this->Layers->HasFailed; }
  Refinement Grow(Communicator& ranks, std::size_t triangles, std::uint64_t freeMemory) override;
  void EndGrowth(bool hasFailed) override;

private:
  using Clock = std::chrono::steady_clock;

  /// The exact layers of a sample.
  struct Growth
  {
    explicit Growth(std::shared_ptr<FinishedLayers> finished)
      : Finished(std::move(finished))
    {
    }
    ~Growth() { this->Show(false); }
    Growth(const Growth&) = delete;
    Growth& operator=(const Growth&) = delete;
    /// Tells the layers' writer whether they are shown.
    void Show(bool shows);

    const std::shared_ptr<FinishedLayers> Finished;
    bool AreShown = false;
    std::int64_t Slices = 0;     ///< of cells that the surface has exactly
    std::int64_t NextSlices = 0; ///< those of the prepared one
    Clock::time_point Begin;     ///< when extracting it began
    Clock::time_point Due;       ///< before which the next one does not begin
    bool HasGrown = false;       ///< whether Due is to be found
    bool HasFailed = false;      ///< on any rank
  };

  /// Null when the execution has ended, and nobody else has it.
  std::shared_ptr<BlockedVolume> GetVolume() const { return this->Volume.lock(); }
  /// Makes the extraction of the surface with `slices` of exact layers.
  ExtractionTask MakeTask(std::int64_t slices) const;
  Status PrepareTask(const ExtractionTask& task, int level);
  /// How many slices of exact layers the surface is to have, and its triangles. Collective.
  std::int64_t ChooseSlices(Communicator& ranks, std::int64_t finished, std::size_t triangles,
    Refinement& refinement) const;
  /// Whether `slices` of exact layers are due, and there is memory for them. Collective.
  bool IsGrowthDue(
    Communicator& ranks, std::int64_t slices, std::uint64_t freeMemory, Refinement& refinement);

  VolumeContour Contour;
  std::weak_ptr<BlockedVolume> Volume;
  ExtractionTask Task; ///< without the volume
  ExtractionBudget Budget;
  std::string AskedSampled; ///< what was asked
  std::string Sampled;      ///< the volume until whose finer surface this one may stay; or empty
  bool Same = false;
  bool OfLastSample = false;
  std::unique_ptr<Growth> Layers; ///< of a sample whose surface may become exact
};

} // namespace isosurface

#endif
