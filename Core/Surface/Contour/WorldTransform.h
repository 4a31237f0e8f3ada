// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_WorldTransform_h
#define isosurface_WorldTransform_h

#include "Ground/Volume/GridGeometry.h"
#include "Surface/Contour/BrickKernel.h"

namespace isosurface
{

/**
 * The transformation of points from structured to world coordinates, and of normals, with the
 * matrices and the order of operations of vtkImageData and vtkImageTransform: the results are
 * bitwise equal, but for the normals where the direction is mirrored: these point to low values, and
 * those of vtkImageTransform to high ones.
 * @param normalsByDirection as in ContourRequest
 */
WorldTransform MakeWorldTransform(const GridGeometry& geometry, bool normalsByDirection = false);

} // namespace isosurface

#endif
