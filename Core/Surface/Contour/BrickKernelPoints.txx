// SPDX-License-Identifier: BSD-3-Clause
// Points and normals, and their final place. A part of BrickKernel.txx.
#ifndef isosurface_BrickKernelPoints_txx
#define isosurface_BrickKernelPoints_txx

#include "Surface/Contour/BrickKernelBasics.txx"

#include <math.h>

namespace isosurface
{
namespace ISOSURFACE_KERNEL
{
namespace
{

inline int IOf(EdgeCode code)
{
  return static_cast<int>(code & 63);
}
inline int JOf(EdgeCode code)
{
  return static_cast<int>(code >> 6 & 63);
}
inline int KOf(EdgeCode code)
{
  return static_cast<int>(code >> 12 & 63);
}
inline int AxisOf(EdgeCode code) // 3 if the code is that of a vertex
{
  return static_cast<int>(code >> 18);
}
inline int CoordinateOf(EdgeCode code) // the axis of PointOutput::Coordinates: x for a vertex
{
  return 0x24 >> (2 * AxisOf(code)) & 3;
}

template <typename T>
inline double Interpolate(double isovalue, T from, T to)
{
  double t = (isovalue - static_cast<double>(from)) / Subtract(to, from);
  if constexpr (IsWide<T>)
  {
    // Samples of more than 53 bits are rounded above, which can move the point off its edge.
    t = t < 0.0 ? 0.0 : t > 1.0 ? 1.0 : t;
  }
  return t;
}

void LocatePoints(ValueType type, const BrickSamples& samples, double isovalue,
  const EdgeCode* codes, std::uint32_t count, float* coordinates, double* parameters)
{
  double low[3][MaximumBrickSize];
  for (int axis = 0; axis < 3; ++axis)
  {
    for (int n = 0; n < samples.Size[axis]; ++n)
    {
      low[axis][n] = static_cast<double>(samples.Low[axis] + n);
    }
  }
  const double extentLow[3] = { static_cast<double>(samples.ExtentLow[0]),
    static_cast<double>(samples.ExtentLow[1]), static_cast<double>(samples.ExtentLow[2]) };
  const std::ptrdiff_t stride[3] = { samples.Stride[0], samples.Stride[1], samples.Stride[2] };
  Dispatch(type,
    [&](auto zero)
    {
      using T = decltype(zero);
      const T* first = static_cast<const T*>(samples.First);
      for (std::uint32_t n = 0; n < count; ++n)
      {
        const EdgeCode code = codes[n];
        const int axis = AxisOf(code);
        const T* from =
          first + IOf(code) * stride[0] + JOf(code) * stride[1] + KOf(code) * stride[2];
        const double t = Interpolate(isovalue, *from, from[stride[axis]]);
        if (parameters)
        {
          parameters[n] = t;
        }
        const int along = static_cast<int>(code >> (6 * axis) & 63);
        coordinates[n] = static_cast<float>(low[axis][along] + t + extentLow[axis]);
      }
    });
}

// The differences for the derivative along an axis at each of a brick's vertices.
struct Stencil
{
  std::ptrdiff_t Before[MaximumBrickSize];
  std::ptrdiff_t After[MaximumBrickSize];
  double Factor[MaximumBrickSize];
};

inline void MakeStencil(const BrickSamples& samples, int axis, Stencil& stencil)
{
  for (int n = 0; n < samples.Size[axis]; ++n)
  {
    const std::int64_t vertex = samples.Low[axis] + n;
    const bool atLow = vertex == samples.KnownLow[axis];
    const bool atHigh = vertex == samples.KnownHigh[axis] - 1;
    stencil.Before[n] = atLow ? 0 : -samples.Stride[axis];
    stencil.After[n] = atHigh ? 0 : samples.Stride[axis];
    stencil.Factor[n] = atLow || atHigh ? 1.0 : 0.5;
  }
}

template <typename T>
inline void Gradient(
  const T* sample, const Stencil stencils[3], int i, int j, int k, float gradient[3])
{
  const int index[3] = { i, j, k };
  for (int axis = 0; axis < 3; ++axis)
  {
    const Stencil& stencil = stencils[axis];
    const int n = index[axis];
    gradient[axis] = static_cast<float>(
      stencil.Factor[n] * Subtract(sample[stencil.After[n]], sample[stencil.Before[n]]));
  }
}

void ComputeNormals(ValueType type, const BrickSamples& samples, const EdgeCode* codes,
  const double* parameters, std::uint32_t count, float* normals)
{
  Stencil stencils[3];
  for (int axis = 0; axis < 3; ++axis)
  {
    MakeStencil(samples, axis, stencils[axis]);
  }
  const std::ptrdiff_t stride[4] = { samples.Stride[0], samples.Stride[1], samples.Stride[2], 0 };
  Dispatch(type,
    [&](auto zero)
    {
      using T = decltype(zero);
      const T* first = static_cast<const T*>(samples.First);
      for (std::uint32_t n = 0; n < count; ++n)
      {
        const EdgeCode code = codes[n];
        const int axis = AxisOf(code);
        const int i = IOf(code);
        const int j = JOf(code);
        const int k = KOf(code);
        const T* from = first + i * stride[0] + j * stride[1] + k * stride[2];
        float g0[3];
        float g1[3];
        Gradient(from, stencils, i, j, k, g0);
        Gradient(
          from + stride[axis], stencils, i + (axis == 0), j + (axis == 1), k + (axis == 2), g1);
        const double t = parameters[n];
        const float normal[3] = { -static_cast<float>(g0[0] + t * (g1[0] - g0[0])),
          -static_cast<float>(g0[1] + t * (g1[1] - g0[1])),
          -static_cast<float>(g0[2] + t * (g1[2] - g0[2])) };
        const float length =
          sqrtf(normal[0] * normal[0] + normal[1] * normal[1] + normal[2] * normal[2]);
        const float divisor = length != 0.0f ? length : 1.0f;
        normals[3 * n] = normal[0] / divisor;
        normals[3 * n + 1] = normal[1] / divisor;
        normals[3 * n + 2] = normal[2] / divisor;
      }
    });
}

inline void TransformPoint(const WorldTransform& transform, float point[3])
{
  if (transform.Steps == WorldTransform::Kind::Translation)
  {
    for (int axis = 0; axis < 3; ++axis)
    {
      point[axis] = static_cast<float>(point[axis] + transform.Origin[axis]);
    }
    return;
  }
  const double* m = transform.Points;
  const double x = m[0] * point[0] + m[1] * point[1] + m[2] * point[2] + m[3];
  const double y = m[4] * point[0] + m[5] * point[1] + m[6] * point[2] + m[7];
  const double z = m[8] * point[0] + m[9] * point[1] + m[10] * point[2] + m[11];
  point[0] = static_cast<float>(x);
  point[1] = static_cast<float>(y);
  point[2] = static_cast<float>(z);
}

template <bool Transformed>
void WritePositions(
  const BrickSamples& position, const WorldTransform& transform, const PointOutput& output)
{
  float at[3][MaximumBrickSize];
  for (int axis = 0; axis < 3; ++axis)
  {
    for (int n = 0; n < position.Size[axis]; ++n)
    {
      at[axis][n] = static_cast<float>(static_cast<double>(position.Low[axis] + n) +
        static_cast<double>(position.ExtentLow[axis]));
    }
  }
  float* point = output.Points;
  for (std::uint32_t n = 0; n < output.NumberOfPoints; ++n, point += 3)
  {
    const EdgeCode code = output.Codes[n];
    const float coordinate = output.Coordinates[n];
    point[0] = at[0][IOf(code)];
    point[1] = at[1][JOf(code)];
    point[2] = at[2][KOf(code)];
    point[CoordinateOf(code)] = coordinate;
    if (coordinate != coordinate)
    {
      // As in vtkFlyingEdges3D: next to a NaN, all coordinates of the point are NaN.
      point[0] = point[1] = point[2] = coordinate;
    }
    if constexpr (Transformed)
    {
      TransformPoint(transform, point);
    }
  }
}

// Without any rounding to float.
void WriteDoublePositions(
  const BrickSamples& position, const WorldTransform& transform, const PointOutput& output)
{
  double first[3];
  for (int axis = 0; axis < 3; ++axis)
  {
    first[axis] = static_cast<double>(position.Low[axis] + position.ExtentLow[axis]);
  }
  const double* m = transform.Points;
  double* point = output.DoublePoints;
  for (std::uint32_t n = 0; n < output.NumberOfPoints; ++n, point += 3)
  {
    const EdgeCode code = output.Codes[n];
    const double t = output.Parameters[n];
    double at[3] = { first[0] + IOf(code), first[1] + JOf(code), first[2] + KOf(code) };
    at[CoordinateOf(code)] += t;
    if (t != t)
    {
      at[0] = at[1] = at[2] = t; // as in WritePositions
    }
    for (int row = 0; row < 3; ++row)
    {
      point[row] =
        m[4 * row] * at[0] + m[4 * row + 1] * at[1] + m[4 * row + 2] * at[2] + m[4 * row + 3];
    }
  }
}

// As vtkImageTransform since VTK 9.4. A zero gradient stays (0, 0, 0).
void WriteNormalsRoundedOnce(const WorldTransform& transform, const PointOutput& output)
{
  // Scaled before and not after, as there: this decides about last bits and the sign of zeros.
  double m[9];
  for (int element = 0; element < 9; ++element)
  {
    m[element] =
      transform.Normals[element] / transform.Spacing[element % 3] * transform.Determinant;
  }
  const float* from = output.Normals;
  float* to = output.WorldNormals;
  for (std::uint32_t n = 0; n < output.NumberOfPoints; ++n, from += 3, to += 3)
  {
    const double x = from[0];
    const double y = from[1];
    const double z = from[2];
    double normal[3];
    for (int row = 0; row < 3; ++row)
    {
      normal[row] = m[3 * row] * x + m[3 * row + 1] * y + m[3 * row + 2] * z;
    }
    const double length =
      sqrt(normal[0] * normal[0] + normal[1] * normal[1] + normal[2] * normal[2]);
    for (int row = 0; row < 3; ++row)
    {
      to[row] = static_cast<float>(length != 0.0 ? normal[row] / length : 0.0);
    }
  }
}

void WriteNormals(const WorldTransform& transform, const PointOutput& output)
{
  const double* m = transform.Normals;
  const float* from = output.Normals;
  float* to = output.WorldNormals;
  if (transform.Steps != WorldTransform::Kind::Matrix)
  {
    __builtin_memcpy(to, from, sizeof(float) * 3 * output.NumberOfPoints);
    return;
  }
  if (transform.NormalsRoundedOnce)
  {
    WriteNormalsRoundedOnce(transform, output);
    return;
  }
  // Rounded to float after each step, as vtkImageTransform did before VTK 9.4.
  const double* spacing = transform.Spacing;
  for (std::uint32_t n = 0; n < output.NumberOfPoints; ++n, from += 3, to += 3)
  {
    const float x = static_cast<float>(from[0] / spacing[0]);
    const float y = static_cast<float>(from[1] / spacing[1]);
    const float z = static_cast<float>(from[2] / spacing[2]);
    float normal[3];
    for (int row = 0; row < 3; ++row)
    {
      normal[row] = static_cast<float>(m[3 * row] * x + m[3 * row + 1] * y + m[3 * row + 2] * z);
      normal[row] = static_cast<float>(normal[row] * transform.Determinant);
    }
    const float square = normal[0] * normal[0] + normal[1] * normal[1] + normal[2] * normal[2];
    // A zero gradient stays (0, 0, 0); vtkImageTransform divides by 0.
    const float factor =
      square != 0.0f ? static_cast<float>(1.0 / sqrt(static_cast<double>(square))) : 0.0f;
    to[0] = normal[0] * factor;
    to[1] = normal[1] * factor;
    to[2] = normal[2] * factor;
  }
}

void WriteGlobalIds(const BrickSamples& position, const PointOutput& output)
{
  std::int64_t row[MaximumBrickSize];
  std::int64_t plane[MaximumBrickSize];
  const std::int64_t nx = position.Dimensions[0];
  const std::int64_t ny = position.Dimensions[1];
  for (int j = 0; j < position.Size[1]; ++j)
  {
    row[j] = 3 * (position.Low[0] + nx * (position.Low[1] + j)) + output.FirstGlobalId;
  }
  for (int k = 0; k < position.Size[2]; ++k)
  {
    plane[k] = 3 * nx * ny * (position.Low[2] + k);
  }
  for (std::uint32_t n = 0; n < output.NumberOfPoints; ++n)
  {
    const EdgeCode code = output.Codes[n];
    output.GlobalIds[n] = row[JOf(code)] + plane[KOf(code)] + 3 * IOf(code) + AxisOf(code);
  }
}

void WritePoints(
  const BrickSamples& position, const WorldTransform& transform, const PointOutput& output)
{
  if (output.DoublePoints)
  {
    WriteDoublePositions(position, transform, output);
  }
  else if (transform.Steps == WorldTransform::Kind::Identity)
  {
    WritePositions<false>(position, transform, output);
  }
  else
  {
    WritePositions<true>(position, transform, output);
  }
  if (output.WorldNormals)
  {
    WriteNormals(transform, output);
  }
  if (output.GlobalIds)
  {
    WriteGlobalIds(position, output);
  }
}

} // namespace
} // namespace ISOSURFACE_KERNEL
} // namespace isosurface

#endif
