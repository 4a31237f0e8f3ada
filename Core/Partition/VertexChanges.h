// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_VertexChanges_h
#define isosurface_VertexChanges_h

#include "Volume/BlockGrid.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace isosurface
{

/**
 * How the numbers of marching-cubes triangles and of active cells in a lattice change when its
 * vertices go outside, one value after another from the least to the greatest.
 *
 * With the case table used here, which separates the inside corners of an ambiguous face, a cell
 * has
 *
 *     V - 2 F + 4 A - 4 D    triangles,
 *
 * V: its corners inside; F: its faces with all corners inside; A: 1 if all corners are inside; D: 1
 * if exactly the two ends of one of its diagonals are outside. (Euler's formula gives the number of
 * polygons from the inside corners, edges and faces, since nothing but such a diagonal makes the
 * outside fall apart; a polygon of n sides is n - 2 triangles.) So only the minima of faces and
 * cells matter, and the maxima of cells for the active ones. They are found by halves, many cells
 * at a time; on the way back each half hands its weight to the lesser one, down to one vertex.
 * Where values rise evenly the weights of a vertex cancel out.
 *
 * Cost: about 1 ns a cell with vectors of 32 bytes. Memory: 4 bytes a vertex, and slices. One
 * object serves one thread at a time, any number of lattices after each other.
 */
class VertexChanges
{
public:
  /// A cell whose two least corners are the ends of a diagonal: 4 triangles fewer from the greater
  /// one of these on, 4 more again from the least of the other six on.
  struct Diagonal
  {
    std::int16_t Second;
    std::int16_t Third;
  };

  /// What a change counts for an active cell; it counts 1 for a triangle.
  static constexpr int ActiveCellUnit = 256;

  /// Memory for the values of a lattice of at least 2 vertices an axis, x fastest, to be filled.
  std::int16_t* Resize(const Index3& size);

  /// Finds the changes of the lattice that was filled.
  void Compute();

  std::size_t GetNumberOfVertices() const { return this->SliceSize * this->Slices; }
  const std::int16_t* GetValues() const { return this->Values.data() + this->Margin; }
  /// Per vertex, but for the diagonals.
  const std::int16_t* GetChanges() const { return this->Changes.data(); }
  const std::vector<Diagonal>& GetDiagonals() const { return this->Diagonals; }

private:
  /// What is handed down to the parts of a slice of vertices; behind a margin of zeros.
  struct SliceWeights
  {
    std::vector<std::int16_t> LowFace;  ///< to the minima of its faces
    std::vector<std::int16_t> LowEdgeX; ///< to the minima of its edges along x
    std::vector<std::int16_t> LowEdgeY;
    std::vector<std::int16_t> HighFace; ///< to the maxima of its faces
  };

  void FillUnits(std::size_t rows);
  void VisitCells(std::size_t slice);
  void FinishSlice(std::size_t slice);
  void AddDiagonals(const std::int16_t* low, const std::int16_t* high);

  std::size_t Columns = 0;
  std::size_t SliceSize = 0;
  std::size_t Slices = 0;
  std::size_t Margin = 0;           ///< a row and a vertex: as far as neighbours in a slice are
  std::vector<std::int16_t> Values; ///< between two margins
  std::vector<std::int16_t> Changes;
  std::vector<Diagonal> Diagonals;

  // Per vertex of a slice, for what has it as its low corner; 0 where there is nothing.
  std::vector<std::int16_t> Cells;   ///< all bits
  std::vector<std::int16_t> FacesXZ; ///< between this slice and the next: weight
  std::vector<std::int16_t> FacesYZ;
  std::vector<std::int16_t> Corners; ///< of how many cells of one slice of cells it is one

  SliceWeights Lower;
  SliceWeights Upper;
  std::vector<std::int16_t> LowEdge;  ///< all that goes to edges along x
  std::vector<std::int16_t> HighEdge; ///< the same for maxima
  std::vector<std::int16_t> Found;    ///< per cell of a slice: its diagonal
};

} // namespace isosurface

#endif
