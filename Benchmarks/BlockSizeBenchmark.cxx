// SPDX-License-Identifier: BSD-3-Clause
/**
 * What the size of the blocks costs: a volume is written with blocks of 16, 32 and 64 cells, then
 * isosurfaces are extracted with an empty block cache. For each block size it prints the seconds to
 * write, the bytes on disk against the raw ones, and for each isovalue (of the generated volume:
 * those that pass 50, 20 and 5 % of the blocks of 32 cells) the bytes read and the median seconds
 * of query, reading and extraction together: with the files in the page cache, and dropped from it
 * before each run.
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
#include "Writing/BlockedVolumeWriter.h"

#include <CLI/CLI.hpp>

#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

int main(int argc, char** argv)
{
  int side = 512;
  int threads = 1;
  int repeats = 5;
  std::string input;
  std::string folder = ".";
  std::vector<double> isovalues;
  CLI::App application("What the size of the blocks costs");
  application.add_option("--volume", input, "a .vti file; else a generated volume");
  application.add_option("--side", side, "samples along the side of the generated volume");
  application.add_option("--isovalues", isovalues, "for --volume");
  application.add_option("--folder", folder, "where to write the blocked volumes");
  application.add_option("--threads", threads, "threads to extract with");
  application.add_option("--repeats", repeats, "runs of which the median is taken");
  CLI11_PARSE(application, argc, argv);

  vtkSmartPointer<vtkImageData> image;
  std::vector<std::uint16_t> generated;
  if (!input.empty())
  {
    vtkNew<vtkXMLImageDataReader> reader;
    reader->SetFileName(input.c_str());
    reader->Update();
    image = reader->GetOutput();
  }
  else
  {
    generated = isosurface::MakeBenchmarkVolume(side, 2);
    image = vtkSmartPointer<vtkImageData>::New();
    image->SetDimensions(side, side, side);
    vtkNew<vtkUnsignedShortArray> scalars;
    scalars->SetName("waves");
    scalars->SetArray(generated.data(), static_cast<vtkIdType>(generated.size()), 1);
    image->GetPointData()->SetScalars(scalars);
    for (const double share : { 0.5, 0.2, 0.05 })
    {
      isovalues.push_back(isosurface::FindIsovalue(generated, side, share, 2));
    }
  }
  vtkDataArray* scalars = image->GetPointData()->GetScalars();
  if (!scalars)
  {
    std::fprintf(stderr, "%s: no scalars\n", input.c_str());
    return EXIT_FAILURE;
  }
  const isosurface::GridGeometry grid = isosurface::MakeGridGeometry(image, image->GetExtent());
  auto samples = isosurface::MakeImageSamples(grid, image, scalars);
  const auto raw = static_cast<double>(scalars->GetNumberOfTuples() * scalars->GetDataTypeSize());
  std::printf("%s: %.1f MB, %d thread(s), median of %d\n",
    input.empty() ? "generated" : input.c_str(), raw / 1e6, threads, repeats);

  for (const int blockSize : { 16, 32, 64 })
  {
    const std::string path = folder + "/blocks-" + std::to_string(blockSize) + ".bvol";
    isosurface::SerialCommunicator alone;
    isosurface::BlockedVolumeSettings settings;
    settings.BlockSize = blockSize;
    settings.Threads = threads;
    const double start = isosurface::GetSeconds();
    auto written = isosurface::BlockedVolumeWriter(alone).Write(path, grid,
      { { "samples", samples->Components.front().Type } },
      { samples->Components.front().Box, samples->Components }, settings);
    if (!written.IsOk())
    {
      std::fprintf(stderr, "%s\n", written.GetStatus().GetMessage().c_str());
      return EXIT_FAILURE;
    }
    std::printf("block size %d: written in %.2f s, %.2f x the raw bytes\n", blockSize,
      isosurface::GetSeconds() - start, static_cast<double>(written->Bytes) / raw);
    for (const double isovalue : isovalues)
    {
      const auto query = isosurface::MeasureQuery(path, isovalue, threads, repeats, false);
      const auto cold = isosurface::MeasureQuery(path, isovalue, threads, repeats, true);
      std::printf("  isovalue %8.1f: %6llu blocks, %8.1f MB read, %9zu triangles, "
                  "warm %.4f s, cold %.4f s\n",
        isovalue, static_cast<unsigned long long>(query.Statistics.BlocksRead),
        static_cast<double>(query.Statistics.BytesRead) / 1e6, query.Triangles, query.Seconds,
        cold.Seconds);
      std::fflush(stdout);
    }
  }
  return EXIT_SUCCESS;
}
