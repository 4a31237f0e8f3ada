// SPDX-License-Identifier: BSD-3-Clause
// The range of values of some samples. A part of BrickKernel.txx.
#ifndef isosurface_BrickKernelRanges_txx
#define isosurface_BrickKernelRanges_txx

#include "Surface/Contour/BrickKernelBasics.txx"

namespace isosurface
{
namespace ISOSURFACE_KERNEL
{
namespace
{

// A vector of 32 bytes, an extension of GCC and Clang: operators work on all lanes, and the
// compiler splits them into instructions of the processor.
template <typename T>
struct LanesOf
{
  static constexpr int Count = static_cast<int>(32 / sizeof(T));
  typedef T Type __attribute__((vector_size(32)));
};

template <typename T>
void JoinRows(const SampleRows& rows, T& minimum, T& maximum, bool& notANumber)
{
  using Lanes = typename LanesOf<T>::Type;
  constexpr int width = LanesOf<T>::Count;
  const std::int64_t count = rows.Size[0];
  const std::ptrdiff_t stride = rows.Stride[0];
  Lanes low = Lanes{} + minimum;
  Lanes high = Lanes{} + maximum;
  auto odd = low != low;
  const T* row = static_cast<const T*>(rows.First);
  for (std::int64_t n = 0; n < rows.Size[1]; ++n, row += rows.Stride[1])
  {
    if (stride != 1 || count < width)
    {
      for (std::int64_t i = 0; i < count; ++i)
      {
        const T value = row[i * stride];
        minimum = value < minimum ? value : minimum;
        maximum = maximum < value ? value : maximum;
        notANumber = notANumber || value != value;
      }
      continue;
    }
    for (std::int64_t i = 0; i < count; i += width)
    {
      // The last vector ends at the end of the row, so it may overlap the one before.
      Lanes values;
      __builtin_memcpy(&values, row + (i + width <= count ? i : count - width), sizeof(values));
      low = values < low ? values : low;
      high = high < values ? values : high;
      odd |= values != values;
    }
  }
  for (int lane = 0; lane < width; ++lane)
  {
    minimum = low[lane] < minimum ? low[lane] : minimum;
    maximum = maximum < high[lane] ? high[lane] : maximum;
    notANumber = notANumber || odd[lane] != 0;
  }
}

void JoinRange(
  ValueType type, const SampleRows& rows, void* minimum, void* maximum, bool* notANumber)
{
  Dispatch(type,
    [&](auto zero)
    {
      using T = decltype(zero);
      JoinRows(rows, *static_cast<T*>(minimum), *static_cast<T*>(maximum), *notANumber);
    });
}

} // namespace
} // namespace ISOSURFACE_KERNEL
} // namespace isosurface

#endif
