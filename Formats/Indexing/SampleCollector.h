// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_SampleCollector_h
#define isosurface_SampleCollector_h

#include "Formats/Indexing/SourceSample.h"
#include "Ground/Volume/VolumeOpener.h"

#include <cstdint>
#include <memory>
#include <mutex>
#include <vector>

namespace isosurface
{

/**
 * Keeps a sample of what somebody else reads of a volume: so a picture grows while the volume is
 * indexed, and nothing is read twice. The slices of the sample are complete in the order of z, if
 * they are read so.
 *
 * Functions may be called by several threads at once.
 */
class SampleCollector
{
public:
  /// For a lattice of every `step`-th vertex of the whole volume.
  explicit SampleCollector(const Index3& step)
    : Step(step)
  {
  }

  /// Replaces the source of the volume by one that lets this object see what is read. It must
  /// outlive the source. Once.
  void Attach(OpenedVolume& volume);

  /// The share of the volume that is complete, from its first slice on.
  double GetShare() const;
  /// The volume of the complete slices. InvalidArgument if there is none.
  Result<SourceSample> MakeSample(FileSystem& files, const SourceIndex& index) const;

private:
  class Source;

  void Add(const BoxSamples& slab, const VertexBox& box);
  /// Complete slices of the lattice, and their vertices. Under the lock.
  std::int64_t CountSlices() const;
  Lattice FindComplete() const;

  const Index3 Step;
  mutable std::mutex Mutex; ///< guards what follows
  SampledVolume Volume;     ///< no vertices before it is attached; the same ever after
  VertexBox Numbers;        ///< of the lattice
  std::vector<std::vector<std::uint8_t>> Samples; ///< of each variable
  std::vector<bool> IsKnown;                      ///< of each vertex
  std::vector<std::int64_t> KnownOfSlice;         ///< how many vertices
};

} // namespace isosurface

#endif
