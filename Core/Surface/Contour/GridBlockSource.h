// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_GridBlockSource_h
#define isosurface_GridBlockSource_h

#include "Ground/Volume/BlockSelection.h"
#include "Ground/Volume/BlockSource.h"
#include "Surface/Contour/BlockRanges.h"

#include <vector>

namespace isosurface
{

/**
 * The active blocks of samples in memory: a vtkImageData, or the piece of one on this rank.
 * `ranges` must have been computed for the same samples. With a selection, the selected blocks;
 * `grid` is the grid of the samples' coordinates. No sample is copied.
 *
 * The samples and the attributes must outlive the source.
 */
class GridBlockSource : public BlockSource
{
public:
  GridBlockSource(
    const SampleView& samples, const BlockRanges& ranges, const std::vector<double>& isovalues);
  GridBlockSource(const SampleView& samples, const BlockRanges& ranges,
    const std::vector<double>& isovalues, const BlockSelection& selection,
    const GridGeometry& grid);

  /// Sets the arrays to interpolate. Their Available must cover the samples' Box.
  void SetAttributes(std::vector<AttributeView> attributes);

  /// Sets what is hidden of the samples. Its Box must cover the samples' Available.
  void SetBlanking(const Blanking& hidden) { this->Hidden = hidden; }

  std::size_t GetNumberOfBlocks() const override { return this->Active.size(); }
  Index3 GetLatticeCoordinates(std::size_t block) const override;
  VertexBox GetVertices(std::size_t block) const override;
  ValueType GetValueType() const override { return this->Samples.Type; }
  Result<BlockSamples> Acquire(std::size_t block) override;

private:
  /// The vertices of a block of Grid, in coordinates of the samples.
  VertexBox FindVertices(std::int64_t block) const;

  SampleView Samples;
  std::vector<AttributeView> Attributes;
  Blanking Hidden;
  BlockGrid Grid;
  std::vector<std::int64_t> Active;
};

} // namespace isosurface

#endif
