// SPDX-License-Identifier: BSD-3-Clause
// Frames of ranks that draw viewports beside frames of stock compositing, by turns in one run.
// Every rank draws its share of many balls while the camera turns around them. Run it under
// mpiexec.
//
// A frame is split into: render, the slowest rank's, until its image is there; read, the slowest
// rank's reading back; deliver, of the merged image to the root's window, VTK's showing of it
// included; composite, all else: merging, sending, waiting for each other, clearing.
//
// Where there are more ranks than cores, some render while others wait to be read back. With
// --apart no rank goes on before all have rendered, and ranks sleep while they wait: "after" is the
// time from then to the end of the frame, "work" the milliseconds that the processors worked for
// it, summed over all ranks, which do not depend on who waits for whom.
//
// "background 1/4" are frames in which the nearer half of the ranks draws each pixel, the others a
// sample for 4 x 4; beside it, how close the image is to the full one (peak signal to noise ratio
// of red, green and blue). With --budget there is one way only, along a path with two jumps.
#include "PatientMpi.h"

#include "vtkActor.h"
#include "vtkActorCollection.h"
#include "vtkAppendPolyData.h"
#include "vtkCallbackCommand.h"
#include "vtkCamera.h"
#include "vtkCommand.h"
#include "vtkIceTCompositePass.h"
#include "vtkIceTSynchronizedRenderers.h"
#include "vtkMPIController.h"
#include "vtkMath.h"
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
#include "vtkUnsignedCharArray.h"
#include "vtk_glew.h"

#include <CLI/CLI.hpp>
#include <IceT.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <functional>
#include <map>
#include <numeric>
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
  double Radius = 0.02;
  double Budget = 0; ///< seconds of a frame; 0: none
  std::string Only;
  bool IsApart = false;
};

/// Seconds of the clock on the wall, and those that this rank's threads worked.
struct Clocks
{
  double Wall = 0;
  double Work = 0;

  static Clocks Read()
  {
    return { vtkTimerLog::GetUniversalTime(), static_cast<double>(std::clock()) / CLOCKS_PER_SEC };
  }
};

/// Draws, and takes the time until the image is there.
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
    if (this->Controller)
    {
      this->Controller->Barrier();
    }
    this->End = Clocks::Read();
  }
  /// Waits for all ranks in the end; null (the default): does not.
  void SetController(vtkMultiProcessController* controller) { this->Controller = controller; }
  double TakeSeconds() { return std::exchange(this->Seconds, 0.0); }
  /// When the last image was there; on all ranks, if there is a controller.
  const Clocks& GetEnd() const { return this->End; }

private:
  vtkNew<vtkPVDefaultPass> Inner;
  vtkMultiProcessController* Controller = nullptr;
  double Seconds = 0;
  Clocks End;
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

// Parts of equal numbers, one behind the other as the first camera sees them.
std::vector<int> ShareOutInLayers(const std::vector<Center>& centers, int ranks)
{
  std::vector<std::size_t> order(centers.size());
  std::iota(order.begin(), order.end(), 0U);
  const auto depth = [&centers](std::size_t ball)
  { return 1.5 * centers[ball][0] + centers[ball][1] + 2.1 * centers[ball][2]; };
  std::sort(
    order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return depth(a) > depth(b); });
  std::vector<int> owners(centers.size());
  for (std::size_t index = 0; index < order.size(); ++index)
  {
    owners[order[index]] = static_cast<int>(index * static_cast<std::size_t>(ranks) / order.size());
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
  const std::vector<int> owners = options.Layout == "layers"
    ? ShareOutInLayers(centers, ranks)
    : ShareOut(centers, ranks, options.Layout == "compact");
  vtkNew<vtkAppendPolyData> append;
  append->AddInputData(vtkNew<vtkPolyData>());
  for (std::size_t ball = 0; ball < centers.size(); ++ball)
  {
    if (owners[ball] == rank)
    {
      vtkNew<vtkSphereSource> sphere;
      sphere->SetCenter(centers[ball].data());
      sphere->SetRadius(options.Radius);
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
  bool HasBackground = false; ///< the divisor is that of the farther half of the ranks only
  double Budget = 0;
  double SquaredError = 0; ///< of colors, to the full image
  double RenderSeconds = 0;
  double ReadSeconds = 0;
  double DeliverSeconds = 0;
  double AfterSeconds = 0;
  double WorkSeconds = 0; ///< of all ranks
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
    this->Pass->SetController(options.IsApart ? controller : nullptr);
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

  /// The root's image without background; empty elsewhere.
  std::vector<unsigned char> GetImage()
  {
    vtkSynchronizedRenderers::vtkRawImage tile;
    this->Renderers->GetIceTCompositePass()->GetLastRenderedTile(tile);
    if (!tile.IsValid())
    {
      return {};
    }
    const unsigned char* bytes = tile.GetRawPtr()->GetPointer(0);
    return { bytes, bytes + std::size_t{ 4 } * tile.GetWidth() * tile.GetHeight() };
  }

  /// Of a rank in the last frame; 0 if it drew nothing.
  int GetDivisor(int rank)
  {
    std::array<int, 5> viewport{};
    vtkMetabufferPass::SafeDownCast(this->Renderers->GetIceTCompositePass())
      ->GetViewport(rank, viewport.data());
    return viewport[4];
  }

  /// Seconds of the frame on the slowest rank.
  double DrawFrame(Way& way)
  {
    auto* pass = vtkMetabufferPass::SafeDownCast(this->Renderers->GetIceTCompositePass());
    if (pass)
    {
      pass->SetCompositeMode(way.CompositeMode);
      this->SetDivisors(pass, way);
      pass->SetFrameTimeBudget(way.Budget);
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
    const Clocks end = Clocks::Read();
    this->Controller->Barrier();
    const Clocks& rendered = this->Pass->GetEnd();
    std::array<double, 5> seconds = { this->Pass->TakeSeconds(), 0,
      this->Controller->GetLocalProcessId() == 0 ? end.Wall - this->BeginOfDelivery : 0,
      vtkTimerLog::GetUniversalTime() - begin, end.Wall - rendered.Wall };
    std::array<double, 3> counts{};
    if (pass)
    {
      seconds[1] = pass->GetReadSeconds();
      counts = { static_cast<double>(pass->GetDrawnPixels()),
        static_cast<double>(pass->GetBytesSent()), 0 };
    }
    else
    {
      IceTInt bytes = 0;
      icetGetIntegerv(ICET_BYTES_SENT, &bytes);
      // Of the callback that draws, which also reads and clears.
      icetGetDoublev(ICET_RENDER_TIME, &seconds[1]);
      seconds[1] = std::max(0.0, seconds[1] - seconds[0]);
      const int* size = this->Window->GetActualSize();
      counts = { seconds[0] > 0 ? static_cast<double>(size[0]) * size[1] : 0,
        static_cast<double>(bytes), 0 };
    }
    counts[2] = end.Work - rendered.Work;
    std::array<double, 5> slowest{};
    std::array<double, 3> all{};
    this->Controller->AllReduce(seconds.data(), slowest.data(), 5, vtkCommunicator::MAX_OP);
    this->Controller->AllReduce(counts.data(), all.data(), 3, vtkCommunicator::SUM_OP);
    way.RenderSeconds += slowest[0];
    way.ReadSeconds += slowest[1];
    way.DeliverSeconds += slowest[2];
    way.FrameSeconds += slowest[3];
    way.AfterSeconds += slowest[4];
    way.WorkSeconds += all[2];
    way.DrawnPixels += all[0];
    way.BytesSent += all[1];
    return slowest[3];
  }

private:
  void SetDivisors(vtkMetabufferPass* pass, const Way& way)
  {
    const int ranks = this->Controller->GetNumberOfProcesses();
    pass->SetNumberOfDivisors(ranks);
    std::vector<double> distances(static_cast<std::size_t>(ranks));
    std::array<double, 3> position{};
    this->Renderer->GetActiveCamera()->GetPosition(position.data());
    // Satellites have the camera of the frame before until this one begins.
    this->Controller->Broadcast(position.data(), 3, 0);
    vtkActor* actor = this->Renderer->GetActors()->GetLastActor();
    const double distance =
      std::sqrt(vtkMath::Distance2BetweenPoints(position.data(), actor->GetCenter()));
    this->Controller->AllGather(&distance, distances.data(), 1);
    std::vector<double> sorted = distances;
    std::sort(sorted.begin(), sorted.end());
    for (int rank = 0; rank < ranks; ++rank)
    {
      const bool isNear = way.HasBackground &&
        distances[static_cast<std::size_t>(rank)] < sorted[static_cast<std::size_t>(ranks / 2)];
      pass->SetDivisor(rank, isNear ? 1 : way.Divisor);
    }
  }

  vtkMPIController* Controller;
  vtkNew<vtkRenderWindow> Window;
  vtkNew<vtkRenderer> Renderer;
  vtkNew<TimedPass> Pass;
  vtkNew<vtkCallbackCommand> EndOfPasses;
  double BeginOfDelivery = 0;
  vtkNew<vtkSynchronizedRenderWindows> Windows;
  vtkSmartPointer<vtkIceTSynchronizedRenderers> Renderers;
};

void PlaceCamera(vtkRenderer* renderer, int frame, double distance)
{
  vtkCamera* camera = renderer->GetActiveCamera();
  camera->SetFocalPoint(0.5, 0.5, 0.5);
  camera->SetPosition(0.5 + 1.5 * distance, 0.5 + distance, 0.5 + 2.1 * distance);
  camera->SetViewUp(0, 1, 0);
  camera->SetViewAngle(30);
  camera->Azimuth(3 * frame);
  camera->SetClippingRange(0.1, 8);
}

void PrintTable(const std::vector<Way>& ways, const Options& options, int ranks)
{
  std::printf(
    "%d x %d, %d ranks, %s\n", options.Width, options.Height, ranks, options.Layout.c_str());
  std::printf("%-16s %8s %8s %10s %8s %8s %12s %12s", "way", "render", "read", "composite",
    "deliver", "frame ms", "pixels drawn", "bytes sent");
  if (options.IsApart)
  {
    std::printf(" %8s %8s", "after", "work");
  }
  std::printf(" %6s\n", "dB");
  const double toMilliseconds = 1e3 / options.Frames;
  for (const Way& way : ways)
  {
    std::printf("%-16s %8.1f %8.1f %10.1f %8.1f %8.1f %12.0f %12.0f", way.Name.c_str(),
      toMilliseconds * way.RenderSeconds, toMilliseconds * way.ReadSeconds,
      toMilliseconds *
        (way.FrameSeconds - way.RenderSeconds - way.ReadSeconds - way.DeliverSeconds),
      toMilliseconds * way.DeliverSeconds, toMilliseconds * way.FrameSeconds,
      way.DrawnPixels / options.Frames, way.BytesSent / options.Frames);
    if (options.IsApart)
    {
      std::printf(
        " %8.1f %8.1f", toMilliseconds * way.AfterSeconds, toMilliseconds * way.WorkSeconds);
    }
    if (way.SquaredError > 0)
    {
      const double samples = 3.0 * options.Width * options.Height * options.Frames;
      std::printf(" %6.1f", 10 * std::log10(255.0 * 255.0 * samples / way.SquaredError));
    }
    std::printf("\n");
  }
}

// Of red, green, blue.
double GetSquaredError(
  const std::vector<unsigned char>& image, const std::vector<unsigned char>& expected)
{
  double sum = 0;
  for (std::size_t byte = 0; byte < std::min(image.size(), expected.size()); ++byte)
  {
    const double difference = byte % 4 == 3 ? 0.0 : image[byte] - expected[byte];
    sum += difference * difference;
  }
  return sum;
}

void RunWays(Display& stock, Display& ours, const Options& options, vtkMPIController* controller)
{
  std::vector<Way> ways = { { "stock" }, { "direct send", vtkMetabufferPass::DIRECT_SEND },
    { "IceT", vtkMetabufferPass::ICET }, { "direct send 1/2", vtkMetabufferPass::DIRECT_SEND, 2 },
    { "direct send 1/4", vtkMetabufferPass::DIRECT_SEND, 4 },
    { "background 1/4", vtkMetabufferPass::DIRECT_SEND, 4, true } };
  if (!options.Only.empty())
  {
    ways.erase(std::remove_if(ways.begin(), ways.end(),
                 [&options](const Way& way) { return way.Name != options.Only; }),
      ways.end());
  }
  std::vector<unsigned char> full;
  // The first frames, which fill buffers and compile shaders, do not count.
  for (int frame = -1; frame < options.Frames; ++frame)
  {
    for (Way& way : ways)
    {
      Display& display = way.CompositeMode < 0 ? stock : ours;
      PlaceCamera(display.GetRenderer(), frame, 1);
      Way ignored = way;
      Way& counted = frame < 0 ? ignored : way;
      display.DrawFrame(counted);
      const std::vector<unsigned char> image = display.GetImage();
      if (way.CompositeMode < 0)
      {
        full = image;
      }
      counted.SquaredError += GetSquaredError(image, full);
    }
  }
  if (controller->GetLocalProcessId() == 0)
  {
    PrintTable(ways, options, controller->GetNumberOfProcesses());
  }
}

// A path that goes nearer and away, with a jump at a third and at two thirds of it.
double GetPathZoom(int frame, int frames)
{
  const double wave = 1 + 0.35 * std::sin(0.09 * frame);
  return 3 * frame < frames ? wave : 3 * frame < 2 * frames ? 0.45 * wave : 1.6 * wave;
}

// How long frames were, and at which resolutions ranks drew.
void PrintBudget(const std::vector<double>& seconds, const std::map<int, int>& divisors,
  const Options& options, int ranks)
{
  std::vector<double> sorted = seconds;
  std::sort(sorted.begin(), sorted.end());
  const auto within = std::count_if(sorted.begin(), sorted.end(),
    [&options](double frame) { return frame <= 1.1 * options.Budget; });
  std::printf("%d x %d, %d ranks, %s, budget %.0f ms: %.1f %% of %d frames within 1.1 times\n",
    options.Width, options.Height, ranks, options.Layout.c_str(), 1e3 * options.Budget,
    100.0 * static_cast<double>(within) / options.Frames, options.Frames);
  std::printf("mean %.1f ms, quantiles",
    1e3 * std::accumulate(sorted.begin(), sorted.end(), 0.0) / options.Frames);
  for (const int percent : { 5, 50, 90, 95, 99 })
  {
    std::printf(" %d %%: %.1f", percent,
      1e3 * sorted[sorted.size() * static_cast<std::size_t>(percent) / 100]);
  }
  std::printf("\nresolutions of ranks:");
  for (const auto& [divisor, count] : divisors)
  {
    std::printf(" 1/%d %.1f %%", divisor, 100.0 * count / (ranks * options.Frames));
  }
  std::printf("\n");
  for (const int jump : { 0, (options.Frames + 2) / 3, (2 * options.Frames + 2) / 3 })
  {
    std::printf("from frame %d on:", jump);
    for (int frame = jump; frame < std::min(jump + 10, options.Frames); ++frame)
    {
      std::printf(" %.0f", 1e3 * seconds[static_cast<std::size_t>(frame)]);
    }
    std::printf(" ms\n");
  }
}

void RunBudget(Display& ours, const Options& options, vtkMPIController* controller)
{
  const int ranks = controller->GetNumberOfProcesses();
  Way way = { "budget", vtkMetabufferPass::DIRECT_SEND };
  PlaceCamera(ours.GetRenderer(), 0, 1);
  ours.DrawFrame(way);
  way.Budget = options.Budget;
  std::vector<double> seconds;
  std::map<int, int> divisors;
  for (int frame = 0; frame < options.Frames; ++frame)
  {
    PlaceCamera(ours.GetRenderer(), frame, GetPathZoom(frame, options.Frames));
    seconds.push_back(ours.DrawFrame(way));
    for (int rank = 0; rank < ranks; ++rank)
    {
      ++divisors[ours.GetDivisor(rank)];
    }
  }
  if (controller->GetLocalProcessId() == 0)
  {
    PrintBudget(seconds, divisors, options, ranks);
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
  if (options.Budget > 0)
  {
    RunBudget(ours, options, controller);
    return;
  }
  RunWays(stock, ours, options, controller);
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
    ->check(CLI::IsMember({ "compact", "random", "layers" }));
  application.add_option("--radius", options.Radius, "Of a ball, in a cube of 1");
  application.add_option("--budget", options.Budget, "Seconds of a frame, to be kept along a path");
  application.add_option("--only", options.Only, "The one way to make frames; all without it");
  application.add_flag(
    "--apart", options.IsApart, "All ranks render, then all go on; waiting ranks sleep");
  CLI11_PARSE(application, argc, argv);
  WaitPatiently(options.IsApart);
  Run(controller, options);
  vtkMultiProcessController::SetGlobalController(nullptr);
  controller->Finalize();
  return 0;
}
