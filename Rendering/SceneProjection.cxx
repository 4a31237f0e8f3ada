// SPDX-License-Identifier: BSD-3-Clause
#include "SceneProjection.h"

#include "Ranks/Compositing/BoundsProjection.h"

#include "vtkActor.h"
#include "vtkBoundingBox.h"
#include "vtkCamera.h"
#include "vtkCompositeDataSet.h"
#include "vtkDataSet.h"
#include "vtkMapper.h"
#include "vtkMath.h"
#include "vtkMatrix4x4.h"
#include "vtkNew.h"
#include "vtkProperty.h"
#include "vtkRenderState.h"
#include "vtkRenderer.h"

#include <algorithm>
#include <array>

namespace isosurface
{
namespace
{

// The bounds of grid, cube and polar axes are those of what they surround. Their labels are outside, at most
// as far away as the box is long.
bool IsAxes(vtkProp* prop)
{
  return prop->IsA("vtkGridAxes3DActor") || // before ParaView 6.0
    prop->IsA("vtkGridAxesActor3D") || prop->IsA("vtkCubeAxesActor") ||
    prop->IsA("vtkPolarAxesActor");
}

// Whether a prop may draw beyond its bounds: as glyphs, which the mapper makes of points.
bool DrawsBeyondBounds(vtkProp* prop)
{
  const auto* actor = vtkActor::SafeDownCast(prop);
  auto* mapper = actor ? const_cast<vtkActor*>(actor)->GetMapper() : nullptr;
  return mapper &&
    (mapper->IsA("vtkPointGaussianMapper") || mapper->IsA("vtkOpenGLSphereMapper") ||
      mapper->IsA("vtkOpenGLStickMapper"));
}

// Half the width of the prop's lines and points, in pixels.
double GetHalfWidth(vtkProp* prop)
{
  auto* actor = vtkActor::SafeDownCast(prop);
  vtkProperty* property = actor ? actor->GetProperty() : nullptr;
  return property ? 0.5 * std::max(property->GetLineWidth(), property->GetPointSize()) : 0;
}

/// What the visible props of a render state have in common.
struct VisibleProps
{
  vtkBoundingBox Bounds;
  double HalfWidth = 0.5;
  bool MayBeAnywhere = false; ///< the bounds do not tell where some prop draws
};

VisibleProps FindVisibleProps(const vtkRenderState* state)
{
  VisibleProps visible;
  for (int index = 0; index < state->GetPropArrayCount(); ++index)
  {
    vtkProp* prop = state->GetPropArray()[index];
    if (!prop->GetVisibility())
    {
      continue;
    }
    const double* bounds = prop->GetUseBounds() ? prop->GetBounds() : nullptr;
    if (!bounds)
    {
      visible.MayBeAnywhere = true;
      continue;
    }
    vtkBoundingBox box(bounds);
    if (!box.IsValid())
    {
      continue;
    }
    if (IsAxes(prop))
    {
      box.Inflate(box.GetMaxLength());
    }
    visible.Bounds.AddBox(box);
    visible.MayBeAnywhere = visible.MayBeAnywhere || DrawsBeyondBounds(prop);
    visible.HalfWidth = std::max(visible.HalfWidth, GetHalfWidth(prop));
  }
  return visible;
}

// Where the props are on the display, if one pixel is a block of divisor x divisor.
ProjectedBounds ProjectProps(
  const VisibleProps& visible, vtkCamera* camera, const PixelRectangle& display, int divisor)
{
  if (visible.MayBeAnywhere)
  {
    return { display, -1.0, 1.0 };
  }
  std::array<double, 6> bounds{ 1, -1, 1, -1, 1, -1 };
  if (visible.Bounds.IsValid())
  {
    visible.Bounds.GetBounds(bounds.data());
  }
  vtkNew<vtkMatrix4x4> worldToClip;
  vtkMatrix4x4::Multiply4x4(
    MakeProjection(camera, display), camera->GetModelViewTransformMatrix(), worldToClip);
  std::array<double, 16> matrix{};
  std::copy_n(worldToClip->GetData(), 16, matrix.begin());
  return ProjectBounds(bounds, matrix, display, (visible.HalfWidth + 0.5) * divisor);
}

// The distance from the camera, in world units, at a normalized device depth.
double GetDistance(vtkCamera* camera, double depth)
{
  const double* range = camera->GetClippingRange();
  const double nearest = range[0];
  const double farthest = range[1];
  return camera->GetParallelProjection()
    ? nearest + 0.5 * (depth + 1) * (farthest - nearest)
    : 2 * nearest * farthest / (farthest + nearest - depth * (farthest - nearest));
}

// The number of cells that the visible props draw.
std::int64_t CountCells(const vtkRenderState* state)
{
  std::int64_t cells = 0;
  for (int index = 0; index < state->GetPropArrayCount(); ++index)
  {
    auto* actor = vtkActor::SafeDownCast(state->GetPropArray()[index]);
    vtkMapper* mapper = actor && actor->GetVisibility() ? actor->GetMapper() : nullptr;
    vtkDataObject* data = mapper && mapper->GetNumberOfInputConnections(0) > 0
      ? mapper->GetInputDataObject(0, 0)
      : nullptr;
    if (auto* set = vtkDataSet::SafeDownCast(data))
    {
      cells += set->GetNumberOfCells();
    }
    else if (auto* composite = vtkCompositeDataSet::SafeDownCast(data))
    {
      cells += composite->GetNumberOfCells();
    }
  }
  return cells;
}

} // namespace

vtkSmartPointer<vtkMatrix4x4> MakeProjection(vtkCamera* camera, const PixelRectangle& display)
{
  auto projection = vtkSmartPointer<vtkMatrix4x4>::New();
  projection->DeepCopy(camera->GetProjectionTransformMatrix(
    static_cast<double>(display.Width) / display.Height, -1, 1));
  return projection;
}

FrameProposal MakeProposal(const vtkRenderState* state, const PixelRectangle& display,
  const std::vector<int>& divisors, bool isFullDisplay)
{
  vtkCamera* camera = state->GetRenderer()->GetActiveCamera();
  const VisibleProps visible = FindVisibleProps(state);
  FrameProposal proposal;
  for (const int divisor : divisors)
  {
    const ProjectedBounds bounds = ProjectProps(visible, camera, display, divisor);
    if (proposal.Choices.empty() && !bounds.Pixels.IsEmpty())
    {
      proposal.NearDistance = GetDistance(camera, bounds.NearDepth);
      proposal.FarDistance = GetDistance(camera, bounds.FarDepth);
    }
    proposal.Choices.push_back(MakeViewport(isFullDisplay ? display : bounds.Pixels, divisor));
  }
  proposal.Triangles = CountCells(state);
  return proposal;
}

const vtkMapper* FindLastMapper(const vtkRenderState* state)
{
  vtkProp** props = state->GetPropArray();
  vtkProp** end = props + state->GetPropArrayCount();
  if (std::any_of(props, end,
        [](vtkProp* prop)
        { return prop->HasTranslucentPolygonalGeometry() != 0 || prop->IsA("vtkVolume"); }))
  {
    return nullptr;
  }
  const auto isEmpty = [](vtkProp* prop)
  {
    const double* bounds = prop->GetBounds();
    return bounds && !vtkMath::AreBoundsInitialized(bounds);
  };
  // ParaView has an actor for what is selected of a surface, mostly of nothing.
  while (end != props && isEmpty(*(end - 1)))
  {
    --end;
  }
  vtkActor* last = end != props ? vtkActor::SafeDownCast(*(end - 1)) : nullptr;
  return last ? last->GetMapper() : nullptr;
}

} // namespace isosurface
