// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_BrickKernel_h
#define isosurface_BrickKernel_h

#include "Contour/MarchingCubesCases.h"
#include "Volume/ValueType.h"

#include <cstddef>
#include <cstdint>

namespace isosurface
{

/// Most vertices of a brick on an axis: 32 cells, so that a row of vertices fits one 64-bit word.
constexpr int MaximumBrickSize = 33;

/// Where an edge lies on an axis across it: on the brick's near face, between, on its far face.
constexpr int NumberOfPlaces = 3;

// The structures below are all that the kernels see. They are plain, and so is the code that the
// kernels call: see BrickKernels.

/// The samples of a brick: vertex (i, j, k) of the brick at First + i*Stride[0] + j*Stride[1] + ...
struct BrickSamples
{
  const void* First;
  std::ptrdiff_t Stride[3];   ///< in samples
  int Size[3];                ///< vertices, 2 to 33
  std::int64_t Low[3];        ///< the first vertex, counted from the grid's first
  std::int64_t Dimensions[3]; ///< of the grid
  std::int64_t ExtentLow[3];  ///< structured coordinates of the grid's first vertex
};

/**
 * Which of a brick's edges the brick makes points for, as words over a row of vertices. An index is
 * the place of the row on the axes across the edge, x before y before z.
 */
struct BrickOwnership
{
  std::uint64_t X[NumberOfPlaces][NumberOfPlaces]; ///< [y][z]
  std::uint64_t Y[NumberOfPlaces];                 ///< [z]; the first and last bit differ by x
  std::uint64_t Z[NumberOfPlaces];                 ///< [y]
};

/// Numbers found while rows are numbered.
struct BrickCounts
{
  std::uint32_t Points;
  std::uint32_t Triangles;
  std::uint32_t Polygons; ///< loops of the surface in cells
};

/**
 * A crossed edge as a word: vertex i, j, k of the brick (6 bits each from the lowest), then axis;
 * or, where what is made of points says so, a vertex: axis 3.
 */
using EdgeCode = std::uint32_t;

/// Slots past the last edge code that NumberRows may overwrite.
constexpr int EdgeCodeSlack = 4;

/// How structured coordinates become world coordinates, in the steps of vtkImageTransform.
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
  double Normals[9]; ///< 3 rows of 3: the transposed inverse of the direction
  double Spacing[3] = { 1, 1, 1 };
  double Determinant = 1; ///< of the direction; -1 flips normals along with the triangles
};

/// Where the points of a brick go, and from what they are made.
struct PointOutput
{
  const EdgeCode* Codes;
  const float* Coordinates; ///< the structured coordinate along the edge, or x of a vertex
  const float* Normals;     ///< in structured axes; null for none
  std::uint32_t NumberOfPoints;
  float* Points;
  float* WorldNormals;        ///< null for none
  std::int64_t* GlobalIds;    ///< null for none
  std::int64_t FirstGlobalId; ///< added to every global id
};

/// Rows of samples, one after the other along y.
struct SampleRows
{
  const void* First;
  std::ptrdiff_t Stride[2]; ///< in samples, along a row and between rows
  std::int64_t Size[2];     ///< samples a row, rows
};

/// The points of one row of edges: the bits that have one, and the number of the first.
struct EdgeRow
{
  std::uint64_t Bits;
  std::int64_t First;
};

/// What a brick keeps of its rows, and where its points begin; see BrickKernels::NumberRows.
struct NumberedRows
{
  const std::uint64_t* Inside;
  const std::uint32_t* Offsets;
  const BrickOwnership* Ownership;
  std::int64_t FirstPoint;
  int Size[3]; ///< vertices
};

/**
 * Two neighbouring planes of rows, as the triangles between them need it: X and Y rows and inside
 * words of both planes, and the Z rows from one to the other.
 */
struct RowSlab
{
  const std::uint64_t* Inside[2];
  const EdgeRow* X[2];
  const EdgeRow* Y[2];
  const EdgeRow* Z;
  int Size[2]; ///< vertices on x and y
  /// Per row of vertices: numbers of the points on edges in the first and the last column, which
  /// may belong to other bricks than the row between. [0] is the first column, [1] the last.
  const std::int64_t* ColumnY[2][2]; ///< [column][plane]
  const std::int64_t* ColumnZ[2];    ///< [column]
  /// The first column's points are those of the row.
  bool FirstColumnInRow;
};

/**
 * The inner loops. They exist twice, compiled for the oldest processor and for one with AVX2, BMI
 * and POPCNT; results are bitwise equal. The source of both is BrickKernel.txx. So that no copy of
 * a function compiled for the newer processor is called on the older one, that source calls no
 * inline functions or templates that other sources share.
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
   * Numbers the owned crossed edges row by row: X, then Y, then Z edges of a row. Row r's first is
   * offsets[r], codes[n] tells edge n. Counts the triangles and polygons of all the brick's cells.
   */
  BrickCounts (*NumberRows)(const int size[3], const std::uint64_t* inside,
    const BrickOwnership& ownership, std::uint32_t* offsets, EdgeCode* codes);

  /**
   * For each edge its structured coordinate along its axis and, if `parameters` is not null, how
   * far along the edge that is (0 to 1).
   */
  void (*LocatePoints)(ValueType type, const BrickSamples& samples, double isovalue,
    const EdgeCode* codes, std::uint32_t count, float* coordinates, double* parameters);

  /// For each edge or vertex the unit normal: the negative gradient, interpolated by `parameters`,
  /// which are 0 for vertices.
  void (*ComputeNormals)(ValueType type, const BrickSamples& samples, const EdgeCode* codes,
    const double* parameters, std::uint32_t count, float* normals);

  /// Puts points, normals and global ids into their final place.
  void (*WritePoints)(
    const BrickSamples& position, const WorldTransform& transform, const PointOutput& output);

  /// The X, Y and Z rows of edges that begin in plane k, one each for every row of vertices, as far
  /// as the brick owns them.
  void (*FindRows)(const NumberedRows& rows, int k, EdgeRow* x, EdgeRow* y, EdgeRow* z);

  /**
   * Writes the triangles of a slab's cells; returns where the next ones go. Values between that
   * and `end` may be overwritten.
   */
  std::int32_t* (*WriteTriangles32)(
    const RowSlab& slab, std::int32_t* connectivity, std::int32_t* end);
  std::int64_t* (*WriteTriangles64)(
    const RowSlab& slab, std::int64_t* connectivity, std::int64_t* end);

  /**
   * Writes the polygons of a slab's cells and where each begins; advances all three.
   * `cases` is GetPolygonCases().
   */
  void (*WritePolygons32)(const RowSlab& slab, const PolygonCase* cases,
    std::int32_t*& connectivity, std::int32_t*& offsets, std::int64_t& index);
  void (*WritePolygons64)(const RowSlab& slab, const PolygonCase* cases,
    std::int64_t*& connectivity, std::int64_t*& offsets, std::int64_t& index);

  /**
   * Least and greatest of some rows of samples, NaN left out, joined to what minimum and maximum
   * hold; these point to one value of the type each. Sets *notANumber if there is a NaN.
   */
  void (*JoinRange)(
    ValueType type, const SampleRows& rows, void* minimum, void* maximum, bool* notANumber);
};

/// The kernels for any processor.
const BrickKernels& GetBaselineBrickKernels();

/// The kernels for newer processors; null if this processor or this build has none.
const BrickKernels* GetAvx2BrickKernels();

/// The fastest kernels that run here.
const BrickKernels& GetBrickKernels();

} // namespace isosurface

#endif
