// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_ImageSamples_h
#define isosurface_ImageSamples_h

#include "IsosurfaceBridgeModule.h"

#include "vtkSmartPointer.h"
#include "vtkType.h"

#include "Ground/Base/Status.h"
#include "Ground/Volume/Blanking.h"
#include "Ground/Volume/GridGeometry.h"
#include "Ground/Volume/SampleView.h"

#include <array>
#include <optional>
#include <string>
#include <vector>

class vtkDataArray;
class vtkDataObject;
class vtkImageData;

namespace isosurface
{

/// The Core type of an array's values; Unsupported for VTK_BIT.
ISOSURFACEBRIDGE_EXPORT Result<ValueType> GetValueTypeOf(vtkDataArray* array);

/// The array, or a copy of it if its memory is not laid out in the standard way.
ISOSURFACEBRIDGE_EXPORT vtkSmartPointer<vtkDataArray> MakePlainArray(vtkDataArray* array);

/// Views of the components of such an array, which has a tuple for each vertex of a box.
ISOSURFACEBRIDGE_EXPORT std::vector<SampleView> MakeComponentViews(
  vtkDataArray* array, ValueType type, const VertexBox& box);

/// The unit of an array's values (vtkDataArray::UNITS_LABEL); empty if it has none.
ISOSURFACEBRIDGE_EXPORT std::string GetUnitOf(vtkDataArray* array);

/// The VTK data type of a Core type.
ISOSURFACEBRIDGE_EXPORT int GetVTKType(ValueType type);

/// The grid of the whole extent, of which the image is a piece.
ISOSURFACEBRIDGE_EXPORT GridGeometry MakeGridGeometry(
  vtkImageData* image, const int wholeExtent[6]);

/**
 * Keeps, in an image's field data, the whole extent of the grid that it is a block of; filters hand
 * field data on. FindWholeExtent gives it back, or false if there is none that holds the image.
 */
ISOSURFACEBRIDGE_EXPORT void StoreWholeExtent(vtkImageData* image, const int wholeExtent[6]);
ISOSURFACEBRIDGE_EXPORT bool FindWholeExtent(vtkImageData* image, int wholeExtent[6]);

/// The unit of length of a dataset's coordinates: that of all axes in the field PhysicalSizeUnit, which
/// vtkOMETIFFReader has, too.
constexpr const char* LengthUnitName = "PhysicalSizeUnit";
ISOSURFACEBRIDGE_EXPORT void StoreLengthUnit(vtkDataObject* data, LengthUnit unit);
ISOSURFACEBRIDGE_EXPORT LengthUnit FindLengthUnitOf(vtkDataObject* data);

/// What views tell of an array, as fields beside it, whose names begin with that of the array: the unit of
/// its values, and those that are black and white by what its file says.
constexpr const char* UnitEnd = " Unit";
constexpr const char* WindowEnd = " Window";
ISOSURFACEBRIDGE_EXPORT void StoreUnit(
  vtkDataObject* data, const std::string& array, const std::string& unit);
ISOSURFACEBRIDGE_EXPORT void StoreWindow(
  vtkDataObject* data, const std::string& array, const std::array<double, 2>& window);

/// The time of a dataset: that of the pipeline, else the field TimeValue, which files carry.
ISOSURFACEBRIDGE_EXPORT std::optional<double> FindTime(vtkDataObject* data);

/// The vertices of an extent, counted from the grid's first vertex. Unlike an extent, a box does
/// not include its High.
ISOSURFACEBRIDGE_EXPORT VertexBox MakeVertexBox(const GridGeometry& grid, const int extent[6]);

/**
 * The vertices of the cells that are the image's own: those that vtkGhostType does not mark as
 * duplicates. Ghost cells form layers around the own ones, so these are a box; an image of nothing
 * but ghosts has an empty one. Cost: one pass over vtkGhostType, if there is one.
 */
ISOSURFACEBRIDGE_EXPORT VertexBox FindOwnVertices(const GridGeometry& grid, vtkImageData* image);

/**
 * What is hidden of an image: the cells that vtkGhostType marks as hidden or refined, and the points
 * that it marks as hidden. Only a vtkUniformGrid hides something; vtkContourFilter ignores the marks
 * of any other vtkImageData. The view must not outlive the image.
 */
ISOSURFACEBRIDGE_EXPORT Blanking FindBlanking(const GridGeometry& grid, vtkImageData* image);

/// The samples of an array of an image, and who owns them.
struct ImageSamples
{
  /// A view a component; Box is the image's own vertices, Available all of them.
  std::vector<SampleView> Components;
  Blanking Hidden;                     ///< see FindBlanking
  vtkSmartPointer<vtkDataArray> Array; ///< keeps the samples alive
};

/**
 * A point array of an image, as Core sees it. No sample is copied, unless the array's memory is not
 * laid out in the standard way: components are views with a stride. Errors (InvalidArgument,
 * Unsupported) name the array.
 */
ISOSURFACEBRIDGE_EXPORT Result<ImageSamples> MakeImageSamples(
  const GridGeometry& grid, vtkImageData* image, vtkDataArray* array);

} // namespace isosurface

#endif
