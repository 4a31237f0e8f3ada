// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_ExtractionRate_h
#define isosurface_ExtractionRate_h

#include <array>
#include <cstddef>
#include <vector>

namespace isosurface
{

/// The work of an extraction on one rank, as far as it is known beforehand.
struct ExtractionWork
{
  double Blocks = 0;      ///< active ones
  double SampleBytes = 0; ///< of their decoded samples
  double BlocksRead = 0;  ///< blocks that are not in the block cache: seeks of a disk
  double ReadBytes = 0;   ///< of these blocks
  double Triangles = 0;
};

/**
 * Predicts the seconds of an extraction: a sum over kinds of work, each with a rate of its own. The
 * rates are fitted to the last extractions: they minimise the squares of the relative errors (below
 * some milliseconds, of the absolute ones), and none is negative. A kind that these do not
 * determine has the rate of a usual laptop, scaled by this machine's speed relative to it. Reads
 * beyond the maximum of earlier ones take at least the time of a usual disk, since a few blocks may
 * have come from memory or one after another.
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
  static constexpr std::size_t Kinds = 6; ///< the query itself, then the members of ExtractionWork
  static constexpr std::array<std::size_t, 2> ReadKinds = { 3, 4 }; ///< of these, those of a disk
  using Terms = std::array<double, Kinds>;
  struct Observation
  {
    Terms Counts;
    double Seconds;
  };

  static Terms Count(const ExtractionWork& work);
  double FindSpeed() const;
  double FindMaximum(std::size_t kind) const;
  void Fit();

  static constexpr Terms UsualRates = { 2e-3, 2e-6, 1e-9, 2e-4, 3e-9, 3e-8 }; ///< s
  Terms Rates = UsualRates;
  std::vector<Observation> Observations; ///< the last ones, the oldest first
};

} // namespace isosurface

#endif
