// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_ExtractionRate_h
#define isosurface_ExtractionRate_h

#include <array>

namespace isosurface
{

/// What an extraction has to do on one rank, as far as it can be known beforehand.
struct ExtractionWork
{
  double Blocks = 0;      ///< active ones
  double SampleBytes = 0; ///< of their decoded samples
  double ReadBytes = 0;   ///< of those that are not in the block cache
  double Triangles = 0;
};

/**
 * Seconds that extractions take here: a sum over kinds of work, each with a rate of its own. The
 * rates begin at those of a slow laptop and follow what is measured: each observation multiplies
 * every rate by the ratio of measured to predicted seconds, to the power of its share of the
 * prediction (normalised least mean squares on logarithms), so they stay positive, and what an
 * observation tells nothing of stays as it was.
 *
 * A value class; cost of each call: a few multiplications.
 */
class ExtractionRate
{
public:
  double Predict(const ExtractionWork& work) const;
  void Observe(const ExtractionWork& work, double seconds);
  /// Whether anything was measured.
  bool IsKnown() const { return this->Known; }

private:
  static constexpr int Kinds = 5; ///< the query itself, then the members of ExtractionWork
  using Terms = std::array<double, Kinds>;

  static Terms Count(const ExtractionWork& work);

  Terms Rates = { 2e-3, 2e-6, 1e-9, 3e-9, 3e-8 }; ///< seconds each
  bool Known = false;
};

} // namespace isosurface

#endif
