// SPDX-License-Identifier: BSD-3-Clause
// The inner loops of marching cubes by bits, included by BrickKernelBaseline.cxx and
// BrickKernelAvx2.cxx, which define ISOSURFACE_KERNEL as the namespace to compile them into.
//
// Numerics follow vtkFlyingEdges3D: differences of samples are taken in the sample's own type where
// that is exact or rounds (float), everything else in double, coordinates and gradients are rounded
// to float. Where its integer differences would wrap around (32 and 64 bits), ours are exact.

#include "Contour/BrickKernelCells.txx"
#include "Contour/BrickKernelPoints.txx"
#include "Contour/BrickKernelRanges.txx"
#include "Contour/BrickKernelRows.txx"

namespace isosurface
{
namespace ISOSURFACE_KERNEL
{

extern const BrickKernels Kernels;
const BrickKernels Kernels = { ClassifyRows, NumberRows, LocatePoints, ComputeNormals, WritePoints,
  FindRows, WriteTriangles<std::int32_t>, WriteTriangles<std::int64_t>, WritePolygons<std::int32_t>,
  WritePolygons<std::int64_t>, JoinRange };

} // namespace ISOSURFACE_KERNEL
} // namespace isosurface
