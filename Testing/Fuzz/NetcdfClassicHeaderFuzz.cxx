// SPDX-License-Identifier: BSD-3-Clause
// Input: a file of a classic format of NetCDF, of which the header is read for the end of the
// variables "v" and "t", and of none.
#include "FuzzTarget.h"
#include "SealedBytes.h"

#include "Formats/Netcdf/NetcdfClassicHeader.h"

#include <string>

using namespace isosurface;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size)
{
  if (size < 4)
  {
    return 0;
  }
  MemoryDisk disk;
  const std::string path = "/data/a.nc";
  const std::string longer = "/data/b.nc";
  PutFile(disk, path, SealedBytes(bytes, bytes + size));
  SealedBytes more(bytes, bytes + size);
  more.resize(size + 100);
  PutFile(disk, longer, std::move(more));
  const MemoryLimit limit(64 * size + (std::size_t{ 1 } << 20));
  for (const char* variable : { "", "v", "t" })
  {
    const Status status = CheckNetcdfClassicSize(disk, path, variable);
    Require(status.IsOk() || status.GetCode() == StatusCode::Corrupt, "a bad header is Corrupt");
    Require(status.IsOk() || status.GetMessage().find(path) == 0, "an error names the file");
    Require(!status.IsOk() || CheckNetcdfClassicSize(disk, longer, variable).IsOk(),
      "a longer file has all samples that the shorter one has");
  }
  return 0;
}
