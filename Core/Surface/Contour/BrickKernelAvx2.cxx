// SPDX-License-Identifier: BSD-3-Clause
// The inner loops for x86-64 processors with AVX2, BMI and POPCNT; compiled with these switched on.
#define ISOSURFACE_KERNEL Avx2Kernel
#include "Surface/Contour/BrickKernel.txx"
