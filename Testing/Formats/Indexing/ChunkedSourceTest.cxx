// SPDX-License-Identifier: BSD-3-Clause
#include "Storage/Store/ChunkedSource.h"
#include "Fixtures/Require.h"
#include "Fixtures/SampleFiles.h"
#include "Fixtures/VolumeOnDisk.h"
#include "Fixtures/ZarrOnDisk.h"
#include "Formats/Opener/ForeignVolume.h"
#include "Ground/Volume/SampleCopy.h"
#include "Storage/Store/BlockCache.h"

using namespace isosurface;

namespace
{

const std::string ChunkedPath = "/data/scan.zarr";
const std::string ChunkedVolume = "/data/scan.bvol";
const Index3 ChunkedSize = { 70, 45, 51 };
constexpr std::uint64_t EnoughForAll = std::uint64_t{ 1 } << 24;

class ChunkedSourceTest : public testing::Test
{
protected:
  ChunkedSourceTest() { WriteZarr(this->Disk, ChunkedPath, this->Samples, { 16, 11, 20 }); }

  /// Opens the file, and has threads decode it.
  std::unique_ptr<BoxSource> Open(const std::string& path, const ChunkDecoding& decoding)
  {
    OpenedVolume opened = Require(OpenForeignVolume(this->Disk, path));
    const SourceRecord record = Require(DescribeSource(
      this->Disk, OpenForeignVolume, ChunkedVolume, path, {}, opened.Grid, opened.Arrays));
    this->Plain = opened.Source.get();
    const Status replaced = ChunkedSource::Replace(opened.Source, this->Disk, OpenForeignVolume,
      ChunkedVolume, path, record, opened.Grid, opened.Arrays, decoding);
    EXPECT_TRUE(replaced.IsOk()) << replaced.GetMessage();
    return std::move(opened.Source);
  }

  void ExpectSamples(BoxSource& source, const VertexBox& box) const
  {
    const BoxSamples read = Require(source.Read(box));
    ASSERT_TRUE(read.Fits({ ValueType::Int16 }, box));
    std::vector<std::int16_t> samples(static_cast<std::size_t>(box.GetNumberOfVertices()));
    CopyBox(read.Arrays[0], box, box, samples.data());
    const SampleVolume<std::int16_t> expected(box.GetSize(),
      [&](auto i, auto j, auto k)
      { return this->Samples.At(box.Low[0] + i, box.Low[1] + j, box.Low[2] + k); });
    EXPECT_EQ(samples, expected.Samples);
  }

  const SampleVolume<std::int16_t> Samples = MakeVolume<std::int16_t>(ChunkedSize);
  MemoryDisk Disk;
  const BoxSource* Plain = nullptr; ///< as it was opened
};

} // namespace

TEST_F(ChunkedSourceTest, BoxesHaveTheSamplesOfTheFileWithAnyNumberOfThreads)
{
  for (const int threads : { 2, 3, 7 })
  {
    const auto source = this->Open(ChunkedPath, { EnoughForAll, threads, {} });
    EXPECT_NE(source.get(), this->Plain);
    for (const VertexBox& box :
      { VertexBox{ { 0, 0, 0 }, ChunkedSize }, VertexBox{ { 15, 10, 19 }, { 17, 12, 21 } },
        VertexBox{ { 0, 3, 50 }, { 70, 45, 51 } }, VertexBox{ { 5, 0, 7 }, { 6, 45, 44 } } })
    {
      this->ExpectSamples(*source, box);
    }
  }
}

TEST_F(ChunkedSourceTest, EachChunkIsDecodedOnceAndStaysForOthersAsLongAsItIsShared)
{
  bool isShared = false;
  const auto source = this->Open(ChunkedPath, { EnoughForAll, 2, [&] { return isShared; } });
  const auto countBytes = [&] // of chunks
  { return this->Disk.GetBytesRead("") - this->Disk.GetBytesRead(".zarray"); };
  const std::uint64_t before = countBytes();
  for (std::int64_t slice = 0; slice < ChunkedSize[2]; slice += 17)
  {
    isShared = slice > 0; // the first boxes are of the first layer of chunks
    this->ExpectSamples(*source, { { 0, 0, slice }, { 70, 45, slice + 17 } });
    this->ExpectSamples(*source, { { 0, 0, slice }, { 70, 45, slice + 1 } });
  }
  constexpr std::uint64_t chunks = 5 * 5 * 3;
  EXPECT_EQ(countBytes() - before, chunks * 16 * 11 * 20 * 2);

  const OpenedVolume opened = Require(OpenForeignVolume(this->Disk, ChunkedPath));
  const SourceRecord record = Require(DescribeSource(
    this->Disk, OpenForeignVolume, ChunkedVolume, ChunkedPath, {}, opened.Grid, opened.Arrays));
  const auto others = Require(SourceSamples::Open(this->Disk, OpenForeignVolume, ChunkedVolume,
    record, opened.Grid, opened.Arrays, BlockCache::GetProcessCache()));
  std::vector<std::int16_t> samples(this->Samples.Samples.size());
  QueryStatistics statistics;
  const Status read = others->Read(
    0, { { 0, 0, 0 }, ChunkedSize }, reinterpret_cast<std::uint8_t*>(samples.data()), statistics);
  EXPECT_TRUE(read.IsOk()) << read.GetMessage();
  EXPECT_EQ(statistics.BlocksRead, 5u * 5) << "those of the first layer";
  EXPECT_EQ(samples, this->Samples.Samples);
}

TEST_F(ChunkedSourceTest, SmallChunksAreDecodedOnceToo)
{
  WriteZarr(this->Disk, "/data/small.zarr", this->Samples, { 4, 4, 4 });
  const auto source = this->Open("/data/small.zarr", { EnoughForAll, 2, {} });
  EXPECT_NE(source.get(), this->Plain);
  const auto countBytes = [&]
  { return this->Disk.GetBytesRead("") - this->Disk.GetBytesRead(".zarray"); };
  const std::uint64_t before = countBytes();
  this->ExpectSamples(*source, { { 0, 0, 0 }, { 70, 45, 16 } });
  this->ExpectSamples(*source, { { 0, 0, 15 }, { 70, 45, 16 } });
  EXPECT_EQ(countBytes() - before, 18u * 12 * 4 * 64 * 2);
}

TEST_F(ChunkedSourceTest, WithoutMemoryOrThreadsOrChunksFilesAreReadAsTheyWereOpened)
{
  const auto isReplaced = [&](const std::string& path, std::uint64_t memory, int threads) {
    return this->Open(path, { memory, threads, {} }).get() != this->Plain;
  };
  EXPECT_FALSE(isReplaced(ChunkedPath, EnoughForAll, 1));
  constexpr std::uint64_t layer = 70 * 45 * 20 * 2;
  EXPECT_FALSE(isReplaced(ChunkedPath, 2 * layer, 2));
  this->Disk.SetFile("/data/scan_70x45x51_int16.raw", MakeBytes(this->Samples));
  EXPECT_FALSE(isReplaced("/data/scan_70x45x51_int16.raw", EnoughForAll, 2));

  const auto source = this->Open(ChunkedPath, { 5 * layer, 1000, {} });
  EXPECT_NE(source.get(), this->Plain);
  EXPECT_LE(source->GetHeldBytes(), 5 * layer) << "few threads decode";
  this->ExpectSamples(*source, { { 0, 0, 0 }, ChunkedSize });
}

TEST_F(ChunkedSourceTest, ADamagedChunkIsOneErrorThatNamesIt)
{
  const auto source = this->Open(ChunkedPath, { EnoughForAll, 3, {} });
  this->Disk.GetFile(ChunkedPath + "/1.2.3").resize(100);
  this->ExpectSamples(*source, { { 0, 0, 0 }, { 70, 45, 20 } });
  const auto read = source->Read({ { 0, 0, 0 }, ChunkedSize });
  ASSERT_FALSE(read.IsOk());
  EXPECT_NE(read.GetStatus().GetMessage().find(ChunkedPath + "/1.2.3"), std::string::npos)
    << read.GetStatus().GetMessage();
  EXPECT_FALSE(source->Read({ { 48, 22, 30 }, { 50, 24, 31 } }).IsOk()) << "it is not kept";
}
