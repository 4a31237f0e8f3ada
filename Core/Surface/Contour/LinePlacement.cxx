// SPDX-License-Identifier: BSD-3-Clause
#include "Surface/Contour/LinePlacement.h"

#include <cmath>
#include <cstddef>

namespace isosurface
{
namespace
{

constexpr EdgeCode VertexCode = 3;

Index3 FindVertex(const LinedBrick& brick, EdgeCode code)
{
  return { brick.Low[0] + (code & 63), brick.Low[1] + (code >> 6 & 63),
    brick.Low[2] + (code >> 12 & 63) };
}

Index3 StepAlong(Index3 vertex, std::size_t axis, std::int64_t step)
{
  vertex[axis] += step;
  return vertex;
}

double GetSample(const SampleView& scalars, const Index3& vertex)
{
  double sample = 0;
  DispatchValueType(scalars.Type,
    [&](auto zero) { sample = static_cast<double>(*scalars.At<decltype(zero)>(vertex)); });
  return sample;
}

std::array<double, 3> ComputeGradient(const LinedBrick& brick, const SampleView& scalars,
  const VertexBox& knownSamples, const CellVisibility* unknown, const Index3& vertex)
{
  std::array<double, 3> gradient{};
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    Index3 ends[2] = { vertex, vertex };
    double distance = 0;
    for (const int side : { 0, 1 })
    {
      const Index3 neighbor = StepAlong(vertex, axis, 2 * side - 1);
      const bool isWithin =
        neighbor[axis] >= knownSamples.Low[axis] && neighbor[axis] < knownSamples.High[axis];
      if (isWithin && !(unknown && !unknown->IsKnown(neighbor)))
      {
        ends[side] = neighbor;
        distance +=
          std::abs(brick.Lines.At(axis, neighbor[axis]) - brick.Lines.At(axis, vertex[axis]));
      }
    }
    if (distance > 0)
    {
      gradient[axis] = (GetSample(scalars, ends[1]) - GetSample(scalars, ends[0])) / distance;
    }
  }
  return gradient;
}

// The coordinate on an edge along an axis. Beyond the grid both ends are the border.
double PlaceOnEdge(const LinedBrick& brick, std::size_t axis, const Index3& from, double parameter)
{
  const double low = brick.Lines.At(axis, from[axis]);
  const double high = brick.Lines.At(axis, from[axis] + 1);
  return low + parameter * (high - low);
}

} // namespace

void LocateOnLines(const LinedBrick& brick, const SampleView& scalars, double isovalue,
  float* coordinates, double* parameters)
{
  for (std::uint32_t n = 0; n < brick.Count && scalars.Type == ValueType::Float32; ++n)
  {
    const std::size_t axis = brick.Codes[n] >> 18;
    if (axis != VertexCode)
    {
      const Index3 from = FindVertex(brick, brick.Codes[n]);
      const double low = *scalars.At<float>(from);
      const double high = *scalars.At<float>(StepAlong(from, axis, 1));
      parameters[n] = (isovalue - low) / (high - low);
    }
  }
  PlaceOnLines(brick, parameters, coordinates);
}

void WriteDoublePointsOnLines(const LinedBrick& brick, const double* parameters, double* points)
{
  for (std::uint32_t n = 0; n < brick.Count; ++n, points += 3)
  {
    const std::size_t axis = brick.Codes[n] >> 18;
    const Index3 from = FindVertex(brick, brick.Codes[n]);
    for (std::size_t a = 0; a < 3; ++a)
    {
      points[a] = brick.Lines.At(a, from[a]);
    }
    if (axis != VertexCode)
    {
      points[axis] = PlaceOnEdge(brick, axis, from, parameters[n]);
    }
    if (std::isnan(parameters[n]))
    {
      points[0] = points[1] = points[2] = parameters[n];
    }
  }
}

void PlaceOnLines(const LinedBrick& brick, const double* parameters, float* coordinates)
{
  for (std::uint32_t n = 0; n < brick.Count; ++n)
  {
    const std::size_t axis = brick.Codes[n] >> 18;
    const Index3 from = FindVertex(brick, brick.Codes[n]);
    if (axis == VertexCode)
    {
      coordinates[n] = static_cast<float>(brick.Lines.At(0, from[0]));
      continue;
    }
    coordinates[n] = static_cast<float>(PlaceOnEdge(brick, axis, from, parameters[n]));
  }
}

void ComputeNormalsOnLines(const LinedBrick& brick, const SampleView& scalars,
  const VertexBox& knownSamples, const CellVisibility* unknown, const double* parameters,
  float* normals)
{
  for (std::uint32_t n = 0; n < brick.Count; ++n)
  {
    const std::size_t axis = brick.Codes[n] >> 18;
    const Index3 from = FindVertex(brick, brick.Codes[n]);
    const Index3 to = axis == VertexCode ? from : StepAlong(from, axis, 1);
    const auto g0 = ComputeGradient(brick, scalars, knownSamples, unknown, from);
    const auto g1 = ComputeGradient(brick, scalars, knownSamples, unknown, to);
    double normal[3];
    for (std::size_t a = 0; a < 3; ++a)
    {
      normal[a] = g0[a] + parameters[n] * (g1[a] - g0[a]);
    }
    const double length =
      std::sqrt(normal[0] * normal[0] + normal[1] * normal[1] + normal[2] * normal[2]);
    for (std::size_t a = 0; a < 3; ++a)
    {
      normals[3 * n + a] = static_cast<float>(-(length != 0.0 ? normal[a] / length : normal[a]));
    }
  }
}

void WritePointsOnLines(const LinedBrick& brick, const float* coordinates, float* points)
{
  for (std::uint32_t n = 0; n < brick.Count; ++n, points += 3)
  {
    const std::size_t axis = brick.Codes[n] >> 18;
    const Index3 from = FindVertex(brick, brick.Codes[n]);
    for (std::size_t a = 0; a < 3; ++a)
    {
      points[a] = static_cast<float>(brick.Lines.At(a, from[a]));
    }
    points[axis == VertexCode ? 0 : axis] = coordinates[n];
    if (std::isnan(coordinates[n]))
    {
      // As in images: next to a NaN, all coordinates of the point are NaN.
      points[0] = points[1] = points[2] = coordinates[n];
    }
  }
}

} // namespace isosurface
