// SPDX-FileCopyrightText: Copyright (c) 2026, the ScalableIsosurface authors
// SPDX-License-Identifier: BSD-3-Clause
#include "vtkIsosurfaceRepresentation.h"

#include "MeasuredTriangles.h"
#include "ThinnedPolyData.h"
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
#include "vtkPolyData.h"

vtkStandardNewMacro(vtkIsosurfaceRepresentation);

struct vtkIsosurfaceRepresentation::Measures
{
  isosurface::MeasuredTriangles Full;
  isosurface::MeasuredTriangles Thinned;
};

namespace
{

// The surface of a piece that has no other block.
vtkPolyData* GetSurfaceAlone(vtkDataObject* piece)
{
  auto* blocks = vtkMultiBlockDataSet::SafeDownCast(piece);
  return blocks && blocks->GetNumberOfBlocks() == 1 ? vtkPolyData::SafeDownCast(blocks->GetBlock(0))
                                                    : nullptr;
}

// Puts another object in the place of one that the superclass made.
template <typename BaseT, typename T>
void Replace(BaseT*& place, T* object)
{
  place->Delete();
  place = object;
}

} // namespace

//------------------------------------------------------------------------------
vtkIsosurfaceRepresentation::vtkIsosurfaceRepresentation()
  : Pieces(new Measures)
{
  Replace(this->GeometryFilter, vtkIsosurfaceGeometryFilter::New());
  this->GeometryFilter->AddObserver(vtkCommand::ProgressEvent, this,
    &vtkIsosurfaceRepresentation::HandleGeometryRepresentationProgress);
  auto* mapper = vtkIsosurfaceMapper::New();
  mapper->SetProcessIdArrayName("vtkProcessId");
  mapper->SetCompositeIdArrayName("vtkCompositeIndex");
  Replace(this->Mapper, mapper);
  Replace(this->LODMapper, vtkIsosurfaceMapper::New());
  this->SetArrayIdNames(nullptr, nullptr);
  this->SetupDefaults();
}

//------------------------------------------------------------------------------
vtkIsosurfaceRepresentation::~vtkIsosurfaceRepresentation() = default;

//------------------------------------------------------------------------------
int vtkIsosurfaceRepresentation::ProcessViewRequest(
  vtkInformationRequestKey* request, vtkInformation* input, vtkInformation* output)
{
  if (this->GetVisibility() && request == vtkPVView::REQUEST_UPDATE())
  {
    // The superclass counts bounds as soon as it has updated; then they are to be there.
    this->vtkPVDataRepresentation::ProcessViewRequest(request, input, output);
    this->StoreBounds(this->MultiBlockMaker->GetOutputDataObject(0));
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
    this->StoreBounds(vtkPVView::GetDeliveredPiece(input, this));
    if (vtkPolyData* thinned = GetSurfaceAlone(vtkPVView::GetDeliveredPieceLOD(input, this)))
    {
      if (this->Pieces->Thinned.Measure(thinned, isosurface::ChooseDrawingThreads()))
      {
        isosurface::StoreCellsBounds(thinned, this->Pieces->Thinned.GetMeasure());
      }
    }
  }
  return this->Superclass::ProcessViewRequest(request, input, output);
}

//------------------------------------------------------------------------------
void vtkIsosurfaceRepresentation::StoreBounds(vtkDataObject* piece)
{
  vtkPolyData* surface = GetSurfaceAlone(piece);
  if (this->Pieces->Full.Measure(surface, isosurface::ChooseDrawingThreads()))
  {
    isosurface::StoreCellsBounds(surface, this->Pieces->Full.GetMeasure());
  }
}

//------------------------------------------------------------------------------
bool vtkIsosurfaceRepresentation::ProvideLevelOfDetail(vtkInformation* input)
{
  if (this->SuppressLOD || input->Has(vtkPVRenderView::USE_OUTLINE_FOR_LOD()))
  {
    return false;
  }
  vtkDataObject* piece = vtkPVView::GetPiece(input, this);
  vtkPolyData* surface = GetSurfaceAlone(piece);
  const int threads = isosurface::ChooseDrawingThreads();
  if (!this->Pieces->Full.Measure(surface, threads))
  {
    return false;
  }
  const double resolution = input->Has(vtkPVRenderView::LOD_RESOLUTION())
    ? input->Get(vtkPVRenderView::LOD_RESOLUTION())
    : 0.5;
  vtkNew<vtkPolyData> thinned;
  isosurface::ThinPolyData(surface, this->Pieces->Full, resolution, threads, thinned);
  vtkNew<vtkMultiBlockDataSet> blocks;
  blocks->SetBlock(0, thinned);
  // The superclass knows by the field data that the block is not one of the user's.
  blocks->GetFieldData()->ShallowCopy(piece->GetFieldData());
  vtkPVView::SetPieceLOD(input, this, blocks);
  return true;
}

//------------------------------------------------------------------------------
void vtkIsosurfaceRepresentation::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
}
