// SPDX-FileCopyrightText: Copyright (c) 2026, the ScalableIsosurface authors
// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkMiddleSlicesRepresentation
 * @brief   shows three slices through the middle of a volume
 *
 * One slice of vertices along each axis, of the level of detail that the volume's reader gives, without
 * light. On several ranks each has its part of them.
 */

#ifndef vtkMiddleSlicesRepresentation_h
#define vtkMiddleSlicesRepresentation_h

#include "IsosurfaceRepresentationModule.h" // For export macro
#include "vtkGeometryRepresentationWithFaces.h"

class ISOSURFACEREPRESENTATION_EXPORT vtkMiddleSlicesRepresentation
  : public vtkGeometryRepresentationWithFaces
{
public:
  static vtkMiddleSlicesRepresentation* New();
  vtkTypeMacro(vtkMiddleSlicesRepresentation, vtkGeometryRepresentationWithFaces);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  int ProcessViewRequest(
    vtkInformationRequestKey* request, vtkInformation* input, vtkInformation* output) override;

protected:
  vtkMiddleSlicesRepresentation();
  ~vtkMiddleSlicesRepresentation() override = default;

private:
  vtkMiddleSlicesRepresentation(const vtkMiddleSlicesRepresentation&) = delete;
  void operator=(const vtkMiddleSlicesRepresentation&) = delete;
};

#endif
