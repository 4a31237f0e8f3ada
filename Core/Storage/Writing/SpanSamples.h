// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_SpanSamples_h
#define isosurface_SpanSamples_h

#include "Ground/Base/Status.h"
#include "Ground/Volume/BlockGrid.h"
#include "Ground/Volume/BoxSource.h"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

namespace isosurface
{

/// Blocks [Begin, End), in the order of their indices.
struct BlockSpan
{
  std::int64_t Begin = 0;
  std::int64_t End = 0;

  std::int64_t GetCount() const { return this->End - this->Begin; }
};

/**
 * The samples for the records of a span of blocks, as far as one source has them.
 *
 * A block needs its own slices with one more on either side and, for the ghost layers of its
 * coarser levels, the slices 2, 4, ... BlockSize before and after. Only these are read, one by one:
 *
 *     z   -32        -16   -8 -4 -2 -1 [0 ... 32] +1 +2 +4  +8    +16         +32
 *          |          |     |  |  |====================|  |  |      |           |
 */
class SpanSamples
{
public:
  /// The boxes that a span needs of a part of the volume: whole rows, by ascending z. None for an
  /// empty span.
  static std::vector<VertexBox> FindBoxes(
    const BlockGrid& grid, const BlockSpan& span, const VertexBox& part);

  /// The memory that reading some boxes takes.
  static std::uint64_t GetReadBytes(const BoxSource& source, const std::vector<VertexBox>& boxes);

  /// Fails if the source's samples are not of the given types. `whenRead`, if it is not null, gets each slab.
  Status Read(BoxSource& source, const std::vector<VertexBox>& boxes,
    const std::vector<ValueType>& types,
    const std::function<void(const BoxSamples& slab, const VertexBox& box)>& whenRead);

  /// The samples of a slice of one of the boxes.
  const SampleView& Find(std::size_t array, std::int64_t z) const
  {
    return this->Slabs[this->SlabOfSlice[static_cast<std::size_t>(z - this->FirstSlice)]]
      .Arrays[array];
  }

  /// The samples of a box, one view an array; empty if they were not read by one read.
  std::vector<SampleView> FindViews(const VertexBox& box) const;

private:
  std::vector<BoxSamples> Slabs;
  std::int64_t FirstSlice = 0;
  std::vector<std::uint32_t> SlabOfSlice;
};

} // namespace isosurface

#endif
