// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_Blanking_h
#define isosurface_Blanking_h

#include "Ground/Volume/BlockGrid.h"

#include <cstddef>
#include <cstdint>

namespace isosurface
{

/**
 * A view of flags that hide cells and vertices of a box, such as vtkGhostType: a byte for each, x
 * fastest. A cell is visible if neither it nor one of its vertices is hidden. What is hidden has no
 * surface and no influence on one: see ContourRequest.
 */
struct Blanking
{
  VertexBox Box;                          ///< the vertices; the cells are those between them
  const std::uint8_t* Cells = nullptr;    ///< null: no cell is hidden
  std::uint8_t HidesCell = 0;             ///< any of these bits
  const std::uint8_t* Vertices = nullptr; ///< null: no vertex is hidden
  std::uint8_t HidesVertex = 0;

  bool IsEmpty() const { return !this->Cells && !this->Vertices; }

  /// The flag of a vertex of the box. Vertices must be given.
  const std::uint8_t* AtVertex(const Index3& vertex) const
  {
    const Index3 size = this->Box.GetSize();
    return this->Vertices + this->GetIndex(vertex, size);
  }

  /// The flag of the cell whose low corner is this vertex. Cells must be given.
  const std::uint8_t* AtCell(const Index3& cell) const
  {
    const Index3 size = this->Box.GetSize();
    return this->Cells + this->GetIndex(cell, { size[0] - 1, size[1] - 1, size[2] - 1 });
  }

  bool HasCell(const Index3& cell) const
  {
    bool has = true;
    for (std::size_t axis = 0; axis < 3; ++axis)
    {
      has = has && cell[axis] >= this->Box.Low[axis] && cell[axis] + 1 < this->Box.High[axis];
    }
    return has;
  }

private:
  std::ptrdiff_t GetIndex(const Index3& at, const Index3& size) const
  {
    return static_cast<std::ptrdiff_t>(at[0] - this->Box.Low[0] +
      size[0] * (at[1] - this->Box.Low[1] + size[1] * (at[2] - this->Box.Low[2])));
  }
};

} // namespace isosurface

#endif
