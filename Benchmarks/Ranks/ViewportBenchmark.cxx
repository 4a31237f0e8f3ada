// SPDX-License-Identifier: BSD-3-Clause
// Compares frames of ranks that draw viewports with frames of stock compositing, in one run. Every
// rank draws some of many balls while the camera turns around them. Run it under mpiexec.
//
// The steps of a frame: render, the slowest rank's, until its image is there; read, the slowest
// rank's reading back; deliver, from the merged image to the root's shown window; composite, all
// else: merging, sending, waiting for each other, clearing.
//
// Where there are more ranks than cores, some ranks render while others wait. With --apart no rank
// goes on before all have rendered, and waiting ranks sleep. "after" is the time from then to the
// end of the frame, "work" the processor time in it, summed over all ranks.
//
// "background 1/4" are frames in which the nearer half of the ranks draws each pixel, the others one
// sample for 4 x 4 pixels. dB is the peak signal to noise ratio of red, green and blue, compared with
// full resolution. With --budget there is one way only, along a path with two jumps.
#include "BallScene.h"
#include "PatientMpi.h"
#include "TimedDisplay.h"

#include "vtkActor.h"
#include "vtkCamera.h"
#include "vtkMPIController.h"
#include "vtkMetabufferPass.h"
#include "vtkNew.h"
#include "vtkRenderer.h"

#include <CLI/CLI.hpp>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <numeric>
#include <string>
#include <vector>

namespace
{

struct Options
{
  int Width = 1280;
  int Height = 720;
  BallScene Scene;
  int Frames = 10;
  double Budget = 0; ///< seconds of a frame; 0: none
  std::string Only;
  bool IsApart = false;
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
    "%d x %d, %d ranks, %s\n", options.Width, options.Height, ranks, options.Scene.Layout.c_str());
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

// The sum of squared differences of red, green and blue.
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

void RunWays(
  TimedDisplay& stock, TimedDisplay& ours, const Options& options, vtkMPIController* controller)
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
  // Frame -1, which fills buffers and compiles shaders, does not count.
  for (int frame = -1; frame < options.Frames; ++frame)
  {
    for (Way& way : ways)
    {
      TimedDisplay& display = way.CompositeMode < 0 ? stock : ours;
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

// The distance on a path that goes nearer and away, with jumps at one and two thirds of it.
double GetPathZoom(int frame, int frames)
{
  const double wave = 1 + 0.35 * std::sin(0.09 * frame);
  return 3 * frame < frames ? wave : 3 * frame < 2 * frames ? 0.45 * wave : 1.6 * wave;
}

// Prints how long frames took, and at which resolutions ranks drew.
void PrintBudget(const std::vector<double>& seconds, const std::map<int, int>& divisors,
  const Options& options, int ranks)
{
  std::vector<double> sorted = seconds;
  std::sort(sorted.begin(), sorted.end());
  const auto within = std::count_if(sorted.begin(), sorted.end(),
    [&options](double frame) { return frame <= 1.1 * options.Budget; });
  std::printf("%d x %d, %d ranks, %s, budget %.0f ms: %.1f %% of %d frames within 1.1 times\n",
    options.Width, options.Height, ranks, options.Scene.Layout.c_str(), 1e3 * options.Budget,
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

void RunBudget(TimedDisplay& ours, const Options& options, vtkMPIController* controller)
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
  TimedDisplay stock(controller, options.Width, options.Height, true, options.IsApart);
  TimedDisplay ours(controller, options.Width, options.Height, false, options.IsApart);
  // A mapper for each window: a shared one would load its data anew for each frame.
  stock.GetRenderer()->AddActor(MakeBalls(options.Scene, controller->GetLocalProcessId(), ranks));
  ours.GetRenderer()->AddActor(MakeBalls(options.Scene, controller->GetLocalProcessId(), ranks));
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
  application.add_option("--balls", options.Scene.Balls, "Balls in all; 1,104 triangles each");
  application.add_option("--frames", options.Frames, "Frames of each way");
  application.add_option("--layout", options.Scene.Layout, "How balls are dealt out to ranks")
    ->check(CLI::IsMember({ "compact", "random", "layers" }));
  application.add_option("--radius", options.Scene.Radius, "Radius of a ball, in a cube of 1");
  application.add_option("--budget", options.Budget, "Seconds that a frame may take, along a path");
  application.add_option("--only", options.Only, "The only way to make frames; default: all");
  application.add_flag(
    "--apart", options.IsApart, "No rank goes on before all have rendered; waiting ranks sleep");
  CLI11_PARSE(application, argc, argv);
  WaitPatiently(options.IsApart);
  Run(controller, options);
  vtkMultiProcessController::SetGlobalController(nullptr);
  controller->Finalize();
  return 0;
}
