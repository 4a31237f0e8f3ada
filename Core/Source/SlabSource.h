// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_SlabSource_h
#define isosurface_SlabSource_h

#include "Base/Status.h"
#include "Volume/SampleView.h"

#include <cstdint>
#include <memory>
#include <vector>

namespace isosurface
{

/// Samples of a box of vertices: one view an array, each with the box as its Box. Owner keeps them
/// in memory; without one they belong to somebody who outlives the source.
struct SampleSlab
{
  std::vector<SampleView> Arrays;
  std::shared_ptr<const void> Owner;

  /// Whether there is a view of each type, with samples all over the box.
  bool Fits(const std::vector<ValueType>& types, const VertexBox& box) const;
};

/**
 * A volume, or a rank's part of it, that gives its samples box by box, so that it need not be in
 * memory as a whole: a file, a pipeline, or a piece that is in memory after all. Vertices are
 * counted from 0 at the grid's first one.
 *
 * A reader asks for a box more than once, mostly in the order of z, with single slices before and
 * after what it works on.
 */
class SlabSource
{
public:
  virtual ~SlabSource() = default;

  /// What this source can give; a rank's part of the volume, or all of it. May be empty.
  virtual const VertexBox& GetBox() const = 0;

  /// The memory that Read() takes for a box, what it needs on the way included.
  virtual std::uint64_t GetReadBytes(const VertexBox& box) const = 0;

  /// The memory that the source takes between reads, at most.
  virtual std::uint64_t GetHeldBytes() const { return 0; }

  /// Whether Read() may be called by another thread than the one that made the source. Never by
  /// two at once.
  virtual bool CanReadAhead() const { return true; }

  /// The samples of a box within GetBox(). Errors name the file and the reason.
  virtual Result<SampleSlab> Read(const VertexBox& box) = 0;
};

} // namespace isosurface

#endif
