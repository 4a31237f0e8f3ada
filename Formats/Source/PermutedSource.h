// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_PermutedSource_h
#define isosurface_PermutedSource_h

#include "Ground/Volume/BoxSource.h"

#include <array>
#include <cstddef>
#include <memory>
#include <optional>
#include <utility>

namespace isosurface
{

/// Another source with its axes in another order. The samples stay where they are: the views have
/// other strides.
class PermutedSource : public BoxSource
{
public:
  /// Axis `n` of the other source is axis `to[n]` of this one.
  PermutedSource(std::unique_ptr<BoxSource> source, const std::array<std::size_t, 3>& to)
    : Source(std::move(source))
    , To(to)
    , Box(this->Permute(this->Source->GetBox()))
  {
  }

  const VertexBox& GetBox() const override { return this->Box; }
  std::uint64_t GetReadBytes(const VertexBox& box) const override
  {
    return this->Source->GetReadBytes(this->Restore(box));
  }
  std::uint64_t GetHeldBytes() const override { return this->Source->GetHeldBytes(); }
  std::optional<Index3> GetChunk() const override
  {
    const auto chunk = this->Source->GetChunk();
    return chunk ? std::optional<Index3>(this->Permute({ { 0, 0, 0 }, *chunk }).High) : chunk;
  }
  bool CanReadAhead() const override { return this->Source->CanReadAhead(); }

  Result<BoxSamples> Read(const VertexBox& box) override
  {
    auto slab = this->Source->Read(this->Restore(box));
    if (slab.IsOk())
    {
      for (SampleView& view : slab->Arrays)
      {
        view.Available = this->Permute(view.Available);
        view.Box = box;
        const std::array<std::ptrdiff_t, 3> stride = view.Stride;
        for (std::size_t axis = 0; axis < 3; ++axis)
        {
          view.Stride[this->To[axis]] = stride[axis];
        }
      }
    }
    return slab;
  }

private:
  VertexBox Permute(const VertexBox& box) const
  {
    VertexBox permuted;
    for (std::size_t axis = 0; axis < 3; ++axis)
    {
      permuted.Low[this->To[axis]] = box.Low[axis];
      permuted.High[this->To[axis]] = box.High[axis];
    }
    return permuted;
  }
  VertexBox Restore(const VertexBox& box) const
  {
    VertexBox restored;
    for (std::size_t axis = 0; axis < 3; ++axis)
    {
      restored.Low[axis] = box.Low[this->To[axis]];
      restored.High[axis] = box.High[this->To[axis]];
    }
    return restored;
  }

  std::unique_ptr<BoxSource> Source;
  std::array<std::size_t, 3> To;
  VertexBox Box;
};

} // namespace isosurface

#endif
