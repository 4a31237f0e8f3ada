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

/// Where on the edges that begin at the vertices of a slice the crossings are, 0 to 1.
using CrossingPlane = std::array<float, CrossingPlaneSize>;
/// [this slice, the one before, the next one][axis]
using CrossingPositions = std::array<std::array<CrossingPlane, 3>, 3>;

/**
 * Predicts where on an edge the surface is, from where it was on edges nearby: the zero of a linear
 * function that is fitted, by weighted least squares, to 0 at those points and, with little weight,
 * to -1 and 1 at vertices outside and inside.
 *
 * In double precision with additions, multiplications and divisions in a fixed order only: IEEE 754
 * defines each of them to the last bit, so encoder and decoder agree on every machine.
 */
class CrossingFit
{
public:
  static constexpr std::ptrdiff_t RowStride = 80;
  static constexpr std::ptrdiff_t RowMargin = 8;
  static constexpr std::size_t PlaneSize = CrossingPlaneSize;
  static constexpr float None = -1;  ///< for edges without a crossing
  static constexpr float Later = -2; ///< for crossings that are not decoded yet

  struct Result
  {
    double Position = 0.5;
    int Steepness = 0; ///< how straight the surface crosses the edge, 0 to 7
    int Number = 0;    ///< of crossings that were used
  };

  CrossingFit();

  /// at: the place of the edge's first vertex (x, y) in a plane; inside: its sign.
  Result Predict(int axis, int x, int y, std::ptrdiff_t at, bool inside,
    const std::array<const SignSlice*, 3>& slices, const CrossingPositions& positions) const;

  /// The mean of the nearest parallel edges only.
  Result PredictParallel(int axis, std::ptrdiff_t at, const CrossingPositions& positions) const;

private:
  // An edge nearby: where its position stands, and its first vertex as seen from the middle of the
  // edge to predict.
  struct Neighbor
  {
    std::size_t Plane;
    std::size_t Axis;
    std::ptrdiff_t Offset;
    double First[3];
    double Weight;      ///< once it is decoded
    double WeightLater; ///< before: its middle counts instead
  };
  struct Equations
  {
    double A[4][4]; ///< lower triangle
    double B[4];
  };

  void AddSigns(int axis, int x, int y, const std::array<const SignSlice*, 3>& slices,
    Equations& equations) const;
  static bool Solve(Equations& equations);

  std::array<std::vector<Neighbor>, 3> Neighbors;
  std::array<Equations, 3> SignEquations; ///< A of the vertices around an edge
};

} // namespace isosurface

#endif
