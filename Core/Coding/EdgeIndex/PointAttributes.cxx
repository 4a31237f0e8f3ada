// SPDX-License-Identifier: BSD-3-Clause
#include "Coding/EdgeIndex/PointAttributes.h"

#include "Coding/EdgeIndex/SingleBlock.h"
#include "Ground/Volume/Handedness.h"
#include "Surface/Contour/SurfaceExtractor.h"

#include <algorithm>
#include <cstring>
#include <functional>

namespace isosurface
{
namespace
{

std::size_t GetTupleSize(const EdgeIndexAttribute& attribute)
{
  return GetValueSize(attribute.Type) * static_cast<std::size_t>(attribute.NumberOfComponents);
}

// The layouts of the block's arrays, whose interpolated types must be those of the header.
Status FindLayouts(
  const EdgeIndexHeader& header, const BlockSamples& samples, std::vector<AttributeLayout>& layouts)
{
  for (const EdgeIndexAttribute& attribute : header.Attributes)
  {
    if (attribute.IsNormals)
    {
      continue;
    }
    const std::size_t n = layouts.size();
    if (n >= samples.Attributes.size() || samples.Attributes[n].Components.empty() ||
      GetInterpolatedType(samples.Attributes[n].Components.front().Type) != attribute.Type)
    {
      return { StatusCode::InvalidArgument,
        "A block to encode lacks the array " + attribute.Name +
          ", or has it in a type that is not interpolated to the one of the stream." };
    }
    layouts.push_back(
      { samples.Attributes[n].Components.front().Type, attribute.NumberOfComponents });
  }
  return Status::Ok();
}

} // namespace

PointAttributes::PointAttributes(const EdgeIndexHeader& header, const VertexBox& vertices)
  : Tuples(header.Attributes.size())
  , Coded(header.Attributes.size())
{
  const auto count = static_cast<std::size_t>(vertices.GetNumberOfVertices());
  for (std::size_t n = 0; n < this->Tuples.size(); ++n)
  {
    this->Coded[n].Type = header.Attributes[n].Type;
    this->Coded[n].NumberOfComponents = header.Attributes[n].NumberOfComponents;
    this->Coded[n].MaximumError = header.Attributes[n].MaximumError;
    for (std::size_t axis = 0; axis < 3; ++axis)
    {
      this->Tuples[n][axis] = Buffer<std::uint8_t>(count * GetTupleSize(header.Attributes[n]));
      this->Coded[n].Edges.First[axis] = this->Tuples[n][axis].GetData();
    }
  }
}

std::vector<AttributeView> PointAttributes::GetViews(
  const EdgeIndexHeader& header, const VertexBox& vertices) const
{
  std::vector<AttributeView> views;
  for (std::size_t n = 0; n < this->Coded.size(); ++n)
  {
    EdgeTupleView tuples;
    tuples.Type = header.Attributes[n].Type;
    tuples.NumberOfComponents = header.Attributes[n].NumberOfComponents;
    tuples.Box = vertices;
    for (std::size_t axis = 0; axis < 3; ++axis)
    {
      tuples.First[axis] = this->Coded[n].Edges.First[axis];
    }
    views.emplace_back();
    views.back().EdgeTuples = tuples;
  }
  return views;
}

Status PointAttributes::Interpolate(
  const EdgeIndexHeader& header, const BlockSamples& samples, std::size_t isovalue)
{
  ContourRequest request;
  // Not a list of one, of which GCC 14 says with sanitizers that it is out of its bounds.
  request.Isovalues.assign(1, header.Isovalues[isovalue]);
  request.GlobalIds = true;
  request.Precision = PointPrecision::Single; // of points that nobody uses
  for (const EdgeIndexAttribute& attribute : header.Attributes)
  {
    if (attribute.IsNormals)
    {
      request.Normals = true;
      request.NormalsRoundedOnce = attribute.NormalsRoundedOnce;
      request.NormalsByDirection = attribute.NormalsByDirection;
    }
  }
  ISOSURFACE_RETURN_IF_ERROR(FindLayouts(header, samples, request.Attributes));
  SingleBlock source(samples);
  ISOSURFACE_ASSIGN_OR_RETURN(Surface surface, ExtractSurface(header.Geometry, source, request, 1));
  TurnStoredNormals(header.Geometry, surface.Normals);
  const Index3 dimensions = header.Geometry.GetDimensions();
  const VertexBox& box = samples.Scalars.Box;
  const Index3 size = box.GetSize();
  std::size_t interpolated = 0;
  for (std::size_t n = 0; n < header.Attributes.size(); ++n)
  {
    const bool isNormals = header.Attributes[n].IsNormals;
    const std::size_t width = GetTupleSize(header.Attributes[n]);
    const auto* tuples = isNormals
      ? reinterpret_cast<const std::uint8_t*>(surface.Normals.GetData())
      : surface.Attributes[interpolated++].Bytes.GetData();
    for (std::size_t point = 0; point < surface.NumberOfPoints; ++point)
    {
      const std::int64_t id = surface.GlobalIds[point];
      const std::int64_t vertex = id / 3;
      const std::int64_t i = vertex % dimensions[0] - box.Low[0];
      const std::int64_t j = vertex / dimensions[0] % dimensions[1] - box.Low[1];
      const std::int64_t k = vertex / (dimensions[0] * dimensions[1]) - box.Low[2];
      const auto place = static_cast<std::size_t>(i + size[0] * (j + size[1] * k));
      std::memcpy(this->Coded[n].Edges.First[static_cast<std::size_t>(id % 3)] + place * width,
        tuples + point * width, width);
    }
  }
  return Status::Ok();
}

void TurnStoredNormals(const GridGeometry& grid, Buffer<float>& normals)
{
  if (HasMirroredDirection(grid))
  {
    std::transform(normals.begin(), normals.end(), normals.begin(), std::negate<>());
  }
}

std::vector<AttributeLayout> GetAttributeLayouts(const EdgeIndexHeader& header)
{
  std::vector<AttributeLayout> layouts;
  for (const EdgeIndexAttribute& attribute : header.Attributes)
  {
    layouts.push_back({ attribute.Type, attribute.NumberOfComponents });
  }
  return layouts;
}

} // namespace isosurface
