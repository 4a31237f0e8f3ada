// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_SampleView_h
#define isosurface_SampleView_h

#include "Ground/Volume/BlockGrid.h"
#include "Ground/Volume/ValueType.h"

#include <array>
#include <cstddef>
#include <cstdint>

namespace isosurface
{

/**
 * A view of the samples of one array on a box of vertices, in memory that the view does not own: a
 * decoded block, or a part of a vtkImageData. Box contains the vertices to work on. Available
 * contains Box and may be larger: gradients may use the samples around Box.
 *
 * The sample of vertex (i, j, k) is at
 * First + (i - Available.Low[0]) * Stride[0] + (j - Available.Low[1]) * Stride[1] + ...
 */
struct SampleView
{
  ValueType Type = ValueType::UInt8;
  const void* First = nullptr;            ///< the sample at Available.Low
  std::array<std::ptrdiff_t, 3> Stride{}; ///< in samples
  VertexBox Available;
  VertexBox Box;

  /// The sample at a vertex of Available. T must be the type that Type names.
  template <typename T>
  const T* At(const Index3& vertex) const
  {
    return static_cast<const T*>(this->First) + this->FindOffset(vertex);
  }
  /// The same of any type.
  const std::uint8_t* AtBytes(const Index3& vertex) const
  {
    return static_cast<const std::uint8_t*>(this->First) +
      this->FindOffset(vertex) * static_cast<std::ptrdiff_t>(GetValueSize(this->Type));
  }

private:
  std::ptrdiff_t FindOffset(const Index3& vertex) const
  {
    return (vertex[0] - this->Available.Low[0]) * this->Stride[0] +
      (vertex[1] - this->Available.Low[1]) * this->Stride[1] +
      (vertex[2] - this->Available.Low[2]) * this->Stride[2];
  }
};

} // namespace isosurface

#endif
