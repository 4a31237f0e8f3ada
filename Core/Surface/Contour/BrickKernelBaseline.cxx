// SPDX-License-Identifier: BSD-3-Clause
// The inner loops for every processor of the platform.
#define ISOSURFACE_KERNEL BaselineKernel
#include "Surface/Contour/BrickKernel.txx"
