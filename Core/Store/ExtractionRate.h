// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_ExtractionRate_h
#define isosurface_ExtractionRate_h

#include <array>
#include <vector>

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
 * rates are those that fit the last extractions best: the least squares of the relative errors
 * (below some milliseconds of the absolute ones), without negative rates. Where these tell nothing
 * of a kind, its rate is that of a usual laptop, faster or slower by as much as this machine is.
 *
 * A value class. Cost of Observe: some microseconds.
 */
class ExtractionRate
{
public:
  double Predict(const ExtractionWork& work) const;
  void Observe(const ExtractionWork& work, double seconds);
  /// Whether anything was measured.
  bool IsKnown() const { return !this->Observations.empty(); }

private:
  static constexpr int Kinds = 5; ///< the query itself, then the members of ExtractionWork
  using Terms = std::array<double, Kinds>;
  struct Observation
  {
    Terms Counts;
    double Seconds;
  };

  static Terms Count(const ExtractionWork& work);
  double FindSpeed() const;
  void Fit();

  static constexpr Terms UsualRates = { 2e-3, 2e-6, 1e-9, 3e-9, 3e-8 }; ///< seconds each
  Terms Rates = UsualRates;
  std::vector<Observation> Observations; ///< the last ones, the oldest first
};

} // namespace isosurface

#endif
