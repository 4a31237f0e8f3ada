// SPDX-License-Identifier: BSD-3-Clause
// Makes a volume of any size from a scan by interpolation and added detail (LargeVolume.h), as .mhd
// and .raw.
#include "Volumes/LargeVolume.h"
#include "Volumes/VolumeQuery.h"

#include "Ground/Base/ParallelFor.h"

#include <CLI/CLI.hpp>

#include <cstdio>
#include <cstdlib>
#include <map>
#include <string>
#include <vector>

using namespace isosurface;

int main(int argc, char** argv)
{
  // The sides of cubes of uint16 samples, by their size in decimal gigabytes.
  const std::map<std::string, std::int64_t> presets = { { "2GB", 1024 }, { "8GB", 1600 },
    { "17GB", 2048 } };
  std::string output;
  std::string scanPath;
  std::string preset;
  std::string type = "uint16";
  std::vector<std::int64_t> dimensions;
  LargeVolumeSettings settings;
  int threads = ChooseThreadCount(1);
  CLI::App app("Makes a large volume from a scan by interpolation and added detail.");
  app.add_option("output", output, "NAME.mhd; the samples go to NAME.raw")->required();
  app.add_option("--scan", scanPath,
    "a volume (.mhd, .mha, .nrrd, .nhdr); default: the head MRI of Debian's mricron-data");
  auto* named = app.add_option("--preset", preset, "2GB (1024^3), 8GB (1600^3) or 17GB (2048^3)")
                  ->check(CLI::IsMember(presets));
  app.add_option("--dimensions", dimensions, "samples along x, y and z")
    ->expected(3)
    ->excludes(named);
  app.add_option("--type", type, "type of the samples: int8, uint8, ... float32, float64");
  app.add_option("--detail", settings.Detail, "how far surfaces are moved, in samples of the scan");
  app.add_option("--seed", settings.Seed, "seed of the detail");
  app.add_option("--threads", threads, "number of threads")->check(CLI::PositiveNumber);
  CLI11_PARSE(app, argc, argv);

  const std::int64_t side = preset.empty() ? 0 : presets.at(preset);
  settings.Dimensions = { side, side, side };
  if (dimensions.size() == 3)
  {
    settings.Dimensions = { dimensions[0], dimensions[1], dimensions[2] };
  }
  const auto valueType = FindValueType(type);
  const auto scan = scanPath.empty() ? Result<RawVolume>(FindDebianScan())
                                     : RawVolume::ReadHeader(GetLocalFileSystem(), scanPath);
  if (!valueType || !scan.IsOk())
  {
    std::fprintf(stderr, "%s\n",
      scan.IsOk() ? (type + ": unknown type of samples").c_str()
                  : scan.GetStatus().GetMessage().c_str());
    return EXIT_FAILURE;
  }
  settings.Type = *valueType;
  const double start = GetSeconds();
  const auto volume = LargeVolume::Open(GetLocalFileSystem(), *scan, settings);
  const Status status =
    volume.IsOk() ? volume->Write(GetLocalFileSystem(), output, threads) : volume.GetStatus();
  if (!status.IsOk())
  {
    std::fprintf(stderr, "%s: cannot be made: %s\n", output.c_str(), status.GetMessage().c_str());
    return EXIT_FAILURE;
  }
  const double seconds = GetSeconds() - start;
  const double bytes = static_cast<double>(volume->GetGrid().GetNumberOfVertices()) *
    static_cast<double>(GetValueSize(settings.Type));
  std::printf("%s: %.2f GB in %.1f s, %.0f MB/s\n", output.c_str(), bytes * 1e-9, seconds,
    bytes * 1e-6 / seconds);
  return EXIT_SUCCESS;
}
