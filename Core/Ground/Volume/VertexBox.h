// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_VertexBox_h
#define isosurface_VertexBox_h

#include "Ground/Base/Coding.h"
#include "Ground/Volume/GridGeometry.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace isosurface
{

/// A box of vertices [Low, High), counted from 0 at the grid's first vertex.
struct VertexBox
{
  Index3 Low{ 0, 0, 0 };
  Index3 High{ 0, 0, 0 };

  Index3 GetSize() const
  {
    return { this->High[0] - this->Low[0], this->High[1] - this->Low[1],
      this->High[2] - this->Low[2] };
  }
  std::int64_t GetNumberOfVertices() const
  {
    const Index3 size = this->GetSize();
    return this->IsEmpty() ? 0 : size[0] * size[1] * size[2];
  }
  bool IsEmpty() const
  {
    return this->Low[0] >= this->High[0] || this->Low[1] >= this->High[1] ||
      this->Low[2] >= this->High[2];
  }
  VertexBox Intersect(const VertexBox& other) const;
  /// Whether all vertices of `part`, which is not empty, are in the box.
  bool Contains(const VertexBox& part) const { return this->Intersect(part) == part; }
  /// Makes the box the smallest that contains both, neither of which is empty.
  void Extend(const VertexBox& other);
  VertexBox Translate(const Index3& offset) const;
  /// The box with one more layer of vertices on each side, where `known` has one.
  VertexBox AddLayer(const VertexBox& known) const;
  /// The same; the known vertices are those of a grid.
  VertexBox AddLayer(const Index3& dimensions) const
  {
    return this->AddLayer(VertexBox{ { 0, 0, 0 }, dimensions });
  }
  /// The index of a vertex of the box in an array of the box's vertices, x fastest.
  std::size_t FindIndex(const Index3& vertex) const
  {
    const Index3 size = this->GetSize();
    return static_cast<std::size_t>(vertex[0] - this->Low[0] +
      size[0] * (vertex[1] - this->Low[1] + size[1] * (vertex[2] - this->Low[2])));
  }
  bool operator==(const VertexBox& other) const
  {
    return this->Low == other.Low && this->High == other.High;
  }
};

/// Calls functor(first vertex, number of vertices) for each row of the box, x fastest.
template <typename Functor>
void VisitRows(const VertexBox& box, const Functor& functor)
{
  const std::int64_t count = box.High[0] - box.Low[0];
  for (std::int64_t k = box.Low[2]; k < box.High[2]; ++k)
  {
    for (std::int64_t j = box.Low[1]; j < box.High[1]; ++j)
    {
      functor(Index3{ box.Low[0], j, k }, count);
    }
  }
}

/// Calls functor(vertex) for each vertex of the box, x fastest.
template <typename Functor>
void VisitVertices(const VertexBox& box, const Functor& functor)
{
  VisitRows(box,
    [&](Index3 vertex, std::int64_t)
    {
      for (; vertex[0] < box.High[0]; ++vertex[0])
      {
        functor(vertex);
      }
    });
}

/// Appends six int64 to a message: low x, y, z, high x, y, z.
void AppendBox(std::vector<std::uint8_t>& message, const VertexBox& box);
VertexBox ReadBox(ByteReader& reader);

} // namespace isosurface

#endif
