// SPDX-License-Identifier: BSD-3-Clause
#include "Surface/Contour/BorderBrick.h"

namespace isosurface
{
namespace
{

SampleView ExtendView(SampleView view, const Brick& brick)
{
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    if (brick.Side[axis] == 0)
    {
      continue;
    }
    // The inner vertex: the second one beyond a low side, the first one beyond a high side.
    const std::int64_t inner = brick.Vertices.Low[axis] + (brick.Side[axis] < 0 ? 1 : 0);
    const std::ptrdiff_t offset = (inner - view.Available.Low[axis]) * view.Stride[axis] *
      static_cast<std::ptrdiff_t>(GetValueSize(view.Type));
    view.First = static_cast<const std::uint8_t*>(view.First) + offset;
    view.Stride[axis] = 0;
    view.Available.Low[axis] = brick.Vertices.Low[axis];
    view.Available.High[axis] = brick.Vertices.High[axis];
  }
  view.Box = brick.Vertices;
  return view;
}

} // namespace

BlockSamples ExtendBeyond(const BlockSamples& samples, const Brick& brick)
{
  BlockSamples extended;
  extended.Scalars = ExtendView(samples.Scalars, brick);
  for (const AttributeView& attribute : samples.Attributes)
  {
    extended.Attributes.emplace_back();
    for (const SampleView& component : attribute.Components)
    {
      extended.Attributes.back().Components.push_back(ExtendView(component, brick));
    }
  }
  return extended;
}

void SetOuterVertices(const Brick& brick, bool areInside, std::uint64_t* inside)
{
  const Index3 size = brick.Vertices.GetSize();
  std::int64_t index[3];
  // The outer vertex is vertex 0 beyond a low side, vertex 1 beyond a high side.
  const auto isOuter = [&](std::size_t axis)
  { return brick.Side[axis] != 0 && index[axis] == (brick.Side[axis] < 0 ? 0 : 1); };
  const std::uint64_t innerBits = brick.Side[0] == 0 ? ~std::uint64_t(0)
    : brick.Side[0] < 0                              ? 2
                                                     : 1;
  const std::uint64_t allBits = (std::uint64_t(1) << size[0]) - 1;
  for (index[2] = 0; index[2] < size[2]; ++index[2])
  {
    for (index[1] = 0; index[1] < size[1]; ++index[1])
    {
      const std::uint64_t inner = isOuter(1) || isOuter(2) ? 0 : innerBits;
      *inside = areInside ? *inside | (~inner & allBits) : *inside & inner;
      ++inside;
    }
  }
}

void LocateBorderPoints(const Brick& brick, const BrickSamples& position, const EdgeCode* codes,
  std::uint32_t count, float* coordinates, double* parameters)
{
  for (std::uint32_t n = 0; n < count; ++n)
  {
    const std::size_t axis = codes[n] >> 18;
    const std::int64_t inner = position.Low[axis] + (brick.Side[axis] < 0 ? 1 : 0);
    coordinates[n] = static_cast<float>(
      static_cast<double>(inner) + static_cast<double>(position.ExtentLow[axis]));
    if (parameters)
    {
      parameters[n] = brick.Side[axis] < 0 ? 1 : 0;
    }
  }
}

void ComputeOutwardNormals(
  const Brick& brick, const EdgeCode* codes, std::uint32_t count, float* normals)
{
  for (std::uint32_t n = 0; n < count; ++n, normals += 3)
  {
    const std::size_t axis = codes[n] >> 18;
    normals[0] = normals[1] = normals[2] = 0.0f;
    normals[axis] = static_cast<float>(brick.Side[axis]);
  }
}

} // namespace isosurface
