// SPDX-License-Identifier: BSD-3-Clause
// The inner loops of marching cubes by bits, included by BrickKernelBaseline.cxx and
// BrickKernelAvx2.cxx, which define ISOSURFACE_KERNEL as the namespace to compile them into.
//
// Numerics follow vtkFlyingEdges3D: differences of samples are taken in the sample's own type where
// that is exact or rounds (float), everything else in double, coordinates and gradients are rounded
// to float. Where its integer differences would wrap around (32 and 64 bits), ours are exact.

#include "Contour/BrickKernel.h"
#include "Contour/MarchingCubesCases.h"

#include <math.h>

#if defined(__SSE2__)
#  include <emmintrin.h>
#endif

namespace isosurface
{
namespace ISOSURFACE_KERNEL
{
namespace
{

using Word = std::uint64_t;

inline int CountBits(Word bits)
{
  return __builtin_popcountll(bits);
}
inline int FindFirstBit(Word bits) // of a word that is not 0
{
  return __builtin_ctzll(bits);
}
inline Word MaskBelow(int bit)
{
  return (Word(1) << bit) - 1;
}

// ---- Types -------------------------------------------------------------------------------------

template <typename T>
struct IsFloating
{
  static constexpr bool Value = T(0.5) != T(0);
};

template <typename T>
constexpr bool IsWide = !IsFloating<T>::Value && sizeof(T) == 8;

// a - b without overflow, rounded once.
template <typename T>
inline double Subtract(T a, T b)
{
  if constexpr (IsFloating<T>::Value)
  {
    return static_cast<double>(static_cast<T>(a - b));
  }
  else if constexpr (IsWide<T>)
  {
    return a >= b ? static_cast<double>(Word(a) - Word(b))
                  : -static_cast<double>(Word(b) - Word(a));
  }
  else
  {
    return static_cast<double>(a) - static_cast<double>(b);
  }
}

// Calls functor(T{}) with the type of the samples; a switch of this namespace's own.
template <typename Functor>
inline void Dispatch(ValueType type, const Functor& functor)
{
  // clang-format off
  switch (type)
  {
    case ValueType::Int8: functor(std::int8_t{}); break;
    case ValueType::UInt8: functor(std::uint8_t{}); break;
    case ValueType::Int16: functor(std::int16_t{}); break;
    case ValueType::UInt16: functor(std::uint16_t{}); break;
    case ValueType::Int32: functor(std::int32_t{}); break;
    case ValueType::UInt32: functor(std::uint32_t{}); break;
    case ValueType::Int64: functor(std::int64_t{}); break;
    case ValueType::UInt64: functor(std::uint64_t{}); break;
    case ValueType::Float32: functor(float{}); break;
    case ValueType::Float64: functor(double{}); break;
  }
  // clang-format on
}

// ---- Inside or outside -------------------------------------------------------------------------

// One bit for each of 32 bytes that are 0 or 1.
inline Word PackFlags(const std::uint8_t* flags)
{
#if defined(__SSE2__)
  const __m128i low = _mm_load_si128(reinterpret_cast<const __m128i*>(flags));
  const __m128i high = _mm_load_si128(reinterpret_cast<const __m128i*>(flags + 16));
  // The flag is moved to the byte's top bit, which movemask gathers.
  return static_cast<unsigned>(_mm_movemask_epi8(_mm_slli_epi16(low, 7))) |
    static_cast<Word>(static_cast<unsigned>(_mm_movemask_epi8(_mm_slli_epi16(high, 7)))) << 16;
#else
  Word bits = 0;
  for (int n = 0; n < 32; ++n)
  {
    bits |= static_cast<Word>(flags[n]) << n;
  }
  return bits;
#endif
}

template <typename T>
inline Word ClassifyRow(const T* row, std::ptrdiff_t stride, int count, T threshold)
{
  if (stride == 1 && count >= 32)
  {
    alignas(32) std::uint8_t flags[32];
    for (int i = 0; i < 32; ++i)
    {
      flags[i] = row[i] >= threshold;
    }
    Word bits = PackFlags(flags);
    if (count == 33)
    {
      bits |= static_cast<Word>(row[32] >= threshold) << 32;
    }
    return bits;
  }
  Word bits = 0;
  for (int i = 0; i < count; ++i)
  {
    bits |= static_cast<Word>(row[i * stride] >= threshold) << i;
  }
  return bits;
}

void ClassifyRows(ValueType type, const BrickSamples& samples, const void* threshold, Word* inside)
{
  Dispatch(type,
    [&](auto zero)
    {
      using T = decltype(zero);
      const T limit = *static_cast<const T*>(threshold);
      const T* plane = static_cast<const T*>(samples.First);
      const std::ptrdiff_t lastInRow = (samples.Size[0] - 1) * samples.Stride[0];
      for (int k = 0; k < samples.Size[2]; ++k, plane += samples.Stride[2])
      {
        const T* row = plane;
        for (int j = 0; j < samples.Size[1]; ++j, row += samples.Stride[1])
        {
          // The rows of a brick are too short for the processor to see where the next ones are.
          if (k + 1 < samples.Size[2])
          {
            __builtin_prefetch(row + samples.Stride[2]);
            __builtin_prefetch(row + samples.Stride[2] + lastInRow);
          }
          *inside++ = ClassifyRow(row, samples.Stride[0], samples.Size[0], limit);
        }
      }
    });
}

// ---- Numbering ---------------------------------------------------------------------------------

inline int PlaceOf(int index, int size)
{
  return index == 0 ? 0 : index == size - 1 ? 2 : 1;
}

// Appends a code for each bit. Four slots are always written, since that is cheaper than finding
// out how few are needed.
inline EdgeCode* AppendCodes(EdgeCode* codes, Word bits, EdgeCode base)
{
  const int count = CountBits(bits);
  EdgeCode* next = codes;
  for (int left = count;; left -= 4)
  {
    for (int n = 0; n < 4; ++n)
    {
      next[n] = base + static_cast<EdgeCode>(FindFirstBit(bits | Word(1) << 63));
      bits &= bits - 1;
    }
    if (left <= 4)
    {
      return codes + count;
    }
    next += 4;
  }
}

inline unsigned CaseOf(int i, Word row00, Word row10, Word row01, Word row11)
{
  return static_cast<unsigned>(
    (row00 >> i & 3) | (row10 >> i & 3) << 2 | (row01 >> i & 3) << 4 | (row11 >> i & 3) << 6);
}

// The cells of a row of cells that have vertices on both sides, by their low vertex.
inline Word ActiveCells(Word row00, Word row10, Word row01, Word row11, Word cells)
{
  Word any = row00 | row10 | row01 | row11;
  Word all = row00 & row10 & row01 & row11;
  any |= any >> 1;
  all &= all >> 1;
  return any & ~all & cells;
}

BrickCounts NumberRows(const int size[3], const Word* inside, const BrickOwnership& ownership,
  std::uint32_t* offsets, EdgeCode* codes)
{
  const int nx = size[0];
  const int ny = size[1];
  const int nz = size[2];
  const Word cells = MaskBelow(nx - 1);
  const Word noWord = 0;
  EdgeCode* const first = codes;
  Word triangles = 0;
  Word corners = 0;
  for (int k = 0; k < nz; ++k)
  {
    const int zPlace = PlaceOf(k, nz);
    for (int j = 0; j < ny; ++j, ++inside)
    {
      const int yPlace = PlaceOf(j, ny);
      const Word row = *inside;
      const Word rowY = j + 1 < ny ? inside[1] : row;
      const Word rowZ = k + 1 < nz ? inside[ny] : row;
      const Word x = (row ^ row >> 1) & cells;
      const Word y = row ^ rowY;
      const Word z = row ^ rowZ;
      *offsets++ = static_cast<std::uint32_t>(codes - first);
      if ((x | y | z) != noWord)
      {
        const EdgeCode base = static_cast<EdgeCode>(j) << 6 | static_cast<EdgeCode>(k) << 12;
        codes = AppendCodes(codes, x & ownership.X[yPlace][zPlace], base);
        codes = AppendCodes(codes, y & ownership.Y[zPlace], base | 1u << 18);
        codes = AppendCodes(codes, z & ownership.Z[yPlace], base | 2u << 18);
      }
      if (j + 1 == ny || k + 1 == nz)
      {
        continue;
      }
      const Word rowYZ = inside[ny + 1];
      Word active = ActiveCells(row, rowY, rowZ, rowYZ, cells);
      if (active == 0)
      {
        continue;
      }
      // Crossed edges of all the row's cells; each cell's triangles number its crossed edges less
      // two for each of its loops.
      const Word xY = (rowY ^ rowY >> 1) & cells;
      const Word xZ = (rowZ ^ rowZ >> 1) & cells;
      const Word xYZ = (rowYZ ^ rowYZ >> 1) & cells;
      const Word yZ = rowZ ^ rowYZ;
      const Word zY = rowY ^ rowYZ;
      corners += static_cast<Word>(CountBits(x) + CountBits(xY) + CountBits(xZ) + CountBits(xYZ) +
        CountBits(y & cells) + CountBits(y >> 1 & cells) + CountBits(yZ & cells) +
        CountBits(yZ >> 1 & cells) + CountBits(z & cells) + CountBits(z >> 1 & cells) +
        CountBits(zY & cells) + CountBits(zY >> 1 & cells));
      for (; active != 0; active &= active - 1)
      {
        triangles += MarchingCubesCases[CaseOf(FindFirstBit(active), row, rowY, rowZ, rowYZ)] >> 60;
      }
    }
  }
  return { static_cast<std::uint32_t>(codes - first), static_cast<std::uint32_t>(triangles),
    static_cast<std::uint32_t>((corners - triangles) / 2) };
}

// ---- Points ------------------------------------------------------------------------------------

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
inline int AxisOf(EdgeCode code)
{
  return static_cast<int>(code >> 18);
}

template <typename T>
inline double Interpolate(double isovalue, T from, T to)
{
  double t = (isovalue - static_cast<double>(from)) / Subtract(to, from);
  if constexpr (IsWide<T>)
  {
    // A sample of more than 53 bits is rounded above, which can put the point off its edge.
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

// ---- Normals -----------------------------------------------------------------------------------

// Which samples make the derivative along an axis at each of a brick's vertices.
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
    const bool atLow = vertex == 0;
    const bool atHigh = vertex == samples.Dimensions[axis] - 1;
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

// ---- Points in their final place ---------------------------------------------------------------

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
    point[AxisOf(code)] = coordinate;
    if (coordinate != coordinate)
    {
      // As in vtkFlyingEdges3D: beside a NaN there is no point on the edge, nor a part of one.
      point[0] = point[1] = point[2] = coordinate;
    }
    if constexpr (Transformed)
    {
      TransformPoint(transform, point);
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
  for (std::uint32_t n = 0; n < output.NumberOfPoints; ++n, from += 3, to += 3)
  {
    const double x = m[0] * from[0] + m[1] * from[1] + m[2] * from[2];
    const double y = m[3] * from[0] + m[4] * from[1] + m[5] * from[2];
    const double z = m[6] * from[0] + m[7] * from[1] + m[8] * from[2];
    const double length = sqrt(x * x + y * y + z * z);
    const double divisor = length != 0.0 ? length : 1.0;
    to[0] = static_cast<float>(x / divisor);
    to[1] = static_cast<float>(y / divisor);
    to[2] = static_cast<float>(z / divisor);
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
  if (transform.Steps == WorldTransform::Kind::Identity)
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

// ---- Rows ---------------------------------------------------------------------------------------

void FindRows(const NumberedRows& rows, int k, EdgeRow* x, EdgeRow* y, EdgeRow* z)
{
  const int nx = rows.Size[0];
  const int ny = rows.Size[1];
  const int zPlace = PlaceOf(k, rows.Size[2]);
  const Word cells = MaskBelow(nx - 1);
  const Word* inside = rows.Inside + k * ny;
  const std::uint32_t* offsets = rows.Offsets + k * ny;
  const Word* insideZ = k + 1 < rows.Size[2] ? inside + ny : inside;
  for (int j = 0; j < ny; ++j)
  {
    const int yPlace = PlaceOf(j, ny);
    const Word row = inside[j];
    x[j].Bits = (row ^ row >> 1) & cells & rows.Ownership->X[yPlace][zPlace];
    x[j].First = rows.FirstPoint + offsets[j];
    y[j].Bits = (row ^ inside[j + 1 < ny ? j + 1 : j]) & rows.Ownership->Y[zPlace];
    y[j].First = x[j].First + CountBits(x[j].Bits);
    z[j].Bits = (row ^ insideZ[j]) & rows.Ownership->Z[yPlace];
    z[j].First = y[j].First + CountBits(y[j].Bits);
  }
}

// ---- Triangles ---------------------------------------------------------------------------------

template <typename Id>
inline Id NumberOf(const EdgeRow& row, Word below)
{
  return static_cast<Id>(row.First) + static_cast<Id>(CountBits(row.Bits & below));
}

// The numbers of the points on the twelve edges of cell (i, j); meaningless for uncrossed edges.
template <typename Id>
inline void NumberEdges(const RowSlab& slab, int i, int j, Id numbers[12])
{
  const Word below = MaskBelow(i);
  const Word upTo = below << 1 | 1;
  numbers[0] = NumberOf<Id>(slab.X[0][j], below);
  numbers[1] = NumberOf<Id>(slab.X[0][j + 1], below);
  numbers[2] = NumberOf<Id>(slab.X[1][j], below);
  numbers[3] = NumberOf<Id>(slab.X[1][j + 1], below);
  numbers[4] = NumberOf<Id>(slab.Y[0][j], below);
  numbers[5] = NumberOf<Id>(slab.Y[0][j], upTo);
  numbers[6] = NumberOf<Id>(slab.Y[1][j], below);
  numbers[7] = NumberOf<Id>(slab.Y[1][j], upTo);
  numbers[8] = NumberOf<Id>(slab.Z[j], below);
  numbers[9] = NumberOf<Id>(slab.Z[j], upTo);
  numbers[10] = NumberOf<Id>(slab.Z[j + 1], below);
  numbers[11] = NumberOf<Id>(slab.Z[j + 1], upTo);
}

// Puts right the edges of a cell's low (side 0) or high (side 1) x face that lies in a column.
template <typename Id>
inline void NumberColumnEdges(const RowSlab& slab, int side, int j, Id numbers[12])
{
  numbers[4 + side] = static_cast<Id>(slab.ColumnY[side][0][j]);
  numbers[6 + side] = static_cast<Id>(slab.ColumnY[side][1][j]);
  numbers[8 + side] = static_cast<Id>(slab.ColumnZ[side][j]);
  numbers[10 + side] = static_cast<Id>(slab.ColumnZ[side][j + 1]);
}

constexpr int MostCorners = 15;

template <typename Id>
inline Id* AppendTriangles(Id* out, const Id* end, Word triangles, const Id numbers[12])
{
  const int corners = 3 * static_cast<int>(triangles >> 60);
  if (end - out >= MostCorners)
  {
    // Two triangles are the rule: they are written in any case, which saves guessing the number.
    for (int n = 0; n < 6; ++n)
    {
      out[n] = numbers[triangles >> (4 * n) & 15];
    }
    if (corners > 6)
    {
      for (int n = 6; n < MostCorners; ++n)
      {
        // Nibbles of no triangle are 0, and so name an edge.
        out[n] = numbers[triangles >> (4 * n) & 15];
      }
    }
    return out + corners;
  }
  for (int n = 0; n < corners; ++n)
  {
    out[n] = numbers[triangles >> (4 * n) & 15];
  }
  return out + corners;
}

// Calls forCell(case, numbers) for every cell of the slab that the surface crosses.
template <typename Id, typename Functor>
inline void VisitCells(const RowSlab& slab, const Functor& forCell)
{
  const int lastCell = slab.Size[0] - 2;
  const Word cells = MaskBelow(slab.Size[0] - 1);
  for (int j = 0; j + 1 < slab.Size[1]; ++j)
  {
    const Word row00 = slab.Inside[0][j];
    const Word row10 = slab.Inside[0][j + 1];
    const Word row01 = slab.Inside[1][j];
    const Word row11 = slab.Inside[1][j + 1];
    Id numbers[12];
    for (Word active = ActiveCells(row00, row10, row01, row11, cells); active != 0;
         active &= active - 1)
    {
      const int i = FindFirstBit(active);
      NumberEdges(slab, i, j, numbers);
      if (i == lastCell)
      {
        NumberColumnEdges(slab, 1, j, numbers);
      }
      if (i == 0 && !slab.FirstColumnInRow)
      {
        NumberColumnEdges(slab, 0, j, numbers);
      }
      forCell(CaseOf(i, row00, row10, row01, row11), numbers);
    }
  }
}

template <typename Id>
Id* WriteTriangles(const RowSlab& slab, Id* out, Id* end)
{
  VisitCells<Id>(slab,
    [&](unsigned cellCase, const Id numbers[12])
    { out = AppendTriangles(out, end, MarchingCubesCases[cellCase], numbers); });
  return out;
}

template <typename Id>
void WritePolygons(const RowSlab& slab, const PolygonCase* cases, Id*& connectivity, Id*& offsets,
  std::int64_t& index)
{
  VisitCells<Id>(slab,
    [&](unsigned cellCase, const Id numbers[12])
    {
      const PolygonCase& polygons = cases[cellCase];
      for (int polygon = 0; polygon < polygons.NumberOfPolygons; ++polygon)
      {
        *offsets++ = static_cast<Id>(index);
        index += polygons.Sizes[polygon];
      }
      for (int corner = 0; corner < polygons.NumberOfCorners; ++corner)
      {
        *connectivity++ = numbers[polygons.Corners[corner]];
      }
    });
}

// ---- Ranges ------------------------------------------------------------------------------------

// 32 bytes of samples side by side, as GCC and Clang have it: operators work on all lanes, and the
// compiler breaks them down to what the processor has.
template <typename T>
struct LanesOf
{
  static constexpr int Count = static_cast<int>(32 / sizeof(T));
  typedef T Type __attribute__((vector_size(32)));
};

template <typename T>
void JoinRows(const SampleRows& rows, T& minimum, T& maximum, bool& notANumber)
{
  using Lanes = typename LanesOf<T>::Type;
  constexpr int width = LanesOf<T>::Count;
  const std::int64_t count = rows.Size[0];
  const std::ptrdiff_t stride = rows.Stride[0];
  Lanes low = Lanes{} + minimum;
  Lanes high = Lanes{} + maximum;
  auto odd = low != low;
  const T* row = static_cast<const T*>(rows.First);
  for (std::int64_t n = 0; n < rows.Size[1]; ++n, row += rows.Stride[1])
  {
    if (stride != 1 || count < width)
    {
      for (std::int64_t i = 0; i < count; ++i)
      {
        const T value = row[i * stride];
        minimum = value < minimum ? value : minimum;
        maximum = maximum < value ? value : maximum;
        notANumber = notANumber || value != value;
      }
      continue;
    }
    for (std::int64_t i = 0; i < count; i += width)
    {
      // The last step goes back to end with the row: samples may be seen twice.
      Lanes values;
      __builtin_memcpy(&values, row + (i + width <= count ? i : count - width), sizeof(values));
      low = values < low ? values : low;
      high = high < values ? values : high;
      odd |= values != values;
    }
  }
  for (int lane = 0; lane < width; ++lane)
  {
    minimum = low[lane] < minimum ? low[lane] : minimum;
    maximum = maximum < high[lane] ? high[lane] : maximum;
    notANumber = notANumber || odd[lane] != 0;
  }
}

void JoinRange(
  ValueType type, const SampleRows& rows, void* minimum, void* maximum, bool* notANumber)
{
  Dispatch(type,
    [&](auto zero)
    {
      using T = decltype(zero);
      JoinRows(rows, *static_cast<T*>(minimum), *static_cast<T*>(maximum), *notANumber);
    });
}

} // namespace

extern const BrickKernels Kernels;
const BrickKernels Kernels = { ClassifyRows, NumberRows, LocatePoints, ComputeNormals, WritePoints,
  FindRows, WriteTriangles<std::int32_t>, WriteTriangles<std::int64_t>, WritePolygons<std::int32_t>,
  WritePolygons<std::int64_t>, JoinRange };

} // namespace ISOSURFACE_KERNEL
} // namespace isosurface
