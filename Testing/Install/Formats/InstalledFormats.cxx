// SPDX-License-Identifier: BSD-3-Clause
// Uses the installed Formats: a MetaImage is opened, and the module of TIFF is found.
#include "Formats/Opener/ForeignVolume.h"

#include <cstdio>
#include <fstream>

using namespace isosurface;

int main()
{
  std::ofstream("eight.mhd") << "ObjectType = Image\nNDims = 3\nDimSize = 2 2 2\n"
                             << "ElementType = MET_UCHAR\nElementDataFile = eight.raw\n";
  std::ofstream("eight.raw") << "12345678";
  std::ofstream("none.tif") << "no TIFF";
  const auto volume = OpenForeignVolume(GetLocalFileSystem(), "eight.mhd");
  if (!volume.IsOk())
  {
    std::fprintf(stderr, "%s\n", volume.GetStatus().GetMessage().c_str());
    return 1;
  }
  const std::string error =
    OpenForeignVolume(GetLocalFileSystem(), "none.tif").GetStatus().GetMessage();
  if (error.empty() || error.find("module") != std::string::npos)
  {
    std::fprintf(stderr, "%s\n", error.c_str());
    return 1;
  }
  std::printf("%d samples\n", static_cast<int>(volume->Grid.GetNumberOfVertices()));
  return 0;
}
