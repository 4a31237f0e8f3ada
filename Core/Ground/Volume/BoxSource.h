// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_BoxSource_h
#define isosurface_BoxSource_h

#include "Ground/Base/Status.h"
#include "Ground/Volume/SampleView.h"

#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <vector>

namespace isosurface
{

/// The samples of a box of vertices: a view for each array, with the box as its Box. The samples
/// are valid as long as Owner is held; without an Owner, they outlive the source.
struct BoxSamples
{
  std::vector<SampleView> Arrays;
  std::shared_ptr<const void> Owner;

  /// Whether there is one view for each type, in this order, that covers the box.
  bool Fits(const std::vector<ValueType>& types, const VertexBox& box) const;
};

/**
 * A volume, or a rank's piece of it, whose samples are read box by box, so that it need not fit in
 * memory: a file, a pipeline, or a piece in memory. Vertices are counted from 0 at the grid's first
 * vertex.
 *
 * A writer reads boxes more than once, mostly in the order of z, with single slices before and
 * after the slab on which it works.
 */
class BoxSource
{
public:
  virtual ~BoxSource() = default;

  /// The vertices that this source can read: a rank's piece of the volume, or all of it. May be
  /// empty.
  virtual const VertexBox& GetBox() const = 0;

  /// The memory that Read() takes for a box, temporary memory included.
  virtual std::uint64_t GetReadBytes(const VertexBox& box) const = 0;

  /// The maximum memory of the source between reads.
  virtual std::uint64_t GetHeldBytes() const { return 0; }

  /// How many rows to read from all slices before the next rows, beginning at multiples of this
  /// number: as many as the chunks have that the source can keep. More than any slice has if the
  /// order does not matter.
  virtual std::int64_t GetRowsAtOnce() const { return std::numeric_limits<std::int64_t>::max(); }

  /// The vertices on x, y and z that are best read together, in boxes that begin at multiples of
  /// them: those of a chunk of the file, or as much as costs few reads. Nothing if boxes are best
  /// read in the order of z: a stream.
  virtual std::optional<Index3> GetChunk() const { return std::nullopt; }

  /// Whether some rows of each slice cost little more alone than with the others: they are not
  /// decoded.
  virtual bool HasCheapRows() const { return false; }
  /// Whether several of these, each of a thread, decode chunks at the same time.
  virtual bool DecodesInParallel() const { return false; }
  /// Hints that the samples of a box will be read soon. Does not wait for them.
  virtual void Prefetch(const VertexBox&) const {}

  /// Whether another thread than the one that made the source may call Read(). Two threads never
  /// call it at the same time.
  virtual bool CanReadAhead() const { return true; }

  /// Another source of the same samples, for another thread: what was read to open this one is shared.
  /// May be called while a thread reads. Null if the file has to be opened again.
  virtual std::unique_ptr<BoxSource> Fork() const { return nullptr; }

  /// The samples of a box within GetBox(). Errors name the file and the reason.
  virtual Result<BoxSamples> Read(const VertexBox& box) = 0;
};

} // namespace isosurface

#endif
