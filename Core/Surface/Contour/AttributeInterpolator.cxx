// SPDX-License-Identifier: BSD-3-Clause
#include "Surface/Contour/AttributeInterpolator.h"

#include <cstring>
#include <type_traits>

namespace isosurface
{
namespace
{

// v0 + t * (v1 - v0), without overflow.
template <typename T>
double InterpolateValue(T v0, T v1, double t)
{
  if constexpr (std::is_floating_point_v<T>)
  {
    return static_cast<double>(v0) + t * static_cast<double>(v1 - v0);
  }
  else
  {
    const double first = static_cast<double>(v0);
    return first + t * (static_cast<double>(v1) - first);
  }
}

template <typename T, typename Out>
void InterpolateComponent(const SampleView& samples, const T* first, const EdgeCode* codes,
  const double* parameters, std::size_t count, Out* out, std::size_t step)
{
  // Axis 3 is the code of a vertex.
  const std::ptrdiff_t along[4] = { samples.Stride[0], samples.Stride[1], samples.Stride[2], 0 };
  for (std::size_t n = 0; n < count; ++n, out += step)
  {
    const EdgeCode code = codes[n];
    const T* from = first;
    for (unsigned axis = 0; axis < 3; ++axis)
    {
      from += static_cast<std::ptrdiff_t>(code >> (6 * axis) & 63) * samples.Stride[axis];
    }
    *out = static_cast<Out>(InterpolateValue(*from, from[along[code >> 18]], parameters[n]));
  }
}

} // namespace

void InterpolateAttribute(const AttributeView& view, const Index3& low, const EdgeCode* codes,
  const double* parameters, std::size_t count, std::uint8_t* tuples)
{
  const std::size_t components = view.Components.size();
  for (std::size_t component = 0; component < components; ++component)
  {
    const SampleView& samples = view.Components[component];
    DispatchValueType(samples.Type,
      [&](auto zero)
      {
        using T = decltype(zero);
        using Out = std::conditional_t<std::is_same_v<T, double>, double, float>;
        InterpolateComponent(samples, samples.At<T>(low), codes, parameters, count,
          reinterpret_cast<Out*>(tuples) + component, components);
      });
  }
}

void CopyEdgeTuples(const EdgeTupleView& view, const Index3& low, const EdgeCode* codes,
  std::size_t count, std::uint8_t* tuples)
{
  const Index3 size = view.Box.GetSize();
  const std::size_t width =
    GetValueSize(view.Type) * static_cast<std::size_t>(view.NumberOfComponents);
  for (std::size_t n = 0; n < count; ++n, tuples += width)
  {
    Index3 vertex = low;
    for (unsigned axis = 0; axis < 3; ++axis)
    {
      vertex[axis] += (codes[n] >> (6 * axis) & 63) - view.Box.Low[axis];
    }
    const auto place =
      static_cast<std::size_t>(vertex[0] + size[0] * (vertex[1] + size[1] * vertex[2]));
    std::memcpy(tuples, view.First[codes[n] >> 18] + place * width, width);
  }
}

} // namespace isosurface
