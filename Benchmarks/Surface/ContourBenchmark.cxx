// SPDX-License-Identifier: BSD-3-Clause
/**
 * Compares isosurfaces of volumes in memory with VTK's filters, in one run, on the same number of
 * threads. The volumes are uint16 turbulence, or the point arrays of files. For isovalues at which
 * about 50 %, 8 % and 2.5 % of the blocks are active, it prints the median seconds, triangles a
 * second and the ratio to our filter of
 *
 *   kernel   ExtractSurface alone (ranges known)
 *   filter   vtkStabbingContour with GlobalIds, the complete vtkPolyData, a new isovalue
 *   first    the first execution of the filter, which also computes the value ranges
 *   peers    vtkFlyingEdges3D, vtkSynchronizedTemplates3D, vtkContourFilter; vtkmContour (Viskores)
 *            with ParaView 6
 *   islands  the filter that measures all islands, or keeps the largest;
 *            vtkPolyDataConnectivityFilter alone, on the filter's surface
 */
#include "Volumes/BenchmarkVolume.h"

#include "vtkContourFilter.h"
#include "vtkDataArray.h"
#include "vtkFlyingEdges3D.h"
#include "vtkImageData.h"
#include "vtkLogger.h"
#include "vtkNew.h"
#include "vtkPointData.h"
#include "vtkPolyData.h"
#include "vtkPolyDataConnectivityFilter.h"
#include "vtkSMPTools.h"
#include "vtkSmartPointer.h"
#include "vtkStabbingContour.h"
#include "vtkSynchronizedTemplates3D.h"
#include "vtkUnsignedShortArray.h"
#include "vtkXMLImageDataReader.h"
#if ISOSURFACE_VISKORES
#include "vtkmContour.h"
#endif

#include "ImageSamples.h"
#include "Surface/Contour/BlockRanges.h"
#include "Surface/Contour/GridBlockSource.h"
#include "Surface/Contour/SurfaceExtractor.h"

#include <CLI/CLI.hpp>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <string>
#include <vector>

namespace
{

struct Options
{
  std::vector<std::string> Files;
  std::string Array;
  bool AsFloat = false;
  int Side = 768;
  std::vector<int> Threads = { 1, 2 };
  int Repeats = 5;
  bool Attributes = false;
  bool Slow = false;
  bool Islands = false;
};

struct Measurement
{
  double Seconds;
  std::size_t Triangles;
};

/// The median time of the repeats, without `prepare`.
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
  std::fflush(stdout);
}

/// Measures a filter at an isovalue, from its input to its output.
Measurement MeasureFilter(vtkPolyDataAlgorithm* filter, int repeats)
{
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

template <typename Filter>
Measurement MeasurePeer(vtkImageData* image, double isovalue, const Options& options)
{
  vtkNew<Filter> filter;
  filter->SetInputData(image);
  filter->SetComputeNormals(options.Attributes);
  filter->SetComputeScalars(options.Attributes);
  filter->SetValue(0, isovalue);
  return MeasureFilter(filter, std::min(options.Repeats, 3));
}

vtkSmartPointer<vtkStabbingContour> MakeContour(
  vtkImageData* image, double isovalue, int threads, const Options& options)
{
  auto contour = vtkSmartPointer<vtkStabbingContour>::New();
  contour->SetInputData(image);
  contour->SetNumberOfThreads(threads);
  contour->SetComputeNormals(options.Attributes);
  contour->SetComputeScalars(options.Attributes);
  contour->SetValue(0, isovalue);
  return contour;
}

double GetActiveFraction(const isosurface::BlockRanges& ranges, double isovalue)
{
  return static_cast<double>(ranges.FindActiveBlocks({ isovalue }).size()) /
    static_cast<double>(ranges.GetGrid().GetNumberOfBlocks());
}

/// The isovalue in the range at which the fraction of active blocks is closest to `fraction`.
double FindIsovalue(const isosurface::BlockRanges& ranges, const double range[2], double fraction)
{
  double best = range[0];
  double distance = 2;
  constexpr int steps = 1000;
  for (int step = 1; step < steps; ++step)
  {
    const double isovalue = range[0] + (range[1] - range[0]) * (step + 0.25) / steps;
    const double here = std::abs(std::log(GetActiveFraction(ranges, isovalue) / fraction));
    if (here < distance)
    {
      distance = here;
      best = isovalue;
    }
  }
  return best;
}

void MeasureIslands(vtkStabbingContour* contour, const Measurement& filter, const Options& options)
{
  contour->Update();
  vtkNew<vtkPolyData> whole;
  whole->ShallowCopy(contour->GetOutput());
  contour->SetMinimumIslandSize(1);
  Print("ours: islands measured", MeasureFilter(contour, options.Repeats), filter);
  contour->SetMaximumIslands(1);
  Print("ours: largest island", MeasureFilter(contour, options.Repeats), filter);
  std::printf("  %s\n", contour->GetIslandSummary());
  contour->SetMinimumIslandSize(0);
  contour->SetMaximumIslands(0);
  vtkNew<vtkPolyDataConnectivityFilter> connectivity;
  connectivity->SetInputData(whole);
  connectivity->SetExtractionModeToLargestRegion();
  Print("vtkPolyDataConnectivityFilter", MeasureFilter(connectivity, std::min(options.Repeats, 3)),
    filter);
}

void MeasureIsovalue(vtkImageData* image, const isosurface::GridGeometry& grid,
  const isosurface::SampleView& view, const isosurface::BlockRanges& ranges, double isovalue,
  int threads, const Options& options)
{
  isosurface::ContourRequest request;
  request.Isovalues = { isovalue };
  request.Normals = options.Attributes;
  const Measurement kernel = Measure(
    options.Repeats, [] {},
    [&]
    {
      isosurface::GridBlockSource source(view, ranges, request.Isovalues);
      return isosurface::ExtractSurface(grid, source, request, threads)->NumberOfTriangles;
    });
  const auto kept = MakeContour(image, isovalue, threads, options);
  kept->Update();
  const Measurement filter = MeasureFilter(kept, options.Repeats);
  const Measurement first = Measure(
    options.Repeats, [] {},
    [&]
    {
      const auto fresh = MakeContour(image, isovalue, threads, options);
      fresh->Update();
      return static_cast<std::size_t>(fresh->GetOutput()->GetNumberOfPolys());
    });
  Print("ours: kernel", kernel, filter);
  Print("ours: filter", filter, filter);
  Print("ours: filter, first time", first, filter);
  if (options.Islands)
  {
    MeasureIslands(kept, filter, options);
  }
  Print("vtkFlyingEdges3D", MeasurePeer<vtkFlyingEdges3D>(image, isovalue, options), filter);
#if ISOSURFACE_VISKORES
  Print("vtkmContour", MeasurePeer<vtkmContour>(image, isovalue, options), filter);
#endif
  if (options.Slow)
  {
    Print("vtkSynchronizedTemplates3D",
      MeasurePeer<vtkSynchronizedTemplates3D>(image, isovalue, options), filter);
    Print("vtkContourFilter", MeasurePeer<vtkContourFilter>(image, isovalue, options), filter);
  }
}

bool MeasureVolume(const std::string& name, vtkImageData* image, const Options& options)
{
  vtkDataArray* scalars = image->GetPointData()->GetScalars();
  const auto grid = isosurface::MakeGridGeometry(image, image->GetExtent());
  const auto samples = isosurface::MakeImageSamples(grid, image, scalars);
  if (!samples.IsOk())
  {
    std::fprintf(stderr, "%s: %s\n", name.c_str(), samples.GetStatus().GetMessage().c_str());
    return false;
  }
  const isosurface::SampleView& view = samples->Components.front();
  const auto ranges = isosurface::BlockRanges::Compute(view, options.Threads.front());
  const int* size = image->GetDimensions();
  for (const int threads : options.Threads)
  {
    vtkSMPTools::Initialize(threads);
    std::printf("%s: %d x %d x %d %s, %d thread(s), %s, median of %d\n", name.c_str(), size[0],
      size[1], size[2], scalars->GetDataTypeAsString(), threads,
      options.Attributes ? "normals and scalars" : "points and triangles only", options.Repeats);
    for (const double fraction : { 0.5, 0.08, 0.025 })
    {
      const double isovalue = FindIsovalue(*ranges, scalars->GetRange(), fraction);
      std::printf("isovalue %g: %.1f %% of %lld blocks active\n", isovalue,
        100 * GetActiveFraction(*ranges, isovalue),
        static_cast<long long>(ranges->GetGrid().GetNumberOfBlocks()));
      MeasureIsovalue(image, grid, view, *ranges, isovalue, threads, options);
    }
  }
  return true;
}

vtkSmartPointer<vtkImageData> MakeTurbulence(int side)
{
  const std::vector<std::uint16_t> volume = isosurface::MakeBenchmarkVolume(side, 2);
  vtkNew<vtkUnsignedShortArray> scalars;
  scalars->SetName("turbulence");
  scalars->SetNumberOfValues(static_cast<vtkIdType>(volume.size()));
  std::copy(volume.begin(), volume.end(), scalars->GetPointer(0));
  auto image = vtkSmartPointer<vtkImageData>::New();
  image->SetDimensions(side, side, side);
  image->GetPointData()->SetScalars(scalars);
  return image;
}

void ConvertToFloat(vtkImageData* image)
{
  vtkDataArray* scalars = image->GetPointData()->GetScalars();
  const auto converted = vtk::TakeSmartPointer(vtkDataArray::CreateDataArray(VTK_FLOAT));
  converted->DeepCopy(scalars);
  converted->SetName(scalars->GetName());
  image->GetPointData()->SetScalars(converted);
}

} // namespace

int main(int argc, char** argv)
{
  Options options;
  CLI::App application("Compares isosurfaces of volumes in memory with VTK's filters");
  application.add_option("--volumes", options.Files, ".vti files; default: a generated volume");
  application.add_option(
    "--array", options.Array, "the files' point array; default: the first one");
  application.add_flag("--float", options.AsFloat, "samples converted to float");
  application.add_option("--side", options.Side, "samples along the side of the generated volume");
  application.add_option("--threads", options.Threads, "threads of each contender");
  application.add_option("--repeats", options.Repeats, "runs of which the median is taken");
  application.add_flag("--attributes", options.Attributes, "with normals and scalars");
  application.add_flag("--slow", options.Slow, "also the filters slower than vtkFlyingEdges3D");
  application.add_flag("--islands", options.Islands, "also the connected parts of the surfaces");
  CLI11_PARSE(application, argc, argv);
  vtkLogger::SetStderrVerbosity(vtkLogger::VERBOSITY_WARNING);
  vtkSMPTools::SetBackend("STDThread");

  if (options.Files.empty())
  {
    const auto image = MakeTurbulence(options.Side);
    if (options.AsFloat)
    {
      ConvertToFloat(image);
    }
    return MeasureVolume("turbulence", image, options) ? EXIT_SUCCESS : EXIT_FAILURE;
  }
  for (const std::string& file : options.Files)
  {
    vtkNew<vtkXMLImageDataReader> reader;
    reader->SetFileName(file.c_str());
    reader->Update();
    vtkImageData* image = reader->GetOutput();
    vtkPointData* arrays = image->GetPointData();
    vtkDataArray* scalars =
      options.Array.empty() ? arrays->GetArray(0) : arrays->GetArray(options.Array.c_str());
    if (!scalars)
    {
      std::fprintf(stderr, "%s: no such point array\n", file.c_str());
      return EXIT_FAILURE;
    }
    arrays->SetScalars(scalars);
    if (options.AsFloat)
    {
      ConvertToFloat(image);
    }
    if (!MeasureVolume(file, image, options))
    {
      return EXIT_FAILURE;
    }
  }
  return EXIT_SUCCESS;
}
