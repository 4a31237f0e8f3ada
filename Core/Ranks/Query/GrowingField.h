// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_GrowingField_h
#define isosurface_GrowingField_h

#include "Ranks/Query/StoredField.h"
#include "Storage/Store/FinishedLayers.h"

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>

namespace isosurface
{

/// A blocked volume, or the sample of one that is being written: then the surface of the sample becomes
/// exact where layers of the volume are finished, up to a seam that moves on. Its last one may stay until
/// there is a finer one of the volume.
class GrowingField : public StoredField
{
public:
  /// Begins an execution (StoredField::Ask). If `task.Volume` is a sample: `finished` has the layers of the
  /// volume, and `sampled` is the volume's path; else null and empty.
  void Ask(const ExtractionTask& task, const ExtractionBudget& budget,
    std::shared_ptr<FinishedLayers> finished, const std::string& sampled);

  /// With the exact layers that EndGrowth has chosen, which ranks do not share.
  Status Extract(Communicator& ranks, int level, ExtractionOutcome& outcome) override;

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

  /// Extracts the first `slices` of cells exactly, and of the sample only the cells behind them.
  Extraction MakeExtraction(std::int64_t slices) const;
  /// How many slices of exact layers the surface is to have, and its triangles. Collective.
  std::int64_t ChooseSlices(Communicator& ranks, std::int64_t finished, std::size_t triangles,
    Refinement& refinement) const;
  /// Whether `slices` of exact layers are due, and there is memory for them. Collective.
  bool IsGrowthDue(
    Communicator& ranks, std::int64_t slices, std::uint64_t freeMemory, Refinement& refinement);

  std::shared_ptr<FinishedLayers> AskedLayers; ///< what was asked, as the path
  std::string AskedSampled;
  std::string Sampled; ///< the volume until whose finer surface this one may stay; or empty
  bool OfLastSample = false;
  std::unique_ptr<Growth> Layers; ///< of a sample whose surface may become exact
};

} // namespace isosurface

#endif
