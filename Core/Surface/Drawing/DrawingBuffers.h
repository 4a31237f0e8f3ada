// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_DrawingBuffers_h
#define isosurface_DrawingBuffers_h

#include "Surface/Drawing/TriangleMeasure.h"
#include "Surface/Drawing/TriangleSurface.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace isosurface
{

/**
 * Writes the point numbers of the proper triangles of runs [firstRun, lastRun), three each, in their
 * order. `indices` has room for them; `counts` is TriangleMeasure::ProperTriangles of the surface,
 * whose measure is valid.
 */
void CopyProperTriangles(const TriangleSurface& surface, const std::vector<std::uint32_t>& counts,
  std::size_t firstRun, std::size_t lastRun, std::uint32_t* indices, int threads);

/**
 * Writes (coordinate - shift) * scale, computed in double, for each coordinate of `count` points.
 * Shift and scale are those of the axes.
 */
void ShiftAndScale(const float* points, std::size_t count, const double shift[3],
  const double scale[3], float* result, int threads);

/// Copies `count` values.
void CopyValues(const float* values, std::size_t count, float* result, int threads);

/// A texture of `Colors` colors over a range of values, with one more texel at each end for values
/// beyond it.
struct TextureRange
{
  double Minimum = 0;
  double Maximum = 1;
  int Colors = 256;
};

/**
 * Writes the texture coordinates of `count` tuples, two each, as vtkMapper defines them: the first
 * is where the value is in the texture, clamped to [-1000, 1000], or 0.5 for NaN; the second one is
 * 0.49, or 1 for NaN. `component` -1, or beyond the last one, stands for the magnitude. For all
 * arithmetic types of VTK.
 */
template <typename T>
void FindTextureCoordinates(const T* values, std::size_t count, int components, int component,
  const TextureRange& range, float* coordinates, int threads);

/**
 * Finds the runs of equal values: for each the place behind its last one. Empty if there are more than
 * `most`. The points of an isosurface are one run, and have one color.
 */
template <typename T>
std::vector<std::size_t> FindRuns(const T* values, std::size_t count, std::size_t most)
{
  std::vector<std::size_t> ends;
  for (const T* at = values; at != values + count;)
  {
    if (ends.size() == most)
    {
      return {};
    }
    at = std::find_if(
      at + 1, values + count, [value = *at](const T& other) { return !(other == value); });
    ends.push_back(static_cast<std::size_t>(at - values));
  }
  return ends;
}

} // namespace isosurface

#endif
