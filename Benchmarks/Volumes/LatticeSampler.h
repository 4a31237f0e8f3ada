// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_LatticeSampler_h
#define isosurface_LatticeSampler_h

#include "Ground/Volume/GridGeometry.h"

#include <array>
#include <cstdint>
#include <vector>

namespace isosurface
{

/// Numbers on a coarse lattice, to be interpolated to a grid.
struct Lattice
{
  Index3 Size{ 0, 0, 0 };
  std::vector<float> Values; ///< empty: hashed numbers in [-1, 1)
  std::uint64_t Seed = 0;
  float Amplitude = 1;
  bool IsInterpolating = false; ///< Catmull-Rom instead of B-spline
};

/// Interpolates a lattice to the rows of a slice of a grid. Refers to the lattice. For one thread at
/// a time.
class LatticeSampler
{
public:
  /// The ends of the lattice are those of a grid of `dimensions` vertices.
  LatticeSampler(const Lattice& lattice, const Index3& dimensions);

  /// Goes to slice k: interpolates along z and x.
  void SetSlice(std::int64_t k);

  /// Interpolates row j of the slice.
  void GetRow(std::int64_t j, float* out) const;

private:
  /// For each vertex on one axis of the grid: the first of four lattice points, and their weights.
  struct Taps
  {
    std::vector<std::int32_t> First;
    std::vector<std::array<float, 4>> Weights;
  };

  static Taps MakeTaps(std::int64_t points, std::int64_t vertices, bool isInterpolating);
  const float* GetLatticeRow(std::int64_t j, std::int64_t k, std::size_t tap);
  void BlendRow(const std::array<const float*, 4>& rows, std::array<float, 4> weights);
  void StretchRow(float* out) const;

  const Lattice& Points;
  std::array<Taps, 3> Axes;
  std::size_t Width = 0;
  std::vector<float> Hashed;
  std::vector<float> Blended; ///< a row of the lattice, with its ends repeated
  std::vector<float> Rows;    ///< Size[1] rows of the grid's width
};

} // namespace isosurface

#endif
