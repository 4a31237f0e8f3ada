// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_ArraySource_h
#define isosurface_ArraySource_h

#include "Formats/Source/FormatFunctions.h"
#include "Formats/Source/StoredArray.h"
#include "Ground/Volume/BoxSource.h"
#include "Ground/Volume/PageBuffer.h"

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace isosurface
{

/// An array of a volume: one time step of a stored array, and one or more of its channels.
struct ArrayPart
{
  std::string Name;
  std::shared_ptr<StoredArray> Array;
  ArrayAxes Axes;
  std::int64_t Step = 0;
  std::int64_t FirstChannel = 0;
  std::int64_t Channels = 1; ///< the components of the array

  /// The samples on x, y and z.
  Index3 GetDimensions() const;
};

/// The parts of a stored array: its time step `step`; if channels are the fastest axis, they are the
/// components of one part, otherwise each is a part of its own, named by `channels` or its number.
/// InvalidArgument if there is no such step; Corrupt or Unsupported if a volume cannot have the shape.
Result<std::vector<ArrayPart>> MakeParts(const std::string& name,
  std::shared_ptr<StoredArray> array, const ArrayAxes& axes, std::size_t step,
  const std::vector<std::string>& channels = {});

/// Sets Grid.Extent, Arrays, Times (to numbers from 0) and Source of a volume from parts of equal
/// dimensions, of which `names` chooses some; all are taken if one name is unknown.
Status TakeParts(
  std::vector<ArrayPart> parts, const std::vector<std::string>& names, OpenedVolume& volume);

/**
 * Boxes of stored arrays, whose axes may have any order: the samples stay in the order of the file,
 * and the views have its strides.
 */
class ArraySource : public BoxSource
{
public:
  /// The parts must have the same dimensions.
  explicit ArraySource(std::vector<ArrayPart> parts);

  const VertexBox& GetBox() const override { return this->Box; }
  std::uint64_t GetReadBytes(const VertexBox& box) const override;
  std::uint64_t GetHeldBytes() const override;
  std::int64_t GetRowsAtOnce() const override;
  /// That of the first part.
  std::optional<Index3> GetChunk() const override;
  /// Whether no part has chunks, and z is the slowest of the axes of each.
  bool HasCheapRows() const override;
  bool DecodesInParallel() const override;
  Result<BoxSamples> Read(const VertexBox& box) override;

private:
  std::vector<ArrayPart> Parts;
  VertexBox Box;
  std::shared_ptr<PageBufferPool> Pool;
};

} // namespace isosurface

#endif
