// SPDX-License-Identifier: BSD-3-Clause
#include "Surface/Contour/BrickKernel.h"

namespace isosurface
{

namespace BaselineKernel
{
extern const BrickKernels Kernels;
}
#ifdef ISOSURFACE_AVX2_KERNEL
namespace Avx2Kernel
{
extern const BrickKernels Kernels;
}
#endif

const BrickKernels& GetBaselineBrickKernels()
{
  return BaselineKernel::Kernels;
}

const BrickKernels* GetAvx2BrickKernels()
{
#ifdef ISOSURFACE_AVX2_KERNEL
  static const bool runs = __builtin_cpu_supports("avx2") && __builtin_cpu_supports("bmi") &&
    __builtin_cpu_supports("bmi2") && __builtin_cpu_supports("popcnt");
  return runs ? &Avx2Kernel::Kernels : nullptr;
#else
  return nullptr;
#endif
}

const BrickKernels& GetBrickKernels()
{
  const BrickKernels* newer = GetAvx2BrickKernels();
  return newer ? *newer : GetBaselineBrickKernels();
}

} // namespace isosurface
