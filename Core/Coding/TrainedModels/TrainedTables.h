// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_TrainedTables_h
#define isosurface_TrainedTables_h

#include <array>
#include <cstdint>

// The tables of priors.txt, curved-crossings.txt and sign-network.txt, part of the edge-index
// format. Documentation/formats/edge-index.md, "Tables", says what each number means.
namespace isosurface
{

// Signs of vertices.
extern const std::array<std::int8_t, 8192> NearSignPriors; ///< stretched probabilities / 16
extern const std::array<std::int8_t, 8> QuietSignPriors;   ///< likewise
extern const std::array<std::int16_t, 1024> SignMixers;

// Magnitudes: levels are stretched probabilities / 16, symbols are cumulative shares.
extern const std::array<std::int8_t, 512> ValueLevels;
extern const std::array<std::uint16_t, 4096> ValueSymbols;
extern const std::array<std::int16_t, 512> ValueMixers;
extern const std::array<std::int8_t, 512> CrossingLevels;
extern const std::array<std::uint16_t, 4096> CrossingSymbols;
extern const std::array<std::int16_t, 512> CrossingMixers;
extern const std::array<std::int8_t, 512> CurvedCrossingLevels;
extern const std::array<std::int16_t, 512> CurvedCrossingMixers;

/// The first weights of the filter that predicts values.
extern const std::array<std::int32_t, 16> ValueWeights;

// The network that predicts signs: rows of SignNetworkWeights one after the other.
extern const std::array<std::int16_t, 5888> SignNetworkFirst;
extern const std::array<std::int16_t, 1024> SignNetworkSecond;
extern const std::array<std::int32_t, 16> SignNetworkSecondAdded;
extern const std::array<std::int16_t, 16> SignNetworkThird;
extern const std::array<std::int32_t, 1> SignNetworkThirdAdded;

/// The tables that a model of magnitudes begins with.
struct MagnitudeTables
{
  const std::array<std::int8_t, 512>* Levels = nullptr;
  const std::array<std::uint16_t, 4096>* Symbols = nullptr; ///< of the profile fast only
  const std::array<std::int16_t, 512>* Mixers = nullptr;    ///< of the other profiles only
};

} // namespace isosurface

#endif
