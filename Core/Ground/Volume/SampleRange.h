// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_SampleRange_h
#define isosurface_SampleRange_h

#include "Ground/Base/Communicator.h"
#include "Ground/Volume/SampleView.h"
#include "Ground/Volume/ValueKey.h"

#include <cstdint>
#include <vector>

namespace isosurface
{

/// The range of samples: of all of them, and of the finite ones.
struct SampleRange
{
  KeyRange All;
  KeyRange Finite;

  void Add(const SampleRange& other);
};

/// The range of the samples in `box`. Cost: one pass over them, two if there are infinities.
SampleRange FindSampleRange(const SampleView& samples, const VertexBox& box);

/// The keys of the isovalues' thresholds, ascending, each once. Isovalues above all values of the
/// type have none.
std::vector<ValueKey> FindThresholdKeys(ValueType type, const std::vector<double>& isovalues);

/// Ranges that become those of all ranks.
class CommonRanges
{
public:
  /// The range must outlive this object, in its place.
  void Add(KeyRange& range);
  /// Makes each range that of all ranks, which have added as many. Collective.
  void Join(Communicator& ranks);

private:
  std::vector<KeyRange*> Ranges;
  std::vector<std::uint64_t> Minima;
  std::vector<std::uint64_t> Maxima;
};

} // namespace isosurface

#endif
