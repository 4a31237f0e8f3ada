// SPDX-License-Identifier: BSD-3-Clause
#include "Surface/Contour/PointRestriction.h"

#include <algorithm>
#include <cstring>

namespace isosurface
{
namespace
{

std::uint32_t CountEdges(std::uint64_t edges)
{
  return static_cast<std::uint32_t>(__builtin_popcountll(edges));
}

/// Finds the points that a part does not own any more.
class DroppedPoints
{
public:
  DroppedPoints(
    const BrickOwnership& before, const BrickOwnership& after, std::vector<std::uint32_t>& dropped)
    : Before(before)
    , After(after)
    , Dropped(dropped)
  {
    this->Dropped.clear();
  }

  /// Lists them in ascending order, and renumbers the rows of the part.
  void Find(const Index3& size, const BrickSurface& part)
  {
    const auto ny = static_cast<std::size_t>(size[1]);
    const auto nz = static_cast<std::size_t>(size[2]);
    const std::uint64_t cells = (std::uint64_t{ 1 } << (size[0] - 1)) - 1;
    bool areSame[NumberOfPlaces][NumberOfPlaces];
    for (std::size_t y = 0; y < NumberOfPlaces; ++y)
    {
      for (std::size_t z = 0; z < NumberOfPlaces; ++z)
      {
        areSame[y][z] = this->Before.X[y][z] == this->After.X[y][z] &&
          this->Before.Y[z] == this->After.Y[z] && this->Before.Z[y] == this->After.Z[y];
      }
    }
    const std::uint64_t* inside = part.Inside;
    std::uint32_t* offset = part.Offsets;
    for (std::size_t k = 0; k < nz; ++k)
    {
      const std::size_t z = FindPlace(k, nz);
      for (std::size_t j = 0; j < ny; ++j, ++inside, ++offset)
      {
        const std::size_t y = FindPlace(j, ny);
        std::uint32_t first = *offset;
        *offset -= static_cast<std::uint32_t>(this->Dropped.size());
        if (areSame[y][z])
        {
          continue;
        }
        const std::uint64_t row = *inside;
        const std::uint64_t rowY = j + 1 < ny ? inside[1] : row;
        const std::uint64_t rowZ = k + 1 < nz ? inside[ny] : row;
        this->AddEdges((row ^ row >> 1) & cells, this->Before.X[y][z], this->After.X[y][z], first);
        this->AddEdges(row ^ rowY, this->Before.Y[z], this->After.Y[z], first);
        this->AddEdges(row ^ rowZ, this->Before.Z[y], this->After.Z[y], first);
      }
    }
  }

private:
  static std::size_t FindPlace(std::size_t index, std::size_t size)
  {
    return index == 0 ? 0 : index == size - 1 ? 2 : 1;
  }

  /// `first`: the number of the first point on these edges; raised by how many there are.
  void AddEdges(
    std::uint64_t crossed, std::uint64_t before, std::uint64_t after, std::uint32_t& first)
  {
    const std::uint64_t owned = crossed & before;
    for (std::uint64_t lost = owned & ~after; lost != 0; lost &= lost - 1)
    {
      const std::uint64_t below = (lost & -lost) - 1;
      this->Dropped.push_back(first + CountEdges(owned & below));
    }
    first += CountEdges(owned);
  }

  const BrickOwnership& Before;
  const BrickOwnership& After;
  std::vector<std::uint32_t>& Dropped;
};

void RestrictVertexPoints(const std::vector<std::uint32_t>& dropped, BrickSurface& part)
{
  std::uint32_t kept = 0;
  for (std::uint32_t n = 0; n < part.NumberOfVertexPoints; ++n)
  {
    VertexPoint moved = part.VertexPoints[n];
    const auto next = std::lower_bound(dropped.begin(), dropped.end(), moved.Point);
    if (next == dropped.end() || *next != moved.Point)
    {
      moved.Point -= static_cast<std::uint32_t>(next - dropped.begin());
      part.VertexPoints[kept++] = moved;
    }
  }
  part.NumberOfVertexPoints = kept;
}

} // namespace

void MovePoints(const BrickSurface& part, const std::vector<AttributeLayout>& attributes,
  std::size_t from, std::size_t to, std::size_t count)
{
  const auto move = [&](auto* values, std::size_t size)
  { std::memmove(values + to * size, values + from * size, count * size * sizeof(*values)); };
  move(part.Codes, 1);
  move(part.Coordinates, 1);
  if (part.Parameters)
  {
    move(part.Parameters, 1);
  }
  if (part.Normals)
  {
    move(part.Normals, 3);
  }
  for (std::size_t n = 0; n < attributes.size(); ++n)
  {
    move(part.Attributes[n], GetTupleSize(attributes[n]));
  }
}

void RestrictPoints(const VertexBox& vertices, const BrickOwnership& before,
  const BrickOwnership& after, const std::vector<AttributeLayout>& attributes, BrickSurface& part,
  std::vector<std::uint32_t>& dropped)
{
  DroppedPoints(before, after, dropped).Find(vertices.GetSize(), part);
  RestrictVertexPoints(dropped, part);
  for (std::size_t n = 0; n < dropped.size(); ++n)
  {
    // The points between two dropped ones move together.
    const std::size_t from = std::size_t{ dropped[n] } + 1;
    const std::size_t end = n + 1 < dropped.size() ? dropped[n + 1] : part.Counts.Points;
    MovePoints(part, attributes, from, from - n - 1, end - from);
  }
  part.Counts.Points -= static_cast<std::uint32_t>(dropped.size());
}

} // namespace isosurface
