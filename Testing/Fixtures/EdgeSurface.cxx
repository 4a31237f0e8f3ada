// SPDX-License-Identifier: BSD-3-Clause
#include "EdgeSurface.h"

#include "vtkCellArray.h"
#include "vtkCellArrayIterator.h"
#include "vtkDataArray.h"
#include "vtkFlyingEdges3D.h"
#include "vtkIdTypeArray.h"
#include "vtkImageData.h"
#include "vtkMatrix3x3.h"
#include "vtkNew.h"
#include "vtkPointData.h"
#include "vtkPolyData.h"
#include "vtkUnsignedCharArray.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>
#include <tuple>

namespace isosurface
{
namespace
{

std::array<std::uint32_t, 3> GetBits(vtkDataArray* array, vtkIdType index)
{
  std::array<std::uint32_t, 3> bits{};
  for (int component = 0; array && component < 3; ++component)
  {
    const auto value = static_cast<float>(array->GetComponent(index, component));
    std::memcpy(&bits[component], &value, sizeof(value));
    bits[component] = std::isnan(value) ? 0x7fc00000u : bits[component];
  }
  return bits;
}

float ToFloat(std::uint32_t bits)
{
  float value = 0;
  std::memcpy(&value, &bits, sizeof(value));
  return value;
}

std::string ToString(const EdgePoint& point)
{
  std::string text = "edge " + std::to_string(point.Edge) + " at";
  for (const std::uint32_t bits : point.Position)
  {
    text += " " + std::to_string(ToFloat(bits));
  }
  text += ", normal";
  for (const std::uint32_t bits : point.Normal)
  {
    text += " " + std::to_string(ToFloat(bits));
  }
  return text;
}

std::string ToString(const EdgeSurface::Triangle& triangle)
{
  return "triangle " + std::to_string(triangle[0]) + " " + std::to_string(triangle[1]) + " " +
    std::to_string(triangle[2]);
}

// Appends points and triangles of which edges[n] is the edge of point n, or negative: left out.
void Append(vtkPolyData* polyData, const std::vector<std::int64_t>& edges, EdgeSurface& surface)
{
  if (edges.empty())
  {
    return;
  }
  vtkDataArray* positions = polyData->GetPoints()->GetData();
  vtkDataArray* normals = polyData->GetPointData()->GetNormals();
  for (std::size_t point = 0; point < edges.size(); ++point)
  {
    if (edges[point] >= 0)
    {
      const auto index = static_cast<vtkIdType>(point);
      surface.Points.push_back(
        { edges[point], GetBits(positions, index), GetBits(normals, index) });
    }
  }
  const auto cells = vtk::TakeSmartPointer(polyData->GetPolys()->NewIterator());
  for (cells->GoToFirstCell(); !cells->IsDoneWithTraversal(); cells->GoToNextCell())
  {
    vtkIdType size = 0;
    const vtkIdType* points = nullptr;
    cells->GetCurrentCell(size, points);
    ASSERT_EQ(size, 3);
    EdgeSurface::Triangle triangle{ edges.at(points[0]), edges.at(points[1]), edges.at(points[2]) };
    std::rotate(
      triangle.begin(), std::min_element(triangle.begin(), triangle.end()), triangle.end());
    if (triangle[0] >= 0)
    {
      surface.Triangles.push_back(triangle);
    }
  }
  std::sort(surface.Points.begin(), surface.Points.end());
  std::sort(surface.Triangles.begin(), surface.Triangles.end());
}

// The edges of the points of a surface of inside and outside on a unit grid.
std::vector<std::int64_t> FindEdges(vtkPolyData* middles, vtkImageData* image)
{
  const int* extent = image->GetExtent();
  const int* dimensions = image->GetDimensions();
  std::vector<std::int64_t> edges;
  for (vtkIdType point = 0; point < middles->GetNumberOfPoints(); ++point)
  {
    double position[3];
    middles->GetPoint(point, position);
    std::int64_t vertex = 0;
    int axis = -1;
    for (int n = 2; n >= 0; --n)
    {
      const double low = std::floor(position[n]);
      if (position[n] != low)
      {
        EXPECT_EQ(axis, -1) << "vtkFlyingEdges3D has a point off the edges";
        axis = n;
      }
      vertex = vertex * dimensions[n] + static_cast<std::int64_t>(low) - extent[2 * n];
    }
    edges.push_back(3 * vertex + axis);
  }
  return edges;
}

void TurnCorners(EdgeSurface& surface)
{
  for (EdgeSurface::Triangle& triangle : surface.Triangles)
  {
    std::swap(triangle[1], triangle[2]);
  }
  std::sort(surface.Triangles.begin(), surface.Triangles.end());
}

void ReverseNormals(EdgeSurface& surface)
{
  constexpr std::uint32_t sign = 0x80000000u;
  for (EdgePoint& point : surface.Points)
  {
    for (std::uint32_t& bits : point.Normal)
    {
      bits = std::isnan(ToFloat(bits)) ? bits : bits ^ sign;
    }
  }
  std::sort(surface.Points.begin(), surface.Points.end());
}

// The first item that is in `a` but not in `b`, as text.
template <typename T>
std::string FindExtra(const std::vector<T>& a, const std::vector<T>& b)
{
  std::vector<T> extra;
  std::set_difference(a.begin(), a.end(), b.begin(), b.end(), std::back_inserter(extra));
  return extra.empty()
    ? "nothing"
    : ToString(extra.front()) + " and " + std::to_string(extra.size() - 1) + " more";
}

} // namespace

bool EdgePoint::operator==(const EdgePoint& other) const
{
  return std::tie(this->Edge, this->Position, this->Normal) ==
    std::tie(other.Edge, other.Position, other.Normal);
}

bool EdgePoint::operator<(const EdgePoint& other) const
{
  return std::tie(this->Edge, this->Position, this->Normal) <
    std::tie(other.Edge, other.Position, other.Normal);
}

void EdgeSurface::Add(vtkPolyData* contour, std::int64_t firstId, std::int64_t endId)
{
  auto* ids = vtkIdTypeArray::SafeDownCast(contour->GetPointData()->GetGlobalIds());
  std::vector<std::int64_t> edges;
  if (contour->GetNumberOfPoints() > 0)
  {
    ASSERT_NE(ids, nullptr);
    ASSERT_STREQ(ids->GetName(), "GlobalIds");
    ASSERT_EQ(ids->GetNumberOfTuples(), contour->GetNumberOfPoints());
    for (vtkIdType point = 0; point < ids->GetNumberOfTuples(); ++point)
    {
      const std::int64_t id = ids->GetValue(point);
      edges.push_back(id >= firstId && id < endId ? id - firstId : -1);
    }
  }
  Append(contour, edges, *this);
}

void EdgeSurface::MergeEqualPoints()
{
  this->Points.erase(std::unique(this->Points.begin(), this->Points.end()), this->Points.end());
}

void EdgeSurface::DropNormals()
{
  for (EdgePoint& point : this->Points)
  {
    point.Normal = {};
  }
  std::sort(this->Points.begin(), this->Points.end());
}

void EdgeSurface::DropSignsOfZeros()
{
  for (EdgePoint& point : this->Points)
  {
    for (std::uint32_t& bits : point.Normal)
    {
      bits = ToFloat(bits) == 0 ? 0 : bits;
    }
  }
  std::sort(this->Points.begin(), this->Points.end());
}

void EdgeSurface::ClearZeroNormals(bool isNan)
{
  const auto hasNoDirection = [isNan](std::uint32_t bits)
  {
    float value = 0;
    std::memcpy(&value, &bits, sizeof(value));
    return value == 0 || (isNan && std::isnan(value));
  };
  for (EdgePoint& point : this->Points)
  {
    if (std::all_of(point.Normal.begin(), point.Normal.end(), hasNoDirection))
    {
      point.Normal = {};
    }
  }
  std::sort(this->Points.begin(), this->Points.end());
}

vtkSmartPointer<vtkPolyData> RunFlyingEdges(vtkImageData* image, double isovalue, bool normals)
{
  vtkNew<vtkFlyingEdges3D> contour;
  contour->SetInputData(image);
  contour->SetValue(0, isovalue);
  contour->SetComputeNormals(normals);
  contour->SetComputeGradients(false);
  contour->SetComputeScalars(false);
  contour->Update();
  return contour->GetOutput();
}

EdgeSurface ContourByFlyingEdges(vtkImageData* image, double isovalue)
{
  vtkDataArray* samples = image->GetPointData()->GetScalars();
  vtkNew<vtkUnsignedCharArray> inside;
  inside->SetName("inside");
  inside->SetNumberOfValues(samples->GetNumberOfTuples());
  for (vtkIdType index = 0; index < samples->GetNumberOfTuples(); ++index)
  {
    inside->SetValue(index, samples->GetTuple1(index) >= isovalue);
  }
  vtkNew<vtkImageData> copy;
  copy->SetExtent(image->GetExtent());
  copy->GetPointData()->SetScalars(inside);

  EdgeSurface surface;
  const auto contour = RunFlyingEdges(image, isovalue, true);
  const auto middles = RunFlyingEdges(copy, 0.5, false);
  EXPECT_EQ(contour->GetNumberOfPoints(), middles->GetNumberOfPoints());
  Append(contour, FindEdges(middles, copy), surface);
  const double mirror = image->GetDirectionMatrix()->Determinant();
  const double* spacing = image->GetSpacing();
  if (mirror * spacing[0] * spacing[1] * spacing[2] < 0)
  {
    TurnCorners(surface);
  }
  if (mirror < 0)
  {
    ReverseNormals(surface);
  }
  return surface;
}

testing::AssertionResult AreEqual(const EdgeSurface& surface, const EdgeSurface& expected)
{
  if (surface.Points == expected.Points && surface.Triangles == expected.Triangles)
  {
    return testing::AssertionSuccess();
  }
  return testing::AssertionFailure()
    << surface.Points.size() << " points, " << surface.Triangles.size() << " triangles; expected "
    << expected.Points.size() << " and " << expected.Triangles.size()
    << "\nsurplus points: " << FindExtra(surface.Points, expected.Points)
    << "\nmissing points: " << FindExtra(expected.Points, surface.Points)
    << "\nsurplus triangles: " << FindExtra(surface.Triangles, expected.Triangles)
    << "\nmissing triangles: " << FindExtra(expected.Triangles, surface.Triangles);
}

bool IsClosed(const EdgeSurface& surface)
{
  std::map<std::pair<std::int64_t, std::int64_t>, int> sides;
  for (const EdgeSurface::Triangle& triangle : surface.Triangles)
  {
    for (std::size_t n = 0; n < 3; ++n)
    {
      const std::int64_t from = triangle[n];
      const std::int64_t to = triangle[(n + 1) % 3];
      sides[std::minmax(from, to)] += from < to ? 1 : -1;
    }
  }
  return std::all_of(sides.begin(), sides.end(), [](const auto& side) { return side.second == 0; });
}

testing::AssertionResult IsClosedManifold(const EdgeSurface& surface)
{
  std::map<std::pair<std::int64_t, std::int64_t>, int> sides;
  for (const EdgeSurface::Triangle& triangle : surface.Triangles)
  {
    for (int corner = 0; corner < 3; ++corner)
    {
      ++sides[{ triangle[corner], triangle[(corner + 1) % 3] }];
    }
  }
  for (const auto& [side, uses] : sides)
  {
    const auto back = sides.find({ side.second, side.first });
    if (uses != 1 || back == sides.end() || side.first == side.second)
    {
      return testing::AssertionFailure()
        << "side " << side.first << " -> " << side.second << " is there " << uses
        << " times, and back " << (back == sides.end() ? 0 : back->second) << " times";
    }
  }
  return testing::AssertionSuccess();
}

} // namespace isosurface
