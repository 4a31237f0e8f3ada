// SPDX-License-Identifier: BSD-3-Clause
// Uses the installed Formats: opens a MetaImage, asks what an isovalue costs, and extracts the surface; the
// module of TIFF is found.
#include "Formats/Files/SurfaceQueries.h"

#include <cstdio>
#include <fstream>

using namespace isosurface;

int main()
{
  std::ofstream("eight.mhd") << "ObjectType = Image\nNDims = 3\nDimSize = 3 3 2\n"
                             << "ElementType = MET_UCHAR\nElementDataFile = eight.raw\n";
  std::ofstream("eight.raw") << "111111111"
                             << "333333333";
  std::ofstream("none.tif") << "no TIFF";
  const std::string error = VolumeFile::Open("none.tif").GetStatus().GetMessage();
  if (error.empty() || error.find("module") != std::string::npos)
  {
    std::fprintf(stderr, "%s\n", error.c_str());
    return 1;
  }
  const auto file = VolumeFile::Open("eight.mhd");
  if (!file.IsOk())
  {
    std::fprintf(stderr, "%s\n", file.GetStatus().GetMessage().c_str());
    return 1;
  }
  SurfaceRequest request;
  request.Isovalues = { '2' };
  std::string warning;
  const auto cost = EstimateTriangles(**file, {}, request);
  const auto surface = ExtractSurface(**file, {}, request, {}, warning);
  if (!cost.IsOk() || !surface.IsOk() || *cost != 8)
  {
    std::fprintf(
      stderr, "cost %g; %s\n", cost.IsOk() ? *cost : -1, surface.GetStatus().GetMessage().c_str());
    return 1;
  }
  std::printf("%zu triangles\n", surface->NumberOfTriangles);
  return 0;
}
