// SPDX-License-Identifier: BSD-3-Clause
#include "Contour/BrickKernel.h"
#include "TestVolume.h"

#include <gtest/gtest.h>

#include <cstring>
#include <random>

namespace isosurface
{
TEST(BrickKernels, Placeholder) {}
} // namespace isosurface
