// SPDX-License-Identifier: BSD-3-Clause
#include "Ground/Volume/Magnitude.h"

#include "Ground/Volume/SampleCopy.h"

#include <cmath>

namespace isosurface
{
namespace
{

template <typename T>
void AddSquares(const T* from, std::ptrdiff_t stride, std::int64_t count, double* sums)
{
  for (std::int64_t i = 0; i < count; ++i)
  {
    const auto value = static_cast<double>(from[i * stride]);
    const double square = value * value;
    sums[i] += square;
  }
}

} // namespace

void ComputeMagnitudes(
  const std::vector<SampleView>& components, const VertexBox& box, double* magnitudes)
{
  const Index3 size = box.GetSize();
  double* row = magnitudes;
  for (std::int64_t k = box.Low[2]; k < box.High[2]; ++k)
  {
    for (std::int64_t j = box.Low[1]; j < box.High[1]; ++j, row += size[0])
    {
      for (std::int64_t i = 0; i < size[0]; ++i)
      {
        row[i] = 0;
      }
      for (const SampleView& component : components)
      {
        DispatchValueType(component.Type,
          [&](auto zero)
          {
            AddSquares(component.At<decltype(zero)>({ box.Low[0], j, k }), component.Stride[0],
              size[0], row);
          });
      }
      for (std::int64_t i = 0; i < size[0]; ++i)
      {
        row[i] = std::sqrt(row[i]);
      }
    }
  }
}

SampleView MakeMagnitudeView(const VertexBox& box, const double* magnitudes)
{
  return MakeSampleView(ValueType::Float64, box, magnitudes);
}

} // namespace isosurface
