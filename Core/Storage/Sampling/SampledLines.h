// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_SampledLines_h
#define isosurface_SampledLines_h

#include <array>
#include <cstdint>
#include <vector>

namespace isosurface
{

/// Lines of two points in an image of samples.
struct ImageLines
{
  std::vector<std::array<double, 2>> Points;      ///< in columns and rows, counted from 0
  std::vector<std::array<std::int64_t, 2>> Lines; ///< the numbers of their points
};

/// Those of some lines that are kept, in their order.
struct KeptLines
{
  std::vector<std::int64_t> Points;               ///< that have a line, in their order
  std::vector<std::array<std::int64_t, 2>> Lines; ///< numbers among the points that are kept
};

/**
 * Leaves out the lines, each within a cell of an image of this size (2 columns and rows at least),
 * that have a place without samples: those with an end beside NaN, which is nowhere, and those in a
 * cell with a point that is hidden. `isHidden`: not 0 for points that are, a column after the other
 * in each row; null if none is.
 */
KeptLines KeepSampledLines(
  const ImageLines& lines, std::int64_t columns, std::int64_t rows, const std::uint8_t* isHidden);

} // namespace isosurface

#endif
