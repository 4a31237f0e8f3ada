// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_TrainedTables_h
#define isosurface_TrainedTables_h

#include <array>
#include <cstdint>

// The tables of priors.txt, part of the edge-index format. Documentation/formats/edge-index.md,
// "Tables", says what each number means.
namespace isosurface
{

// Signs of vertices.
extern const std::array<std::int8_t, 8192> NearSignPriors; ///< stretched probabilities / 16
extern const std::array<std::int8_t, 8> QuietSignPriors;   ///< likewise
extern const std::array<std::int16_t, 1024> SignMixers;

// Magnitudes: levels are stretched probabilities / 16, symbols are cumulative shares.
extern const std::array<std::int8_t, 512> ValueLevels;
extern const std::array<std::int16_t, 512> ValueMixers;
extern const std::array<std::int8_t, 512> CrossingLevels;
extern const std::array<std::uint16_t, 4096> CrossingSymbols;
extern const std::array<std::int16_t, 512> CrossingMixers;

/// The first weights of the filter that predicts values.
extern const std::array<std::int32_t, 16> ValueWeights;

} // namespace isosurface

#endif
