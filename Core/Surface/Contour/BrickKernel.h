// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_BrickKernel_h
#define isosurface_BrickKernel_h

#include "Ground/Volume/ValueType.h"
#include "Surface/Contour/MarchingCubesCases.h"

#include <cstddef>
#include <cstdint>

namespace isosurface
{

/// The maximum number of vertices of a brick on an axis, for 32 cells. A row of vertices fits in a
/// 64-bit word.
constexpr int MaximumBrickSize = 33;

/// The places of an edge on an axis across it: 0 on the brick's low face, 1 between, 2 on its high
/// face.
constexpr int NumberOfPlaces = 3;

// The structures below are the interface of the kernels. They are plain structures: see
// BrickKernels.

/// The samples of a brick: vertex (i, j, k) of the brick at First + i*Stride[0] + j*Stride[1] + ...
struct BrickSamples
{
  const void* First;
  std::ptrdiff_t Stride[3];   ///< in samples
  int Size[3];                ///< vertices, 2 to 33
  std::int64_t Low[3];        ///< the first vertex, counted from the grid's first
  std::int64_t Dimensions[3]; ///< of the grid
  std::int64_t KnownLow[3];   ///< the box of the samples that gradients are made of, [low, high)
  std::int64_t KnownHigh[3];
  std::int64_t ExtentLow[3]; ///< structured coordinates of the grid's first vertex
};

/**
 * The edges that a brick owns, that is, for which it makes points: words with a bit for each vertex
 * of a row. The indices are the places of the row on the axes across the edge, x before y before z.
 */
struct BrickOwnership
{
  std::uint64_t X[NumberOfPlaces][NumberOfPlaces]; ///< [y][z]
  std::uint64_t Y[NumberOfPlaces];                 ///< [z]; the first and last bit differ by x
  std::uint64_t Z[NumberOfPlaces];                 ///< [y]
};

/// The counts of a brick.
struct BrickCounts
{
  std::uint32_t Points;
  std::uint32_t Triangles;
  std::uint32_t Polygons; ///< loops of the surface in the cells
};

/**
 * A crossed edge as a word: the vertex i, j, k of the brick (6 bits each, i lowest), then the axis.
 * If a point was moved to a vertex, the axis is 3.
 */
using EdgeCode = std::uint32_t;

/// The number of edge codes after the last one that NumberRows may overwrite.
constexpr int EdgeCodeSlack = 4;

/// Transforms structured coordinates to world coordinates, in the steps of vtkImageTransform.
struct WorldTransform
{
  enum class Kind : std::uint8_t
  {
    Identity,
    Translation,
    Matrix
  };
  Kind Steps;
  double Origin[3];
  double Points[12]; ///< 3 rows of 4: direction * spacing, origin
  double Normals[9]; ///< 3 rows of 3: the transposed inverse of the direction, or that itself
  double Spacing[3] = { 1, 1, 1 };
  /// The magnitude of that of the direction: vtkImageTransform multiplies normals by it.
  double Determinant = 1;
  bool NormalsRoundedOnce = false; ///< as in ContourRequest
};

/// The input and output of WritePoints for a brick.
struct PointOutput
{
  const EdgeCode* Codes;
  const float* Coordinates; ///< the structured coordinate along the edge; x for a vertex
  const float* Normals;     ///< in structured axes; null for none
  std::uint32_t NumberOfPoints;
  float* Points;              ///< null if there are DoublePoints
  double* DoublePoints;       ///< without a rounding to float32, from Parameters; null for none
  const double* Parameters;   ///< the positions on the edges, 0 to 1; 0 for a vertex
  float* WorldNormals;        ///< null for none
  std::int64_t* GlobalIds;    ///< null for none
  std::int64_t FirstGlobalId; ///< added to every global id
};

/// Rows of samples along x.
struct SampleRows
{
  const void* First;
  std::ptrdiff_t Stride[2]; ///< in samples, along a row and between rows
  std::int64_t Size[2];     ///< samples a row, rows
};

/// The points of a row of edges: the bits of the edges with a point, and the number of the first
/// point.
struct EdgeRow
{
  std::uint64_t Bits;
  std::int64_t First;
};

/// The rows of a brick after BrickKernels::NumberRows.
struct NumberedRows
{
  const std::uint64_t* Inside;
  const std::uint32_t* Offsets;
  const BrickOwnership* Ownership;
  std::int64_t FirstPoint;
  int Size[3]; ///< vertices
};

/**
 * The input for the triangles between two neighbouring planes of vertices: the inside words and the
 * X and Y rows of both planes, and the Z rows between them.
 */
struct RowSlab
{
  const std::uint64_t* Inside[2];
  const std::uint64_t* Visible; ///< the cells to visit in each row; null for all
  CellCases Cases;
  const EdgeRow* X[2];
  const EdgeRow* Y[2];
  const EdgeRow* Z;
  int Size[2]; ///< vertices on x and y
  /// By row of vertices: the numbers of the points on edges in the first and in the last column.
  /// These may belong to other bricks than the rest of the row.
  const std::int64_t* ColumnY[2][2]; ///< [column][plane]
  const std::int64_t* ColumnZ[2];    ///< [column]
  /// Whether the first column belongs to the same brick as the row: then ColumnY[0] and ColumnZ[0]
  /// are not used.
  bool FirstColumnInRow;
};

/**
 * The inner loops. They are compiled twice from BrickKernel.txx: for any processor, and for one
 * with AVX2, BMI and POPCNT. The results are bitwise equal. That source calls no inline functions
 * or templates of other sources: otherwise the linker might choose their AVX2 version for both.
 */
struct BrickKernels
{
  /**
   * Sets inside[j + Size[1] * k] to the bits of the row's vertices with value >= threshold.
   * `threshold` points to one value of the samples' type.
   */
  void (*ClassifyRows)(
    ValueType type, const BrickSamples& samples, const void* threshold, std::uint64_t* inside);

  /**
   * Numbers the owned crossed edges row by row: the X, then the Y, then the Z edges of a row. The
   * first edge of row r is offsets[r]; codes[n] is the code of edge n. Counts the triangles and
   * polygons of all cells of the brick.
   */
  BrickCounts (*NumberRows)(const int size[3], const std::uint64_t* inside,
    const BrickOwnership& ownership, std::uint32_t* offsets, EdgeCode* codes);

  /**
   * Computes the structured coordinate of the point on each edge, along the axis of the edge. If
   * `parameters` is not null, also the position on the edge (0 to 1).
   */
  void (*LocatePoints)(ValueType type, const BrickSamples& samples, double isovalue,
    const EdgeCode* codes, std::uint32_t count, float* coordinates, double* parameters);

  /// Computes the unit normal for each edge or vertex: the negative gradient, interpolated by
  /// `parameters`, which are 0 for vertices.
  void (*ComputeNormals)(ValueType type, const BrickSamples& samples, const EdgeCode* codes,
    const double* parameters, std::uint32_t count, float* normals);

  /// Writes points, normals and global ids to their final place.
  void (*WritePoints)(
    const BrickSamples& position, const WorldTransform& transform, const PointOutput& output);

  /// Finds the owned edges that begin in plane k: an X, a Y and a Z row for each row of vertices.
  void (*FindRows)(const NumberedRows& rows, int k, EdgeRow* x, EdgeRow* y, EdgeRow* z);

  /**
   * Writes the triangles of a slab's cells; returns the end of what was written. Values between
   * that and `end` may be overwritten.
   */
  std::int32_t* (*WriteTriangles32)(
    const RowSlab& slab, std::int32_t* connectivity, std::int32_t* end);
  std::int64_t* (*WriteTriangles64)(
    const RowSlab& slab, std::int64_t* connectivity, std::int64_t* end);

  /// Writes the polygons of a slab's cells and their offsets; advances all three references.
  void (*WritePolygons32)(
    const RowSlab& slab, std::int32_t*& connectivity, std::int32_t*& offsets, std::int64_t& index);
  void (*WritePolygons64)(
    const RowSlab& slab, std::int64_t*& connectivity, std::int64_t*& offsets, std::int64_t& index);

  /**
   * Extends the range *minimum to *maximum, which are values of the type, by rows of samples. NaN
   * is left out; *notANumber is set if there is one.
   */
  void (*JoinRange)(
    ValueType type, const SampleRows& rows, void* minimum, void* maximum, bool* notANumber);
};

/// The kernels for any processor.
const BrickKernels& GetBaselineBrickKernels();

/// The kernels for AVX2; null if this processor or this build does not have it.
const BrickKernels* GetAvx2BrickKernels();

/// The fastest kernels for this processor.
const BrickKernels& GetBrickKernels();

} // namespace isosurface

#endif
