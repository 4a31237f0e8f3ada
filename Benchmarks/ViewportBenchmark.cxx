// SPDX-License-Identifier: BSD-3-Clause
// Frames of ranks that draw viewports beside frames of stock compositing, by turns in one run.
// Every rank draws its share of many balls while the camera turns around them. Run it under
// mpiexec.
//
// A frame is split into: render, the slowest rank's, until its picture is there; read, the slowest
// rank's reading back; deliver, of the merged picture to the root's window, VTK's showing of it
// included; composite, all else: merging, sending, waiting for each other, clearing.
#include "vtkActor.h"
#include "vtkAppendPolyData.h"
#include "vtkCallbackCommand.h"
#include "vtkCamera.h"
#include "vtkCommand.h"
#include "vtkIceTCompositePass.h"
#include "vtkIceTSynchronizedRenderers.h"
#include "vtkMPIController.h"
#include "vtkMetabufferPass.h"
#include "vtkMetabufferSynchronizedRenderers.h"
#include "vtkNew.h"
#include "vtkObjectFactory.h"
#include "vtkPVDefaultPass.h"
#include "vtkPolyData.h"
#include "vtkPolyDataMapper.h"
#include "vtkRenderWindow.h"
#include "vtkRenderer.h"
#include "vtkSmartPointer.h"
#include "vtkSphereSource.h"
#include "vtkSynchronizedRenderWindows.h"
#include "vtkTimerLog.h"
#include "vtk_glew.h"

#include <CLI/CLI.hpp>
#include <IceT.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <functional>
#include <random>
#include <string>
#include <vector>

namespace
{

struct Options
{
  int Width = 1280;
  int Height = 720;
  int Balls = 2000;
  int Frames = 10;
  std::string Layout = "compact";
  std::string Only;
};

/// Draws, and takes the time until the picture is there.
class TimedPass : public vtkRenderPass
{
public:
  static TimedPass* New();
  vtkTypeMacro(TimedPass, vtkRenderPass);
  void Render(const vtkRenderState* state) override
  {
    const double begin = vtkTimerLog::GetUniversalTime();
    this->Inner->Render(state);
    glFinish();
    this->Seconds += vtkTimerLog::GetUniversalTime() - begin;
  }
  double TakeSeconds() { return std::exchange(this->Seconds, 0.0); }

private:
  vtkNew<vtkPVDefaultPass> Inner;
  double Seconds = 0;
};
vtkStandardNewMacro(TimedPass);

using Center = std::array<double, 3>;

/// Who owns which ball: at random, or parts of equal numbers cut across x, y and z by turns.
std::vector<int> ShareOut(const std::vector<Center>& centers, int ranks, bool isCompact)
{
  std::vector<int> owners(centers.size());
  std::vector<std::size_t> order(centers.size());
  for (std::size_t ball = 0; ball < centers.size(); ++ball)
  {
    owners[ball] = static_cast<int>(ball % static_cast<std::size_t>(ranks));
    order[ball] = ball;
  }
  std::function<void(std::size_t, std::size_t, int, int, std::size_t)> cut =
    [&](std::size_t begin, std::size_t end, int first, int count, std::size_t axis)
  {
    if (count == 1)
    {
      for (std::size_t index = begin; index < end; ++index)
      {
        owners[order[index]] = first;
      }
      return;
    }
    const std::size_t middle =
      begin + (end - begin) * static_cast<std::size_t>(count / 2) / static_cast<std::size_t>(count);
    const auto at = [&order](std::size_t index)
    { return order.begin() + static_cast<std::ptrdiff_t>(index); };
    std::nth_element(at(begin), at(middle), at(end),
      [&](std::size_t a, std::size_t b) { return centers[a][axis] < centers[b][axis]; });
    cut(begin, middle, first, count / 2, (axis + 1) % 3);
    cut(middle, end, first + count / 2, count - count / 2, (axis + 1) % 3);
  };
  if (isCompact)
  {
    cut(0, centers.size(), 0, ranks, 0);
  }
  return owners;
}

vtkSmartPointer<vtkActor> MakeShare(const Options& options, int rank, int ranks)
{
  std::mt19937 random(42);
  std::uniform_real_distribution<double> place(0, 1);
  std::vector<Center> centers(static_cast<std::size_t>(options.Balls));
  for (Center& center : centers)
  {
    center = { place(random), place(random), place(random) };
  }
  const std::vector<int> owners = ShareOut(centers, ranks, options.Layout == "compact");
  vtkNew<vtkAppendPolyData> append;
  append->AddInputData(vtkNew<vtkPolyData>());
  for (std::size_t ball = 0; ball < centers.size(); ++ball)
  {
    if (owners[ball] == rank)
    {
      vtkNew<vtkSphereSource> sphere;
      sphere->SetCenter(centers[ball].data());
      sphere->SetRadius(0.02);
      sphere->SetThetaResolution(24);
      sphere->SetPhiResolution(24);
      sphere->Update();
      append->AddInputData(sphere->GetOutput());
    }
  }
  vtkNew<vtkPolyDataMapper> mapper;
  mapper->SetInputConnection(append->GetOutputPort());
  auto actor = vtkSmartPointer<vtkActor>::New();
  actor->SetMapper(mapper);
  return actor;
}

/// One way to make the frames, with what they cost. Times are of the slowest rank, counts of all.
struct Way
{
  std::string Name;
  int CompositeMode = -1; ///< of vtkMetabufferPass; -1: stock
  int Divisor = 1;
  double RenderSeconds = 0;
  double ReadSeconds = 0;
  double DeliverSeconds = 0;
  double FrameSeconds = 0;
  double DrawnPixels = 0;
  double BytesSent = 0;
};

class Display
{
public:
  Display(vtkMPIController* controller, const Options& options, bool isStock)
    : Controller(controller)
  {
    this->Renderers = isStock ? vtkSmartPointer<vtkIceTSynchronizedRenderers>::New()
                              : vtkSmartPointer<vtkIceTSynchronizedRenderers>(
                                  vtkSmartPointer<vtkMetabufferSynchronizedRenderers>::New());
    this->Window->SetMultiSamples(0);
    this->Window->SetOffScreenRendering(1);
    this->Window->SetSize(options.Width, options.Height);
    this->Window->AddRenderer(this->Renderer);
    this->Windows->SetRenderWindow(this->Window);
    this->Windows->SetParallelController(controller);
    this->Windows->SetIdentifier(isStock ? 1 : 2);
    this->Renderers->SetRenderPass(this->Pass);
    this->Renderers->SetRenderer(this->Renderer);
    this->Renderers->SetParallelController(controller);
    this->Renderers->FixBackgroundOn();
    // Before the synchronizer, which delivers.
    this->EndOfPasses->SetClientData(&this->BeginOfDelivery);
    this->EndOfPasses->SetCallback(
      [](vtkObject*, unsigned long, void* time, void*)
      {
        glFinish();
        *static_cast<double*>(time) = vtkTimerLog::GetUniversalTime();
      });
    this->Renderer->AddObserver(vtkCommand::EndEvent, this->EndOfPasses, 1);
  }
  vtkRenderer* GetRenderer() { return this->Renderer; }

  void DrawFrame(Way& way)
  {
    auto* pass = vtkMetabufferPass::SafeDownCast(this->Renderers->GetIceTCompositePass());
    if (pass)
    {
      pass->SetCompositeMode(way.CompositeMode);
      pass->SetDivisor(0, way.Divisor);
      pass->CollectDepthsOff();
    }
    this->Controller->Barrier();
    const double begin = vtkTimerLog::GetUniversalTime();
    if (this->Controller->GetLocalProcessId() == 0)
    {
      this->Window->Render();
      this->Controller->TriggerBreakRMIs();
    }
    else
    {
      this->Controller->ProcessRMIs();
    }
    const double end = vtkTimerLog::GetUniversalTime();
    this->Controller->Barrier();
    std::array<double, 4> seconds = { this->Pass->TakeSeconds(), 0,
      this->Controller->GetLocalProcessId() == 0 ? end - this->BeginOfDelivery : 0,
      vtkTimerLog::GetUniversalTime() - begin };
    std::array<double, 2> counts{};
    if (pass)
    {
      seconds[1] = pass->GetFrameCost().ReadSeconds;
      counts = { static_cast<double>(pass->GetFrameCost().DrawnPixels),
        static_cast<double>(pass->GetFrameCost().BytesSent) };
    }
    else
    {
      IceTInt bytes = 0;
      icetGetIntegerv(ICET_BYTES_SENT, &bytes);
      icetGetDoublev(ICET_BUFFER_READ_TIME, &seconds[1]);
      const int* size = this->Window->GetActualSize();
      counts = { seconds[0] > 0 ? static_cast<double>(size[0]) * size[1] : 0,
        static_cast<double>(bytes) };
    }
    std::array<double, 4> slowest{};
    std::array<double, 2> all{};
    this->Controller->AllReduce(seconds.data(), slowest.data(), 4, vtkCommunicator::MAX_OP);
    this->Controller->AllReduce(counts.data(), all.data(), 2, vtkCommunicator::SUM_OP);
    way.RenderSeconds += slowest[0];
    way.ReadSeconds += slowest[1];
    way.DeliverSeconds += slowest[2];
    way.FrameSeconds += slowest[3];
    way.DrawnPixels += all[0];
    way.BytesSent += all[1];
  }

private:
  vtkMPIController* Controller;
  vtkNew<vtkRenderWindow> Window;
  vtkNew<vtkRenderer> Renderer;
  vtkNew<TimedPass> Pass;
  vtkNew<vtkCallbackCommand> EndOfPasses;
  double BeginOfDelivery = 0;
  vtkNew<vtkSynchronizedRenderWindows> Windows;
  vtkSmartPointer<vtkIceTSynchronizedRenderers> Renderers;
};

void PlaceCamera(vtkRenderer* renderer, int frame)
{
  vtkCamera* camera = renderer->GetActiveCamera();
  camera->SetFocalPoint(0.5, 0.5, 0.5);
  camera->SetPosition(2.0, 1.5, 2.6);
  camera->SetViewUp(0, 1, 0);
  camera->SetViewAngle(30);
  camera->Azimuth(7 * frame);
  camera->SetClippingRange(0.5, 6);
}

void PrintTable(const std::vector<Way>& ways, const Options& options, int ranks)
{
  std::printf(
    "%d x %d, %d ranks, %s\n", options.Width, options.Height, ranks, options.Layout.c_str());
  std::printf("%-16s %8s %8s %10s %8s %8s %12s %12s\n", "way", "render", "read", "composite",
    "deliver", "frame ms", "pixels drawn", "bytes sent");
  const double toMilliseconds = 1e3 / options.Frames;
  for (const Way& way : ways)
  {
    std::printf("%-16s %8.1f %8.1f %10.1f %8.1f %8.1f %12.0f %12.0f\n", way.Name.c_str(),
      toMilliseconds * way.RenderSeconds, toMilliseconds * way.ReadSeconds,
      toMilliseconds *
        (way.FrameSeconds - way.RenderSeconds - way.ReadSeconds - way.DeliverSeconds),
      toMilliseconds * way.DeliverSeconds, toMilliseconds * way.FrameSeconds,
      way.DrawnPixels / options.Frames, way.BytesSent / options.Frames);
  }
}

void Run(vtkMPIController* controller, const Options& options)
{
  const int ranks = controller->GetNumberOfProcesses();
  Display stock(controller, options, true);
  Display ours(controller, options, false);
  // Each its own: a mapper that two windows show loads its data into them by turns.
  stock.GetRenderer()->AddActor(MakeShare(options, controller->GetLocalProcessId(), ranks));
  ours.GetRenderer()->AddActor(MakeShare(options, controller->GetLocalProcessId(), ranks));
  std::vector<Way> ways = { { "stock" }, { "direct send", vtkMetabufferPass::DIRECT_SEND },
    { "IceT", vtkMetabufferPass::ICET }, { "direct send 1/2", vtkMetabufferPass::DIRECT_SEND, 2 },
    { "direct send 1/4", vtkMetabufferPass::DIRECT_SEND, 4 } };
  if (!options.Only.empty())
  {
    ways.erase(std::remove_if(ways.begin(), ways.end(),
                 [&](const Way& way) { return way.Name != options.Only; }),
      ways.end());
  }
  // The first frames, which fill buffers and compile shaders, do not count.
  for (int frame = -1; frame < options.Frames; ++frame)
  {
    for (Way& way : ways)
    {
      Display& display = way.CompositeMode < 0 ? stock : ours;
      PlaceCamera(display.GetRenderer(), frame);
      Way ignored = way;
      display.DrawFrame(frame < 0 ? ignored : way);
    }
  }
  if (controller->GetLocalProcessId() == 0)
  {
    PrintTable(ways, options, ranks);
  }
}

} // namespace

int main(int argc, char** argv)
{
  vtkNew<vtkMPIController> controller;
  controller->Initialize(&argc, &argv);
  vtkMultiProcessController::SetGlobalController(controller);
  Options options;
  CLI::App application{ "Frames of viewports beside those of stock compositing" };
  application.add_option("--width", options.Width, "Pixels of the display");
  application.add_option("--height", options.Height, "Pixels of the display");
  application.add_option("--balls", options.Balls, "Balls in all; 1,104 triangles each");
  application.add_option("--frames", options.Frames, "Frames of each way");
  application.add_option("--layout", options.Layout, "How balls are dealt out to ranks")
    ->check(CLI::IsMember({ "compact", "random" }));
  application.add_option("--only", options.Only, "The one way to make frames; all without it");
  CLI11_PARSE(application, argc, argv);
  Run(controller, options);
  vtkMultiProcessController::SetGlobalController(nullptr);
  controller->Finalize();
  return 0;
}
