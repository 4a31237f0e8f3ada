// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_BenchmarkVolume_h
#define isosurface_BenchmarkVolume_h

#include <cstdint>
#include <vector>

namespace isosurface
{

/**
 * Makes a volume of `side`^3 samples that looks like turbulence: a sum of plane waves of random
 * directions and phases, with wavelengths from side/4 down to 12 samples and amplitudes
 * proportional to them, scaled to the range of uint16. Deterministic. Cost: about 10 ns a sample
 * and thread.
 */
std::vector<std::uint16_t> MakeBenchmarkVolume(int side, int threads);

} // namespace isosurface

#endif
