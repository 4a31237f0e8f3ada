// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_Testing_TestBlockSource_h
#define isosurface_Testing_TestBlockSource_h

#include "Fixtures/SampleVolume.h"
#include "Ground/Volume/BlockSource.h"

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

namespace isosurface
{

/**
 * Blocks of any size. Each is copied with its ghost layer to memory of exactly its size, so that
 * the address sanitizer detects reads beyond it.
 */
template <typename T>
class TestBlockSource : public BlockSource
{
public:
  TestBlockSource(const SampleVolume<T>& volume, int blockSize, int ghosts = 1, int components = 1)
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
    VisitVertices(view.Available,
      [&](const Index3& vertex)
      {
        memory[static_cast<std::ptrdiff_t>(at)] = this->Volume.At(vertex);
        at += static_cast<std::size_t>(this->Components);
      });
    view.First = memory.get();
    samples.Owner = memory;
    return samples;
  }

private:
  const SampleVolume<T>& Volume;
  BlockGrid Grid;
  int Ghosts;
  int Components;
};

} // namespace isosurface

#endif
