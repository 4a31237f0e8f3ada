// SPDX-License-Identifier: BSD-3-Clause
#include "Surface/Contour/CellVisibility.h"

#include "Surface/Contour/MarchingCubesCases.h"

#include <algorithm>
#include <cmath>
#include <type_traits>

namespace isosurface
{
namespace
{

std::uint64_t MaskBelow(int bit)
{
  return (std::uint64_t(1) << bit) - 1;
}

Index3 Step(Index3 vertex, std::size_t axis, std::int64_t step)
{
  vertex[axis] += step;
  return vertex;
}

} // namespace

CellVisibility::CellVisibility(const BlockSamples& samples, bool skipNotANumber)
  : Scalars(samples.Scalars)
  , Hidden(samples.Hidden && !samples.Hidden->IsEmpty() ? samples.Hidden : nullptr)
  , SkipsNotANumber(skipNotANumber && IsFloatingType(samples.Scalars.Type))
{
}

bool CellVisibility::IsNotANumber(const Index3& vertex) const
{
  return this->Scalars.Type == ValueType::Float32 ? std::isnan(*this->Scalars.At<float>(vertex))
                                                  : std::isnan(*this->Scalars.At<double>(vertex));
}

std::uint64_t CellVisibility::FindRow(const Index3& first, int count) const
{
  std::uint64_t row = MaskBelow(count);
  if (this->Hidden && this->Hidden->Vertices)
  {
    const std::uint8_t* flags = this->Hidden->AtVertex(first);
    for (int n = 0; n < count; ++n)
    {
      const bool isHidden = (flags[n] & this->Hidden->HidesVertex) != 0;
      row &= ~(static_cast<std::uint64_t>(isHidden) << n);
    }
  }
  if (this->SkipsNotANumber)
  {
    DispatchValueType(this->Scalars.Type,
      [&](auto zero)
      {
        using T = decltype(zero);
        if constexpr (std::is_floating_point_v<T>)
        {
          const T* sample = this->Scalars.At<T>(first);
          for (int n = 0; n < count; ++n, sample += this->Scalars.Stride[0])
          {
            row &= ~(static_cast<std::uint64_t>(std::isnan(*sample)) << n);
          }
        }
      });
  }
  return row;
}

std::uint64_t CellVisibility::FindCellRow(const Index3& first, int count) const
{
  std::uint64_t row = MaskBelow(count);
  if (this->Hidden && this->Hidden->Cells)
  {
    const std::uint8_t* flags = this->Hidden->AtCell(first);
    for (int n = 0; n < count; ++n)
    {
      const bool isHidden = (flags[n] & this->Hidden->HidesCell) != 0;
      row &= ~(static_cast<std::uint64_t>(isHidden) << n);
    }
  }
  return row;
}

bool CellVisibility::IsCellVisible(const Index3& cell) const
{
  std::uint64_t corners = this->FindCellRow(cell, 1) != 0 ? 3 : 0;
  for (std::int64_t n = 0; n < 4; ++n)
  {
    corners &= this->FindRow({ cell[0], cell[1] + n % 2, cell[2] + n / 2 }, 2);
  }
  return corners == 3;
}

bool CellVisibility::IsKnown(const Index3& vertex) const
{
  if (this->SkipsNotANumber && this->IsNotANumber(vertex))
  {
    return false;
  }
  if (!this->Hidden)
  {
    return true;
  }
  // Blanked samples are in memory with all that is around them.
  for (std::int64_t n = 0; n < 8; ++n)
  {
    const Index3 cell{ vertex[0] - n % 2, vertex[1] - n / 2 % 2, vertex[2] - n / 4 };
    if (this->Hidden->HasCell(cell) && this->IsCellVisible(cell))
    {
      return true;
    }
  }
  return false;
}

bool CellVisibility::FindVisibleCells(const Brick& brick, std::uint64_t* visible) const
{
  if (brick.IsBeyond())
  {
    this->FindCellsBeyond(brick, visible);
  }
  else
  {
    this->FindInnerCells(brick, visible);
  }
  const Index3 size = brick.Vertices.GetSize();
  const std::uint64_t all = MaskBelow(static_cast<int>(size[0]) - 1);
  bool areAllVisible = true;
  for (std::int64_t k = 0; k + 1 < size[2]; ++k)
  {
    const std::uint64_t* rows = visible + k * size[1];
    areAllVisible = areAllVisible &&
      std::all_of(rows, rows + size[1] - 1, [all](std::uint64_t row) { return row == all; });
  }
  return !areAllVisible;
}

void CellVisibility::FindInnerCells(const Brick& brick, std::uint64_t* visible) const
{
  const Index3 size = brick.Vertices.GetSize();
  const Index3& low = brick.Vertices.Low;
  const int vertices = static_cast<int>(size[0]);
  std::uint64_t* row = visible;
  for (std::int64_t k = 0; k < size[2]; ++k)
  {
    for (std::int64_t j = 0; j < size[1]; ++j)
    {
      const std::uint64_t known = this->FindRow({ low[0], low[1] + j, low[2] + k }, vertices);
      *row++ = known & known >> 1;
    }
  }
  // Every row of cells is between four rows of vertices; later rows are not changed yet.
  row = visible;
  for (std::int64_t k = 0; k + 1 < size[2]; ++k)
  {
    for (std::int64_t j = 0; j < size[1]; ++j, ++row)
    {
      if (j + 1 < size[1])
      {
        *row &= row[1] & row[size[1]] & row[size[1] + 1];
        *row &= this->FindCellRow({ low[0], low[1] + j, low[2] + k }, vertices - 1);
      }
    }
  }
}

// Cells beyond a side are visible if those are that the side belongs to.
void CellVisibility::FindCellsBeyond(const Brick& brick, std::uint64_t* visible) const
{
  const Index3 size = brick.Vertices.GetSize();
  Index3 step{};
  for (step[2] = 0; step[2] < size[2]; ++step[2])
  {
    for (step[1] = 0; step[1] < size[1]; ++step[1])
    {
      std::uint64_t row = 0;
      const bool isRowOfCells = step[1] + 1 < size[1] && step[2] + 1 < size[2];
      for (step[0] = 0; isRowOfCells && step[0] + 1 < size[0]; ++step[0])
      {
        Index3 cell{};
        for (std::size_t axis = 0; axis < 3; ++axis)
        {
          cell[axis] = brick.Vertices.Low[axis] + step[axis] - brick.Side[axis];
        }
        row |= static_cast<std::uint64_t>(this->IsCellVisible(cell)) << step[0];
      }
      *visible++ = row;
    }
  }
}

bool CellVisibility::HasUnknownSamples(const Brick& brick, const VertexBox& knownSamples) const
{
  VertexBox around = brick.Vertices;
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    --around.Low[axis];
    ++around.High[axis];
  }
  around = around.Intersect(knownSamples).Intersect(this->Scalars.Available);
  const Index3 size = around.GetSize();
  const auto vertices = static_cast<int>(size[0]);
  for (std::int64_t k = 0; k < size[2]; ++k)
  {
    for (std::int64_t j = 0; j < size[1]; ++j)
    {
      const Index3 first{ around.Low[0], around.Low[1] + j, around.Low[2] + k };
      const bool isRowOfCells = vertices > 1 && j + 1 < size[1] && k + 1 < size[2];
      if (this->FindRow(first, vertices) != MaskBelow(vertices) ||
        (isRowOfCells && this->FindCellRow(first, vertices - 1) != MaskBelow(vertices - 1)))
      {
        return true;
      }
    }
  }
  return false;
}

BrickCounts CountVisible(
  const int size[3], const std::uint64_t* inside, const std::uint64_t* visible)
{
  BrickCounts counts{ 0, 0, 0 };
  const PolygonCase* polygons = GetCellCases(false).Polygons;
  for (int k = 0; k + 1 < size[2]; ++k)
  {
    for (int j = 0; j + 1 < size[1]; ++j)
    {
      const std::uint64_t* rows[4] = { inside + j + k * size[1], nullptr, nullptr, nullptr };
      rows[1] = rows[0] + 1;
      rows[2] = rows[0] + size[1];
      rows[3] = rows[2] + 1;
      for (std::uint64_t cells = visible[j + k * size[1]]; cells != 0; cells &= cells - 1)
      {
        const int i = __builtin_ctzll(cells);
        std::uint64_t cellCase = 0;
        for (int row = 0; row < 4; ++row)
        {
          cellCase |= (*rows[row] >> i & 3) << (2 * row);
        }
        counts.Triangles += static_cast<std::uint32_t>(MarchingCubesCases[cellCase] >> 60);
        counts.Polygons += polygons[cellCase].NumberOfPolygons;
      }
    }
  }
  return counts;
}

namespace
{

// Gradients of known samples, rounded as the kernels do.
class KnownGradients
{
public:
  KnownGradients(
    const CellVisibility& visibility, const SampleView& scalars, const VertexBox& knownSamples)
    : Visibility(visibility)
    , Scalars(scalars)
    , KnownSamples(knownSamples)
  {
  }

  // Whether all samples around a vertex are known.
  bool IsPlain(const Index3& vertex) const
  {
    for (std::size_t axis = 0; axis < 3; ++axis)
    {
      for (const int side : { -1, 1 })
      {
        const Index3 neighbor = Step(vertex, axis, side);
        if (this->IsWithin(neighbor, axis) && !this->Visibility.IsKnown(neighbor))
        {
          return false;
        }
      }
    }
    return true;
  }

  template <typename T>
  std::array<float, 3> Compute(const Index3& vertex) const
  {
    std::array<float, 3> gradient{};
    for (std::size_t axis = 0; axis < 3; ++axis)
    {
      Index3 ends[2] = { vertex, vertex };
      int steps = 0;
      for (const int side : { 0, 1 })
      {
        const Index3 neighbor = Step(vertex, axis, 2 * side - 1);
        if (this->IsWithin(neighbor, axis) && this->Visibility.IsKnown(neighbor))
        {
          ends[side] = neighbor;
          ++steps;
        }
      }
      const T after = *this->Scalars.At<T>(ends[1]);
      const T before = *this->Scalars.At<T>(ends[0]);
      const double difference = std::is_floating_point_v<T>
        ? static_cast<double>(static_cast<T>(after - before))
        : static_cast<double>(static_cast<long double>(after) - static_cast<long double>(before));
      gradient[axis] = static_cast<float>(steps == 2 ? 0.5 * difference : difference);
    }
    return gradient;
  }

private:
  bool IsWithin(const Index3& vertex, std::size_t axis) const
  {
    return vertex[axis] >= this->KnownSamples.Low[axis] &&
      vertex[axis] < this->KnownSamples.High[axis];
  }

  const CellVisibility& Visibility;
  const SampleView& Scalars;
  const VertexBox& KnownSamples;
};

} // namespace

void CorrectNormals(const CellVisibility& visibility, const SampleView& scalars,
  const VertexBox& knownSamples, const Index3& low, const EdgeCode* codes, const double* parameters,
  std::uint32_t count, float* normals)
{
  const KnownGradients gradients(visibility, scalars, knownSamples);
  for (std::uint32_t n = 0; n < count; ++n)
  {
    const std::size_t axis = codes[n] >> 18;
    const Index3 from{ low[0] + (codes[n] & 63), low[1] + (codes[n] >> 6 & 63),
      low[2] + (codes[n] >> 12 & 63) };
    const Index3 to = axis < 3 ? Step(from, axis, 1) : from;
    if (gradients.IsPlain(from) && gradients.IsPlain(to))
    {
      continue;
    }
    std::array<float, 3> g0{};
    std::array<float, 3> g1{};
    DispatchValueType(scalars.Type,
      [&](auto zero)
      {
        g0 = gradients.Compute<decltype(zero)>(from);
        g1 = gradients.Compute<decltype(zero)>(to);
      });
    std::array<float, 3> normal{};
    for (std::size_t a = 0; a < 3; ++a)
    {
      normal[a] = -static_cast<float>(g0[a] + parameters[n] * (g1[a] - g0[a]));
    }
    const float length =
      std::sqrt(normal[0] * normal[0] + normal[1] * normal[1] + normal[2] * normal[2]);
    for (std::size_t a = 0; a < 3; ++a)
    {
      normals[3 * n + a] = normal[a] / (length != 0.0f ? length : 1.0f);
    }
  }
}

} // namespace isosurface
