// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_FixedDepths_h
#define isosurface_FixedDepths_h

#include <cstddef>

namespace isosurface
{

/**
 * Makes depths of the numbers that a depth buffer of 32 bits has, from 0 (near) to 2^32 - 1 (far),
 * in place: each of `depths` has the bits of a number at first. They are those that Mesa gives: the
 * quotients by 2^32 - 1, as doubles, rounded to floats. Cost: that of the memory where nothing was
 * drawn.
 */
void ConvertFixedDepths(float* depths, std::size_t count);

} // namespace isosurface

#endif
