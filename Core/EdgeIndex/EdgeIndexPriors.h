// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_EdgeIndexPriors_h
#define isosurface_EdgeIndexPriors_h

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>

namespace isosurface
{

struct BlockModel;
struct NetworkSignModel;
struct ResidualModel;
struct SignModel;
struct ValueModel;

/// What magnitudes are like before any came; see ResidualModel.
struct ResidualPriors
{
  std::array<std::int8_t, 512> ByLevel;    ///< stretched probabilities / 16
  std::array<std::uint16_t, 4096> Symbols; ///< cumulative, 16 for each level and side; the first 0
  std::array<std::int16_t, 512> Mixers;
};

/// The same of magnitudes whose contexts are always mixed.
struct MixedResidualPriors
{
  std::array<std::int8_t, 512> ByLevel;
  std::array<std::int16_t, 512> Mixers;
};

/**
 * What a model knows before its first block: learnt from Debian's scans and generated fields by
 * Benchmarks/TrainEdgeIndexPriors.cxx, which writes EdgeIndexPriors.cxx. Part of the format.
 */
struct EdgeIndexPriors
{
  std::array<std::int8_t, 8192> Near; ///< stretched probabilities / 16
  std::array<std::int8_t, 8> Quiet;
  std::array<std::int16_t, 1024> SignMixers;
  ResidualPriors Values;
  ResidualPriors Crossings;
  std::array<std::int32_t, 16> Weights; ///< of the two profiles' filter
};
extern const EdgeIndexPriors Priors;

/// Of the crossings of the scheme Compact; written likewise, to CurvedCrossingPriors.cxx.
extern const MixedResidualPriors CurvedCrossingPriors;

/// Gives a model what is known before its first block.
void ApplyPriors(SignModel& model);
void ApplyPriors(NetworkSignModel& model);
void ApplyPriors(ResidualModel& model, const ResidualPriors& priors);
void ApplyPriors(ResidualModel& model, const MixedResidualPriors& priors);
void ApplyPriors(ValueModel& model);

/// The source text of EdgeIndexPriors.cxx, of models of both profiles that have seen many blocks.
std::string WritePriors(const BlockModel& mixed, const BlockModel& fast);

/// The source text of CurvedCrossingPriors.cxx, of a model that has seen many blocks.
std::string WriteCrossingPriors(const BlockModel& compact);

/// Makes what is known by sides what is known by the level alone, as it is at the begin of a block.
void ForgetSides(ResidualModel& model);

} // namespace isosurface

#endif
