// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_AttributeNeighbors_h
#define isosurface_AttributeNeighbors_h

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace isosurface
{

/// The edges near an edge from whose tuples its tuple is predicted, with their weights.
class AttributeNeighbors
{
public:
  /// The edges along one axis that begin in one row, at x - 2 to x + 2.
  struct Row
  {
    std::size_t Plane = 0; ///< 0: this slice; 1: the one before
    std::size_t Axis = 0;
    int Y = 0;              ///< relative to the edge
    std::uint32_t Near = 0; ///< bits of the edges that are near enough
    std::array<std::int32_t, 5> Weights{};
  };

  /// The table for all blocks, made by the first call.
  static const AttributeNeighbors& Get();

  const std::vector<Row>& GetRows(int axis) const
  {
    return this->Rows[static_cast<std::size_t>(axis)];
  }

private:
  AttributeNeighbors();

  std::array<std::vector<Row>, 3> Rows;
};

} // namespace isosurface

#endif
