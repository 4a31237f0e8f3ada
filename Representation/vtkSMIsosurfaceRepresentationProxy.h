// SPDX-FileCopyrightText: Copyright (c) 2026, the ScalableIsosurface authors
// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkSMIsosurfaceRepresentationProxy
 * @brief   gives each isosurface a color, and keeps colors and legend as the isovalues are
 *
 * While IsosurfaceColors is 1 and a surface is colored by the array that was contoured, it has a color
 * map of its own with a category for each isovalue, in the order of the list: its annotation is the
 * isovalue, as the list shows it. When isovalues change, an isovalue that stays keeps its text, color
 * and opacity; one that is new takes over those of one that has gone, or else gets
 * colors that are not used yet. So a surface that is moved keeps its color. One surface alone has the
 * color of surfaces without colors. In a CT, isovalues of tissues look as these usually do.
 *
 * All of it is in ParaView's own properties of the color map, and happens when a view updates: the
 * same in the window, in scripts, and through a server. Surfaces are those of Isosurface, of
 * Distribute Isosurface behind it, and of edge-index files, which know no tissues.
 */

#ifndef vtkSMIsosurfaceRepresentationProxy_h
#define vtkSMIsosurfaceRepresentationProxy_h

#include "IsosurfaceRepresentationModule.h" // For export macro
#include "vtkSMPVRepresentationProxy.h"

class ISOSURFACEREPRESENTATION_EXPORT vtkSMIsosurfaceRepresentationProxy
  : public vtkSMPVRepresentationProxy
{
public:
  static vtkSMIsosurfaceRepresentationProxy* New();
  vtkTypeMacro(vtkSMIsosurfaceRepresentationProxy, vtkSMPVRepresentationProxy);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  void ViewUpdated(vtkSMProxy* view) override;

  /// Whether a representation colors a surface by its isovalues: by the array that the contour (a filter, or
  /// the reader of an edge-index file) was told, or, if it was told none, by the scalars of the surface.
  static bool ShowsIsovalues(vtkSMProxy* representation, vtkSMProxy* contour);

protected:
  vtkSMIsosurfaceRepresentationProxy() = default;
  ~vtkSMIsosurfaceRepresentationProxy() override = default;

private:
  vtkSMIsosurfaceRepresentationProxy(const vtkSMIsosurfaceRepresentationProxy&) = delete;
  void operator=(const vtkSMIsosurfaceRepresentationProxy&) = delete;

  /// The filter or reader whose isovalues color the surface; null if something else does.
  vtkSMProxy* FindColoringContour();
  /// Takes the color map of this representation alone, or that of all that show the array; the legend
  /// goes with it.
  void ChangeColorMap(vtkSMProxy* view, bool separate);
  void UpdateColors(vtkSMProxy* view, vtkSMProxy* contour);
  /// A slice of the volume may have a legend under the array's name.
  void NameLegend(vtkSMProxy* view, vtkSMProxy* map);

  bool HasOwnMap = false; ///< since the last update, or longer
};

#endif
