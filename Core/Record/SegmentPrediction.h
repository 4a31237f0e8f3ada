// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_SegmentPrediction_h
#define isosurface_SegmentPrediction_h

#include "Record/BlockSegment.h"
#include "Volume/SampleView.h"

#include <cstdint>
#include <vector>

namespace isosurface
{

/**
 * Predictions of a segment's samples from the next coarser level, as unsigned integers u
 * (SegmentFilter.h) of the samples' size.
 *
 * The vertex (i, j, k) of level l lies between the vertices i / 2 rounded down and up, j / 2 ...,
 * k / 2 ... of level l + 1; coordinates beyond that level's ghosted box are moved to its last one.
 * With mean(a, b) = (a + b + 1) / 2 rounded down, its prediction is the mean along x of the means
 * along z of the means along y of their eight values u, equal ones among them. Most vertices have
 * one or two odd coordinates, hence two or four different neighbours.
 *
 * The mean of two neighbours has half the noise of one, and follows a gradient exactly; the
 * prediction of a row depends on the coarser level alone, so that rows are computed whole.
 */
class SegmentPrediction
{
public:
  /**
   * Predicts the samples of `segment`, in its order. `coarser`: the whole ghosted box of the next
   * coarser level (AssembleLevel). Returns memory of this object, valid until the next call.
   */
  const void* Compute(const BlockSegment& segment, const SampleView& coarser);

private:
  std::vector<std::uint8_t> Coarse;
  std::vector<std::uint8_t> Rows;
  std::vector<std::uint8_t> Predictions;
};

} // namespace isosurface

#endif
