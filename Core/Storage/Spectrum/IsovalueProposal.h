// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_IsovalueProposal_h
#define isosurface_IsovalueProposal_h

#include "Storage/Spectrum/WorkloadSpectrum.h"

#include <optional>
#include <vector>

namespace isosurface
{

/**
 * An isovalue to begin with, if nothing is known but how often values occur: that which divides the
 * samples into the two classes whose means differ most beside the spread within them. It is rounded to
 * a power of ten, at most a fiftieth of what the means are apart. Nothing if there are not two values.
 * `values` ascend; each has its count.
 *
 * Source: N. Otsu, "A threshold selection method from gray-level histograms", IEEE Transactions on
 * Systems, Man, and Cybernetics, 1979.
 */
std::optional<double> ProposeIsovalue(
  const std::vector<double>& values, const std::vector<double>& counts);

/// The same for the samples of a volume, whose counts are what the volume loses from one isovalue to
/// the next.
std::optional<double> ProposeIsovalue(const WorkloadSpectrum& spectrum);

} // namespace isosurface

#endif
