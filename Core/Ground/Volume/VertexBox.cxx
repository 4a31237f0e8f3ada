// SPDX-License-Identifier: BSD-3-Clause
#include "Ground/Volume/VertexBox.h"

#include <algorithm>

namespace isosurface
{

VertexBox VertexBox::Intersect(const VertexBox& other) const
{
  VertexBox box;
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    box.Low[axis] = std::max(this->Low[axis], other.Low[axis]);
    box.High[axis] = std::max(box.Low[axis], std::min(this->High[axis], other.High[axis]));
  }
  return box;
}

void VertexBox::Extend(const VertexBox& other)
{
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    this->Low[axis] = std::min(this->Low[axis], other.Low[axis]);
    this->High[axis] = std::max(this->High[axis], other.High[axis]);
  }
}

VertexBox VertexBox::Translate(const Index3& offset) const
{
  VertexBox box = *this;
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    box.Low[axis] += offset[axis];
    box.High[axis] += offset[axis];
  }
  return box;
}

VertexBox VertexBox::AddLayer(const VertexBox& known) const
{
  VertexBox box = *this;
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    --box.Low[axis];
    ++box.High[axis];
  }
  return box.Intersect(known);
}

void AppendBox(std::vector<std::uint8_t>& message, const VertexBox& box)
{
  for (const Index3* corner : { &box.Low, &box.High })
  {
    for (const std::int64_t coordinate : *corner)
    {
      AppendLittleEndian(message, coordinate);
    }
  }
}

VertexBox ReadBox(ByteReader& reader)
{
  VertexBox box;
  reader.ReadAll(box.Low);
  reader.ReadAll(box.High);
  return box;
}

} // namespace isosurface
