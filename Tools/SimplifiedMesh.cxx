// SPDX-License-Identifier: BSD-3-Clause
#include "SimplifiedMesh.h"

#include "Ground/Volume/Vector3.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <tuple>

namespace isosurface
{
namespace
{

/// The sum of squared distances from planes, by their weights: p A p + 2 b p + c.
struct PlaneQuadric
{
  std::array<double, 6> A{}; ///< xx, yy, zz, xy, xz, yz
  Vector3 B{};
  double C = 0;

  /// The plane through a point across a normal that is as long as the weight.
  void AddPlane(const Vector3& point, const Vector3& normal, double weight)
  {
    const Vector3 n = { normal[0] / weight, normal[1] / weight, normal[2] / weight };
    const double d = -Dot(n, point);
    const std::array<double, 6> products = { n[0] * n[0], n[1] * n[1], n[2] * n[2], n[0] * n[1],
      n[0] * n[2], n[1] * n[2] };
    for (std::size_t i = 0; i < 6; ++i)
    {
      this->A[i] += weight * products[i];
    }
    for (std::size_t i = 0; i < 3; ++i)
    {
      this->B[i] += weight * d * n[i];
    }
    this->C += weight * d * d;
  }

  void Add(const PlaneQuadric& other)
  {
    for (std::size_t i = 0; i < 6; ++i)
    {
      this->A[i] += other.A[i];
    }
    for (std::size_t i = 0; i < 3; ++i)
    {
      this->B[i] += other.B[i];
    }
    this->C += other.C;
  }

  double Measure(const Vector3& p) const
  {
    const double square = this->A[0] * p[0] * p[0] + this->A[1] * p[1] * p[1] +
      this->A[2] * p[2] * p[2] +
      2 * (this->A[3] * p[0] * p[1] + this->A[4] * p[0] * p[2] + this->A[5] * p[1] * p[2]);
    return std::abs(square + 2 * Dot(this->B, p) + this->C);
  }
};

/// Brings points into the unit cube, where numbers are fine enough.
class UnitFrame
{
public:
  UnitFrame(std::size_t numberOfPoints, const float* points)
  {
    Vector3 high;
    for (std::size_t axis = 0; axis < 3; ++axis)
    {
      this->Low[axis] = high[axis] = static_cast<double>(points[axis]);
      for (std::size_t point = 1; point < numberOfPoints; ++point)
      {
        const auto place = static_cast<double>(points[3 * point + axis]);
        this->Low[axis] = std::min(this->Low[axis], place);
        high[axis] = std::max(high[axis], place);
      }
      this->Size = std::max(this->Size, high[axis] - this->Low[axis]);
    }
    this->Size = this->Size > 0 ? this->Size : 1;
  }

  Vector3 Place(const float* point) const
  {
    Vector3 placed;
    for (std::size_t axis = 0; axis < 3; ++axis)
    {
      placed[axis] = (static_cast<double>(point[axis]) - this->Low[axis]) / this->Size;
    }
    return placed;
  }

private:
  Vector3 Low{};
  double Size = 0;
};

/// Collapses in passes. In a pass each point takes part in at most one collapse, so that the triangles
/// of both ends are those at the start of the pass, but for corners that were moved (GetCorner).
class EdgeCollapser
{
public:
  EdgeCollapser(
    const float* points, std::size_t numberOfPoints, std::vector<std::uint32_t>& corners)
    : Points(points)
    , Corners(corners)
    , Frame(numberOfPoints, points)
    , Quadrics(numberOfPoints)
    , IsFixed(numberOfPoints)
    , IsTouched(numberOfPoints)
    , Marks(numberOfPoints)
    , Places(numberOfPoints)
    , FirstTriangle(numberOfPoints + 1)
  {
    std::iota(this->Places.begin(), this->Places.end(), 0);
    this->ListTriangles();
    this->AddPlanes();
    for (std::uint32_t point = 0; point < numberOfPoints; ++point)
    {
      this->IsFixed[point] = this->IsInside(point) ? 0 : 1;
    }
  }

  /// Whether anything was collapsed.
  bool RunPass(std::size_t triangles)
  {
    const std::size_t wanted = (this->Corners.size() / 3 - triangles + 1) / 2;
    this->ListEdges();
    if (this->Edges.empty())
    {
      return false;
    }
    // Not all edges can be collapsed in a pass; the others wait for the next one.
    const auto middle =
      this->Edges.begin() + static_cast<std::ptrdiff_t>(std::min(wanted, this->Edges.size() - 1));
    std::nth_element(this->Edges.begin(), middle, this->Edges.end(), IsBefore);
    const float limit = 1.5F * middle->Error;
    const auto within = std::partition(
      middle, this->Edges.end(), [limit](const Edge& edge) { return edge.Error <= limit; });
    std::fill(this->IsTouched.begin(), this->IsTouched.end(), std::uint8_t{ 0 });
    std::size_t done = this->Collapse(this->Edges.begin(), within, wanted);
    if (10 * done <= wanted)
    {
      done += this->Collapse(within, this->Edges.end(), (wanted + 9) / 10 - done);
    }
    this->MoveCorners();
    this->ListTriangles();
    return done > 0;
  }

private:
  struct Edge
  {
    std::uint32_t From; ///< the point that goes
    std::uint32_t To;
    float Error;
  };

  static bool IsBefore(const Edge& a, const Edge& b)
  {
    return std::tie(a.Error, a.From, a.To) < std::tie(b.Error, b.From, b.To);
  }

  /// Collapses those that can be, in the order of their errors, but not more than are wanted. Returns
  /// how many.
  std::size_t Collapse(
    std::vector<Edge>::iterator begin, std::vector<Edge>::iterator end, std::size_t wanted)
  {
    std::sort(begin, end, IsBefore);
    std::size_t done = 0;
    for (auto edge = begin; edge != end && done < wanted; ++edge)
    {
      if (!this->IsTouched[edge->From] && !this->IsTouched[edge->To] && this->CanCollapse(*edge))
      {
        this->Places[edge->From] = edge->To;
        this->Quadrics[edge->To].Add(this->Quadrics[edge->From]);
        this->IsTouched[edge->From] = this->IsTouched[edge->To] = 1;
        ++done;
      }
    }
    return done;
  }

  Vector3 GetPoint(std::uint32_t point) const
  {
    return this->Frame.Place(this->Points + std::size_t{ 3 } * point);
  }

  std::uint32_t GetCorner(std::size_t triangle, std::size_t corner) const
  {
    return this->Places[this->Corners[3 * triangle + corner % 3]];
  }

  /// Calls functor(second corner, third corner) for each triangle of a point; in the order of the
  /// triangle's corners, the point being the first one.
  template <typename Functor>
  void VisitTriangles(std::uint32_t point, const Functor& functor) const
  {
    for (std::size_t n = this->FirstTriangle[point]; n < this->FirstTriangle[point + 1]; ++n)
    {
      const std::size_t triangle = this->Triangles[n];
      const std::uint32_t* corners = this->Corners.data() + 3 * triangle;
      const auto own = static_cast<std::size_t>(std::find(corners, corners + 3, point) - corners);
      const std::uint32_t second = this->GetCorner(triangle, own + 1);
      const std::uint32_t third = this->GetCorner(triangle, own + 2);
      if (second != third)
      {
        functor(second, third);
      }
    }
  }

  void ListTriangles()
  {
    std::fill(this->FirstTriangle.begin(), this->FirstTriangle.end(), 0);
    for (const std::uint32_t corner : this->Corners)
    {
      ++this->FirstTriangle[corner + std::size_t{ 1 }];
    }
    std::partial_sum(
      this->FirstTriangle.begin(), this->FirstTriangle.end(), this->FirstTriangle.begin());
    this->Triangles.resize(this->Corners.size());
    // Each entry moves to the end of its point's list, so those of the next point come first.
    for (std::size_t corner = this->Corners.size(); corner-- > 0;)
    {
      this->Triangles[--this->FirstTriangle[this->Corners[corner] + std::size_t{ 1 }]] =
        static_cast<std::uint32_t>(corner / 3);
    }
    std::copy(
      this->FirstTriangle.begin() + 1, this->FirstTriangle.end(), this->FirstTriangle.begin());
    this->FirstTriangle.back() = static_cast<std::uint32_t>(this->Corners.size());
  }

  void AddPlanes()
  {
    for (std::size_t triangle = 0; triangle < this->Corners.size() / 3; ++triangle)
    {
      const std::uint32_t* corners = this->Corners.data() + 3 * triangle;
      const Vector3 first = this->GetPoint(corners[0]);
      const Vector3 normal = Cross(
        Subtract(this->GetPoint(corners[1]), first), Subtract(this->GetPoint(corners[2]), first));
      const double weight = std::sqrt(Dot(normal, normal));
      for (std::size_t corner = 0; corner < 3 && weight > 0; ++corner)
      {
        this->Quadrics[corners[corner]].AddPlane(first, normal, weight);
      }
    }
  }

  /// Whether the triangles of a point are one closed fan around it.
  bool IsInside(std::uint32_t point)
  {
    this->Around.clear();
    this->VisitTriangles(point,
      [this](std::uint32_t second, std::uint32_t third) {
        this->Around.push_back({ second, third });
      });
    const std::size_t count = this->FirstTriangle[point + 1] - this->FirstTriangle[point];
    if (count < 3 || this->Around.size() != count)
    {
      return false;
    }
    std::uint32_t at = this->Around[0][0];
    for (std::size_t n = 0; n < count; ++n)
    {
      const auto isNext = [at](const std::array<std::uint32_t, 2>& side) { return side[0] == at; };
      const auto next = std::find_if(this->Around.begin(), this->Around.end(), isNext);
      if (next == this->Around.end() ||
        std::find_if(next + 1, this->Around.end(), isNext) != this->Around.end())
      {
        return false;
      }
      at = (*next)[1];
      if (at == this->Around[0][0] && n + 1 < count)
      {
        return false; // another fan is left
      }
    }
    return at == this->Around[0][0];
  }

  void ListEdges()
  {
    this->Edges.clear();
    for (std::size_t corner = 0; corner < this->Corners.size(); ++corner)
    {
      const std::uint32_t a = this->Corners[corner];
      const std::uint32_t b = this->Corners[corner % 3 == 2 ? corner - 2 : corner + 1];
      if (a > b || (this->IsFixed[a] && this->IsFixed[b]))
      {
        continue; // of the two directions of an edge, one is taken
      }
      const double there = this->Quadrics[a].Measure(this->GetPoint(b));
      const double back = this->Quadrics[b].Measure(this->GetPoint(a));
      const bool goesBack = this->IsFixed[a] || (!this->IsFixed[b] && back < there);
      this->Edges.push_back(goesBack ? Edge{ b, a, static_cast<float>(back) }
                                     : Edge{ a, b, static_cast<float>(there) });
    }
  }

  bool CanCollapse(const Edge& edge)
  {
    return this->KeepsTopology(edge) && !this->TurnsTriangles(edge);
  }

  /// The link condition: both ends have no neighbours in common but the two across the edge, and are
  /// not two corners of a tetrahedron.
  bool KeepsTopology(const Edge& edge)
  {
    const std::uint64_t mark = this->NextMark;
    this->NextMark += 2;
    std::array<std::uint32_t, 2> across{};
    std::size_t triangles = 0;
    std::size_t degree = 0;
    this->VisitTriangles(edge.From,
      [&](std::uint32_t second, std::uint32_t third)
      {
        ++degree;
        this->Marks[second] = this->Marks[third] = mark;
        if (second == edge.To || third == edge.To)
        {
          across[triangles++ % 2] = second == edge.To ? third : second;
        }
      });
    std::size_t common = 0;
    bool hasOpposite = false;
    this->VisitTriangles(edge.To,
      [&](std::uint32_t second, std::uint32_t third)
      {
        for (const std::uint32_t point : { second, third })
        {
          common += this->Marks[point] == mark ? 1U : 0U;
          this->Marks[point] = this->Marks[point] == mark ? mark + 1 : this->Marks[point];
        }
        hasOpposite = hasOpposite || (second == across[0] && third == across[1]) ||
          (second == across[1] && third == across[0]);
      });
    return triangles == 2 && common == 2 && !(degree == 3 && hasOpposite);
  }

  /// Whether a triangle would turn by more than about 80 degrees, or lose its area.
  bool TurnsTriangles(const Edge& edge) const
  {
    const Vector3 from = this->GetPoint(edge.From);
    const Vector3 to = this->GetPoint(edge.To);
    bool turns = false;
    this->VisitTriangles(edge.From,
      [&](std::uint32_t second, std::uint32_t third)
      {
        if (turns || second == edge.To || third == edge.To)
        {
          return;
        }
        const Vector3 a = this->GetPoint(second);
        const Vector3 side = Subtract(this->GetPoint(third), a);
        const Vector3 before = Cross(side, Subtract(from, a));
        const Vector3 after = Cross(side, Subtract(to, a));
        const double lengths = std::sqrt(Dot(before, before) * Dot(after, after));
        turns = Dot(before, before) > 0 && Dot(before, after) <= 0.2 * lengths;
      });
    return turns;
  }

  void MoveCorners()
  {
    std::size_t kept = 0;
    for (std::size_t triangle = 0; triangle < this->Corners.size() / 3; ++triangle)
    {
      const std::array<std::uint32_t, 3> corners = { this->GetCorner(triangle, 0),
        this->GetCorner(triangle, 1), this->GetCorner(triangle, 2) };
      if (corners[0] != corners[1] && corners[1] != corners[2] && corners[2] != corners[0])
      {
        std::copy(corners.begin(), corners.end(), this->Corners.data() + kept);
        kept += 3;
      }
    }
    this->Corners.resize(kept);
  }

  const float* Points;
  std::vector<std::uint32_t>& Corners;
  UnitFrame Frame;
  std::vector<PlaneQuadric> Quadrics;
  std::vector<std::uint8_t> IsFixed;
  std::vector<std::uint8_t> IsTouched;      ///< in this pass
  std::vector<std::uint64_t> Marks;         ///< of neighbours
  std::vector<std::uint32_t> Places;        ///< where corners have moved
  std::vector<std::uint32_t> FirstTriangle; ///< of each point in Triangles
  std::vector<std::uint32_t> Triangles;
  std::vector<Edge> Edges;
  std::vector<std::array<std::uint32_t, 2>> Around;
  std::uint64_t NextMark = 1;
};

/**
 * Collapses edges of a mesh, those first that move the surface least, until it has at most the
 * wanted number of triangles. The points that are left stay where they are. Error: the quadrics of
 * M. Garland and P. S. Heckbert, "Surface simplification using quadric error metrics", SIGGRAPH
 * 1997.
 *
 * Topology is kept: an edge is collapsed only if that joins no other points and triangles (the link
 * condition: T. K. Dey et al., "Topology preserving edge contraction", Publ. Inst. Math. 66, 1999), so
 * a manifold stays one, and a closed surface stays closed. Points on open sides, and those where the
 * mesh is no manifold, stay. So there may be more triangles than wanted.
 *
 * `corners`: three numbers of points a triangle; becomes that of the triangles that are left. Memory:
 * about 250 bytes a point.
 */
void CollapseEdges(const float* points, std::size_t numberOfPoints, std::size_t triangles,
  std::vector<std::uint32_t>& corners)
{
  if (corners.size() <= 3 * triangles)
  {
    return;
  }
  EdgeCollapser collapser(points, numberOfPoints, corners);
  while (corners.size() > 3 * triangles && collapser.RunPass(triangles))
  {
  }
}

} // namespace

SimplifiedMesh::SimplifiedMesh(const Mesh& mesh, std::size_t triangles)
  : Description(mesh)
  , Corners(mesh.Corners, mesh.Corners + 3 * mesh.NumberOfTriangles)
{
  CollapseEdges(mesh.Points, mesh.NumberOfPoints, triangles, this->Corners);
  this->KeepUsedPoints(mesh);
}

void SimplifiedMesh::KeepUsedPoints(const Mesh& mesh)
{
  constexpr std::uint32_t unused = std::numeric_limits<std::uint32_t>::max();
  std::vector<std::uint32_t> places(mesh.NumberOfPoints, unused);
  for (const std::uint32_t corner : this->Corners)
  {
    places[corner] = 0;
  }
  std::uint32_t kept = 0;
  for (std::size_t point = 0; point < places.size(); ++point)
  {
    if (places[point] == unused)
    {
      continue;
    }
    for (std::size_t axis = 0; axis < 3; ++axis)
    {
      this->Points.push_back(mesh.Points[3 * point + axis]);
      if (mesh.DoublePoints)
      {
        this->DoublePoints.push_back(mesh.DoublePoints[3 * point + axis]);
      }
      if (mesh.Normals)
      {
        this->Normals.push_back(mesh.Normals[3 * point + axis]);
      }
    }
    this->GlobalIds.push_back(mesh.GlobalIds[point]);
    places[point] = kept++;
  }
  for (std::uint32_t& corner : this->Corners)
  {
    corner = places[corner];
  }
}

Mesh SimplifiedMesh::Get() const
{
  Mesh mesh = this->Description;
  mesh.Points = this->Points.data();
  mesh.DoublePoints = this->Description.DoublePoints ? this->DoublePoints.data() : nullptr;
  mesh.Normals = this->Description.Normals ? this->Normals.data() : nullptr;
  mesh.GlobalIds = this->GlobalIds.data();
  mesh.NumberOfPoints = this->GlobalIds.size();
  mesh.Corners = this->Corners.data();
  mesh.NumberOfTriangles = this->Corners.size() / 3;
  return mesh;
}

} // namespace isosurface
