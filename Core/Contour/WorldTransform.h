// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_WorldTransform_h
#define isosurface_WorldTransform_h

#include "Contour/BrickKernel.h"
#include "Volume/GridGeometry.h"

namespace isosurface
{

/**
 * From structured coordinates to the world and for normals, with the very matrices, in the order of
 * operations, that vtkImageData and vtkImageTransform use, so that results agree to the last bit.
 */
WorldTransform MakeWorldTransform(const GridGeometry& geometry);

} // namespace isosurface

#endif
