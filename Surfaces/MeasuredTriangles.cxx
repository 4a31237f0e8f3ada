// SPDX-License-Identifier: BSD-3-Clause
#include "MeasuredTriangles.h"

#include "vtkCellArray.h"
#include "vtkFloatArray.h"
#include "vtkMultiBlockDataSet.h"
#include "vtkMultiProcessController.h"
#include "vtkPartitionedDataSetCollection.h"
#include "vtkPoints.h"
#include "vtkPolyData.h"

#include "Ground/Base/ParallelFor.h"

#include <algorithm>
#include <cstdint>
#include <limits>

namespace isosurface
{
namespace
{

constexpr auto MaximumIndices = static_cast<vtkIdType>(std::numeric_limits<std::uint32_t>::max());

/// The polygons of a surface that has float points and no other cells; null for other surfaces.
vtkCellArray* GetPolygonsAlone(vtkPolyData* surface)
{
  vtkCellArray* polygons = surface->GetPolys();
  const bool alone = surface->GetPoints() &&
    vtkFloatArray::FastDownCast(surface->GetPoints()->GetData()) &&
    polygons->GetNumberOfCells() > 0 && surface->GetNumberOfVerts() == 0 &&
    surface->GetNumberOfLines() == 0 && surface->GetNumberOfStrips() == 0;
  return alone ? polygons : nullptr;
}

/// The values of an array of a vtkCellArray, which are integers, if they have the size of T and lie in
/// memory one behind the other; else null, as for the offsets that VTK 9.6 computes where all cells
/// have the same size.
template <typename T>
const T* GetIntegers(vtkDataArray* array)
{
  const bool has =
    array->HasStandardMemoryLayout() && array->GetDataTypeSize() == static_cast<int>(sizeof(T));
  return has ? static_cast<const T*>(array->GetVoidPointer(0)) : nullptr;
}

bool AreTriangles(vtkCellArray* polygons, int threads)
{
  const auto cells = static_cast<std::size_t>(polygons->GetNumberOfCells());
  if (const auto* offsets = GetIntegers<std::int64_t>(polygons->GetOffsetsArray()))
  {
    return AreTriangleOffsets(offsets, cells, threads);
  }
  if (const auto* offsets = GetIntegers<std::int32_t>(polygons->GetOffsetsArray()))
  {
    return AreTriangleOffsets(offsets, cells, threads);
  }
  return polygons->IsHomogeneous() == 3;
}

TriangleSurface View(vtkDataArray* points, vtkCellArray* triangles)
{
  TriangleSurface view;
  view.Points = vtkFloatArray::FastDownCast(points)->GetPointer(0);
  view.NumberOfPoints = static_cast<std::size_t>(points->GetNumberOfTuples());
  view.NumberOfTriangles = static_cast<std::size_t>(triangles->GetNumberOfCells());
  view.Connectivity.Values32 = GetIntegers<std::int32_t>(triangles->GetConnectivityArray());
  view.Connectivity.Values64 = GetIntegers<std::int64_t>(triangles->GetConnectivityArray());
  return view;
}

/// Access to the protected bounds of a vtkPolyData. There are no objects of this class.
class PolyDataBounds : public vtkPolyData
{
public:
  static void Store(vtkPolyData* surface, const TriangleMeasure& measure)
  {
    double(vtkPolyData::*bounds)[6] = &PolyDataBounds::CellsBounds;
    vtkTimeStamp vtkPolyData::*time = &PolyDataBounds::CellsBoundsTime;
    if (surface->GetMeshMTime() > (surface->*time).GetMTime())
    {
      std::copy(measure.Bounds.begin(), measure.Bounds.end(), surface->*bounds);
      (surface->*time).Modified();
    }
  }
};

} // namespace

vtkPolyData* GetSurfaceAlone(vtkDataObject* data)
{
  if (auto* blocks = vtkMultiBlockDataSet::SafeDownCast(data))
  {
    return blocks->GetNumberOfBlocks() == 1 ? vtkPolyData::SafeDownCast(blocks->GetBlock(0))
                                            : nullptr;
  }
  // Since ParaView 5.13.
  if (auto* collection = vtkPartitionedDataSetCollection::SafeDownCast(data))
  {
    return collection->GetNumberOfPartitionedDataSets() == 1 &&
        collection->GetNumberOfPartitions(0) == 1
      ? vtkPolyData::SafeDownCast(collection->GetPartitionAsDataObject(0, 0))
      : nullptr;
  }
  return vtkPolyData::SafeDownCast(data);
}

bool MeasuredTriangles::Measure(vtkPolyData* surface, int threads)
{
  vtkCellArray* polygons = surface ? GetPolygonsAlone(surface) : nullptr;
  if (!polygons)
  {
    return false;
  }
  vtkDataArray* points = surface->GetPoints()->GetData();
  const Key key{ points->GetMTime(), polygons->GetOffsetsArray()->GetMTime(),
    polygons->GetConnectivityArray()->GetMTime() };
  const bool isNew = !(key == this->Measured);
  this->Surface = View(points, polygons);
  if (isNew)
  {
    this->Measured = key;
    this->IsCovered =
      (this->Surface.Connectivity.Values32 || this->Surface.Connectivity.Values64) &&
      polygons->GetNumberOfConnectivityIds() == 3 * polygons->GetNumberOfCells() &&
      polygons->GetNumberOfConnectivityIds() <= MaximumIndices &&
      points->GetNumberOfTuples() <= MaximumIndices && AreTriangles(polygons, threads);
  }
  if (!this->IsCovered)
  {
    return false;
  }
  if (isNew)
  {
    this->Found = MeasureTriangles(this->Surface, threads);
    this->IsCovered = this->Found.IsValid;
  }
  return this->IsCovered;
}

void StoreCellsBounds(vtkPolyData* surface, const TriangleMeasure& measure)
{
  PolyDataBounds::Store(surface, measure);
}

int ChooseDrawingThreads()
{
  vtkMultiProcessController* controller = vtkMultiProcessController::GetGlobalController();
  return ChooseThreadCount(controller ? controller->GetNumberOfProcesses() : 1);
}

} // namespace isosurface
