// SPDX-License-Identifier: BSD-3-Clause
#include "OcclusionCulling.h"

#include "DrawingBudget.h"
#include "OpenGLFunctions.h"
#include "Surface/Drawing/SharedDepths.h"

#include "vtkActor.h"
#include "vtkInformation.h"
#include "vtkInformationObjectBaseVectorKey.h"
#include "vtkLight.h"
#include "vtkLightCollection.h"
#include "vtkMapper.h"
#include "vtkMatrix3x3.h"
#include "vtkMatrix4x4.h"
#include "vtkOpenGLCamera.h"
#include "vtkOpenGLRenderPass.h"
#include "vtkOpenGLRenderWindow.h"
#include "vtkOpenGLState.h"
#include "vtkPlane.h"
#include "vtkPlaneCollection.h"
#include "vtkProperty.h"
#include "vtkRenderer.h"
#include "vtkShaderProperty.h"

#include <algorithm>
#include <chrono>
#include <cstring>
#include <utility>

namespace isosurface
{
namespace
{

GLint GetInteger(GLenum name)
{
  GLint value = 0;
  glGetIntegerv(name, &value);
  return value;
}

std::size_t CountPixels(const std::array<int, 4>& viewport)
{
  return static_cast<std::size_t>(viewport[2]) * static_cast<std::size_t>(viewport[3]);
}

/// Reads the viewport from the framebuffer that is drawn to.
void ReadImage(const std::array<int, 4>& viewport, GLenum format, GLenum type, void* pixels)
{
  const auto before = static_cast<GLuint>(GetInteger(GL_READ_FRAMEBUFFER_BINDING));
  glBindFramebuffer(
    GL_READ_FRAMEBUFFER, static_cast<GLuint>(GetInteger(GL_DRAW_FRAMEBUFFER_BINDING)));
  const auto bufferBefore = static_cast<GLenum>(GetInteger(GL_READ_BUFFER));
  glReadBuffer(static_cast<GLenum>(GetInteger(GL_DRAW_BUFFER0)));
  glPixelStorei(GL_PACK_ALIGNMENT, 1);
  glReadPixels(viewport[0], viewport[1], viewport[2], viewport[3], format, type, pixels);
  glReadBuffer(bufferBefore);
  glBindFramebuffer(GL_READ_FRAMEBUFFER, before);
}

void ReadDepths(const std::array<int, 4>& viewport, std::vector<float>& depths)
{
  depths.resize(CountPixels(viewport));
  ReadImage(viewport, GL_DEPTH_COMPONENT, GL_FLOAT, depths.data());
}

void ReadColors(const std::array<int, 4>& viewport, std::vector<std::uint32_t>& colors)
{
  colors.resize(CountPixels(viewport));
  ReadImage(viewport, GL_RGBA, GL_UNSIGNED_BYTE, colors.data());
}

/// What the shaders do to a point of the surface.
std::array<double, 16> FindModelToClip(vtkRenderer* renderer, vtkActor* actor)
{
  auto* camera = static_cast<vtkOpenGLCamera*>(renderer->GetActiveCamera());
  vtkMatrix4x4* worldToView = nullptr;
  vtkMatrix3x3* normals = nullptr;
  vtkMatrix4x4* viewToClip = nullptr;
  vtkMatrix4x4* worldToClip = nullptr;
  camera->GetKeyMatrices(renderer, worldToView, normals, viewToClip, worldToClip);
  vtkNew<vtkMatrix4x4> all;
  vtkMatrix4x4::Transpose(worldToClip, all); // shaders have them transposed
  vtkMatrix4x4::Multiply4x4(all, actor->GetMatrix(), all);
  std::array<double, 16> values{};
  std::memcpy(values.data(), all->GetData(), sizeof(values));
  return values;
}

/// When the look of the surface, or the light, changed last. ParaView modifies the actor before each
/// image; where it is, the matrices tell.
vtkMTimeType FindChange(vtkRenderer* renderer, vtkActor* actor)
{
  vtkMTimeType last = std::max(actor->GetProperty()->GetMTime(), renderer->GetMTime());
  if (vtkProperty* backface = actor->GetBackfaceProperty())
  {
    last = std::max(last, backface->GetMTime());
  }
  vtkLightCollection* lights = renderer->GetLights();
  vtkCollectionSimpleIterator place;
  lights->InitTraversal(place);
  while (vtkLight* light = lights->GetNextLight(place))
  {
    last = std::max(last, light->GetMTime());
  }
  return std::max(last, lights->GetMTime());
}

/// Origins and normals. A collection of planes does not tell that one of them has moved.
std::vector<double> FindClippingPlanes(vtkMapper* mapper)
{
  std::vector<double> found;
  vtkPlaneCollection* planes = mapper->GetClippingPlanes();
  vtkCollectionSimpleIterator place;
  if (planes)
  {
    planes->InitTraversal(place);
    while (vtkPlane* plane = planes->GetNextPlane(place))
    {
      found.insert(found.end(), plane->GetOrigin(), plane->GetOrigin() + 3);
      found.insert(found.end(), plane->GetNormal(), plane->GetNormal() + 3);
    }
  }
  return found;
}

} // namespace

bool OcclusionCulling::IsSoftware()
{
  const auto* name = reinterpret_cast<const char*>(glGetString(GL_RENDERER));
  return name &&
    (std::strstr(name, "llvmpipe") || std::strstr(name, "SWR") || std::strstr(name, "softpipe"));
}

bool OcclusionCulling::IsPossible(vtkRenderer* renderer, vtkActor* actor)
{
  vtkShaderProperty* shaders = actor->GetShaderProperty();
  vtkInformation* keys = actor->GetPropertyKeys();
  const bool isPlain = !renderer->GetSelector() &&
    !actor->IsRenderingTranslucentPolygonalGeometry() && !actor->GetForceOpaque() &&
    !(keys && keys->Has(vtkOpenGLRenderPass::RenderPasses())) &&
    vtkOpenGLCamera::SafeDownCast(renderer->GetActiveCamera()) &&
    actor->GetCoordinateSystem() == vtkProp3D::WORLD &&
    !(shaders &&
      (shaders->HasVertexShaderCode() || shaders->HasFragmentShaderCode() ||
        shaders->HasGeometryShaderCode() || shaders->GetNumberOfShaderReplacements() > 0));
  if (!isPlain)
  {
    return false;
  }
  std::array<GLfloat, 2> range{};
  glGetFloatv(GL_DEPTH_RANGE, range.data());
  GLboolean writes = GL_FALSE;
  glGetBooleanv(GL_DEPTH_WRITEMASK, &writes);
  return glIsEnabled(GL_DEPTH_TEST) == GL_TRUE && writes == GL_TRUE &&
    GetInteger(GL_DEPTH_FUNC) == GL_LEQUAL && range[0] == 0 && range[1] == 1 &&
    GetInteger(GL_SAMPLE_BUFFERS) == 0 && GetInteger(GL_DRAW_BUFFER0) != GL_NONE &&
    GetInteger(GL_DRAW_BUFFER1) == GL_NONE && glIsEnabled(GL_SCISSOR_TEST) == GL_TRUE;
}

bool OcclusionCulling::Conditions::operator==(const Conditions& other) const
{
  return this->ModelToClip == other.ModelToClip && this->ModelToWorld == other.ModelToWorld &&
    this->Viewport == other.Viewport && this->Changed == other.Changed &&
    this->BackfaceProperty == other.BackfaceProperty &&
    this->ClippingPlanes == other.ClippingPlanes && this->ColorsBefore == other.ColorsBefore &&
    this->DepthsBefore == other.DepthsBefore;
}

OcclusionCulling::Conditions OcclusionCulling::FindConditions(
  vtkRenderer* renderer, vtkActor* actor, vtkMTimeType changed) const
{
  Conditions found;
  found.ModelToClip = FindModelToClip(renderer, actor);
  std::memcpy(found.ModelToWorld.data(), actor->GetMatrix()->GetData(), sizeof(found.ModelToWorld));
  glGetIntegerv(GL_VIEWPORT, found.Viewport.data());
  found.Changed = std::max(changed, FindChange(renderer, actor));
  found.BackfaceProperty = actor->GetBackfaceProperty(); // of the other one, VTK makes new buffers
  found.ClippingPlanes = FindClippingPlanes(this->Mapper);
  ReadColors(found.Viewport, found.ColorsBefore);
  ReadDepths(found.Viewport, found.DepthsBefore);
  return found;
}

void OcclusionCulling::Take(const TriangleMeasure& measure)
{
  this->Runs.Take(measure);
  this->Image.Clear();
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    this->Centre[axis] = (measure.PointBounds[2 * axis] + measure.PointBounds[2 * axis + 1]) / 2;
  }
}

void OcclusionCulling::Draw(vtkRenderer* renderer, vtkActor* actor, vtkMapper* mapper,
  vtkMTimeType changed, vtkOpenGLIndexBufferObject* all, const DrawIndices& draw)
{
  // Of stereo images, each would end what is saved of the other. What other ranks hide may appear.
  const bool mayStop = SavedImage::IsPossible() &&
    !renderer->GetRenderWindow()->GetStereoRender() && !SharedDepths::GetCurrent();
  DrawingBudget* budget = mayStop ? DrawingBudget::GetCurrent() : nullptr;
  if (budget && !budget->IsFinished())
  {
    return; // the image before this surface is not that of the next time
  }
  this->State = static_cast<vtkOpenGLRenderWindow*>(renderer->GetRenderWindow())->GetState();
  this->Mapper = mapper;
  const bool mayGoOn = !this->Image.IsEmpty();
  Conditions conditions;
  if (budget || mayGoOn)
  {
    conditions = FindConditions(renderer, actor, changed);
  }
  if (mayGoOn && conditions == this->Known)
  {
    this->Image.Restore();
  }
  else
  {
    this->Known = std::move(conditions);
    this->Begin(FindModelToClip(renderer, actor));
  }

  for (bool hasDrawn = false; this->Now != Stage::End; hasDrawn = true)
  {
    const double seconds = budget ? budget->GetSecondsLeft() : 0;
    if (budget && seconds <= 0 && hasDrawn) // each image brings it forward
    {
      budget->SetUnfinished();
      break;
    }
    if (this->Waiting.empty())
    {
      this->FindNext(all, draw);
    }
    else if (budget)
    {
      this->DrawFor(seconds, all, draw);
    }
    else
    {
      this->DrawPortion(all, std::exchange(this->Waiting, {}), draw);
    }
  }
  this->Image.Clear();
  if (budget)
  {
    this->Image.Save(this->Viewport);
  }
  this->Drawn = this->Runs.CountDrawn();
}

void OcclusionCulling::Begin(const std::array<double, 16>& modelToClip)
{
  glGetIntegerv(GL_VIEWPORT, this->Viewport.data());
  this->Ties.clear();
  this->Runs.Begin(BoxProjection(modelToClip, this->Viewport[2], this->Viewport[3], this->Centre));
  this->Waiting = this->Runs.FindFirst(this->Pyramid);
  this->Now = Stage::First;
}

void OcclusionCulling::FindNext(vtkOpenGLIndexBufferObject* all, const DrawIndices& draw)
{
  constexpr std::size_t few = 32;
  if (this->Now == Stage::Again)
  {
    this->Now = Stage::End;
    return;
  }
  ReadDepths(this->Viewport, this->Depths);
  this->Pyramid.Build(this->Depths, this->Viewport[2], this->Viewport[3]);
  if (SharedDepths* shared = SharedDepths::GetCurrent())
  {
    shared->Share(this->Mapper, this->Pyramid);
  }
  this->Waiting = this->Runs.FindNext(this->Pyramid);
  this->Now = this->Runs.HasBegunAnew() ? Stage::First : Stage::Further;
  if (this->Waiting.empty() && this->Ties.size() > few)
  {
    this->Waiting = this->Runs.FindDrawn();
    this->Now = Stage::Again;
  }
  else if (this->Waiting.empty())
  {
    this->DrawTies(all, draw);
    this->Now = Stage::End;
  }
}

void OcclusionCulling::DrawFor(
  double seconds, vtkOpenGLIndexBufferObject* all, const DrawIndices& draw)
{
  constexpr double fewest = 50000;
  const auto begin = std::chrono::steady_clock::now();
  const auto most = static_cast<std::size_t>(std::max(fewest, seconds * this->Rate));
  Ranges some;
  std::size_t count = 0;
  auto next = this->Waiting.begin();
  while (next != this->Waiting.end() && count < most)
  {
    const std::size_t last = std::min(next->Last, next->First + (most - count));
    some.push_back({ next->First, last });
    count += last - next->First;
    next->First = last;
    next += next->First == next->Last ? 1 : 0;
  }
  this->Waiting.erase(this->Waiting.begin(), next);
  this->DrawPortion(all, some, draw);
  glFinish();
  const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - begin;
  this->Rate = static_cast<double>(count) / std::max(taken.count(), 1e-3);
}

void OcclusionCulling::DrawPortion(
  vtkOpenGLIndexBufferObject* all, const Ranges& triangles, const DrawIndices& draw)
{
  if (triangles.empty())
  {
    return;
  }
  vtkOpenGLIndexBufferObject* indices = this->CopyIndices(all, triangles);
  if (this->Now == Stage::Further)
  {
    this->FindTies(indices, draw);
  }
  draw(indices);
}

void OcclusionCulling::ReleaseGraphicsResources()
{
  this->Some->ReleaseGraphicsResources();
  this->Room = 0;
  this->Image.Clear();
}

vtkOpenGLIndexBufferObject* OcclusionCulling::CopyIndices(
  vtkOpenGLIndexBufferObject* all, const Ranges& triangles)
{
  constexpr std::size_t size = 3 * sizeof(std::uint32_t);
  std::size_t count = 0;
  for (const VisibleRuns::Range& range : triangles)
  {
    count += range.Last - range.First;
  }
  if (3 * count == all->IndexCount)
  {
    return all;
  }
  this->Some->GenerateBuffer(vtkOpenGLBufferObject::ElementArrayBuffer);
  glBindBuffer(GL_COPY_READ_BUFFER, static_cast<GLuint>(all->GetHandle()));
  glBindBuffer(GL_COPY_WRITE_BUFFER, static_cast<GLuint>(this->Some->GetHandle()));
  if (this->Room < count * size)
  {
    this->Room = count * size;
    glBufferData(
      GL_COPY_WRITE_BUFFER, static_cast<GLsizeiptr>(this->Room), nullptr, GL_DYNAMIC_DRAW);
  }
  std::size_t to = 0;
  for (const VisibleRuns::Range& range : triangles)
  {
    const std::size_t bytes = (range.Last - range.First) * size;
    glCopyBufferSubData(GL_COPY_READ_BUFFER, GL_COPY_WRITE_BUFFER,
      static_cast<GLintptr>(range.First * size), static_cast<GLintptr>(to),
      static_cast<GLsizeiptr>(bytes));
    to += bytes;
  }
  glBindBuffer(GL_COPY_READ_BUFFER, 0);
  glBindBuffer(GL_COPY_WRITE_BUFFER, 0);
  this->Some->IndexCount = 3 * count;
  return this->Some;
}

void OcclusionCulling::FindTies(vtkOpenGLIndexBufferObject* indices, const DrawIndices& draw)
{
  ReadColors(this->Viewport, this->Before);
  {
    const vtkOpenGLState::ScopedglDepthFunc savedOrder(this->State);
    const vtkOpenGLState::ScopedglDepthMask savedMask(this->State);
    this->State->vtkglDepthFunc(GL_EQUAL);
    this->State->vtkglDepthMask(GL_FALSE);
    draw(indices);
  }
  ReadColors(this->Viewport, this->After);
  for (std::size_t pixel = 0; pixel < this->After.size(); ++pixel)
  {
    if (this->Before[pixel] != this->After[pixel])
    {
      this->Ties.push_back(pixel);
    }
  }
}

void OcclusionCulling::DrawTies(vtkOpenGLIndexBufferObject* all, const DrawIndices& draw)
{
  const vtkOpenGLState::ScopedglScissor saved(this->State);
  for (const std::size_t pixel : this->Ties)
  {
    const auto width = static_cast<std::size_t>(this->Viewport[2]);
    const int x = static_cast<int>(pixel % width);
    const int y = static_cast<int>(pixel / width);
    this->State->vtkglScissor(this->Viewport[0] + x, this->Viewport[1] + y, 1, 1);
    draw(this->CopyIndices(all, this->Runs.FindDrawnAt(x, y)));
  }
}

} // namespace isosurface
