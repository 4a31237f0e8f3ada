// SPDX-FileCopyrightText: Copyright (c) 2026, the ScalableIsosurface authors
// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkIsosurfaceRepresentation
 * @brief   ParaView's surface representation, faster for surfaces of triangles
 *
 * Shows what vtkGeometryRepresentationWithFaces shows, pixel for pixel. A single vtkPolyData of
 * triangles is passed on as it is (vtkIsosurfaceGeometryFilter), measured once by threads instead
 * of cell by cell, and drawn by vtkIsosurfaceMapper. While the camera moves, points of the surface
 * itself are shown (isosurface::ThinSurface) instead of those of quadric clustering.
 *
 * Everything else is left to the superclass.
 */

#ifndef vtkIsosurfaceRepresentation_h
#define vtkIsosurfaceRepresentation_h

#include "IsosurfaceRepresentationModule.h" // For export macro
#include "vtkGeometryRepresentationWithFaces.h"
#include "vtkSmartPointer.h" // For the thinned surface
#include "vtkWeakPointer.h"  // For what it was made of

#include <memory> // For what thins

class vtkDataObject;
class vtkIsosurfaceMapper;
class vtkPolyData;

namespace isosurface
{
class BackgroundThinning;
}

class ISOSURFACEREPRESENTATION_EXPORT vtkIsosurfaceRepresentation
  : public vtkGeometryRepresentationWithFaces
{
public:
  static vtkIsosurfaceRepresentation* New();
  vtkTypeMacro(vtkIsosurfaceRepresentation, vtkGeometryRepresentationWithFaces);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  int ProcessViewRequest(
    vtkInformationRequestKey* request, vtkInformation* input, vtkInformation* output) override;

protected:
  vtkIsosurfaceRepresentation();
  ~vtkIsosurfaceRepresentation() override;

private:
  vtkIsosurfaceRepresentation(const vtkIsosurfaceRepresentation&) = delete;
  void operator=(const vtkIsosurfaceRepresentation&) = delete;

  /// Gives the view a thinned surface, that of the last time if it is still the one; false if the
  /// superclass has to.
  bool ProvideLevelOfDetail(vtkInformation* input);
  /// Has a surface thinned while it is drawn, if one was shown thinned before.
  void BeginThinning(vtkPolyData* surface);

  vtkIsosurfaceMapper* SurfaceMapper; ///< the superclass's Mapper, which it owns
  vtkIsosurfaceMapper* ThinnedMapper; ///< the superclass's LODMapper, which it owns

  /// The last thinned surface, and what it was made of.
  vtkSmartPointer<vtkDataObject> Thinned;
  vtkWeakPointer<vtkPolyData> ThinnedSurface;
  vtkMTimeType ThinnedTime;
  double ThinnedResolution;
  std::unique_ptr<isosurface::BackgroundThinning> Thinning;
};

#endif
