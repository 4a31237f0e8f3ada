// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_ImageField_h
#define isosurface_ImageField_h

#include "Ground/Base/CollectiveTask.h"
#include "Ground/Base/Status.h"
#include "Ranks/Query/Field.h"
#include "Storage/Sampling/ImagePlan.h"

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

namespace isosurface
{

/// This rank's part of an image of samples, and of a coarse one that is there sooner: a field of two levels.
/// The exact one may be filled beside the calling thread, by this rank alone.
class ImageField : public Field
{
public:
  /// Begins an execution. `source` tells what the exact image is made of from others. `coarse`: nothing, or
  /// one of the same level, if the exact image is there as soon.
  void Ask(std::uint64_t source, SampledBox exact, std::optional<SampledBox> coarse);
  /// Fills the part of a level, or waits for the thread that does. Errors: SampledBox::Fill.
  Status Fill(int level, const Progress& progress);
  SampledBox& GetBox(int level)
  {
    return this->Coarse && level > this->Exact.Plan.Level ? *this->Coarse : this->Exact;
  }

  std::string GetName() const override;
  bool IsSame() const override { return true; } // else the caller names another change
  int FindFinestLevel(int) const override { return this->Exact.Plan.Level; }
  Result<First> FindFirst(Communicator&, const std::vector<std::uint64_t>&, int finest) override
  {
    return First{ this->Coarse ? this->Coarse->Plan.Level : finest, true };
  }
  Status Prepare(Communicator&, int) override;
  CollectiveTask* GetPrepared() override { return this->Work.get(); }
  void DropPrepared() override;

private:
  LevelsOfVolume Levels;
  std::uint64_t Source = 0; ///< of Exact
  SampledBox Exact;
  std::optional<SampledBox> Coarse;
  std::unique_ptr<CollectiveTask> Work; ///< the last member: it fills Exact
};

} // namespace isosurface

#endif
