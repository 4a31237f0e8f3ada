// SPDX-License-Identifier: BSD-3-Clause
// Compares frames of an isosurface that ranks have parts of: stock compositing, viewports in which each
// rank leaves out what is hidden by its own triangles, and viewports in which the ranks share depths. All
// in one run, under mpiexec. The camera turns by some degrees between frames.
#include "PatientMpi.h"
#include "TimedDisplay.h"

#include "vtkActor.h"
#include "vtkBlockedVolumeReader.h"
#include "vtkCamera.h"
#include "vtkDistributeIsosurface.h"
#include "vtkIsosurfaceMapper.h"
#include "vtkMPIController.h"
#include "vtkMetabufferPass.h"
#include "vtkMetabufferSynchronizedRenderers.h"
#include "vtkNew.h"
#include "vtkPolyData.h"
#include "vtkRenderer.h"
#include "vtkStabbingContour.h"

#include <CLI/CLI.hpp>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdio>
#include <string>
#include <vector>

namespace
{

struct Options
{
  std::string Volume;
  double Isovalue = 0;
  bool IsDistributed = false;
  int Width = 1280;
  int Height = 800;
  int Frames = 10;
  double Degrees = 5;
  double Zoom = 1;
};

/// This rank's part of the surface. Collective.
vtkSmartPointer<vtkPolyData> MakeSurface(const Options& options, vtkMPIController* ranks)
{
  vtkNew<vtkBlockedVolumeReader> reader;
  reader->SetController(ranks);
  reader->SetFileName(options.Volume.c_str());
  vtkNew<vtkStabbingContour> contour;
  contour->SetController(ranks);
  contour->SetInputConnection(reader->GetOutputPort());
  contour->SetValue(0, options.Isovalue);
  vtkNew<vtkDistributeIsosurface> distribution;
  distribution->SetController(ranks);
  distribution->SetInputConnection(contour->GetOutputPort());
  vtkPolyDataAlgorithm* last = contour;
  if (options.IsDistributed)
  {
    last = distribution;
  }
  last->UpdatePiece(ranks->GetLocalProcessId(), ranks->GetNumberOfProcesses(), 0);
  return last->GetOutput();
}

/// The bounds of all ranks' parts. Collective.
std::array<double, 6> FindBounds(vtkPolyData* surface, vtkMPIController* ranks)
{
  std::array<double, 6> mine = { VTK_DOUBLE_MAX, VTK_DOUBLE_MAX, VTK_DOUBLE_MAX, VTK_DOUBLE_MAX,
    VTK_DOUBLE_MAX, VTK_DOUBLE_MAX };
  if (surface->GetNumberOfPoints() > 0)
  {
    surface->GetBounds(mine.data());
    for (const std::size_t maximum : { 1, 3, 5 })
    {
      mine[maximum] = -mine[maximum]; // so that all six are minima
    }
  }
  std::array<double, 6> all{};
  ranks->AllReduce(mine.data(), all.data(), 6, vtkCommunicator::MIN_OP);
  for (const std::size_t maximum : { 1, 3, 5 })
  {
    all[maximum] = -all[maximum];
  }
  return all;
}

/// One way to make frames, in a window of its own, because a mapper knows what it drew before.
class SurfaceDisplay
{
public:
  SurfaceDisplay(const std::string& name, bool isStock, bool isShared, const Options& options,
    vtkPolyData* surface, vtkMPIController* ranks)
    : Display(ranks, options.Width, options.Height, isStock, false)
    , Ranks(ranks)
  {
    this->Total.Name = name;
    this->Total.CompositeMode = isStock ? -1 : vtkMetabufferPass::DIRECT_SEND;
    this->Total.SharesDepths = isShared;
    this->Mapper->SetInputDataObject(surface);
    this->Mapper->ScalarVisibilityOff();
    vtkNew<vtkActor> actor;
    actor->SetMapper(this->Mapper);
    this->Display.GetRenderer()->AddActor(actor);
    const std::array<double, 6> bounds = FindBounds(surface, ranks);
    vtkRenderer* renderer = this->Display.GetRenderer();
    renderer->ResetCamera(bounds.data());
    renderer->GetActiveCamera()->Zoom(options.Zoom);
    renderer->ResetCameraClippingRange(bounds.data());
    this->Bounds = bounds;
  }

  /// Collective.
  void Draw(bool isCounted)
  {
    Way ignored = this->Total;
    this->Display.DrawFrame(isCounted ? this->Total : ignored);
    const auto mine = static_cast<double>(this->Mapper->GetNumberOfDrawnTriangles());
    double all = 0;
    this->Ranks->AllReduce(&mine, &all, 1, vtkCommunicator::SUM_OP);
    this->Triangles += isCounted ? all : 0;
  }
  void Turn(double degrees)
  {
    vtkRenderer* renderer = this->Display.GetRenderer();
    renderer->GetActiveCamera()->Azimuth(degrees);
    renderer->ResetCameraClippingRange(this->Bounds.data());
  }

  TimedDisplay Display;
  Way Total;
  double Triangles = 0;      ///< that were drawn
  std::size_t Different = 0; ///< pixels, beside stock compositing

private:
  vtkMPIController* Ranks;
  vtkNew<vtkIsosurfaceMapper> Mapper;
  std::array<double, 6> Bounds{};
};

std::size_t CountDifferent(
  const std::vector<unsigned char>& image, const std::vector<unsigned char>& expected)
{
  std::size_t count = image.size() == expected.size() ? 0 : 1;
  for (std::size_t pixel = 0; 4 * pixel < std::min(image.size(), expected.size()); ++pixel)
  {
    const auto place = static_cast<std::ptrdiff_t>(4 * pixel);
    count += std::equal(image.begin() + place, image.begin() + place + 4, expected.begin() + place)
      ? 0
      : 1;
  }
  return count;
}

void Run(vtkMPIController* ranks, const Options& options)
{
  const vtkSmartPointer<vtkPolyData> surface = MakeSurface(options, ranks);
  std::array<SurfaceDisplay, 3> ways = {
    SurfaceDisplay("stock", true, false, options, surface, ranks),
    SurfaceDisplay("each rank alone", false, false, options, surface, ranks),
    SurfaceDisplay("shared depths", false, true, options, surface, ranks),
  };
  // The first two frames fill buffers, and tell the mappers what is visible.
  for (int frame = -2; frame < options.Frames; ++frame)
  {
    for (SurfaceDisplay& way : ways)
    {
      way.Draw(frame >= 0);
      way.Different += CountDifferent(way.Display.GetImage(), ways[0].Display.GetImage());
      way.Turn(options.Degrees);
    }
  }
  const auto mine = static_cast<double>(surface->GetNumberOfPolys());
  double all = 0;
  ranks->AllReduce(&mine, &all, 1, vtkCommunicator::SUM_OP);
  if (ranks->GetLocalProcessId() != 0)
  {
    return;
  }
  std::printf("%d x %d, %d ranks, %.0f triangles%s\n%-16s %9s %9s %6s %10s %10s\n", options.Width,
    options.Height, ranks->GetNumberOfProcesses(), all,
    options.IsDistributed ? " in compact pieces" : "", "way", "render ms", "frame ms", "ratio",
    "triangles", "different");
  for (const SurfaceDisplay& way : ways)
  {
    std::printf("%-16s %9.0f %9.0f %6.2f %9.1f%% %10zu\n", way.Total.Name.c_str(),
      1e3 * way.Total.RenderSeconds / options.Frames, 1e3 * way.Total.FrameSeconds / options.Frames,
      way.Total.FrameSeconds / ways[0].Total.FrameSeconds,
      100 * way.Triangles / (all * options.Frames), way.Different);
  }
}

} // namespace

int main(int argc, char** argv)
{
  vtkNew<vtkMPIController> controller;
  controller->Initialize(&argc, &argv);
  vtkMultiProcessController::SetGlobalController(controller);
  Options options;
  CLI::App application{ "Frames of a surface whose ranks leave out hidden triangles" };
  application.add_option("volume", options.Volume, "A blocked volume")->required();
  application.add_option("--isovalue", options.Isovalue, "Of the surface")->required();
  application.add_flag("--distributed", options.IsDistributed, "A compact piece for each rank");
  application.add_option("--width", options.Width, "Pixels of the display");
  application.add_option("--height", options.Height, "Pixels of the display");
  application.add_option("--frames", options.Frames, "Frames of each way");
  application.add_option("--degrees", options.Degrees, "The camera's turn between frames");
  application.add_option("--zoom", options.Zoom, "How much larger than the whole surface");
  CLI11_PARSE(application, argc, argv);
  WaitPatiently(true);
  Run(controller, options);
  vtkMultiProcessController::SetGlobalController(nullptr);
  controller->Finalize();
  return 0;
}
