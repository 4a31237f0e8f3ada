// SPDX-License-Identifier: BSD-3-Clause
#include "Fixtures/Hdf5OnDisk.h"

#include "ArrayFile/Hdf5File.h"

using namespace isosurface;

namespace
{

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

hid_t MakeChunks(const hsize_t (&chunk)[3])
{
  const hid_t plist = ::H5Pcreate(H5P_DATASET_CREATE);
  ::H5Pset_chunk(plist, 3, chunk);
  ::H5Pset_shuffle(plist);
  return plist;
}

} // namespace

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
  Hdf5OnDisk(path).AddDataset("data", MakeChunks({ 4, 5, 6 }));
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
