// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_SingleBlock_h
#define isosurface_SingleBlock_h

#include "Ground/Volume/BlockSource.h"

#include <cstddef>

namespace isosurface
{

/// A source of one block, whose samples must outlive it.
class SingleBlock : public BlockSource
{
public:
  explicit SingleBlock(const BlockSamples& samples)
    : Samples(samples)
  {
  }
  std::size_t GetNumberOfBlocks() const override { return 1; }
  Index3 GetLatticeCoordinates(std::size_t) const override { return { 0, 0, 0 }; }
  VertexBox GetVertices(std::size_t) const override { return this->Samples.Scalars.Box; }
  ValueType GetValueType() const override { return this->Samples.Scalars.Type; }
  Result<BlockSamples> Acquire(std::size_t) override { return this->Samples; }

private:
  const BlockSamples& Samples;
};

} // namespace isosurface

#endif
