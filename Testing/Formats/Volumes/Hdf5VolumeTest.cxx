// SPDX-License-Identifier: BSD-3-Clause
#include "Fixtures/Hdf5OnDisk.h"

#include "Formats/Hdf5/Hdf5File.h"
#include "Formats/Opener/ForeignVolume.h"

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <utility>
#include <vector>

using namespace isosurface;

namespace
{

std::vector<std::string> ListPaths(const std::string& path)
{
  const auto list = ListForeignVolumes(GetLocalFileSystem(), path);
  EXPECT_TRUE(list.IsOk()) << list.GetStatus().GetMessage();
  std::vector<std::string> paths;
  for (std::size_t entry = 0; list.IsOk() && entry < list->size(); ++entry)
  {
    paths.push_back((*list)[entry].Name);
  }
  return paths;
}

std::vector<std::int16_t> ReadChunks(
  const std::string& path, const StoredArray::Numbers& chunk, std::uint64_t cacheBytes)
{
  std::vector<std::int16_t> samples(120);
  const auto file = Hdf5File::Open(path);
  auto array = file->OpenArray("/data", cacheBytes);
  EXPECT_TRUE(array.IsOk());
  std::vector<std::int16_t> part(120);
  for (std::int64_t k = 0; k < 4; k += chunk[0])
  {
    for (std::int64_t j = 0; j < 5; j += chunk[1])
    {
      const StoredArray::Numbers size = { std::min(chunk[0], 4 - k), std::min(chunk[1], 5 - j), 6 };
      EXPECT_TRUE(
        (*array)->Read({ k, j, 0 }, size, reinterpret_cast<std::uint8_t*>(part.data())).IsOk());
      for (std::int64_t row = 0; row < size[0] * size[1]; ++row)
      {
        std::copy_n(part.begin() + row * 6, 6,
          samples.begin() + ((k + row / size[1]) * 5 + j + row % size[1]) * 6);
      }
    }
  }
  return samples;
}

/// Since HDF5 2.0 files are, unless told otherwise, of later versions, with other bytes and checksums.
void WriteOldFile(const std::string& path, hid_t plist)
{
  const hid_t access = ::H5Pcreate(H5P_FILE_ACCESS);
  ::H5Pset_libver_bounds(access, H5F_LIBVER_EARLIEST, H5F_LIBVER_LATEST);
  Hdf5OnDisk(path, access).AddDataset("data", plist);
  ::H5Pclose(access);
}

/// The library loses memory of damaged files.
bool LeaksAreIgnored = false;

hid_t MakeChunks(const hsize_t (&chunk)[3])
{
  const hid_t plist = ::H5Pcreate(H5P_DATASET_CREATE);
  ::H5Pset_chunk(plist, 3, chunk);
  ::H5Pset_shuffle(plist);
  return plist;
}

/// Image data of VTKHDF with one point array, "data": each sample is the number of its entry on the
/// t axis. Without offsets if there are none.
void WriteSteps(const std::string& path, hsize_t entries, const std::vector<double>& times,
  const std::vector<std::int64_t>& offsets)
{
  Hdf5OnDisk file(path);
  const hid_t links = ::H5Pcreate(H5P_LINK_CREATE);
  ::H5Pset_create_intermediate_group(links, 1);
  const auto add = [&](
                     const char* name, const std::vector<hsize_t>& size, hid_t type, const void* of)
  {
    const hid_t space = ::H5Screate_simple(static_cast<int>(size.size()), size.data(), nullptr);
    const hid_t dataset =
      ::H5Dcreate2(file.Get(), name, type, space, links, H5P_DEFAULT, H5P_DEFAULT);
    EXPECT_GE(::H5Dwrite(dataset, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, of), 0);
    ::H5Dclose(dataset);
    ::H5Sclose(space);
  };
  std::vector<std::int16_t> samples(entries * 60);
  for (std::size_t at = 0; at < samples.size(); ++at)
  {
    samples[at] = static_cast<std::int16_t>(at / 60);
  }
  add("/VTKHDF/PointData/data", { entries, 3, 4, 5 }, H5T_NATIVE_INT16, samples.data());
  add("/VTKHDF/Steps/Values", { times.size() }, H5T_NATIVE_DOUBLE, times.data());
  if (!offsets.empty())
  {
    add(
      "/VTKHDF/Steps/PointDataOffsets/data", { offsets.size() }, H5T_NATIVE_INT64, offsets.data());
  }
  ::H5Pclose(links);
  const hid_t text = ::H5Tcopy(H5T_C_S1);
  ::H5Tset_size(text, 9);
  file.AddAttribute("/VTKHDF", "Type", text, 1, "ImageData");
  ::H5Tclose(text);
  const int extent[] = { 0, 4, 0, 3, 0, 2 };
  file.AddAttribute("/VTKHDF", "WholeExtent", H5T_NATIVE_INT, 6, extent);
}

Result<OpenedVolume> OpenStep(const std::string& path, std::size_t step)
{
  VolumeChoice choice;
  choice.Step = step;
  return OpenForeignVolume(GetLocalFileSystem(), path, choice);
}

} // namespace

/// Asked by LeakSanitizer at the end of the process.
// NOLINTNEXTLINE(bugprone-reserved-identifier)
extern "C" int __lsan_is_turned_off()
{
  return LeaksAreIgnored ? 1 : 0;
}

TEST(Hdf5Volume, AMasterFileWithLinksAndVirtualDatasetsIsRead)
{
  const ScratchFolder folder;
  std::filesystem::create_directories(folder / "parts");
  Hdf5OnDisk(folder / "parts/a.h5").AddDataset("/entry/data");
  {
    Hdf5OnDisk file(folder / "master.h5");
    file.AddLink("relative", "parts/a.h5", "/entry/data");
    file.AddLink("absolute", folder / "parts/a.h5", "/entry/data");
    file.AddLink("moved", "/where/it/was/master.h5", "/relative");
    file.AddLink("group", "parts/a.h5", "/entry");
    file.AddVirtual("virtual", "parts/a.h5", "/entry/data");
    file.AddVirtual("again", ".", "/virtual");
    file.AddVirtual("linked", ".", "/relative");
  }
  for (const char* name :
    { "relative", "absolute", "moved", "group/data", "virtual", "again", "linked" })
  {
    SCOPED_TRACE(name);
    ExpectVolume(folder / "master.h5:/" + name);
  }
}

TEST(Hdf5Volume, ImageDataOfVtkhdfIsReadThroughALink)
{
  const ScratchFolder folder;
  {
    Hdf5OnDisk file(folder / "a.vtkhdf");
    file.AddDataset("/VTKHDF/PointData/data");
    const hid_t text = ::H5Tcopy(H5T_C_S1);
    ::H5Tset_size(text, 9);
    file.AddAttribute("/VTKHDF", "Type", text, 1, "ImageData");
    ::H5Tclose(text);
    const int extent[] = { 0, 5, 0, 4, 0, 3 };
    file.AddAttribute("/VTKHDF", "WholeExtent", H5T_NATIVE_INT, 6, extent);
  }
  Hdf5OnDisk(folder / "master.h5").AddLink("VTKHDF", "a.vtkhdf", "/VTKHDF");
  ExpectVolume(folder / "master.h5");
}

TEST(Hdf5Volume, TimeStepsOfVtkhdfAreWhereTheirOffsetsSay)
{
  const ScratchFolder folder;
  const std::string path = folder / "a.vtkhdf";
  const std::vector<double> times = { 0.5, 1, 1.5 };
  const auto expectSteps = [&](const std::vector<std::int16_t>& entries)
  {
    for (std::size_t step = 0; step < entries.size(); ++step)
    {
      const auto volume = Require(OpenStep(path, step));
      EXPECT_EQ(volume.Times, times);
      const auto slab = Require(volume.Source->Read(volume.Source->GetBox()));
      EXPECT_EQ(*reinterpret_cast<const std::int16_t*>(slab.Arrays[0].First), entries[step]);
    }
  };
  WriteSteps(path, 2, times, { 1, 0, 1 });
  expectSteps({ 1, 0, 1 });
  WriteSteps(path, 3, times, { 2, 1, 0 });
  expectSteps({ 2, 1, 0 });
  ExpectWords(
    OpenStep(path, 3).GetStatus(), { "a.vtkhdf:/VTKHDF", "3 time steps, and none of number 3" });
  WriteSteps(path, 3, times, {});
  expectSteps({ 0, 1, 2 });
  for (const hsize_t entries : { 2, 4 })
  {
    WriteSteps(path, entries, times, {});
    ExpectWords(OpenStep(path, 0).GetStatus(),
      { "a.vtkhdf:/VTKHDF: cannot be read: Steps/Values has 3 time steps, the point array data "
        "has " +
        std::to_string(entries) + ", and no Steps/PointDataOffsets/data" });
  }
  WriteSteps(path, 3, times, { 0, 1 });
  ExpectWords(OpenStep(path, 0).GetStatus(),
    { "/Steps/PointDataOffsets/data: cannot be read: it has 2 numbers for 3 time steps" });
  for (const std::int64_t offset : { -1, 3 })
  {
    WriteSteps(path, 3, times, { 0, offset, 2 });
    EXPECT_TRUE(OpenStep(path, 2).IsOk());
    ExpectWords(OpenStep(path, 1).GetStatus(),
      { "time step 1 has the number " + std::to_string(offset) + ", the point array has 3" });
  }
}

TEST(Hdf5Volume, FilesThatHaveTheSamplesAreNamed)
{
  const ScratchFolder folder;
  Hdf5OnDisk(folder / "a.h5").AddDataset("data");
  WriteRawSamples(folder / "a.raw");
  {
    Hdf5OnDisk file(folder / "master.h5");
    file.AddLink("link", "a.h5", "/data");
    file.AddVirtual("virtual", "a.h5", "/data");
    file.AddExternal("raw", "a.raw");
    file.AddDataset("own");
  }
  const std::string master = folder / "master.h5";
  const std::pair<const char*, const char*> expected[] = { { "link", "a.h5" },
    { "virtual", "a.h5" }, { "raw", "a.raw" }, { "own", nullptr } };
  ListPaths(master); // leaves no trace
  for (const auto& [name, other] : expected)
  {
    const auto volume = Require(OpenLocal(master + ":/" + name));
    ASSERT_EQ(volume.Files.size(), other ? 2U : 1U) << name;
    EXPECT_EQ(volume.Files[0], master);
    EXPECT_TRUE(!other || std::filesystem::equivalent(volume.Files.back(), folder / other));
  }
}

TEST(Hdf5Volume, LinksToAFifoAreRefusedWithoutWaiting)
{
  const ScratchFolder folder;
  folder.MakeFifo("fifo");
  {
    Hdf5OnDisk file(folder / "a.h5");
    file.AddLink("link", "fifo", "/data");
    file.AddLink("absolute", folder / "fifo", "/data");
    file.AddLink("device", "/dev/zero", "/data");
    file.AddVirtual("virtual", ".", "/link");
  }
  ExpectWords(OpenLocal(folder / "a.h5:/link").GetStatus(),
    { "a.h5:/link: cannot be read: ", "fifo", "it is a FIFO" });
  ExpectWords(OpenLocal(folder / "a.h5:/absolute").GetStatus(), { "fifo", "it is a FIFO" });
  ExpectWords(OpenLocal(folder / "a.h5:/device").GetStatus(), { "/dev/zero", "it is a device" });
  ExpectWords(OpenLocal(folder / "a.h5:/virtual").GetStatus(), { "fifo", "it is a FIFO" });
}

TEST(Hdf5Volume, ALinkThatIsNamedVtkhdfDoesNotHoldUpOpening)
{
  const ScratchFolder folder;
  folder.MakeFifo("fifo");
  {
    Hdf5OnDisk file(folder / "a.h5");
    file.AddLink("VTKHDF", "fifo", "/data");
    file.AddDataset("data");
  }
  ExpectVolume(folder / "a.h5");
  EXPECT_EQ(ListPaths(folder / "a.h5"), std::vector<std::string>{ "/data" });
}

TEST(Hdf5Volume, VirtualDatasetsOfAFifoAreRefusedWithoutWaiting)
{
  const ScratchFolder folder;
  folder.MakeFifo("fifo");
  folder.MakeFifo("slice-0");
  {
    Hdf5OnDisk file(folder / "a.h5");
    file.AddVirtual("virtual", "fifo", "/data");
    file.AddVirtual("outer", ".", "/virtual");
    file.AddVirtualSlices("slices", "slice-%b", "/data");
  }
  ExpectWords(
    OpenLocal(folder / "a.h5:/virtual").GetStatus(), { "a.h5:/virtual", "fifo", "it is a FIFO" });
  ExpectWords(
    OpenLocal(folder / "a.h5:/outer").GetStatus(), { "a.h5:/outer", "fifo", "it is a FIFO" });
  ExpectWords(
    OpenLocal(folder / "a.h5:/slices").GetStatus(), { "a.h5:/slices", "slice-0", "it is a FIFO" });
  // A list still tells what there is.
  EXPECT_EQ(
    ListPaths(folder / "a.h5"), (std::vector<std::string>{ "/outer", "/slices", "/virtual" }));
}

TEST(Hdf5Volume, TwoPercentSignsInTheNameOfAVirtualSourceAreOne)
{
  const ScratchFolder folder;
  Hdf5OnDisk(folder / "a%b.h5").AddDataset("100%b");
  {
    Hdf5OnDisk file(folder / "a.h5");
    file.AddVirtual("virtual", "a%%b.h5", "/100%%b");
  }
  ExpectVolume(folder / "a.h5:/virtual");
}

TEST(Hdf5Volume, VirtualDatasetsOfEachOtherAreReadEightDeepAndNoDeeper)
{
  const ScratchFolder folder;
  {
    Hdf5OnDisk file(folder / "a.h5");
    file.AddDataset("0");
    for (int depth = 1; depth <= 9; ++depth)
    {
      file.AddVirtual(std::to_string(depth), ".", "/" + std::to_string(depth - 1));
    }
    file.AddVirtual("self", ".", "/self");
  }
  ExpectVolume(folder / "a.h5:/8");
  ExpectWords(OpenLocal(folder / "a.h5:/9").GetStatus(),
    { "a.h5:/9", "virtual datasets of virtual datasets" });
  ExpectWords(OpenLocal(folder / "a.h5:/self").GetStatus(),
    { "a.h5:/self", "virtual datasets of virtual datasets" });
}

TEST(Hdf5Volume, ExternalSamplesAreRegularFilesInTheFolderOrBelow)
{
  const ScratchFolder folder;
  std::filesystem::create_directories(folder / "in/below");
  WriteRawSamples(folder / "in/below/a.raw", 7);
  WriteRawSamples(folder / "a.raw", 7);
  WriteRawSamples(folder / "in/short.raw", 7, 1);
  std::filesystem::create_symlink(folder / "a.raw", folder / "in/link.raw");
  folder.MakeFifo("in/fifo");
  const std::string path = folder / "in/a.h5";
  {
    Hdf5OnDisk file(path);
    file.AddExternal("relative", "below/a.raw", 7);
    file.AddExternal("absolute", folder / "in/below/a.raw", 7);
    file.AddExternal("passwords", "/etc/passwd");
    file.AddExternal("above", "../a.raw", 7);
    file.AddExternal("link", "link.raw", 7);
    file.AddExternal("fifo", "fifo");
    file.AddExternal("missing", "missing.raw");
    file.AddExternal("short", "short.raw", 7);
    file.AddVirtual("virtual", ".", "/passwords");
  }
  ExpectVolume(path + ":/relative");
  ExpectVolume(path + ":/absolute");
  const char* const outside = "outside of the folder of the file";
  ExpectWords(OpenLocal(path + ":/passwords").GetStatus(),
    { path + ":/passwords: cannot be read: /etc/passwd", outside });
  ExpectWords(OpenLocal(path + ":/above").GetStatus(), { "a.raw", outside });
  ExpectWords(OpenLocal(path + ":/link").GetStatus(), { "link.raw", outside });
  ExpectWords(OpenLocal(path + ":/virtual").GetStatus(),
    { path + ":/virtual", "nor through virtual datasets" });
  ExpectWords(OpenLocal(path + ":/fifo").GetStatus(), { "in/fifo", "it is a FIFO" });
  ExpectWords(OpenLocal(path + ":/missing").GetStatus(), { "missing.raw", "No such file" });
  ExpectWords(OpenLocal(path + ":/short").GetStatus(), { "short.raw", "truncated" });
}

TEST(Hdf5Volume, ExternalSamplesAreListedAndReadWhileTheyAreOpen)
{
  const ScratchFolder folder;
  WriteRawSamples(folder / "a.raw");
  Hdf5OnDisk(folder / "a.h5").AddExternal("data", "a.raw");
  const auto first = Require(OpenLocal(folder / "a.h5"));
  EXPECT_EQ(ListPaths(folder / "a.h5"), std::vector<std::string>{ "/data" });
  ExpectVolume(folder / "a.h5");
  ExpectVolume(folder / "a.h5:/data");
}

TEST(Hdf5Volume, GroupsInOneAnotherAreListedDownToADepthOf32)
{
  const ScratchFolder folder;
  const std::string path = folder / "a.h5";
  {
    Hdf5OnDisk file(path);
    const std::string deep = file.AddGroups("g", 1000);
    file.AddDataset(deep.substr(0, 2 * 31) + "/data");
    file.AddDataset(deep.substr(0, 2 * 32) + "/data");
    ::H5Lcreate_hard(file.Get(), "/", file.Get(), "/g/cycle", H5P_DEFAULT, H5P_DEFAULT);
    ::H5Lcreate_hard(file.Get(), "/g", file.Get(), "/again", H5P_DEFAULT, H5P_DEFAULT);
  }
  const std::vector<std::string> paths = ListPaths(path);
  ASSERT_EQ(paths.size(), 1U);
  ExpectVolume(path + ":" + paths[0]);
  ExpectVolume(path);
}

TEST(Hdf5Volume, AListHasTheFirst10000Objects)
{
  const ScratchFolder folder;
  const std::string path = folder / "a.h5";
  {
    Hdf5OnDisk file(path);
    file.AddDataset("/a/data");
    for (int number = 0; number < 10000; ++number)
    {
      ::H5Gclose(::H5Gcreate2(
        file.Get(), ("b" + std::to_string(number)).c_str(), H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT));
    }
    file.AddDataset("/c/data");
  }
  EXPECT_EQ(ListPaths(path), std::vector<std::string>{ "/a/data" });
  ExpectVolume(path + ":/c/data");
}

TEST(Hdf5Volume, ChunksAtTheEndThatWereNotShuffledAreReadAsTheyAre)
{
  const ScratchFolder folder;
  const std::string path = folder / "a.h5";
  {
    Hdf5OnDisk file(path);
    const hid_t plist = MakeChunks({ 3, 3, 6 });
    ::H5Pset_chunk_opts(plist, H5D_CHUNK_DONT_FILTER_PARTIAL_CHUNKS);
    file.AddDataset("data", plist);
  }
  EXPECT_EQ(ReadChunks(path, { 3, 3, 6 }, 0), MakeHdf5Samples());
}

TEST(Hdf5Volume, ChunksThatWereShuffledAsValuesOfAnotherSizeAreReadAsTheLibraryDoes)
{
  const ScratchFolder folder;
  const std::string path = folder / "a.h5";
  WriteOldFile(path, MakeChunks({ 4, 5, 6 }));
  std::fstream file(path, std::ios::in | std::ios::out | std::ios::binary);
  const std::string bytes(std::istreambuf_iterator<char>(file), {});
  const std::size_t size = bytes.find("shuffle") + 8; // the parameter follows the name
  ASSERT_EQ(bytes[size], 2);
  file.seekp(static_cast<std::streamoff>(size));
  file.put(4);
  file.close();
  const std::vector<std::int16_t> expected = ReadChunks(path, { 4, 5, 6 }, 1 << 20);
  EXPECT_NE(expected, MakeHdf5Samples());
  EXPECT_EQ(ReadChunks(path, { 4, 5, 6 }, 0), expected);
}

// The library (1.10) copies as many bytes of a chunk as its layout says, however few were inflated.
TEST(Hdf5Volume, ChunksOfAnotherSizeThanTheFileSaysAreAnError)
{
  const ScratchFolder folder;
  const hsize_t chunk[] = { 2, 3, 6 };
  const hid_t plist = ::H5Pcreate(H5P_DATASET_CREATE);
  ::H5Pset_chunk(plist, 3, chunk);
  ::H5Pset_deflate(plist, 6);
  WriteOldFile(folder / "a.h5", plist);
  std::ifstream file(folder / "a.h5", std::ios::binary);
  const std::string bytes{ std::istreambuf_iterator<char>(file), {} };
  const std::uint32_t layout[] = { 2, 3, 6, 2 }; // the bytes of a sample, too
  const std::string stored(reinterpret_cast<const char*>(layout), sizeof(layout));
  const std::size_t place = bytes.find(stored);
  ASSERT_NE(place, std::string::npos);
  for (const char size : { 1, 4, 120 }) // the last one is larger than the dataset
  {
    std::string damaged = bytes;
    damaged[place] = size;
    std::ofstream(folder / "b.h5", std::ios::binary) << damaged;
    for (const std::uint64_t cacheBytes : { 0, 1 << 20 })
    {
      const auto array = Hdf5File::Open(folder / "b.h5")->OpenArray("/data", cacheBytes);
      ASSERT_FALSE(array.IsOk());
      EXPECT_EQ(array.GetStatus().GetCode(), StatusCode::Corrupt);
      EXPECT_EQ(array.GetStatus().GetMessage(),
        folder / "b.h5" +
          ":/data: cannot be read: its chunks have another size than the file says");
    }
  }
}

TEST(Hdf5Volume, TheProcessEndsInSilenceAfterADamagedFile)
{
  const ScratchFolder folder;
  const std::string path = folder / "damaged.h5";
  const hid_t access = ::H5Pcreate(H5P_FILE_ACCESS);
  ::H5Pset_libver_bounds(access, H5F_LIBVER_LATEST, H5F_LIBVER_LATEST);
  Hdf5OnDisk(path, access).AddDataset("data");
  ::H5Pclose(access);
  std::fstream file(path, std::ios::in | std::ios::out | std::ios::binary);
  file.seekp(120); // within the root group
  file.write("not this", 8);
  file.close();
  EXPECT_EXIT(
    {
      LeaksAreIgnored = true;
      const auto volume = OpenForeignVolume(GetLocalFileSystem(), path);
      std::exit(volume.IsOk() ? 1 : 0);
    },
    testing::ExitedWithCode(0), "^$");
}
