// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_Testing_SampleVolume_h
#define isosurface_Testing_SampleVolume_h

#include "Fixtures/Require.h"
#include "Ground/Volume/GridGeometry.h"
#include "Ground/Volume/SampleView.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <random>
#include <vector>

namespace isosurface
{

/// A grid and its samples in memory, x fastest.
template <typename T>
struct SampleVolume
{
  GridGeometry Geometry;
  std::vector<T> Samples;

  /// All samples are zero.
  explicit SampleVolume(const Index3& dimensions)
    : Samples(static_cast<std::size_t>(dimensions[0] * dimensions[1] * dimensions[2]))
    , Dimensions(dimensions)
  {
    for (int axis = 0; axis < 3; ++axis)
    {
      this->Geometry.Extent[2 * axis] = 0;
      this->Geometry.Extent[2 * axis + 1] = dimensions[axis] - 1;
    }
  }
  /// The sample at (i, j, k) is function(i, j, k); called with x fastest.
  template <typename Function>
  SampleVolume(const Index3& dimensions, Function&& function)
    : SampleVolume(dimensions)
  {
    auto sample = this->Samples.begin();
    VisitVertices({ { 0, 0, 0 }, dimensions },
      [&](const Index3& at) { *sample++ = static_cast<T>(function(at[0], at[1], at[2])); });
  }

  Index3 GetDimensions() const { return this->Dimensions; }
  T& At(std::int64_t i, std::int64_t j, std::int64_t k)
  {
    return this
      ->Samples[static_cast<std::size_t>(i + this->Dimensions[0] * (j + this->Dimensions[1] * k))];
  }
  T At(std::int64_t i, std::int64_t j, std::int64_t k) const
  {
    return const_cast<SampleVolume*>(this)->At(i, j, k);
  }
  T& At(const Index3& vertex) { return this->At(vertex[0], vertex[1], vertex[2]); }
  T At(const Index3& vertex) const { return this->At(vertex[0], vertex[1], vertex[2]); }

  /// The samples of a box, with all others available beside them.
  SampleView GetView(const VertexBox& box) const
  {
    const Index3& size = this->Dimensions;
    SampleView view;
    view.Type = ValueTypeOf<T>::Value;
    view.First = this->Samples.data();
    view.Stride = { 1, static_cast<std::ptrdiff_t>(size[0]),
      static_cast<std::ptrdiff_t>(size[0] * size[1]) };
    view.Available = { { 0, 0, 0 }, size };
    view.Box = box;
    return view;
  }
  SampleView GetView() const { return this->GetView({ { 0, 0, 0 }, this->Dimensions }); }

private:
  Index3 Dimensions;
};

/// Expects a box of a view to have the samples of a volume, subsampled to a level, bit by bit.
template <typename T>
void ExpectSamples(
  const SampleView& view, const VertexBox& box, const SampleVolume<T>& volume, int level = 0)
{
  ASSERT_EQ(view.Type, ValueTypeOf<T>::Value);
  std::size_t wrong = 0;
  VisitVertices(box,
    [&](const Index3& vertex)
    {
      const T expected = volume.At(vertex[0] << level, vertex[1] << level, vertex[2] << level);
      wrong += std::memcmp(view.At<T>(vertex), &expected, sizeof(T)) != 0;
    });
  EXPECT_EQ(wrong, 0u);
}

/// The types of samples, for typed tests.
using AllValueTypes = testing::Types<std::int8_t, std::uint8_t, std::int16_t, std::uint16_t,
  std::int32_t, std::uint32_t, std::int64_t, std::uint64_t, float, double>;

/// Small integers around zero (or from zero on), so that many equal an isovalue; some NaN.
template <typename T>
SampleVolume<T> MakeRandomVolume(std::mt19937& random, const Index3& dimensions, int levels)
{
  SampleVolume<T> volume(dimensions);
  std::uniform_int_distribution<int> value(0, levels);
  for (T& sample : volume.Samples)
  {
    const int drawn = value(random);
    sample = static_cast<T>(std::numeric_limits<T>::is_signed ? drawn - levels / 2 : drawn);
    if (std::numeric_limits<T>::has_quiet_NaN && random() % 40 == 0)
    {
      sample = std::numeric_limits<T>::quiet_NaN();
    }
  }
  return volume;
}

} // namespace isosurface

#endif
