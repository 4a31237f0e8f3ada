// SPDX-License-Identifier: BSD-3-Clause
#include "SurfaceArrays.h"

#include <cstdint>
#include <utility>

namespace isosurface
{

pybind11::dtype MakeDtype(ValueType type)
{
  return pybind11::dtype(GetValueTypeName(type));
}

pybind11::dict MakeSurfaceArrays(
  Surface surface, bool normals, const std::vector<std::string>& attributes)
{
  using Size = pybind11::ssize_t;
  const auto points = static_cast<Size>(surface.NumberOfPoints);
  const auto triangles = static_cast<Size>(surface.NumberOfCells);
  const std::size_t parts = surface.Parts.size();
  pybind11::array_t<double> isovalues(static_cast<Size>(parts));
  pybind11::array_t<std::int64_t> pointOffsets(static_cast<Size>(parts + 1));
  pybind11::array_t<std::int64_t> triangleOffsets(static_cast<Size>(parts + 1));
  for (std::size_t part = 0; part < parts; ++part)
  {
    isovalues.mutable_data()[part] = surface.Parts[part].Isovalue;
    pointOffsets.mutable_data()[part] = static_cast<std::int64_t>(surface.Parts[part].FirstPoint);
    triangleOffsets.mutable_data()[part] = static_cast<std::int64_t>(surface.Parts[part].FirstCell);
  }
  pointOffsets.mutable_data()[parts] = points;
  triangleOffsets.mutable_data()[parts] = triangles;

  pybind11::dict arrays;
  const auto float32 = pybind11::dtype::of<float>();
  arrays["normals"] = pybind11::none();
  if (normals)
  {
    arrays["normals"] = AdoptBuffer(surface.Normals, float32, { points, 3 });
  }
  arrays["points"] = surface.HasDoublePoints
    ? AdoptBuffer(surface.DoublePoints, pybind11::dtype::of<double>(), { points, 3 })
    : AdoptBuffer(surface.Points, float32, { points, 3 });
  IndexArray& corners = surface.Connectivity;
  arrays["triangles"] = corners.Is64Bit
    ? AdoptBuffer(corners.Values64, pybind11::dtype::of<std::int64_t>(), { triangles, 3 })
    : AdoptBuffer(corners.Values32, pybind11::dtype::of<std::int32_t>(), { triangles, 3 });
  arrays["isovalues"] = isovalues;
  arrays["point_offsets"] = pointOffsets;
  arrays["triangle_offsets"] = triangleOffsets;
  pybind11::dict tuples;
  for (std::size_t n = 0; n < surface.Attributes.size(); ++n)
  {
    SurfaceAttribute& attribute = surface.Attributes[n];
    std::vector<Size> shape{ points };
    if (attribute.Layout.NumberOfComponents > 1)
    {
      shape.push_back(attribute.Layout.NumberOfComponents);
    }
    tuples[pybind11::str(attributes[n])] =
      AdoptBuffer(attribute.Bytes, MakeDtype(GetInterpolatedType(attribute.Layout.Type)), shape);
  }
  arrays["attributes"] = tuples;
  return arrays;
}

} // namespace isosurface
