// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_UnloadedRate_h
#define isosurface_UnloadedRate_h

#include "Ranks/Query/ExtractionRate.h"

#include <vector>

namespace isosurface
{

/**
 * Predicts the seconds of an extraction on a machine that does nothing else, from some that may
 * have been slowed down: by a first use, by other programs. Load only ever adds time. So
 * an extraction counts with at most twice the time that the fastest of the last few, relative to
 * its work, suggests; until there are enough of them, a usual laptop is one of these.
 *
 * A value class.
 */
class UnloadedRate
{
public:
  double Predict(const ExtractionWork& work) const { return this->Rate.Predict(work); }
  void Observe(const ExtractionWork& work, double seconds);

private:
  struct Observation
  {
    ExtractionWork Work;
    double Seconds;
  };

  double FindSlowness() const;

  std::vector<Observation> Observations; ///< the last ones, the oldest first
  ExtractionRate Rate;
};

} // namespace isosurface

#endif
