// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_GrowingField_h
#define isosurface_GrowingField_h

#include "Ranks/Query/SightedBox.h"
#include "Ranks/Query/StoredField.h"
#include "Storage/Store/FinishedLayers.h"

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace isosurface
{

/// A blocked volume, or the sample of one that is being written: then the surface of the sample becomes
/// exact where layers of the volume are finished, up to a seam that moves on, and before that where a person looks
/// (FinishedLayers::LookAlong): in a box around the surface in the middle of the view, which grows. Its last one may
/// stay until there is a finer one of the volume.
class GrowingField : public StoredField
{
public:
  /// Begins an execution (StoredField::Ask). If `task.Volume` is a sample: `finished` has the layers of the
  /// volume, and `sampled` is the volume's path; else null and empty.
  void Ask(const ExtractionTask& task, const ExtractionBudget& budget,
    std::shared_ptr<FinishedLayers> finished, const std::string& sampled);

  /// With the exact parts that EndGrowth has chosen, which ranks do not share.
  Status Extract(Communicator& ranks, int level, ExtractionOutcome& outcome) override;

  void Forget() override;
  bool IsOfLastSample() const override { return this->OfLastSample; }
  bool BeginSample(bool isWanted) override;
  bool Grows() const override { return this->Layers && !this->Layers->HasFailed; }
  Refinement Grow(Communicator& ranks, std::size_t triangles, std::uint64_t freeMemory) override;
  void EndGrowth(bool hasFailed) override;

private:
  using Clock = std::chrono::steady_clock;

  /// What is exact.
  struct ExactPart
  {
    std::int64_t Number = 0; ///< each has another one
    std::int64_t Slices = 0; ///< of cells, from the first one on
    SightedBox Box;
  };

  /// What is looked at. It is as far as it was when somebody looked there, whatever has become exact since.
  struct Look
  {
    Sight Along;
    double Distance = 0;
    std::size_t Boxes = 0; ///< that have been shown or need not be
  };

  /// The exact parts of a sample.
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
    ExactPart Shown;
    ExactPart Next; ///< that of the prepared surface
    std::optional<Look> Sighted;
    Clock::time_point Begin; ///< when extracting it began
    Clock::time_point Due;   ///< before which the next one does not begin
    bool HasGrown = false;   ///< whether Due is to be found
    bool HasFailed = false;  ///< on any rank
  };

  /// Extracts a part exactly, and of the sample only the cells beyond it.
  Extraction MakeExtraction(const ExactPart& part) const;
  /// Keeps some points of a surface, to find what is looked at.
  void KeepPoints(const Surface& surface);
  /// How far the first point of the surface near the middle of a view is. Collective.
  double FindDistance(Communicator& ranks, const Sight& sight) const;
  /// The next box that is wanted of what is looked at. Collective.
  std::optional<SightedBox> FindNextBox(Communicator& ranks);
  /// Begins to extract what Growth::Next says. Collective.
  void PrepareNext(Communicator& ranks);
  double FindShare(const ExactPart& part) const;
  /// How many slices of exact layers the surface is to have, and its triangles. Collective.
  std::int64_t ChooseSlices(Communicator& ranks, std::int64_t finished, std::size_t triangles,
    Refinement& refinement) const;
  /// Whether `slices` of exact layers are due, and there is memory for them. Collective.
  bool IsGrowthDue(
    Communicator& ranks, std::int64_t slices, std::uint64_t freeMemory, Refinement& refinement);
  /// Whether there is memory for the triangles of a refinement. Collective.
  bool FitsMemory(Communicator& ranks, std::uint64_t freeMemory, Refinement& refinement) const;
  /// The triangles that a surface has where the sample's has some; estimated.
  double FindExactTriangles(double ofSample) const;

  std::shared_ptr<FinishedLayers> AskedLayers; ///< what was asked, as the path
  std::string AskedSampled;
  std::vector<std::array<double, 3>> Points; ///< of the surface
  std::string Sampled; ///< the volume until whose finer surface this one may stay; or empty
  bool OfLastSample = false;
  std::unique_ptr<Growth> Layers; ///< of a sample whose surface may become exact
};

} // namespace isosurface

#endif
