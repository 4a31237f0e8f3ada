// SPDX-License-Identifier: BSD-3-Clause
#include "RankScene.h"

#include "vtkActor.h"
#include "vtkCamera.h"
#include "vtkCommunicator.h"
#include "vtkFloatArray.h"
#include "vtkIceTCompositePass.h"
#include "vtkIceTSynchronizedRenderers.h"
#include "vtkMetabufferPass.h"
#include "vtkMetabufferSynchronizedRenderers.h"
#include "vtkMultiProcessController.h"
#include "vtkPolyDataMapper.h"
#include "vtkProperty.h"
#include "vtkRenderWindow.h"
#include "vtkRenderer.h"
#include "vtkSphereSource.h"
#include "vtkSynchronizedRenderWindows.h"
#include "vtkUnsignedCharArray.h"

#include <algorithm>
#include <cstring>
#include <random>

namespace isosurface
{
namespace
{

vtkMultiProcessController* GetController()
{
  return vtkMultiProcessController::GetGlobalController();
}

vtkSmartPointer<vtkActor> MakeBall(const std::array<double, 3>& center, double radius, int color)
{
  vtkNew<vtkSphereSource> sphere;
  sphere->SetCenter(center[0], center[1], center[2]);
  sphere->SetRadius(radius);
  sphere->SetThetaResolution(18);
  sphere->SetPhiResolution(13);
  vtkNew<vtkPolyDataMapper> mapper;
  mapper->SetInputConnection(sphere->GetOutputPort());
  auto actor = vtkSmartPointer<vtkActor>::New();
  actor->SetMapper(mapper);
  actor->GetProperty()->SetColor(
    0.3 + 0.7 * (color % 5) / 4, 0.3 + 0.7 * (color % 3) / 2, 0.3 + 0.7 * (color % 7) / 6);
  return actor;
}

// Those of twenty-four balls in the unit cube for which `owns` is true.
template <typename Function>
std::vector<vtkSmartPointer<vtkActor>> MakeBalls(const Function& owns)
{
  std::vector<vtkSmartPointer<vtkActor>> actors;
  std::mt19937 random(7);
  std::uniform_real_distribution<double> place(0.05, 0.95);
  for (int ball = 0; ball < 24; ++ball)
  {
    const std::array<double, 3> center = { place(random), place(random), place(random) };
    if (owns(ball, center))
    {
      actors.push_back(MakeBall(center, 0.09, ball));
    }
  }
  return actors;
}

std::vector<vtkSmartPointer<vtkActor>> MakeSlabOfBalls(int rank, int ranks)
{
  return MakeBalls([=](int, const std::array<double, 3>& center)
    { return static_cast<int>(center[0] * ranks) == rank; });
}

void Outline(vtkActor* actor, int representation)
{
  actor->GetProperty()->SetRepresentation(representation);
  actor->GetProperty()->SetLineWidth(4);
  actor->GetProperty()->SetPointSize(7);
}

} // namespace

int GetRank()
{
  return GetController()->GetLocalProcessId();
}

int GetNumberOfRanks()
{
  return GetController()->GetNumberOfProcesses();
}

bool IsTrueOnSomeRank(bool mine)
{
  const int value = mine ? 1 : 0;
  int all = 0;
  GetController()->AllReduce(&value, &all, 1, vtkCommunicator::MAX_OP);
  return all != 0;
}

std::size_t Image::CountActive() const
{
  return static_cast<std::size_t>(
    std::count_if(this->Depths.begin(), this->Depths.end(), [](float z) { return z < 1.0F; }));
}

std::size_t CountDifferentColors(const Image& a, const Image& b)
{
  std::size_t different = a.Colors.size() == b.Colors.size() ? 0 : 1;
  for (std::size_t pixel = 0; pixel < std::min(a.Colors.size(), b.Colors.size()); ++pixel)
  {
    different += a.Colors[pixel] == b.Colors[pixel] ? 0 : 1;
  }
  return different;
}

std::size_t CountDifferentDepths(const Image& a, const Image& b)
{
  std::size_t different = a.Depths.size() == b.Depths.size() ? 0 : 1;
  for (std::size_t pixel = 0; pixel < std::min(a.Depths.size(), b.Depths.size()); ++pixel)
  {
    different += a.Depths[pixel] == b.Depths[pixel] ? 0 : 1;
  }
  return different;
}

std::vector<CameraPlace> GetCameraPlaces()
{
  return { { "far away", { 2.6, 1.9, 3.1 }, { 0.5, 0.5, 0.5 }, 30, 0, { 1, 8 } },
    { "near", { 0.5, 0.6, 2.2 }, { 0.9, 0.6, 0.5 }, 25, 0, { 0.3, 4 } },
    { "inside", { 0.6, 0.5, 0.5 }, { 1, 0.5, 0.2 }, 60, 0, { 0.01, 2 } },
    { "beside", { 2.6, 1.9, 3.1 }, { 5, 9, 1 }, 30, 0, { 1, 8 } },
    { "parallel", { 2.6, 1.9, 3.1 }, { 0.5, 0.5, 0.5 }, 30, 0.6, { 1, 8 } } };
}

std::vector<Scene> GetScenes()
{
  const auto wholeRank = [](int representation)
  {
    return [representation](int rank, int ranks)
    {
      auto actors = MakeSlabOfBalls(rank, ranks);
      for (const auto& actor : actors)
      {
        Outline(actor, representation);
      }
      return actors;
    };
  };
  return {
    { "compact", MakeSlabOfBalls },
    { "random",
      [](int rank, int ranks)
      {
        return MakeBalls(
          [=](int ball, const std::array<double, 3>&) { return ball % ranks == rank; });
      } },
    { "nested",
      [](int rank, int)
      {
        return std::vector<vtkSmartPointer<vtkActor>>{ MakeBall(
          { 0.5, 0.5, 0.5 }, 0.45 / (1 + rank), rank) };
      } },
    { "one rank draws",
      [](int rank, int ranks) {
        return rank == ranks - 1 ? MakeSlabOfBalls(0, 1) : std::vector<vtkSmartPointer<vtkActor>>();
      } },
    { "nobody draws", [](int, int) { return std::vector<vtkSmartPointer<vtkActor>>(); } },
    { "wireframe", wholeRank(VTK_WIREFRAME) },
    { "points", wholeRank(VTK_POINTS) },
  };
}

std::vector<vtkSmartPointer<vtkActor>> MakeRowOfBalls(int rank, int)
{
  // Shifted sideways, such that each is visible.
  const double away = 0.45 * rank;
  return { MakeBall(
    { 0.5 - 0.7 * away + 0.12 * rank, 0.5 - 0.4 * away + 0.1 * rank, 0.5 - away }, 0.4, 3 * rank) };
}

RankWindow::RankWindow(Kind kind, int width, int height, int columns, int rows)
{
  if (kind == Stock)
  {
    this->Renderers = vtkSmartPointer<vtkIceTSynchronizedRenderers>::New();
  }
  else
  {
    this->Renderers = vtkSmartPointer<vtkMetabufferSynchronizedRenderers>::New();
  }
  this->Window->SetMultiSamples(0);
  this->Window->SetOffScreenRendering(1);
  this->Window->AddRenderer(this->Renderer);
  this->Window->SetSize(width, height);
  this->Renderer->SetBackground(0.1, 0.2, 0.4);
  this->Windows->SetRenderWindow(this->Window);
  this->Windows->SetParallelController(GetController());
  static int identifier = 100;
  this->Windows->SetIdentifier(++identifier);
  this->Renderers->SetRenderPass(nullptr);
  this->Renderers->SetRenderer(this->Renderer);
  this->Renderers->SetParallelController(GetController());
  this->Renderers->SetTileDimensions(columns, rows);
  this->Renderers->FixBackgroundOn();
}

RankWindow::~RankWindow()
{
  this->Renderers->SetRenderer(nullptr);
  this->Windows->SetRenderWindow(nullptr);
  this->Windows->SetParallelController(nullptr);
}

void RankWindow::SetScene(const Scene& scene)
{
  this->Renderer->RemoveAllViewProps();
  for (const auto& actor : scene.Make(GetRank(), GetNumberOfRanks()))
  {
    this->Renderer->AddActor(actor);
  }
}

namespace
{
void PlaceCamera(vtkRenderer* renderer, const CameraPlace& place)
{
  vtkCamera* camera = renderer->GetActiveCamera();
  camera->SetPosition(place.Position.data());
  camera->SetFocalPoint(place.FocalPoint.data());
  camera->SetViewUp(0, 1, 0);
  camera->SetViewAngle(place.ViewAngle);
  camera->SetParallelProjection(place.ParallelScale > 0 ? 1 : 0);
  camera->SetParallelScale(place.ParallelScale > 0 ? place.ParallelScale : 1);
  camera->SetClippingRange(place.ClippingRange.data());
}
} // namespace

void RankWindow::SetCamera(const CameraPlace& camera)
{
  PlaceCamera(this->Renderer, camera);
}

vtkIceTCompositePass* RankWindow::GetIceTPass()
{
  return this->Renderers->GetIceTCompositePass();
}

vtkMetabufferPass* RankWindow::GetPass()
{
  return vtkMetabufferPass::SafeDownCast(this->Renderers->GetIceTCompositePass());
}

void RankWindow::SetRenderPass(vtkRenderPass* pass)
{
  this->Renderers->SetRenderPass(pass);
}

std::vector<std::uint32_t> RankWindow::GetShownColors()
{
  const int* size = this->Window->GetActualSize();
  vtkNew<vtkUnsignedCharArray> colors;
  this->Window->GetRGBACharPixelData(0, 0, size[0] - 1, size[1] - 1, 1, colors);
  std::vector<std::uint32_t> shown(static_cast<std::size_t>(colors->GetNumberOfTuples()));
  std::memcpy(shown.data(), colors->GetPointer(0), sizeof(std::uint32_t) * shown.size());
  return shown;
}

Image RankWindow::Render()
{
  if (GetNumberOfRanks() == 1)
  {
    this->Window->Render();
  }
  else if (GetRank() == 0)
  {
    this->Window->Render();
    GetController()->TriggerBreakRMIs();
  }
  else
  {
    GetController()->ProcessRMIs();
  }
  GetController()->Barrier();

  Image image;
  vtkSynchronizedRenderers::vtkRawImage tile;
  this->Renderers->GetIceTCompositePass()->GetLastRenderedTile(tile);
  if (tile.IsValid())
  {
    image.Width = tile.GetWidth();
    image.Height = tile.GetHeight();
    const std::size_t pixels =
      static_cast<std::size_t>(image.Width) * static_cast<std::size_t>(image.Height);
    image.Colors.resize(pixels);
    std::memcpy(image.Colors.data(), tile.GetRawPtr()->GetPointer(0), 4 * pixels);
    if (vtkFloatArray* depths = this->Renderers->GetIceTCompositePass()->GetLastRenderedDepths())
    {
      image.Depths.assign(
        depths->GetPointer(0), depths->GetPointer(0) + depths->GetNumberOfTuples());
    }
  }
  return image;
}

Image RenderAlone(const std::vector<vtkSmartPointer<vtkActor>>& actors, const CameraPlace& camera,
  int width, int height)
{
  // One window for all calls: to make one, with its shaders, takes longer than the images.
  static vtkSmartPointer<vtkRenderWindow> window;
  static vtkSmartPointer<vtkRenderer> renderer;
  if (!window)
  {
    window = vtkSmartPointer<vtkRenderWindow>::New();
    renderer = vtkSmartPointer<vtkRenderer>::New();
    window->SetMultiSamples(0);
    window->SetOffScreenRendering(1);
    window->SetAlphaBitPlanes(1);
    window->AddRenderer(renderer);
  }
  window->SetSize(width, height);
  renderer->RemoveAllViewProps();
  for (const auto& actor : actors)
  {
    renderer->AddActor(actor);
  }
  PlaceCamera(renderer, camera);
  window->Render();
  Image image;
  image.Width = width;
  image.Height = height;
  vtkNew<vtkUnsignedCharArray> colors;
  vtkNew<vtkFloatArray> depths;
  window->GetRGBACharPixelData(0, 0, width - 1, height - 1, 0, colors);
  window->GetZbufferData(0, 0, width - 1, height - 1, depths);
  const std::size_t pixels = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  image.Colors.resize(pixels);
  std::memcpy(image.Colors.data(), colors->GetPointer(0), 4 * pixels);
  image.Depths.assign(depths->GetPointer(0), depths->GetPointer(0) + pixels);
  return image;
}

} // namespace isosurface
