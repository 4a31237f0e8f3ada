// SPDX-License-Identifier: BSD-3-Clause
#include "Surface/Contour/PointRestriction.h"

#include <algorithm>
#include <cstring>

namespace isosurface
{

void MovePoint(const BrickPart& part, const std::vector<AttributeLayout>& attributes,
  std::size_t from, std::size_t to)
{
  part.Codes[to] = part.Codes[from];
  part.Coordinates[to] = part.Coordinates[from];
  if (part.Normals)
  {
    std::memmove(part.Normals + 3 * to, part.Normals + 3 * from, 3 * sizeof(float));
  }
  for (std::size_t n = 0; n < attributes.size(); ++n)
  {
    const std::size_t tuple = GetTupleSize(attributes[n]);
    std::memmove(part.Attributes[n] + to * tuple, part.Attributes[n] + from * tuple, tuple);
  }
}

void RestrictPoints(const VertexBox& vertices, const BrickOwnership& before,
  const BrickOwnership& after, const std::vector<AttributeLayout>& attributes, BrickPart& part,
  RestrictionMemory& memory)
{
  const Index3 box = vertices.GetSize();
  const int size[3] = { static_cast<int>(box[0]), static_cast<int>(box[1]),
    static_cast<int>(box[2]) };
  const std::size_t maximum =
    3 * static_cast<std::size_t>(box[0] * box[1] * box[2]) + EdgeCodeSlack;
  const BrickKernels& kernels = GetBrickKernels();
  const std::uint32_t points = part.Counts.Points;
  const EdgeCode* edges = part.Codes;
  if (part.NumberOfVertexPoints > 0)
  {
    // The part's own codes do not tell which edge a point was on that has been moved to a vertex.
    memory.Edges.resize(std::max(memory.Edges.size(), maximum));
    kernels.NumberRows(size, part.Inside, before, part.Offsets, memory.Edges.data());
    edges = memory.Edges.data();
  }
  std::vector<EdgeCode>& kept = memory.Kept;
  kept.resize(std::max(kept.size(), maximum));
  const std::uint32_t keptPoints =
    kernels.NumberRows(size, part.Inside, after, part.Offsets, kept.data()).Points;
  std::uint32_t to = 0;
  std::uint32_t vertexPoint = 0;
  std::uint32_t keptVertexPoints = 0;
  for (std::uint32_t from = 0; from < points; ++from)
  {
    const bool isKept = to < keptPoints && kept[to] == edges[from];
    if (vertexPoint < part.NumberOfVertexPoints && part.VertexPoints[vertexPoint].Point == from)
    {
      const VertexPoint moved = part.VertexPoints[vertexPoint++];
      if (isKept)
      {
        part.VertexPoints[keptVertexPoints] = moved;
        part.VertexPoints[keptVertexPoints++].Point = to;
      }
    }
    if (isKept)
    {
      if (from != to)
      {
        MovePoint(part, attributes, from, to);
      }
      ++to;
    }
  }
  part.Counts.Points = keptPoints;
  part.NumberOfVertexPoints = keptVertexPoints;
}

} // namespace isosurface
