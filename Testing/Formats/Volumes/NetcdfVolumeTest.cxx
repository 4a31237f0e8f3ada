// SPDX-License-Identifier: BSD-3-Clause
#include "Fixtures/Hdf5OnDisk.h"
#include "Fixtures/SampleFiles.h"

#include "Formats/Netcdf/NetcdfClassicHeader.h"
#include "Formats/Opener/ForeignVolume.h"

#include <netcdf.h>

#include <array>
#include <filesystem>
#include <string>
#include <vector>

using namespace isosurface;

namespace
{

/// One error, of opening and of listing, which has the words.
void ExpectRefused(const std::string& path, const std::vector<std::string>& words)
{
  ExpectWords(OpenLocal(path).GetStatus(), words);
  ExpectWords(ListForeignVolumes(GetLocalFileSystem(), path).GetStatus(), words);
}

/// A file of time, z, y and x, whose last bytes are those of the coordinates `last`.
void WriteCoordinates(const std::string& path, const char* last, int format)
{
  int file = 0;
  ASSERT_EQ(::nc_create(path.c_str(), NC_CLOBBER | format, &file), NC_NOERR);
  int axes[4];
  int data = 0;
  int line = 0;
  const char* const names[] = { "time", "z", "y", "x" };
  const std::size_t sizes[] = { 2, 2, 5, 6 };
  for (int axis = 0; axis < 4; ++axis)
  {
    ::nc_def_dim(file, names[axis], sizes[axis], &axes[axis]);
  }
  ::nc_def_var(file, "data", NC_SHORT, 4, axes, &data);
  const int axis = std::string(last) == "time" ? 0 : 2;
  ::nc_def_var(file, last, NC_DOUBLE, 1, &axes[axis], &line);
  ::nc_enddef(file);
  const double numbers[] = { 1, 2, 3, 4, 5 };
  EXPECT_EQ(::nc_put_var_short(file, data, MakeHdf5Samples().data()), NC_NOERR);
  EXPECT_EQ(::nc_put_var_double(file, line, numbers), NC_NOERR);
  ASSERT_EQ(::nc_close(file), NC_NOERR);
}

/// A file of time, z, y and x whose coordinates are integers with a scale and an offset: y with a
/// negative scale, as GOES-R has it, x unsigned, time with an offset alone.
void WritePackedCoordinates(const std::string& path, int format)
{
  int file = 0;
  ASSERT_EQ(::nc_create(path.c_str(), NC_CLOBBER | format, &file), NC_NOERR);
  int axes[4];
  int data = 0;
  int x = 0;
  int y = 0;
  int time = 0;
  const char* const names[] = { "time", "z", "y", "x" };
  const std::size_t sizes[] = { 2, 2, 5, 6 };
  for (int axis = 0; axis < 4; ++axis)
  {
    ::nc_def_dim(file, names[axis], sizes[axis], &axes[axis]);
  }
  ::nc_def_var(file, "data", NC_SHORT, 4, axes, &data);
  ::nc_def_var(file, "time", NC_INT, 1, &axes[0], &time);
  ::nc_def_var(file, "y", NC_SHORT, 1, &axes[2], &y);
  ::nc_def_var(file, "x", NC_BYTE, 1, &axes[3], &x);
  const auto scale = [&](int variable, const char* attribute, double number)
  { ::nc_put_att_double(file, variable, attribute, NC_DOUBLE, 1, &number); };
  scale(time, "add_offset", 100);
  scale(y, "scale_factor", -0.25);
  scale(y, "add_offset", 8);
  scale(x, "scale_factor", 0.5);
  ::nc_put_att_text(file, x, "_Unsigned", 4, "true");
  ::nc_enddef(file);
  const int times[] = { 1, 3 };
  const short rows[] = { -2, 0, 2, 4, 6 };
  const signed char columns[] = { 126, 127, -128, -127, -126, -125 }; // 126 to 131
  EXPECT_EQ(::nc_put_var_short(file, data, MakeHdf5Samples().data()), NC_NOERR);
  EXPECT_EQ(::nc_put_var_int(file, time, times), NC_NOERR);
  EXPECT_EQ(::nc_put_var_short(file, y, rows), NC_NOERR);
  EXPECT_EQ(::nc_put_var_schar(file, x, columns), NC_NOERR);
  ASSERT_EQ(::nc_close(file), NC_NOERR);
}

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
  ExpectWords(CheckNetcdfClassicSize(disk, "/data/a.nc", "v"),
    { "/data/a.nc:v", "truncated", "the samples end after 4722366482869645213" });
}

TEST(NetcdfVolume, CoordinatesAndTimesThatWereCutOffAreAnError)
{
  const ScratchFolder folder;
  const std::string path = folder / "a.nc";
  for (const char* line : { "time", "y" })
  {
    for (const int format : { 0, NC_64BIT_OFFSET, NC_64BIT_DATA })
    {
      WriteCoordinates(path, line, format);
      EXPECT_EQ(OpenLocal(path).GetStatus().GetMessage(), "");
      std::filesystem::resize_file(path, std::filesystem::file_size(path) - 8);
      ExpectWords(OpenLocal(path).GetStatus(), { "a.nc:" + std::string(line), "truncated" });
    }
  }
}

TEST(NetcdfVolume, PackedCoordinatesAndTimesAreUnpacked)
{
  const ScratchFolder folder;
  for (const int format : { 0, NC_64BIT_DATA, NC_NETCDF4 })
  {
    WritePackedCoordinates(folder / "a.nc", format);
    const auto volume = Require(OpenLocal(folder / "a.nc"));
    EXPECT_EQ(volume.Times, (std::vector<double>{ 101, 103 }));
    EXPECT_FALSE(volume.Lines);
    EXPECT_EQ(volume.Grid.Origin, (std::array<double, 3>{ 63, 8.5, 0 }));
    EXPECT_EQ(volume.Grid.Spacing, (std::array<double, 3>{ 0.5, 0.5, 1 }));
    EXPECT_EQ(volume.Grid.Direction, (std::array<double, 9>{ 1, 0, 0, 0, -1, 0, 0, 0, 1 }));
  }
}

TEST(NetcdfVolume, Version4WithLinksToRegularFilesIsRead)
{
  const ScratchFolder folder;
  Hdf5OnDisk(folder / "part.nc").AddDataset("data");
  Hdf5OnDisk(folder / "a.nc").AddLink("link", "part.nc", "/data");
  Hdf5OnDisk(folder / "b.nc").AddVirtual("virtual", "part.nc", "/data");
  ExpectVolume(folder / "a.nc");
  ExpectVolume(folder / "b.nc");
}

TEST(NetcdfVolume, Version4WithLinksToAFifoIsRefusedWithoutWaiting)
{
  const ScratchFolder folder;
  folder.MakeFifo("fifo");
  Hdf5OnDisk(folder / "link.nc").AddLink("link", "fifo", "/data");
  Hdf5OnDisk(folder / "virtual.nc").AddVirtual("virtual", "fifo", "/data");
  Hdf5OnDisk(folder / "external.nc").AddExternal("external", folder / "fifo");
  ExpectRefused(folder / "link.nc", { "link.nc:/link: cannot be read: ", "it is a FIFO" });
  ExpectRefused(folder / "virtual.nc", { "virtual.nc:/virtual", "it is a FIFO" });
  ExpectRefused(folder / "external.nc", { "external.nc:/external", "not read of NetCDF" });
}

TEST(NetcdfVolume, Version4WithGroupsDeeperThan32IsRefused)
{
  const ScratchFolder folder;
  {
    Hdf5OnDisk file(folder / "deep.nc");
    file.AddDataset(file.AddGroups("g", 40) + "/data");
  }
  {
    Hdf5OnDisk file(folder / "cycle.nc");
    file.AddDataset("/a/data");
    ::H5Lcreate_soft("/a", file.Get(), "/a/a", H5P_DEFAULT, H5P_DEFAULT);
  }
  ExpectRefused(folder / "deep.nc", { "deep.nc:/g/g", "deeper than 32" });
  ExpectRefused(folder / "cycle.nc", { "cycle.nc:/a/a", "deeper than 32" });
}
