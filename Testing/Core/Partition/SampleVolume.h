// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_Testing_SampleVolume_h
#define isosurface_Testing_SampleVolume_h

#include "Volume/SampleView.h"

#include <cstdint>
#include <vector>

namespace isosurface
{

/// A volume in memory for tests, dense, x fastest.
template <typename T>
struct SampleVolume
{
  explicit SampleVolume(const Index3& size)
    : Size(size)
    , Values(static_cast<std::size_t>(size[0] * size[1] * size[2]))
  {
  }

  template <typename Function>
  SampleVolume(const Index3& size, Function&& function)
    : SampleVolume(size)
  {
    std::size_t vertex = 0;
    for (std::int64_t k = 0; k < size[2]; ++k)
    {
      for (std::int64_t j = 0; j < size[1]; ++j)
      {
        for (std::int64_t i = 0; i < size[0]; ++i)
        {
          this->Values[vertex++] = static_cast<T>(function(i, j, k));
        }
      }
    }
  }

  T At(std::int64_t i, std::int64_t j, std::int64_t k) const
  {
    return this->Values[static_cast<std::size_t>(i + this->Size[0] * (j + this->Size[1] * k))];
  }

  SampleView GetView(const VertexBox& box) const
  {
    SampleView view;
    view.Type = ValueTypeOf<T>::Value;
    view.First = this->Values.data();
    view.Stride = { 1, this->Size[0], this->Size[0] * this->Size[1] };
    view.Available = { { 0, 0, 0 }, this->Size };
    view.Box = box;
    return view;
  }
  SampleView GetView() const { return this->GetView({ { 0, 0, 0 }, this->Size }); }

  Index3 Size;
  std::vector<T> Values;
};

} // namespace isosurface

#endif
