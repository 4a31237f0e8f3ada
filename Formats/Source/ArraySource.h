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
struct VolumeArray
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

/// The arrays of time step `step` of a stored array: if channels are its fastest axis, they are the
/// components of one array, otherwise each is an array of its own, named by `channels` or its number.
/// InvalidArgument if there is no such step; Corrupt or Unsupported if a volume cannot have the shape.
Result<std::vector<VolumeArray>> MakeVolumeArrays(const std::string& name,
  std::shared_ptr<StoredArray> array, const ArrayAxes& axes, std::size_t step,
  const std::vector<std::string>& channels = {});

/// Sets Grid.Extent, Arrays, Times (to numbers from 0) and Source of a volume from arrays of equal
/// dimensions, of which `names` chooses some; all are taken if one name is unknown.
Status TakeVolumeArrays(
  std::vector<VolumeArray> arrays, const std::vector<std::string>& names, OpenedVolume& volume);

/**
 * Boxes of stored arrays, whose axes may have any order: the samples stay in the order of the file,
 * and the views have its strides.
 */
class ArraySource : public BoxSource
{
public:
  /// The arrays must have the same dimensions.
  explicit ArraySource(std::vector<VolumeArray> arrays);

  const VertexBox& GetBox() const override { return this->Box; }
  std::uint64_t GetReadBytes(const VertexBox& box) const override;
  std::uint64_t GetHeldBytes() const override;
  std::int64_t GetRowsAtOnce() const override;
  /// That of the first array.
  std::optional<Index3> GetChunk() const override;
  /// Whether no array has chunks, and z is the slowest of the axes of each.
  bool HasCheapRows() const override;
  bool DecodesInParallel() const override;
  Result<BoxSamples> Read(const VertexBox& box) override;

private:
  std::vector<VolumeArray> Arrays;
  VertexBox Box;
  std::shared_ptr<PageBufferPool> Pool;
};

} // namespace isosurface

#endif
