// SPDX-License-Identifier: BSD-3-Clause
#include "Fixtures/SampleFiles.h"

#include "Formats/Netcdf/NetcdfClassicHeader.h"

using namespace isosurface;

namespace
{

/// The header of version 5: the dimensions t (of records), z, y and x of `size`, and a variable.
Bytes MakeHugeHeader(std::uint64_t records, std::uint64_t size)
{
  Bytes bytes = MakeBytes("CDF\5");
  const auto add = [&bytes](std::uint64_t number, int count)
  {
    for (int byte = count; byte-- > 0;)
    {
      bytes.push_back(static_cast<std::uint8_t>(number >> (8 * byte)));
    }
  };
  const auto addName = [&](char name)
  {
    add(1, 8);
    bytes.insert(bytes.end(), { static_cast<std::uint8_t>(name), 0, 0, 0 });
  };
  add(records, 8);
  add(10, 4); // dimensions
  add(4, 8);
  for (const char name : { 't', 'z', 'y', 'x' })
  {
    addName(name);
    add(name == 't' ? 0 : size, 8);
  }
  add(0, 4); // no attributes
  add(0, 8);
  add(11, 4); // variables
  add(1, 8);
  addName('v');
  add(4, 8);
  for (std::uint64_t axis = 0; axis < 4; ++axis)
  {
    add(axis, 8);
  }
  add(0, 4);
  add(0, 8);
  add(5, 4); // float
  add(size * size * size * 4, 8);
  add(bytes.size() + 8, 8);
  return bytes;
}

} // namespace

TEST(NetcdfVolume, AHeaderThatNamesMoreBytesThan64BitsCountIsAnError)
{
  MemoryDisk disk;
  WriteFile(disk, "/data/a.nc", MakeHugeHeader(std::uint64_t{ 1 } << 40, 1024));
  const Status status = CheckNetcdfClassicSize(disk, "/data/a.nc", "v");
  for (const char* words :
    { "/data/a.nc:v", "truncated", "the samples end after 4722366482869645213" })
  {
    ExpectMessage(status, words);
  }
}
