// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_BenchmarkVolume_h
#define isosurface_BenchmarkVolume_h

#include <cstdint>
#include <vector>

namespace isosurface
{

/**
 * A volume of `side`^3 samples that looks like turbulence: a sum of plane waves of random
 * directions and phases, with wavelengths from side/4 down to 12 samples and amplitudes in
 * proportion to them, scaled to the range of uint16. The same for every call. Cost: some 10 ns a
 * sample and thread.
 */
std::vector<std::uint16_t> MakeBenchmarkVolume(int side, int threads);

/**
 * The isovalue, above the volume's median, at which the share of 32^3-cell blocks that the surface
 * passes comes closest to `share`.
 */
double FindIsovalue(const std::vector<std::uint16_t>& volume, int side, double share, int threads);

} // namespace isosurface

#endif
