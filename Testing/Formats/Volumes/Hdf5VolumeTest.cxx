// SPDX-License-Identifier: BSD-3-Clause
#include "Fixtures/ScratchFolder.h"

#include "Formats/Hdf5/Hdf5File.h"
#include "Formats/Opener/ForeignVolume.h"

#include <gtest/gtest.h>
#include <hdf5.h>

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <numeric>
#include <string>
#include <vector>

using namespace isosurface;

namespace
{

/// The 4 x 5 x 6 samples of every dataset.
std::vector<std::int16_t> MakeHdf5Samples()
{
  std::vector<std::int16_t> samples(4 * 5 * 6);
  std::iota(samples.begin(), samples.end(), std::int16_t{ 1 });
  return samples;
}

/// Writes a file with the dataset "data", by the library itself. Closes the lists of properties.
void WriteHdf5(const std::string& path, hid_t access, hid_t plist)
{
  const hid_t file = ::H5Fcreate(path.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, access);
  const hsize_t size[] = { 4, 5, 6 };
  const hid_t space = ::H5Screate_simple(3, size, nullptr);
  const hid_t dataset =
    ::H5Dcreate2(file, "data", H5T_STD_I16LE, space, H5P_DEFAULT, plist, H5P_DEFAULT);
  EXPECT_GE(
    ::H5Dwrite(dataset, H5T_NATIVE_INT16, H5S_ALL, H5S_ALL, H5P_DEFAULT, MakeHdf5Samples().data()),
    0);
  ::H5Dclose(dataset);
  ::H5Sclose(space);
  ::H5Fclose(file);
  for (const hid_t list : { access, plist })
  {
    EXPECT_GE(list == H5P_DEFAULT ? 0 : ::H5Pclose(list), 0);
  }
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
  WriteHdf5(path, access, plist);
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

} // namespace

/// Asked by LeakSanitizer at the end of the process.
// NOLINTNEXTLINE(bugprone-reserved-identifier)
extern "C" int __lsan_is_turned_off()
{
  return LeaksAreIgnored ? 1 : 0;
}

TEST(Hdf5Volume, ChunksAtTheEndThatWereNotShuffledAreReadAsTheyAre)
{
  const ScratchFolder folder;
  const std::string path = folder / "a.h5";
  const hid_t plist = MakeChunks({ 3, 3, 6 });
  ::H5Pset_chunk_opts(plist, H5D_CHUNK_DONT_FILTER_PARTIAL_CHUNKS);
  WriteHdf5(path, H5P_DEFAULT, plist);
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
  WriteHdf5(path, access, H5P_DEFAULT);
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
