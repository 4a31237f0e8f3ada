// SPDX-License-Identifier: BSD-3-Clause
/**
 * Isosurfaces of a volume in memory: ours beside vtkFlyingEdges3D and the stock contour filter, in
 * one run, on equal threads. For three isovalues, at which about 50 %, 8 % and 2.5 % of the blocks
 * are active, it prints the median seconds, triangles a second and the ratio to ours of
 *
 *   kernel   ExtractSurface alone, points and triangles only (ranges known)
 *   filter   vtkStabbingContour with GlobalIds, the finished vtkPolyData, a new isovalue
 *   first    the same at the first execution, the index of value ranges included
 *   peers    vtkFlyingEdges3D, vtkContourFilter
 */
#include "BenchmarkVolume.h"

#include "vtkContourFilter.h"
#include "vtkFlyingEdges3D.h"
#include "vtkImageData.h"
#include "vtkLogger.h"
#include "vtkNew.h"
#include "vtkPointData.h"
#include "vtkPolyData.h"
#include "vtkSMPTools.h"
#include "vtkStabbingContour.h"
#include "vtkUnsignedShortArray.h"

#include "Contour/BlockRanges.h"
#include "Contour/GridBlockSource.h"
#include "Contour/SurfaceExtractor.h"

#include <CLI/CLI.hpp>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <functional>
#include <string>
#include <vector>

namespace
{

struct Measurement
{
  double Seconds;
  std::size_t Triangles;
};

/// The median time of the repeats; `prepare` is not timed.
Measurement Measure(
  int repeats, const std::function<void()>& prepare, const std::function<std::size_t()>& run)
{
  std::vector<double> seconds;
  std::size_t triangles = 0;
  for (int repeat = 0; repeat < repeats; ++repeat)
  {
    prepare();
    const auto start = std::chrono::steady_clock::now();
    triangles = run();
    seconds.push_back(
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
  }
  std::sort(seconds.begin(), seconds.end());
  return { seconds[seconds.size() / 2], triangles };
}

void Print(const char* name, const Measurement& measurement, const Measurement& ours)
{
  std::printf("  %-28s %9.4f s %12zu triangles %8.1f M/s   x %.2f\n", name, measurement.Seconds,
    measurement.Triangles, static_cast<double>(measurement.Triangles) / measurement.Seconds / 1e6,
    measurement.Seconds / ours.Seconds);
}

/// A stock filter at an isovalue, from its input to its output.
template <typename Filter>
Measurement MeasureStock(vtkImageData* image, double isovalue, int repeats, bool attributes)
{
  vtkNew<Filter> filter;
  filter->SetInputData(image);
  filter->SetComputeNormals(attributes);
  filter->SetComputeScalars(attributes);
  filter->SetValue(0, isovalue);
  return Measure(
    repeats,
    [&]
    {
      filter->Modified();
      filter->GetOutput()->Initialize();
    },
    [&]
    {
      filter->Update();
      return static_cast<std::size_t>(filter->GetOutput()->GetNumberOfPolys());
    });
}

} // namespace

int main(int argc, char** argv)
{
  int side = 768;
  int threads = 1;
  int repeats = 5;
  bool attributes = false;
  CLI::App application("Isosurfaces of a volume in memory, beside VTK's own filters");
  application.add_option("--side", side, "samples along the side of the volume");
  application.add_option("--threads", threads, "threads of each contender");
  application.add_option("--repeats", repeats, "runs of which the median is taken");
  application.add_flag("--attributes", attributes, "with normals and scalars");
  CLI11_PARSE(application, argc, argv);
  vtkLogger::SetStderrVerbosity(vtkLogger::VERBOSITY_WARNING);
  vtkSMPTools::SetBackend("STDThread");
  vtkSMPTools::Initialize(threads);

  std::vector<std::uint16_t> volume = isosurface::MakeBenchmarkVolume(side, 2);
  vtkNew<vtkImageData> image;
  image->SetDimensions(side, side, side);
  vtkNew<vtkUnsignedShortArray> scalars;
  scalars->SetName("waves");
  scalars->SetArray(volume.data(), static_cast<vtkIdType>(volume.size()), 1);
  image->GetPointData()->SetScalars(scalars);
  std::printf("%d^3 uint16, %d thread(s), %s, median of %d\n", side, threads,
    attributes ? "normals and scalars" : "points and triangles only", repeats);

  isosurface::GridGeometry grid;
  grid.Extent = { 0, side - 1, 0, side - 1, 0, side - 1 };
  isosurface::SampleView view;
  view.Type = isosurface::ValueType::UInt16;
  view.First = volume.data();
  view.Stride = { 1, side, static_cast<std::ptrdiff_t>(side) * side };
  view.Box.High = { side, side, side };
  view.Available = view.Box;
  const auto ranges = isosurface::BlockRanges::Compute(view, threads);

  for (const double share : { 0.5, 0.08, 0.025 })
  {
    const double isovalue = isosurface::FindIsovalue(volume, side, share, 2);
    const isosurface::GridBlockSource counted(view, *ranges, { isovalue });
    std::printf("isovalue %.1f: %.1f %% of %lld blocks active\n", isovalue,
      100.0 * static_cast<double>(counted.GetNumberOfBlocks()) /
        static_cast<double>(ranges->GetGrid().GetNumberOfBlocks()),
      static_cast<long long>(ranges->GetGrid().GetNumberOfBlocks()));

    isosurface::ContourRequest request;
    request.Isovalues = { isovalue };
    request.Normals = attributes;
    const Measurement kernel = Measure(
      repeats, [] {},
      [&]
      {
        isosurface::GridBlockSource source(view, *ranges, request.Isovalues);
        return isosurface::ExtractSurface(grid, source, request, threads)->NumberOfTriangles;
      });

    auto runFilter = [&](vtkStabbingContour* filter)
    {
      filter->SetInputData(image);
      filter->SetNumberOfThreads(threads);
      filter->SetComputeNormals(attributes);
      filter->SetComputeScalars(attributes);
      filter->SetValue(0, isovalue);
      filter->Update();
      return static_cast<std::size_t>(filter->GetOutput()->GetNumberOfPolys());
    };
    vtkNew<vtkStabbingContour> kept;
    runFilter(kept);
    const Measurement filter = Measure(
      repeats,
      [&]
      {
        kept->Modified();
        kept->GetOutput()->Initialize();
      },
      [&] { return runFilter(kept); });
    const Measurement first = Measure(
      repeats, [] {},
      [&]
      {
        vtkNew<vtkStabbingContour> fresh;
        return runFilter(fresh);
      });

    Print("ours: kernel", kernel, filter);
    Print("ours: filter", filter, filter);
    Print("ours: filter, first time", first, filter);
    Print("vtkFlyingEdges3D",
      MeasureStock<vtkFlyingEdges3D>(image, isovalue, std::min(repeats, 3), attributes), filter);
    Print("vtkContourFilter",
      MeasureStock<vtkContourFilter>(image, isovalue, std::min(repeats, 3), attributes), filter);
    std::fflush(stdout);
  }
  return 0;
}
