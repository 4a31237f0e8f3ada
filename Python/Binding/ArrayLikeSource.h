// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_ArrayLikeSource_h
#define isosurface_ArrayLikeSource_h

#include "Ground/Volume/BoxSource.h"

#include <pybind11/pybind11.h>

#include <cstdint>
#include <optional>
#include <vector>

namespace isosurface
{

/// An object of Python whose slices [z0:z1, y0:y1, x0:x1] are arrays of samples, or can be made
/// such.
struct ArrayLike
{
  pybind11::object Object;
  ValueType Type = ValueType::UInt8;
  int Components = 1; ///< a last axis, if there are several
};

/**
 * The samples of such objects: NumPy's, Zarr's, h5py's or Dask's arrays. Read() takes the GIL for
 * the time of the slice, in whatever thread. It is made and destroyed with the GIL held.
 */
class ArrayLikeSource : public BoxSource
{
public:
  /// `chunk`: the vertices on x, y and z that are best read together.
  ArrayLikeSource(
    std::vector<ArrayLike> arrays, const Index3& dimensions, const std::optional<Index3>& chunk);

  const VertexBox& GetBox() const override { return this->Box; }
  std::uint64_t GetReadBytes(const VertexBox& box) const override;
  std::optional<Index3> GetChunk() const override { return this->Chunk; }
  Result<BoxSamples> Read(const VertexBox& box) override;

  /// Throws what a slice has raised. The GIL is held.
  void Rethrow() const;

private:
  std::vector<ArrayLike> Arrays;
  VertexBox Box;
  std::optional<Index3> Chunk;
  std::optional<pybind11::error_already_set> Raised;
};

} // namespace isosurface

#endif
