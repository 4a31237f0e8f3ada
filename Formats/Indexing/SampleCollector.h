// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_SampleCollector_h
#define isosurface_SampleCollector_h

#include "Formats/Indexing/SourceSample.h"
#include "Ground/Base/Communicator.h"
#include "Ground/Volume/VolumeOpener.h"

#include <cstdint>
#include <mutex>
#include <vector>

namespace isosurface
{

/**
 * Keeps a sample of the boxes that the index writer reads of a volume: so a picture grows while it is
 * indexed, and nothing is read twice. The slices of the sample are complete in the order of z, if
 * they are read so. Ranks that read parts of the volume tell each other what they know (Pack).
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

  /// Of this volume. Once.
  void Begin(const OpenedVolume& volume);
  /// What was read of the volume (BlockedVolumeSettings::WhenRead).
  void Add(const BoxSamples& slab, const VertexBox& box);

  /// How many slices of the sample are complete, from the first one on.
  std::int64_t CountSlices() const;
  /// The share of the volume that these first slices stand for.
  double GetShare(std::int64_t slices) const;
  /// The volume of these first slices, which are complete. InvalidArgument if there is none.
  Result<SourceSample> MakeSample(
    FileSystem& files, const SourceIndex& index, std::int64_t slices) const;

  /// What is known of the sample from a slice on.
  Message Pack(std::int64_t fromSlice) const;
  /// Adds what another collector of the same volume has packed; nothing before this one has begun.
  /// False if it does not fit.
  bool Unpack(const Message& message);

private:
  /// Under the lock.
  void MarkKnown(std::size_t first, std::size_t count);
  std::int64_t GetVerticesOfSlice() const { return this->Numbers.High[0] * this->Numbers.High[1]; }
  Lattice FindSlices(std::int64_t slices) const;

  const Index3 Step;
  mutable std::mutex Mutex;                       ///< guards what follows
  SampledVolume Volume;                           ///< no vertices before Begin; the same ever after
  VertexBox Numbers;                              ///< of the lattice
  std::vector<std::vector<std::uint8_t>> Samples; ///< of each variable
  std::vector<bool> IsKnown;                      ///< of each vertex
  std::vector<std::int64_t> KnownOfSlice;         ///< how many vertices
};

} // namespace isosurface

#endif
