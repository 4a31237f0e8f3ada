// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_SegmentPrediction_h
#define isosurface_SegmentPrediction_h

#include "Ground/Volume/SampleView.h"
#include "Storage/Record/BlockSegment.h"

#include <cstdint>
#include <vector>

namespace isosurface
{

/**
 * Predicts the samples of a segment from the next coarser level, as unsigned integers u
 * (OrderedSample.h) of the samples' size.
 *
 * The vertex (i, j, k) of level l lies between the vertices floor(i / 2) and ceil(i / 2), and so on
 * for j and k, of level l + 1; coordinates beyond that level's ghosted box become its last one. The
 * prediction is the mean along x of the means along z of the means along y of the eight values u
 * there, some of which coincide, with mean(a, b) = floor((a + b + 1) / 2). Most vertices have one
 * or two odd coordinates, hence two or four different neighbours.
 *
 * A mean has less noise than one neighbour, and is exact on a gradient. A row's predictions depend
 * on the coarser level alone, so rows are computed as a whole.
 */
class SegmentPrediction
{
public:
  /// Predicts the samples of `segment`, in its order. `coarser`: the whole ghosted box of the next
  /// coarser level (AssembleLevel). Returns memory of this object, valid until the next call.
  const void* Compute(const BlockSegment& segment, const SampleView& coarser);

private:
  std::vector<std::uint8_t> Coarse;
  std::vector<std::uint8_t> Rows;
  std::vector<std::uint8_t> Predictions;
};

} // namespace isosurface

#endif
