// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_CrossingFit_h
#define isosurface_CrossingFit_h

#include "EdgeIndex/SignRows.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace isosurface
{

constexpr std::size_t CrossingPlaneSize = (MaximumCodedVertices + 4) * std::size_t(80);

/// Where on the edges along one axis that begin at the vertices of a slice the crossings are, in
/// units of 1 / CrossingFit::Unit, and which edges are crossed: row y stands at y + 2.
struct CrossingPlane
{
  std::array<std::int16_t, CrossingPlaneSize> Positions;
  std::array<SignRow, MaximumCodedVertices + 4> Crossed;
};
/// [this slice, the one before, the next one][axis]
using CrossingPlanes = std::array<std::array<CrossingPlane, 3>*, 3>;

/**
 * Predicts where on an edge the surface is, from where it was on edges nearby: the zero of a linear
 * function that is fitted, by weighted least squares, to 0 at those points and, with little weight,
 * to -0.7 and 0.7 at vertices outside and inside. Edges that are crossed but not decoded yet count
 * a little as well, by their middles.
 *
 * In integers throughout, so that encoder and decoder agree on every machine: sums of products are
 * exact, the mean is taken out, and the three equations that are left are solved by Cramer's rule.
 */
class CrossingFit
{
public:
  static constexpr std::ptrdiff_t RowStride = 80;
  static constexpr std::ptrdiff_t RowMargin = 8;
  static constexpr std::int32_t Unit = 1024;      ///< of positions on an edge
  static constexpr std::int32_t FineUnit = 65536; ///< of predicted ones
  static constexpr std::int16_t None = -1;        ///< for edges without a crossing
  static constexpr std::int16_t Later = -2;       ///< for crossings that are not decoded yet

  struct Result
  {
    std::int32_t Position = FineUnit / 2; ///< 0 to FineUnit
    int Steepness = 0;                    ///< how straight the surface crosses the edge, 0 to 7
    int Number = 0;                       ///< of crossings that were used
  };

  /// The only one; made once.
  static const CrossingFit& Get();

  /// at: the place of the edge's first vertex (x, y) in a plane; inside: its sign; slices: the
  /// signs before, in and after this slice.
  Result Predict(int axis, int x, int y, std::ptrdiff_t at, bool inside,
    const std::array<const SignSlice*, 3>& slices, const CrossingPlanes& planes) const;

  /// The mean of the nearest parallel edges only.
  Result PredictParallel(
    int axis, int x, int y, std::ptrdiff_t at, const CrossingPlanes& planes) const;

private:
  // An edge nearby: its first vertex as seen from the middle of the edge to predict, in Units.
  struct Neighbor
  {
    std::array<std::int32_t, 3> First{};
    std::int32_t Weight = 0;      ///< once it is decoded
    std::int32_t WeightLater = 0; ///< before
  };
  // Those of one row of vertices, x - 2 to x + 2.
  struct NeighborRow
  {
    std::size_t Plane = 0;
    std::size_t Axis = 0;
    int Y = 0;
    std::uint32_t Near = 0; ///< bits of those that are near enough
    std::array<Neighbor, 5> Neighbors;
  };
  // Lower triangle of the symmetric matrix, and the right-hand side, of (1, x, y, z).
  struct Equations
  {
    std::array<std::int64_t, 10> A{}; ///< 11 xx yy zz, x y z, xy xz yz
    std::array<std::int64_t, 4> B{};
  };
  // What the signs of one row of vertices around the edge add to B, by the signs.
  struct SignRowSums
  {
    int Y = 0;
    std::size_t Slice = 0;
    std::array<std::array<std::int32_t, 4>, 8> Sums;
  };

  CrossingFit();
  void MakeNeighbors(int axis);
  void MakeSigns(int axis);
  static Result Solve(const Equations& equations, int axis, bool inside);

  std::array<std::vector<NeighborRow>, 3> Rows;
  std::array<std::vector<NeighborRow>, 3> ParallelRows; ///< of the same axis only
  std::array<std::vector<SignRowSums>, 3> Signs;
  std::array<Equations, 3> SignEquations; ///< A of the vertices around an edge
};

} // namespace isosurface

#endif
