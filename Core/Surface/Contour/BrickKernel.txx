// SPDX-License-Identifier: BSD-3-Clause
// The inner loops of marching cubes by bits, included by BrickKernelBaseline.cxx and
// BrickKernelAvx2.cxx, which define ISOSURFACE_KERNEL as the namespace to compile them into.
//
// Method: a bit for each vertex (inside), a 64-bit word for each row of vertices. XOR of words gives
// the crossed edges, AND and OR of four words the active cells; population counts number points.
//
// The numerics are those of vtkFlyingEdges3D (Schroeder, Maynard, Geveci, "Flying edges", LDAV
// 2015): differences of samples are computed in the type of the samples where that is exact or
// rounds (float), everything else in double; coordinates and gradients are rounded to float. Where
// its integer differences would overflow (32 and 64 bits), ours are exact.

#include "Surface/Contour/BrickKernelCells.txx"
#include "Surface/Contour/BrickKernelPoints.txx"
#include "Surface/Contour/BrickKernelRanges.txx"
#include "Surface/Contour/BrickKernelRows.txx"

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
