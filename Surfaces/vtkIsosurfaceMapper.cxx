// SPDX-FileCopyrightText: Copyright (c) 2026, the ScalableIsosurface authors
// SPDX-License-Identifier: BSD-3-Clause
#include "vtkIsosurfaceMapper.h"

#include "DrawingBudget.h"
#include "MeasuredTriangles.h"
#include "OcclusionCulling.h"
#include "vtkIsosurfaceMapperHelper.h"

#include "vtkObjectFactory.h"

#if VTK_VERSION_NUMBER >= VTK_VERSION_CHECK(9, 3, 0)
#  include "vtkOpenGLCompositePolyDataMapperDelegator.h"
#  include "vtkSmartPointer.h"

namespace
{

/// Has a vtkIsosurfaceMapperHelper make the buffers of a batch of surfaces.
class IsosurfaceDelegator : public vtkOpenGLCompositePolyDataMapperDelegator
{
public:
  static IsosurfaceDelegator* New();
  vtkTypeMacro(IsosurfaceDelegator, vtkOpenGLCompositePolyDataMapperDelegator);

  void Share(const std::shared_ptr<isosurface::MeasuredTriangles>& triangles,
    const std::shared_ptr<isosurface::OcclusionCulling>& culling)
  {
    this->Helper->Share(triangles, culling);
  }

  IsosurfaceDelegator(const IsosurfaceDelegator&) = delete;
  void operator=(const IsosurfaceDelegator&) = delete;

protected:
  IsosurfaceDelegator()
    : Helper(vtkSmartPointer<vtkIsosurfaceMapperHelper>::New())
  {
    this->GLDelegate = this->Helper;
    this->Delegate = this->Helper;
  }
  ~IsosurfaceDelegator() override = default;

private:
  vtkSmartPointer<vtkIsosurfaceMapperHelper> Helper;
};

vtkStandardNewMacro(IsosurfaceDelegator);

} // namespace
#endif

vtkStandardNewMacro(vtkIsosurfaceMapper);

vtkIsosurfaceMapper::vtkIsosurfaceMapper()
  : Triangles(std::make_shared<isosurface::MeasuredTriangles>())
  , Culling(std::make_shared<isosurface::OcclusionCulling>())
  , OcclusionCulling(SOFTWARE)
{
}

vtkIsosurfaceMapper::~vtkIsosurfaceMapper() = default;

#if VTK_VERSION_NUMBER >= VTK_VERSION_CHECK(9, 3, 0)
vtkCompositePolyDataMapperDelegator* vtkIsosurfaceMapper::CreateADelegator()
{
  IsosurfaceDelegator* delegator = IsosurfaceDelegator::New();
  delegator->Share(this->Triangles, this->Culling);
  return delegator;
}
#else
vtkCompositeMapperHelper2* vtkIsosurfaceMapper::CreateHelper()
{
  vtkIsosurfaceMapperHelper* helper = vtkIsosurfaceMapperHelper::New();
  helper->Share(this->Triangles, this->Culling);
  return helper;
}
#endif

vtkIdType vtkIsosurfaceMapper::GetNumberOfDrawnTriangles()
{
  return static_cast<vtkIdType>(this->Culling->GetDrawn());
}

void vtkIsosurfaceMapper::BeginBudget(double seconds)
{
  isosurface::DrawingBudget::SetCurrent(std::make_unique<isosurface::DrawingBudget>(seconds));
}

bool vtkIsosurfaceMapper::EndBudget()
{
  const isosurface::DrawingBudget* budget = isosurface::DrawingBudget::GetCurrent();
  const bool finished = !budget || budget->IsFinished();
  isosurface::DrawingBudget::SetCurrent(nullptr);
  return finished;
}

void vtkIsosurfaceMapper::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  os << indent << "OcclusionCulling: " << this->OcclusionCulling << "\n";
}
