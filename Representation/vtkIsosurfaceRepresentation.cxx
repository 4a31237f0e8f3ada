// SPDX-FileCopyrightText: Copyright (c) 2026, the ScalableIsosurface authors
// SPDX-License-Identifier: BSD-3-Clause
#include "vtkIsosurfaceRepresentation.h"

#include "BackgroundThinning.h"
#include "MeasuredTriangles.h"
#include "vtkIsosurfaceGeometryFilter.h"
#include "vtkIsosurfaceMapper.h"

#include "vtkAlgorithm.h"
#include "vtkCellData.h"
#include "vtkCommand.h"
#include "vtkFieldData.h"
#include "vtkInformation.h"
#include "vtkInformationDoubleKey.h"
#include "vtkInformationIntegerKey.h"
#include "vtkInformationRequestKey.h"
#include "vtkMultiBlockDataSet.h"
#include "vtkNew.h"
#include "vtkObjectFactory.h"
#include "vtkPVLODActor.h"
#include "vtkPVRenderView.h"
#include "vtkPartitionedDataSetCollection.h"
#include "vtkPolyData.h"

#include <optional>

vtkStandardNewMacro(vtkIsosurfaceRepresentation);

namespace
{

// Where a piece is one surface of triangles, VTK need not compute its bounds cell by cell.
void StoreBounds(vtkDataObject* piece, vtkIsosurfaceMapper* mapper)
{
  vtkPolyData* surface = isosurface::GetSurfaceAlone(piece);
  if (mapper->GetTriangles()->Measure(surface, isosurface::ChooseDrawingThreads()))
  {
    isosurface::StoreCellsBounds(surface, mapper->GetTriangles()->GetMeasure());
  }
}

// A surface alone in data of the same class as another one: what views get of a surface.
vtkSmartPointer<vtkDataObject> WrapAs(vtkDataObject* other, vtkPolyData* surface)
{
  auto wrapped = vtkSmartPointer<vtkDataObject>::Take(other->NewInstance());
  if (auto* blocks = vtkMultiBlockDataSet::SafeDownCast(wrapped))
  {
    blocks->SetBlock(0, surface);
  }
  else if (auto* collection = vtkPartitionedDataSetCollection::SafeDownCast(wrapped))
  {
    collection->SetNumberOfPartitionedDataSets(1);
    collection->SetPartition(0, 0, surface);
  }
  else
  {
    wrapped->ShallowCopy(surface);
  }
  return wrapped;
}

// Puts another object in the place of one that the superclass made.
template <typename BaseT, typename T>
void Replace(BaseT*& place, T* object)
{
  place->Delete();
  place = object;
}

} // namespace

vtkIsosurfaceRepresentation::vtkIsosurfaceRepresentation()
  : SurfaceMapper(vtkIsosurfaceMapper::New())
  , ThinnedMapper(vtkIsosurfaceMapper::New())
  , ThinnedTime(0)
  , ThinnedResolution(0)
  , Thinning(new isosurface::BackgroundThinning)
{
  Replace(this->GeometryFilter, vtkIsosurfaceGeometryFilter::New());
  this->GeometryFilter->AddObserver(vtkCommand::ProgressEvent, this,
    &vtkIsosurfaceRepresentation::HandleGeometryRepresentationProgress);
  this->SurfaceMapper->SetProcessIdArrayName("vtkProcessId");
  this->SurfaceMapper->SetCompositeIdArrayName("vtkCompositeIndex");
  Replace(this->Mapper, this->SurfaceMapper);
  Replace(this->LODMapper, this->ThinnedMapper);
  this->SetArrayIdNames(nullptr, nullptr);
  this->SetupDefaults();
}

vtkIsosurfaceRepresentation::~vtkIsosurfaceRepresentation() = default;

int vtkIsosurfaceRepresentation::ProcessViewRequest(
  vtkInformationRequestKey* request, vtkInformation* input, vtkInformation* output)
{
  if (this->GetVisibility() && request == vtkPVView::REQUEST_UPDATE())
  {
    // The superclass asks for bounds as soon as it has updated; they have to be stored before.
    // NOLINTNEXTLINE(bugprone-parent-virtual-call): this updates; the superclass finds that done.
    this->vtkPVDataRepresentation::ProcessViewRequest(request, input, output);
    vtkDataObject* piece = this->MultiBlockMaker->GetOutputDataObject(0);
    StoreBounds(piece, this->SurfaceMapper);
    this->BeginThinning(isosurface::GetSurfaceAlone(piece));
  }
  else if (this->GetVisibility() && request == vtkPVView::REQUEST_UPDATE_LOD())
  {
    if (this->ProvideLevelOfDetail(input))
    {
      return 1;
    }
  }
  else if (this->GetVisibility() && request == vtkPVView::REQUEST_RENDER())
  {
    StoreBounds(vtkPVView::GetDeliveredPiece(input, this), this->SurfaceMapper);
    StoreBounds(vtkPVView::GetDeliveredPieceLOD(input, this), this->ThinnedMapper);
  }
  return this->Superclass::ProcessViewRequest(request, input, output);
}

void vtkIsosurfaceRepresentation::BeginThinning(vtkPolyData* surface)
{
  // Whoever has turned a surface will turn the next one. Small ones are thinned in no time.
  constexpr vtkIdType large = 500000;
  const bool wasTurned = this->Thinned != nullptr;
  if (wasTurned && !this->SuppressLOD && surface && surface->GetNumberOfPolys() > large &&
    this->SurfaceMapper->GetTriangles()->Measure(surface, isosurface::ChooseDrawingThreads()))
  {
    this->Thinning->Begin(surface, *this->SurfaceMapper->GetTriangles(),
      isosurface::ChooseThinningLimits(this->ThinnedResolution));
  }
  else
  {
    this->Thinning->Forget();
  }
}

bool vtkIsosurfaceRepresentation::ProvideLevelOfDetail(vtkInformation* input)
{
  if (this->SuppressLOD || input->Has(vtkPVRenderView::USE_OUTLINE_FOR_LOD()))
  {
    return false;
  }
  vtkDataObject* piece = vtkPVView::GetPiece(input, this);
  vtkPolyData* surface = isosurface::GetSurfaceAlone(piece);
  const int threads = isosurface::ChooseDrawingThreads();
  if (!this->SurfaceMapper->GetTriangles()->Measure(surface, threads))
  {
    return false;
  }
  const double resolution = input->Has(vtkPVRenderView::LOD_RESOLUTION())
    ? input->Get(vtkPVRenderView::LOD_RESOLUTION())
    : 0.5;
  if (this->ThinnedSurface != surface || this->ThinnedTime != surface->GetMTime() ||
    this->ThinnedResolution != resolution)
  {
    const isosurface::ThinningLimits limits = isosurface::ChooseThinningLimits(resolution);
    std::optional<isosurface::ThinnedSurface> kept = this->Thinning->Take(surface, limits);
    if (!kept)
    {
      const isosurface::MeasuredTriangles& triangles = *this->SurfaceMapper->GetTriangles();
      kept =
        isosurface::ThinSurface(triangles.GetSurface(), triangles.GetMeasure(), limits, threads);
    }
    vtkNew<vtkPolyData> thinned;
    isosurface::CopyThinned(surface, *kept, thinned);
    this->Thinned = WrapAs(piece, thinned);
    // The superclass knows by the field data that the block is not one of the user's.
    this->Thinned->GetFieldData()->ShallowCopy(piece->GetFieldData());
    this->ThinnedSurface = surface;
    this->ThinnedTime = surface->GetMTime();
    this->ThinnedResolution = resolution;
  }
  vtkPVView::SetPieceLOD(input, this, this->Thinned);
  return true;
}

void vtkIsosurfaceRepresentation::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
}
