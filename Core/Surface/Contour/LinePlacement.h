// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_LinePlacement_h
#define isosurface_LinePlacement_h

#include "Ground/Volume/GridLines.h"
#include "Ground/Volume/SampleView.h"
#include "Surface/Contour/BrickKernel.h"
#include "Surface/Contour/CellVisibility.h"

#include <cstdint>

namespace isosurface
{

/// The points of a brick of a rectilinear grid. The numerics are those of
/// vtkRectilinearSynchronizedTemplates.
struct LinedBrick
{
  const GridLines& Lines;
  Index3 Low;            ///< the brick's first vertex
  const EdgeCode* Codes; ///< the points' edges, or vertices
  std::uint32_t Count;   ///< points
};

/// As BrickKernels::LocatePoints, but with coordinates in the world. `parameters` are those of the
/// kernel; where a type's differences would be rounded, they are computed anew.
void LocateOnLines(const LinedBrick& brick, const SampleView& scalars, double isovalue,
  float* coordinates, double* parameters);

/// The coordinates of points whose positions on the edges (0 to 1) are known.
void PlaceOnLines(const LinedBrick& brick, const double* parameters, float* coordinates);

/// As BrickKernels::ComputeNormals, but in the world. `unknown`, if given, tells which samples must
/// not be used.
void ComputeNormalsOnLines(const LinedBrick& brick, const SampleView& scalars,
  const VertexBox& knownSamples, const CellVisibility* unknown, const double* parameters,
  float* normals);

/// Writes the points' x, y, z.
void WritePointsOnLines(const LinedBrick& brick, const float* coordinates, float* points);
/// The same without a rounding to float, from their positions on the edges.
void WriteDoublePointsOnLines(const LinedBrick& brick, const double* parameters, double* points);

} // namespace isosurface

#endif
