// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_TestVolume_h
#define isosurface_TestVolume_h

#include "Volume/BlockSource.h"
#include "Volume/GridGeometry.h"

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <random>
#include <utility>
#include <vector>

namespace isosurface
{

/// A grid and its samples, x fastest.
template <typename T>
struct TestVolume
{
  GridGeometry Geometry;
  std::vector<T> Samples;

  explicit TestVolume(const Index3& dimensions)
  {
    for (int axis = 0; axis < 3; ++axis)
    {
      this->Geometry.Extent[2 * axis] = 0;
      this->Geometry.Extent[2 * axis + 1] = dimensions[axis] - 1;
    }
    this->Samples.resize(static_cast<std::size_t>(dimensions[0] * dimensions[1] * dimensions[2]));
  }
  Index3 GetDimensions() const { return this->Geometry.GetDimensions(); }
  T& At(std::int64_t i, std::int64_t j, std::int64_t k)
  {
    const Index3 size = this->GetDimensions();
    return this->Samples[static_cast<std::size_t>(i + size[0] * (j + size[1] * k))];
  }
  T At(std::int64_t i, std::int64_t j, std::int64_t k) const
  {
    return const_cast<TestVolume*>(this)->At(i, j, k);
  }
  SampleView GetView() const
  {
    SampleView view;
    const Index3 size = this->GetDimensions();
    view.Type = ValueTypeOf<T>::Value;
    view.First = this->Samples.data();
    view.Stride = { 1, static_cast<std::ptrdiff_t>(size[0]),
      static_cast<std::ptrdiff_t>(size[0] * size[1]) };
    view.Available.High = size;
    view.Box = view.Available;
    return view;
  }
};

/// Small whole values around zero (or from zero on), so that many equal an isovalue; some NaN.
template <typename T>
TestVolume<T> MakeRandomVolume(std::mt19937& random, const Index3& dimensions, int levels)
{
  TestVolume<T> volume(dimensions);
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

/**
 * Blocks of any number of cells a side, each copied with its ghost layer to memory of exactly its
 * own size, so that a read beyond it is found by the address sanitizer.
 */
template <typename T>
class TestBlockSource : public BlockSource
{
public:
  TestBlockSource(const TestVolume<T>& volume, int blockSize, int ghosts = 1, int components = 1)
    : Volume(volume)
    , Grid(volume.GetDimensions(), blockSize)
    , Ghosts(ghosts)
    , Components(components)
  {
    for (std::int64_t block = 0; block < this->Grid.GetNumberOfBlocks(); ++block)
    {
      this->Blocks.push_back(block);
    }
  }

  std::vector<std::int64_t> Blocks; ///< which blocks of the grid there are, in any order
  std::optional<std::size_t> Failing;
  std::atomic<int> Acquired{ 0 };

  std::size_t GetNumberOfBlocks() const override { return this->Blocks.size(); }
  Index3 GetLatticeCoordinates(std::size_t block) const override
  {
    return this->Grid.GetBlockCoordinates(this->Blocks[block]);
  }
  VertexBox GetVertices(std::size_t block) const override
  {
    return this->Grid.GetVertices(this->Blocks[block]);
  }
  ValueType GetValueType() const override { return ValueTypeOf<T>::Value; }

  Result<BlockSamples> Acquire(std::size_t block) override
  {
    ++this->Acquired;
    if (block == this->Failing)
    {
      return Status(StatusCode::IoError, "block.store: no medium");
    }
    BlockSamples samples;
    SampleView& view = samples.Scalars;
    view.Type = ValueTypeOf<T>::Value;
    view.Box = this->GetVertices(block);
    view.Available =
      this->Ghosts == 0 ? view.Box : this->Grid.GetGhostedVertices(this->Blocks[block], 0);
    const Index3 size = view.Available.GetSize();
    view.Stride = { this->Components, static_cast<std::ptrdiff_t>(this->Components * size[0]),
      static_cast<std::ptrdiff_t>(this->Components * size[0] * size[1]) };
    const auto values =
      static_cast<std::size_t>(view.Available.GetNumberOfVertices() * this->Components);
    const std::shared_ptr<T[]> memory(new T[values]());
    std::size_t at = 0;
    for (std::int64_t k = view.Available.Low[2]; k < view.Available.High[2]; ++k)
    {
      for (std::int64_t j = view.Available.Low[1]; j < view.Available.High[1]; ++j)
      {
        for (std::int64_t i = view.Available.Low[0]; i < view.Available.High[0]; ++i)
        {
          memory[static_cast<std::ptrdiff_t>(at)] = this->Volume.At(i, j, k);
          at += static_cast<std::size_t>(this->Components);
        }
      }
    }
    view.First = memory.get();
    samples.Owner = memory;
    return samples;
  }

private:
  const TestVolume<T>& Volume;
  BlockGrid Grid;
  int Ghosts;
  int Components;
};

} // namespace isosurface

#endif
