// SPDX-FileCopyrightText: Copyright (c) 2026, the ScalableIsosurface authors
// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkIsosurfaceCompositeRepresentation
 * @brief   a vtkPVCompositeRepresentation whose representation types can be replaced
 *
 * Of representations that are added under one name the last one counts. So a proxy that is derived
 * from ParaView's Geometry Representation keeps its types' names (Surface, Wireframe ...), which
 * users, scripts and state files know, and shows them by another class.
 */

#ifndef vtkIsosurfaceCompositeRepresentation_h
#define vtkIsosurfaceCompositeRepresentation_h

#include "IsosurfaceRepresentationModule.h" // For export macro
#include "vtkPVCompositeRepresentation.h"

class ISOSURFACEREPRESENTATION_EXPORT vtkIsosurfaceCompositeRepresentation
  : public vtkPVCompositeRepresentation
{
public:
  static vtkIsosurfaceCompositeRepresentation* New();
  vtkTypeMacro(vtkIsosurfaceCompositeRepresentation, vtkPVCompositeRepresentation);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  void AddRepresentation(const char* type, vtkPVDataRepresentation* representation) override;

protected:
  vtkIsosurfaceCompositeRepresentation() = default;
  ~vtkIsosurfaceCompositeRepresentation() override = default;

private:
  vtkIsosurfaceCompositeRepresentation(const vtkIsosurfaceCompositeRepresentation&) = delete;
  void operator=(const vtkIsosurfaceCompositeRepresentation&) = delete;
};

#endif
