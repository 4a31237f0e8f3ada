// SPDX-License-Identifier: BSD-3-Clause
/**
 * Measures the effect of the block size: writes a volume with blocks of 16, 32 and 64 cells, then
 * extracts isosurfaces with an empty block cache. Prints, for each block size, the seconds to write
 * and the bytes on disk relative to the raw ones; for each isovalue the bytes read and the median
 * seconds of query, reading and extraction together, with the files in the page cache (warm) and
 * without (cold). Isovalues of the generated volume: 50, 20 and 5 % of the blocks of 32 cells are
 * active.
 */
#include "BenchmarkVolume.h"
#include "VolumeQuery.h"

#include "vtkDataArray.h"
#include "vtkImageData.h"
#include "vtkNew.h"
#include "vtkPointData.h"
#include "vtkSmartPointer.h"
#include "vtkUnsignedShortArray.h"
#include "vtkXMLImageDataReader.h"

#include "ImageSamples.h"
#include "Storage/Writing/BlockedVolumeWriter.h"

#include <CLI/CLI.hpp>

#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

using namespace isosurface;

namespace
{

struct Options
{
  int Side = 512;
  int Threads = 1;
  int Repeats = 5;
  std::string Input;
  std::string Folder = ".";
  std::vector<double> Isovalues;
};

/// An image with scalars; a generated image needs the samples.
struct InputImage
{
  std::vector<std::uint16_t> Generated;
  vtkSmartPointer<vtkImageData> Image;
};

/// Reads the file of the options, or generates a volume and adds its isovalues to the options.
InputImage MakeImage(Options& options)
{
  InputImage input;
  if (!options.Input.empty())
  {
    vtkNew<vtkXMLImageDataReader> reader;
    reader->SetFileName(options.Input.c_str());
    reader->Update();
    input.Image = reader->GetOutput();
    return input;
  }
  const int side = options.Side;
  input.Generated = MakeBenchmarkVolume(side, 2);
  input.Image = vtkSmartPointer<vtkImageData>::New();
  input.Image->SetDimensions(side, side, side);
  vtkNew<vtkUnsignedShortArray> scalars;
  scalars->SetName("waves");
  scalars->SetArray(input.Generated.data(), static_cast<vtkIdType>(input.Generated.size()), 1);
  input.Image->GetPointData()->SetScalars(scalars);
  for (const double fraction : { 0.5, 0.2, 0.05 })
  {
    options.Isovalues.push_back(FindIsovalue(input.Generated, side, fraction, 2));
  }
  return input;
}

void MeasureQueries(const std::string& path, const Options& options)
{
  for (const double isovalue : options.Isovalues)
  {
    const auto query = MeasureQuery(path, isovalue, options.Threads, options.Repeats, false);
    const auto cold = MeasureQuery(path, isovalue, options.Threads, options.Repeats, true);
    std::printf("  isovalue %8.1f: %6llu blocks, %8.1f MB read, %9zu triangles, "
                "warm %.4f s, cold %.4f s\n",
      isovalue, static_cast<unsigned long long>(query.Statistics.BlocksRead),
      static_cast<double>(query.Statistics.BytesRead) / 1e6, query.Triangles, query.Seconds,
      cold.Seconds);
    std::fflush(stdout);
  }
}

/// Writes the volume with blocks of this size, and measures queries of it.
Status MeasureBlockSize(
  int blockSize, const GridGeometry& grid, const ImageSamples& samples, const Options& options)
{
  const std::string path = options.Folder + "/blocks-" + std::to_string(blockSize) + ".bvol";
  const SampleView& first = samples.Components.front();
  SerialCommunicator alone;
  BlockedVolumeSettings settings;
  settings.BlockSize = blockSize;
  settings.Threads = options.Threads;
  const double start = GetSeconds();
  const auto written = BlockedVolumeWriter(alone).Write(
    path, grid, { { "samples", first.Type } }, { first.Box, samples.Components }, settings);
  ISOSURFACE_RETURN_IF_ERROR(written.GetStatus());
  const auto raw =
    static_cast<double>(grid.GetNumberOfVertices()) * static_cast<double>(GetValueSize(first.Type));
  std::printf("block size %d: written in %.2f s, %.2f x the raw bytes\n", blockSize,
    GetSeconds() - start, static_cast<double>(written->Bytes) / raw);
  MeasureQueries(path, options);
  return Status::Ok();
}

} // namespace

int main(int argc, char** argv)
{
  Options options;
  CLI::App application("Measures the effect of the block size");
  application.add_option("--volume", options.Input, "a .vti file; default: a generated volume");
  application.add_option("--side", options.Side, "samples along the side of the generated volume");
  application.add_option("--isovalues", options.Isovalues, "for --volume");
  application.add_option("--folder", options.Folder, "where to write the blocked volumes");
  application.add_option("--threads", options.Threads, "threads for extraction");
  application.add_option("--repeats", options.Repeats, "runs of which the median is taken");
  CLI11_PARSE(application, argc, argv);

  const InputImage input = MakeImage(options);
  vtkDataArray* scalars = input.Image->GetPointData()->GetScalars();
  if (!scalars)
  {
    std::fprintf(stderr, "%s: no scalars\n", options.Input.c_str());
    return EXIT_FAILURE;
  }
  const GridGeometry grid = MakeGridGeometry(input.Image, input.Image->GetExtent());
  const auto samples = MakeImageSamples(grid, input.Image, scalars);
  std::printf("%s: %.1f MB, %d thread(s), median of %d\n",
    options.Input.empty() ? "generated" : options.Input.c_str(),
    static_cast<double>(scalars->GetNumberOfTuples() * scalars->GetDataTypeSize()) / 1e6,
    options.Threads, options.Repeats);
  for (const int blockSize : { 16, 32, 64 })
  {
    const Status status = MeasureBlockSize(blockSize, grid, *samples, options);
    if (!status.IsOk())
    {
      std::fprintf(stderr, "%s\n", status.GetMessage().c_str());
      return EXIT_FAILURE;
    }
  }
  return EXIT_SUCCESS;
}
