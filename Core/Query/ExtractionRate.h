// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_ExtractionRate_h
#define isosurface_ExtractionRate_h

#include <array>
#include <cstddef>
#include <vector>

namespace isosurface
{

/// What an extraction has to do on one rank, as far as it can be known beforehand.
struct ExtractionWork
{
  double Blocks = 0;      ///< active ones
  double SampleBytes = 0; ///< of their decoded samples
  double BlocksRead = 0;  ///< those that are not in the block cache: places that a disk seeks
  double ReadBytes = 0;   ///< of these
  double Triangles = 0;
};

/**
 * Seconds that extractions take here: a sum over kinds of work, each with a rate of its own. The
 * rates are those that fit the last extractions best: the least squares of the relative errors
 * (below some milliseconds of the absolute ones), without negative rates. Where these tell nothing
 * of a kind, its rate is that of a usual laptop, faster or slower by as much as this machine is.
 * What is read beyond the most that was read before takes a usual disk's time at least: few blocks
 * may have come from memory, or lain side by side, where many more do not.
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
  double FindMost(std::size_t kind) const;
  void Fit();

  static constexpr Terms UsualRates = { 2e-3, 2e-6, 1e-9, 2e-4, 3e-9, 3e-8 }; ///< s
  Terms Rates = UsualRates;
  std::vector<Observation> Observations; ///< the last ones, the oldest first
};

} // namespace isosurface

#endif
