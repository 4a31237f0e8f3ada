// SPDX-FileCopyrightText: Copyright (c) 2026, the ScalableIsosurface authors
// SPDX-License-Identifier: BSD-3-Clause
#include "vtkIsosurfaceMapperHelper.h"

#include "DrawingBudget.h"
#include "OcclusionCulling.h"
#include "ScalarColors.h"
#include "vtkIsosurfaceMapper.h"

#include "vtkActor.h"
#include "vtkCellData.h"
#include "vtkFloatArray.h"
#include "vtkHardwareSelector.h"
#include "vtkImageData.h"
#include "vtkMatrix4x4.h"
#include "vtkNew.h"
#include "vtkObjectFactory.h"
#include "vtkOpenGLCellToVTKCellMap.h"
#include "vtkOpenGLIndexBufferObject.h"
#include "vtkOpenGLTexture.h"
#include "vtkOpenGLVertexBufferObject.h"
#include "vtkOpenGLVertexBufferObjectGroup.h"
#include "vtkPointData.h"
#include "vtkPoints.h"
#include "vtkPolyData.h"
#include "vtkProperty.h"
#include "vtkRenderer.h"
#include "vtkScalarsToColors.h"
#include "vtkSelection.h"
#include "vtkSmartPointer.h"
#include "vtkTransform.h"
#if VTK_VERSION_NUMBER >= VTK_VERSION_CHECK(9, 3, 0)
#  include "vtkCompositePolyDataMapper.h"
#else
#  include "vtkCompositePolyDataMapper2.h"
#endif

#include "Surface/Drawing/DrawingBuffers.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <utility>
#include <vector>

vtkStandardNewMacro(vtkIsosurfaceMapperHelper);

using isosurface::DrawingBudget;
using isosurface::TriangleSurface;

namespace
{

using VertexBuffer = vtkOpenGLVertexBufferObject;

// Buffers are written in portions of so many points or triangles: 8 to 12 MB.
constexpr std::size_t TuplesOfPortion = std::size_t{ 1 } << 20;

// What maps coordinates to a unit cube around the origin.
struct ShiftAndScale
{
  std::vector<double> Shift;
  std::vector<double> Scale;

  explicit ShiftAndScale(const std::array<double, 6>& bounds)
  {
    for (std::size_t axis = 0; axis < 3; ++axis)
    {
      const double length = bounds[2 * axis + 1] - bounds[2 * axis];
      this->Shift.push_back(0.5 * (bounds[2 * axis + 1] + bounds[2 * axis]));
      this->Scale.push_back(length > 0 ? 1.0 / length : 1.0);
    }
  }
};

#if VTK_VERSION_NUMBER >= VTK_VERSION_CHECK(9, 3, 0)
constexpr const char* ColorCoordinatesOfShader = "colorTCoord";

using Block = vtkOpenGLBatchedPolyDataMapper::GLBatchElement;

vtkPolyData* GetSurface(const Block& block)
{
  return block.Parent.PolyData;
}
#else
constexpr const char* ColorCoordinatesOfShader = "tcoord";

using Block = vtkCompositeMapperHelperData;

vtkPolyData* GetSurface(const Block& block)
{
  return block.Data;
}
#endif

// Gives a variable another value until the end of the scope.
template <typename T>
class ScopedValue
{
public:
  ScopedValue(T& variable, T value)
    : Variable(variable)
    , Before(variable)
  {
    variable = value;
  }
  ~ScopedValue() { this->Variable = this->Before; }
  ScopedValue(const ScopedValue&) = delete;
  ScopedValue& operator=(const ScopedValue&) = delete;

private:
  T& Variable;
  T Before;
};

// Access to the protected number of tuples of a vertex buffer. There are no objects of this class.
class VertexBufferSize : public VertexBuffer
{
public:
  static void Set(VertexBuffer* buffer, std::size_t tuples)
  {
    unsigned int VertexBuffer::*size = &VertexBufferSize::NumberOfTuples;
    buffer->*size = static_cast<unsigned int>(tuples);
  }
};

// A tuple of zeros: tells a group of vertex buffers the layout of one that is filled later.
vtkSmartPointer<vtkFloatArray> MakeTuple(int components)
{
  auto tuple = vtkSmartPointer<vtkFloatArray>::New();
  tuple->SetNumberOfComponents(components);
  tuple->SetNumberOfTuples(1);
  tuple->FillValue(0);
  return tuple;
}

// A mapper's own arrays are held without a smart pointer.
template <typename ArrayT>
void Drop(ArrayT*& array, vtkObjectBase* owner)
{
  if (array)
  {
    array->UnRegister(owner);
    array = nullptr;
  }
}

} // namespace

vtkIsosurfaceMapperHelper::Block* vtkIsosurfaceMapperHelper::GetBlockAlone()
{
#if VTK_VERSION_NUMBER >= VTK_VERSION_CHECK(9, 3, 0)
  auto& blocks = this->VTKPolyDataToGLBatchElement;
  return blocks.size() == 1 ? blocks.begin()->second.get() : nullptr;
#else
  return this->Data.size() == 1 ? this->Data.begin()->second : nullptr;
#endif
}

bool vtkIsosurfaceMapperHelper::Covers(vtkRenderer* renderer, vtkActor* actor, const Block& block)
{
  vtkPolyData* surface = GetSurface(block);
  // Other helpers of the mapper may have further blocks.
  if (!surface || isosurface::GetSurfaceAlone(this->Parent->GetInputDataObject(0, 0)) != surface)
  {
    return false;
  }
  vtkProperty* property = actor->GetProperty();
  vtkHardwareSelector* selector = renderer->GetSelector();
  const bool picksPoints = selector && this->PopulateSelectionSettings &&
    selector->GetFieldAssociation() == vtkDataObject::FIELD_ASSOCIATION_POINTS;
  const bool isPlain = property->GetRepresentation() == VTK_SURFACE &&
    !property->GetEdgeVisibility() && !property->GetVertexVisibility() && !actor->GetTexture() &&
    property->GetNumberOfTextures() == 0 && !picksPoints;
  const bool shifts = this->ShiftScaleMethod == VertexBuffer::AUTO_SHIFT_SCALE ||
    this->ShiftScaleMethod == VertexBuffer::ALWAYS_AUTO_SHIFT_SCALE;
  const bool ofPoints = !surface->GetCellData()->GetNormals() &&
    !surface->GetPointData()->GetTangents() && this->ScalarMode != VTK_SCALAR_MODE_USE_CELL_DATA &&
    this->ScalarMode != VTK_SCALAR_MODE_USE_CELL_FIELD_DATA &&
    this->ScalarMode != VTK_SCALAR_MODE_USE_FIELD_DATA &&
    (this->ScalarMode == VTK_SCALAR_MODE_USE_POINT_FIELD_DATA || !this->ScalarVisibility);
  this->Threads = isosurface::ChooseDrawingThreads();
  return isPlain && shifts && ofPoints && this->Triangles->Measure(surface, this->Threads);
}

void vtkIsosurfaceMapperHelper::BuildBufferObjects(vtkRenderer* renderer, vtkActor* actor)
{
  this->ReleaseOwnBuffers();
  if (Block* block = this->GetBlockAlone())
  {
#if VTK_VERSION_NUMBER >= VTK_VERSION_CHECK(9, 3, 0)
    // Blocks may have settings of their own, which count instead of the mapper's.
    BatchElement& settings = block->Parent;
    const ScopedValue<int> colorMode(this->ColorMode, settings.ColorMode);
    const ScopedValue<int> scalarMode(this->ScalarMode, settings.ScalarMode);
    const ScopedValue<int> accessMode(this->ArrayAccessMode, settings.ArrayAccessMode);
    const ScopedValue<int> component(this->ArrayComponent, settings.ArrayComponent);
    const ScopedValue<int> arrayId(this->ArrayId, settings.ArrayId);
    const ScopedValue<char*> arrayName(
      this->ArrayName, settings.ArrayName.empty() ? nullptr : settings.ArrayName.data());
    const ScopedValue<vtkIdType> tuple(this->FieldDataTupleId, settings.FieldDataTupleId);
    const ScopedValue<vtkTypeBool> hasScalars(this->ScalarVisibility, settings.ScalarVisibility);
    const ScopedValue<vtkTypeBool> usesRange(
      this->UseLookupTableScalarRange, settings.UseLookupTableScalarRange);
    const ScopedValue<vtkTypeBool> interpolates(
      this->InterpolateScalarsBeforeMapping, settings.InterpolateScalarsBeforeMapping);
    const ScopedValue<double> minimum(this->ScalarRange[0], settings.ScalarRange[0]);
    const ScopedValue<double> maximum(this->ScalarRange[1], settings.ScalarRange[1]);
#endif
    if (this->Covers(renderer, actor, *block))
    {
      this->BuildBuffersOfBlock(renderer, actor, *block);
      return;
    }
  }
  this->Superclass::BuildBufferObjects(renderer, actor);
}

void vtkIsosurfaceMapperHelper::ReleaseOwnBuffers()
{
  if (std::exchange(this->HasOwnBuffers, false))
  {
    this->VBOs->ClearAllVBOs();
    for (vtkOpenGLHelper& primitive : this->Primitives)
    {
      primitive.IBO->ReleaseGraphicsResources();
    }
    this->Buffers.Clear();
  }
}

void vtkIsosurfaceMapperHelper::BuildBuffersOfBlock(
  vtkRenderer* renderer, vtkActor* actor, Block& block)
{
  vtkPolyData* surface = GetSurface(block);
  this->VBOs->ClearAllVBOs();
  for (vtkOpenGLHelper& primitive : this->Primitives)
  {
    primitive.IBO->IndexCount = 0;
  }
  this->EdgeValues.clear();
  this->HaveCellScalars = false;
  this->HaveCellNormals = false;

  vtkCellArray* cells[4] = { surface->GetVerts(), surface->GetLines(), surface->GetPolys(),
    surface->GetStrips() };
  block.CellCellMap->SetStartOffset(0);
  block.CellCellMap->BuildPrimitiveOffsetsIfNeeded(cells, VTK_SURFACE, surface->GetPoints());

  this->MapColors(surface);
  this->MakeVertices(renderer, actor, surface);
  vtkOpenGLIndexBufferObject* indices = this->Primitives[PrimitiveTris].IBO;
  this->MakeIndices(indices, surface);
  this->HasOwnBuffers = true;
  this->Culling->Take(this->Triangles->GetMeasure());

  block.StartVertex = 0;
  block.NextVertex = static_cast<unsigned int>(this->Triangles->GetSurface().NumberOfPoints);
  std::fill(block.StartIndex, block.StartIndex + PrimitiveEnd, 0U);
  std::fill(block.NextIndex, block.NextIndex + PrimitiveEnd, 0U);
  block.NextIndex[PrimitiveTris] = static_cast<unsigned int>(indices->IndexCount);
  this->VBOBuildTime.Modified();
}

void vtkIsosurfaceMapperHelper::MapColors(vtkPolyData* surface)
{
  Drop(this->ColorCoordinates, this);
  Drop(this->Colors, this);
  this->ColorValues = nullptr;
  if (!this->MapColorsToTexture(surface) && !this->MapColorsOfRuns(surface))
  {
    this->MapScalars(surface, 1.0);
  }
  if (this->ColorTextureMap)
  {
    if (!this->InternalColorTexture)
    {
      this->InternalColorTexture = vtkOpenGLTexture::New();
      this->InternalColorTexture->RepeatOff();
    }
    this->InternalColorTexture->SetInputData(this->ColorTextureMap);
  }
}

vtkDataArray* vtkIsosurfaceMapperHelper::FindNamedScalars(vtkPolyData* surface) const
{
  if (!this->ScalarVisibility || this->ScalarMode != VTK_SCALAR_MODE_USE_POINT_FIELD_DATA ||
    this->ArrayAccessMode != VTK_GET_ARRAY_BY_NAME || !this->ArrayName)
  {
    return nullptr;
  }
  vtkDataArray* scalars = surface->GetPointData()->GetArray(this->ArrayName);
  const bool isTaken = scalars && scalars->HasStandardMemoryLayout() &&
    scalars->GetDataType() != VTK_BIT && scalars->GetNumberOfTuples() > 0;
  return isTaken ? scalars : nullptr;
}

bool vtkIsosurfaceMapperHelper::MapColorsOfRuns(vtkPolyData* surface)
{
  constexpr std::size_t most = 4096;
  vtkDataArray* scalars = this->FindNamedScalars(surface);
  if (!scalars || scalars->GetNumberOfComponents() != 1 || !this->LookupTable ||
    !this->LookupTable->GetIndexedLookup())
  {
    return false;
  }
  const std::vector<std::size_t> ends = isosurface::FindRunsOf(scalars, most);
  if (ends.empty())
  {
    return false;
  }

  // VTK, which looks each value up by itself, maps one of each run.
  std::vector<vtkIdType> places;
  for (const std::size_t end : ends)
  {
    places.push_back(static_cast<vtkIdType>(end) - 1);
  }
  this->MapScalars(isosurface::MakeSurfaceOf(scalars, places), 1.0);
  if (!this->Colors)
  {
    return false;
  }
  const auto colors = isosurface::RepeatColors(this->Colors, ends);
  Drop(this->Colors, this);
  this->Colors = colors;
  this->Colors->Register(this);
  return true;
}

bool vtkIsosurfaceMapperHelper::MapColorsToTexture(vtkPolyData* surface)
{
  vtkDataArray* scalars = this->FindNamedScalars(surface);
  if (!scalars || !this->CanUseTextureMapForColoring(surface))
  {
    return false;
  }

  // The superclass makes the texture, with the coordinates of one value.
  this->MapScalars(isosurface::MakeSurfaceOf(scalars, { 0 }), 1.0);
  if (!this->ColorCoordinates || !this->LookupTable || this->LookupTable->UsingLogScale())
  {
    Drop(this->ColorCoordinates, this);
    Drop(this->Colors, this);
    return false;
  }

  // Of the other values they are written where the graphics card reads them.
  this->ColorValues = scalars;
  return true;
}

template <typename WriteT>
void vtkIsosurfaceMapperHelper::MakeVertexBuffer(
  const char* attribute, std::size_t components, std::size_t tuples, WriteT write)
{
  const std::size_t bytes = components * sizeof(float);
  std::vector<std::size_t> ends;
  for (std::size_t first = 0; first < tuples; first += TuplesOfPortion)
  {
    ends.push_back(std::min(tuples, first + TuplesOfPortion) * bytes);
  }
  VertexBuffer* buffer = this->VBOs->GetVBO(attribute);
  this->Buffers.Add(buffer, vtkOpenGLBufferObject::ArrayBuffer, std::move(ends),
    [write = std::move(write), tuples](std::size_t portion, void* values)
    {
      const std::size_t first = portion * TuplesOfPortion;
      write(first, std::min(tuples, first + TuplesOfPortion), static_cast<float*>(values));
    });
  VertexBufferSize::Set(buffer, tuples);
}

void vtkIsosurfaceMapperHelper::MakeVertices(
  vtkRenderer* renderer, vtkActor* actor, vtkPolyData* surface)
{
  const TriangleSurface& triangles = this->Triangles->GetSurface();
  const std::size_t points = triangles.NumberOfPoints;
  const ShiftAndScale map(this->Triangles->GetMeasure().PointBounds);
  vtkDataArray* normals = actor->GetProperty()->GetInterpolation() != VTK_FLAT
    ? surface->GetPointData()->GetNormals()
    : nullptr;
  auto* floatNormals = vtkFloatArray::FastDownCast(normals);
  const bool copiesNormals = floatNormals && floatNormals->GetNumberOfComponents() == 3 &&
    static_cast<std::size_t>(floatNormals->GetNumberOfTuples()) == points;
  const bool hasCoordinates =
    this->ColorTextureMap && this->InterpolateScalarsBeforeMapping && this->ColorCoordinates;
  const bool writesCoordinates = hasCoordinates && this->ColorValues;

  // Buffers of one tuple, where they are filled afterwards.
  this->VBOs->AppendDataArray("vertexMC", MakeTuple(3), VTK_FLOAT);
  if (copiesNormals)
  {
    this->VBOs->AppendDataArray("normalMC", MakeTuple(3), VTK_FLOAT);
  }
  else
  {
    this->VBOs->AppendDataArray("normalMC", normals, VTK_FLOAT);
  }
  this->VBOs->AppendDataArray("scalarColor", this->Colors, VTK_UNSIGNED_CHAR);
  if (hasCoordinates)
  {
    this->VBOs->AppendDataArray(ColorCoordinatesOfShader, this->ColorCoordinates, VTK_FLOAT);
  }
  this->VBOs->BuildAllVBOs(renderer);

  // Arrays that are read later stay.
  const vtkSmartPointer<vtkPolyData> kept = surface;
  this->MakeVertexBuffer("vertexMC", 3, points,
    [this, kept, triangles, map](std::size_t first, std::size_t last, float* written)
    {
      isosurface::ShiftAndScale(triangles.Points + 3 * first, last - first, map.Shift.data(),
        map.Scale.data(), written, this->Threads);
    });
  if (copiesNormals)
  {
    const vtkSmartPointer<vtkFloatArray> copied = floatNormals;
    this->MakeVertexBuffer("normalMC", 3, points,
      [this, copied](std::size_t first, std::size_t last, float* written)
      {
        isosurface::CopyValues(
          copied->GetPointer(0) + 3 * first, 3 * (last - first), written, this->Threads);
      });
  }
  if (writesCoordinates)
  {
    const vtkSmartPointer<vtkDataArray> scalars = this->ColorValues;
    this->MakeVertexBuffer(ColorCoordinatesOfShader, 2, points,
      [this, scalars](std::size_t first, std::size_t last, float* written)
      {
        isosurface::WriteColorCoordinates(
          scalars, this->LookupTable, first, last, written, this->Threads);
      });
  }

  // Shaders and matrices learn afterwards that what was uploaded is shifted and scaled.
  VertexBuffer* buffer = this->VBOs->GetVBO("vertexMC");
  buffer->SetCoordShiftAndScaleMethod(VertexBuffer::MANUAL_SHIFT_SCALE);
  buffer->SetShift(map.Shift);
  buffer->SetScale(map.Scale);
  if (buffer->GetCoordShiftAndScaleEnabled())
  {
    this->VBOInverseTransform->Identity();
    this->VBOInverseTransform->Translate(map.Shift[0], map.Shift[1], map.Shift[2]);
    this->VBOInverseTransform->Scale(1.0 / map.Scale[0], 1.0 / map.Scale[1], 1.0 / map.Scale[2]);
    this->VBOInverseTransform->GetTranspose(this->VBOShiftScale);
  }
}

void vtkIsosurfaceMapperHelper::MakeIndices(
  vtkOpenGLIndexBufferObject* buffer, vtkPolyData* surface)
{
  constexpr std::size_t runsOfPortion =
    TuplesOfPortion / isosurface::TriangleMeasure::TrianglesOfRun;
  const std::vector<std::uint32_t>& counts = this->Triangles->GetMeasure().ProperTriangles;
  std::vector<std::size_t> ends;
  std::size_t count = 0;
  for (std::size_t run = 0; run < counts.size(); ++run)
  {
    count += 3 * counts[run];
    if ((run + 1) % runsOfPortion == 0 || run + 1 == counts.size())
    {
      ends.push_back(count * sizeof(std::uint32_t));
    }
  }
  buffer->IndexCount = count;
  if (count == 0)
  {
    return;
  }
  const vtkSmartPointer<vtkPolyData> kept = surface;
  this->Buffers.Add(buffer, vtkOpenGLBufferObject::ElementArrayBuffer, std::move(ends),
    [this, kept, triangles = this->Triangles->GetSurface(), counts](
      std::size_t portion, void* indices)
    {
      const std::size_t first = portion * runsOfPortion;
      isosurface::CopyProperTriangles(triangles, counts, first,
        std::min(counts.size(), first + runsOfPortion), static_cast<std::uint32_t*>(indices),
        this->Threads);
    });
}

bool vtkIsosurfaceMapperHelper::CanCull(vtkRenderer* renderer, vtkActor* actor)
{
  // Fewer triangles are drawn in less time than depths are read; in portions, fewer fit into one.
  const std::size_t fewest = DrawingBudget::GetCurrent() || this->Culling->IsAmidPortions()
    ? vtkIsosurfaceMapper::TRIANGLES_OF_PORTIONS
    : 500000;
  const bool isSelected = this->GetSelection() && this->GetSelection()->GetNumberOfNodes() > 0;
  if (!this->HasOwnBuffers || !this->GetBlockAlone() || isSelected ||
    this->Primitives[PrimitiveTris].IBO->IndexCount < 3 * fewest)
  {
    return false;
  }
  auto* mapper = vtkIsosurfaceMapper::SafeDownCast(this->Parent);
  const int culling = mapper ? mapper->GetOcclusionCulling() : vtkIsosurfaceMapper::NEVER;
  const bool isWanted = culling == vtkIsosurfaceMapper::ALWAYS ||
    (culling == vtkIsosurfaceMapper::SOFTWARE && isosurface::OcclusionCulling::IsSoftware());
  double factor = 0;
  double units = 0;
  this->GetCoincidentTopologyPolygonOffsetParameters(factor, units);
  // Triangles that are moved to the eye would be in front of their boxes.
  const int coincident = vtkMapper::GetResolveCoincidentTopology();
  const bool isMoved = coincident == VTK_RESOLVE_SHIFT_ZBUFFER ||
    (coincident == VTK_RESOLVE_POLYGON_OFFSET && (factor < 0 || units < 0));
  return isWanted && !isMoved && isosurface::OcclusionCulling::IsPossible(renderer, actor);
}

void vtkIsosurfaceMapperHelper::RenderPieceDraw(vtkRenderer* renderer, vtkActor* actor)
{
  DrawingBudget* budget = DrawingBudget::GetCurrent();
  if (this->HasOwnBuffers && !this->Buffers.IsWritten())
  {
    this->Buffers.Write(budget);
    if (budget && (!this->Buffers.IsWritten() || budget->GetSecondsLeft() <= 0))
    {
      budget->SetUnfinished();
    }
  }
  if (this->HasOwnBuffers && budget && !budget->IsFinished())
  {
    return; // nobody will see this image
  }
  if (!this->CanCull(renderer, actor))
  {
    this->Culling->SetDrawn(this->Primitives[PrimitiveTris].IBO->IndexCount / 3);
    this->Superclass::RenderPieceDraw(renderer, actor);
    return;
  }
  Block& block = *this->GetBlockAlone();
  vtkOpenGLIndexBufferObject*& indices = this->Primitives[PrimitiveTris].IBO;
  vtkOpenGLIndexBufferObject* all = indices;
  const vtkMTimeType changed = std::max(this->Parent->GetMTime(), this->VBOBuildTime.GetMTime());
  this->Culling->Draw(renderer, actor, this->Parent, changed, all,
    [&](vtkOpenGLIndexBufferObject* some)
    {
      indices = some;
      block.NextIndex[PrimitiveTris] = static_cast<unsigned int>(some->IndexCount);
      this->Superclass::RenderPieceDraw(renderer, actor);
    });
  indices = all;
  block.NextIndex[PrimitiveTris] = static_cast<unsigned int>(all->IndexCount);
}

void vtkIsosurfaceMapperHelper::ReleaseGraphicsResources(vtkWindow* window)
{
  this->Culling->ReleaseGraphicsResources();
  this->Superclass::ReleaseGraphicsResources(window);
  this->Buffers.Clear();
}

void vtkIsosurfaceMapperHelper::BuildSelectionIBO(
  vtkPolyData* surface, std::vector<unsigned int> (&indices)[4], vtkIdType offset)
{
  // A surface that came without original ids has its own numbers for ids.
  const std::string pointIds = this->PointIdArrayName ? this->PointIdArrayName : "";
  const std::string cellIds = this->CellIdArrayName ? this->CellIdArrayName : "";
  const Block* block = this->GetBlockAlone();
  vtkPolyData* data = block ? GetSurface(*block) : nullptr;
  const bool noPointIds = data && !data->GetPointData()->HasArray(pointIds.c_str());
  const bool noCellIds = data && !data->GetCellData()->HasArray(cellIds.c_str());
  if (noPointIds)
  {
    this->SetPointIdArrayName(nullptr);
  }
  if (noCellIds)
  {
    this->SetCellIdArrayName(nullptr);
  }
  this->Superclass::BuildSelectionIBO(surface, indices, offset);
  if (noPointIds)
  {
    this->SetPointIdArrayName(pointIds.c_str());
  }
  if (noCellIds)
  {
    this->SetCellIdArrayName(cellIds.c_str());
  }
}

void vtkIsosurfaceMapperHelper::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  os << indent << "Threads: " << this->Threads << endl;
}
