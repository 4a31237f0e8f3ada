// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_RawForm_h
#define isosurface_RawForm_h

#include "Redistribution/SurfaceForm.h"
#include "Volume/GridGeometry.h"

namespace isosurface
{

/**
 * A block as the arrays of its surface: what redistributing polygonal data costs. Points on faces
 * that blocks share travel with each of them, and are merged by GlobalIds on arrival.
 *
 * Bytes of a block, numbers as in CodedNumbers.h, the rest in the byte order of the machine:
 *
 *   of each isovalue   2 numbers   points, cells
 *   corners            number      of all cells
 *   points             3 float32 each
 *   normals            3 float32 each, if asked for
 *   GlobalIds          int64 each
 *   attributes         one after another, as they are
 *   cells              int32 each, if polygons: the corner that it ends before
 *   corners            int32 each: point numbers in the block
 */
class RawForm : public SurfaceForm
{
public:
  /// Both must outlive the form. The request is that of the surface, with GlobalIds and Offsets.
  RawForm(const GridGeometry& geometry, const ContourRequest& request)
    : Geometry(geometry)
    , Request(request)
  {
  }

  Status Pack(
    BlockSource& source, int threads, const Take& take, const Progress& progress) const override;
  Result<Surface> Unpack(
    ArrivingBlocks& blocks, int threads, const Progress& progress) const override;

private:
  const GridGeometry& Geometry;
  const ContourRequest& Request;
};

} // namespace isosurface

#endif
