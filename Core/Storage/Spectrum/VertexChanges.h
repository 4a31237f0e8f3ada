// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_VertexChanges_h
#define isosurface_VertexChanges_h

#include "Ground/Volume/BlockGrid.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace isosurface
{

/**
 * Computes how the numbers of triangles and of active cells in a lattice change at each vertex,
 * when the vertices go outside in the order of increasing values. With the case table of
 * MarchingCubesCases.h, a cell has
 *
 *     V - 2 F + 4 A - 4 D    triangles,
 *
 * V: inside corners; F: faces with all corners inside; A: 1 if all corners are inside; D: 1 if only
 * the two ends of one of its diagonals are outside (by Euler's formula). So only the minima of
 * faces and cells matter, and the maxima of cells for the active ones. Each face and cell has a
 * weight, which is passed on to the half with the minimum (maximum), down to one vertex: from cells
 * to faces, to edges, to vertices. Where values are smooth, the weights of a vertex cancel out.
 *
 * Cost: about 1 ns a cell with vectors of 32 bytes. Memory: 4 bytes a vertex, in noise 8, and a few
 * slices. For one thread at a time; an object can be used for several lattices.
 */
class VertexChanges
{
public:
  /// A cell whose two corners of minimum value are the ends of a diagonal: it has 4 triangles fewer
  /// from the second value to the third.
  struct Diagonal
  {
    std::int16_t Second;
    std::int16_t Third;
  };

  /// What an active cell counts in a change; a triangle counts 1.
  static constexpr int ActiveCellUnit = 256;

  /// Returns the memory for the values of a lattice, x fastest, for the caller to fill. `size`: at
  /// least 2 vertices on each axis.
  std::int16_t* Resize(const Index3& size);

  /// Computes the changes.
  void Compute();

  std::size_t GetNumberOfVertices() const { return this->SliceSize * this->Slices; }
  const std::int16_t* GetValues() const { return this->Values.data() + this->Margin; }
  /// The changes by vertex, without those of the diagonals.
  const std::int16_t* GetChanges() const { return this->Changes.data(); }
  std::size_t GetNumberOfDiagonals() const { return this->NumberOfDiagonals; }
  const Diagonal* GetDiagonals() const { return this->Diagonals.data(); }

private:
  using Numbers = std::vector<std::int16_t>;

  /// By vertex of a slice: the minima of the edges along x and y and of the face whose low corner it
  /// is; and the complements of their maxima, so that these are minima, too. Between two margins.
  struct Extremes
  {
    Numbers LowEdgeX;
    Numbers LowEdgeY;
    Numbers LowFace;
    Numbers HighEdgeX;
    Numbers HighFace;

    void Assign(std::size_t size, std::int16_t value);
  };

  // Sets what depends on the size of a slice alone: Cells, FacesXZ, FacesYZ and Corners.
  void FillUnits(std::size_t rows);
  void FindExtremes(std::size_t slice, Extremes& extremes) const;
  void AddDiagonals(std::size_t slice);
  void FinishSlice(
    std::size_t slice, const Extremes& below, const Extremes& own, const Extremes& above);

  std::size_t Columns = 0;
  std::size_t SliceSize = 0;
  std::size_t Slices = 0;
  std::size_t Margin = 0; ///< a row and a vertex: the maximum offset of neighbours
  Numbers Values;         ///< between two margins
  Numbers Changes;
  std::vector<Diagonal> Diagonals; ///< with room for one a vertex, once there are any
  std::size_t NumberOfDiagonals = 0;

  // By vertex of a slice; 0 if it is not the low corner of a cell or face.
  Numbers Cells;   ///< all bits set if it is the low corner of a cell
  Numbers FacesXZ; ///< the weight of the face between this slice and the next
  Numbers FacesYZ;
  Numbers Corners; ///< the number of cells around it in a slice of cells

  std::array<Extremes, 3> Nearby; ///< of a slice and the ones before and after it, in turn
  Extremes Outside;               ///< of the slices before the first one and after the last one
  /// Weights for minima of a slice, and for maxima. Those of faces and edges begin with a margin of
  /// zeros.
  Numbers LowFace;
  Numbers HighFace;
  Numbers LowEdgeX;
  Numbers LowEdgeY;
  Numbers HighEdgeX;
  Numbers Third;                   ///< of each cell of a slice: the third value of its corners
  Numbers Fall;                    ///< the third value less the second one; 0 without a diagonal
  std::vector<std::uint8_t> Found; ///< 1 for a cell of a slice with a diagonal
};

} // namespace isosurface

#endif
