// SPDX-License-Identifier: BSD-3-Clause
#include "Contour/AttributeInterpolator.h"

#include <cmath>
#include <cstring>
#include <limits>
#include <type_traits>

namespace isosurface
{
namespace
{

// v0 + t * (v1 - v0). A product beyond the type's range (t is NaN, say) must not be converted.
template <typename T>
T InterpolateValue(T v0, T v1, double t)
{
  if constexpr (std::is_floating_point_v<T>)
  {
    return static_cast<T>(static_cast<double>(v0) + t * static_cast<double>(v1 - v0));
  }
  else
  {
    const double first = static_cast<double>(v0);
    const double value = first + t * (static_cast<double>(v1) - first);
    const double end = std::ldexp(1.0, std::numeric_limits<T>::digits);
    return value >= static_cast<double>(std::numeric_limits<T>::min()) && value < end
      ? static_cast<T>(value)
      : (t > 0.5 ? v1 : v0);
  }
}

// Takes the tuples at edges as they are.
void CopyTuples(const AttributeView& view, const Index3& low, const EdgeCode* codes,
  std::size_t count, std::uint8_t* tuples)
{
  const VertexBox& box = view.Samples.Available;
  const Index3 size = box.GetSize();
  const std::size_t width =
    GetValueSize(view.Samples.Type) * static_cast<std::size_t>(view.NumberOfComponents);
  for (std::size_t n = 0; n < count; ++n)
  {
    Index3 vertex = low;
    for (unsigned axis = 0; axis < 3; ++axis)
    {
      vertex[axis] += (codes[n] >> (6 * axis) & 63) - box.Low[axis];
    }
    const auto place =
      static_cast<std::size_t>(vertex[0] + size[0] * (vertex[1] + size[1] * vertex[2]));
    std::memcpy(tuples + n * width, view.Edges[codes[n] >> 18] + place * width, width);
  }
}

} // namespace

void InterpolateAttribute(const AttributeView& view, const Index3& low, const EdgeCode* codes,
  const double* parameters, std::size_t count, std::uint8_t* tuples)
{
  if (view.Edges[0])
  {
    CopyTuples(view, low, codes, count, tuples);
    return;
  }
  DispatchValueType(view.Samples.Type,
    [&](auto zero)
    {
      using T = decltype(zero);
      const T* first = view.Samples.At<T>(low);
      T* out = reinterpret_cast<T*>(tuples);
      for (std::size_t n = 0; n < count; ++n)
      {
        const EdgeCode code = codes[n];
        const T* from = first;
        for (unsigned axis = 0; axis < 3; ++axis)
        {
          from += static_cast<std::ptrdiff_t>(code >> (6 * axis) & 63) * view.Samples.Stride[axis];
        }
        const T* to = from + view.Samples.Stride[code >> 18];
        for (int component = 0; component < view.NumberOfComponents; ++component)
        {
          const std::ptrdiff_t offset = component * view.ComponentStride;
          *out++ = InterpolateValue(from[offset], to[offset], parameters[n]);
        }
      }
    });
}

} // namespace isosurface
