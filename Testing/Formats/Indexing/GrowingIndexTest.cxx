// SPDX-License-Identifier: BSD-3-Clause
// What is shown of a file while its index is written, and the index itself.
#include "Formats/Indexing/GrowingIndex.h"
#include "Fixtures/SampleFiles.h"
#include "Fixtures/VolumeOnDisk.h"
#include "Fixtures/ZarrOnDisk.h"
#include "Formats/Indexing/SourceSampler.h"
#include "Formats/Opener/ForeignVolume.h"
#include "Ground/Volume/SampleCopy.h"
#include "Storage/Store/FinishedLayers.h"

#include <algorithm>
#include <chrono>
#include <map>
#include <mutex>
#include <thread>

using namespace isosurface;

namespace
{

const std::string GrowingSource = "/data/scan.zarr";
constexpr std::uint64_t GrowingMemory = std::uint64_t{ 64 } << 20;
const Index3 GrowingSize = { 70, 45, 51 };
const Index3 GrowingChunk = { 16, 11, 20 };

SourceIndex FindIndex(FileSystem& disk, const std::string& source)
{
  return SourceIndex::Find(disk, source, "", "", "");
}

/// A MetaImage of int16 and its samples.
SampleVolume<std::int16_t> WriteMetaImage(MemoryDisk& disk, const std::string& path, Index3 size)
{
  auto volume = MakeRamp<std::int16_t>(size);
  disk.SetFile(path + ".raw", MakeBytes(volume));
  disk.SetFile(path,
    MakeBytes("ObjectType = Image\nNDims = 3\nDimSize = " + std::to_string(size[0]) + " " +
      std::to_string(size[1]) + " " + std::to_string(size[2]) +
      "\nElementSpacing = 2 3 4\nOffset = 10 20 30\nElementType = MET_SHORT\nElementDataFile = " +
      path.substr(path.rfind('/') + 1) + ".raw\n"));
  return volume;
}

/// A NRRD file of int16 in a gzip stream, and its samples.
SampleVolume<std::int16_t> WriteGzipNrrd(MemoryDisk& disk, const std::string& path)
{
  auto volume = MakeRamp<std::int16_t>({ 256, 256, 200 });
  MemoryDisk::Bytes bytes = MakeBytes("NRRD0004\ntype: short\nendian: little\ndimension: 3\nsizes: "
                                      "256 256 200\nencoding: gzip\n\n");
  const MemoryDisk::Bytes stream = Deflate(MakeBytes(volume));
  bytes.insert(bytes.end(), stream.begin(), stream.end());
  disk.SetFile(path, bytes);
  return volume;
}

/// All samples of a volume at level 0.
std::vector<std::int16_t> ReadSamples(BlockedVolume& volume)
{
  const GridGeometry& grid = volume.GetHeader().Grid;
  std::vector<std::int16_t> samples(static_cast<std::size_t>(grid.GetNumberOfVertices()));
  QueryStatistics statistics;
  const auto blocks = Require(volume.ListBlocks(0, statistics));
  const VertexBox whole{ { 0, 0, 0 }, grid.GetDimensions() };
  for (const BlockReference& block : blocks)
  {
    const auto decoded = Require(volume.ReadBlock(block, 0, 0, 0, statistics));
    CopyBox(decoded->View, decoded->View.Box, whole, samples.data());
  }
  return samples;
}

/// Checks that a sample has every n-th sample of a box.
void ExpectSample(const SourceSample& sample, const SampleVolume<std::int16_t>& volume,
  const Index3& first, const Index3& step)
{
  const Index3 size = sample.Volume->GetHeader().Grid.GetDimensions();
  const SampleVolume<std::int16_t> expected(size,
    [&](auto i, auto j, auto k)
    { return volume.At(first[0] + i * step[0], first[1] + j * step[1], first[2] + k * step[2]); });
  EXPECT_EQ(ReadSamples(*sample.Volume), expected.Samples);
}

std::vector<SourceSample> ReadSamplesOf(
  FileSystem& disk, const std::string& source, const SampleLimits& limits, int ranks)
{
  return ThreadCommunicator::Collect(ranks,
    [&](Communicator& communicator)
    { return Require(ReadSourceSample(communicator, disk, FindIndex(disk, source), limits)); });
}

} // namespace

TEST(SourceSample, OfRowsIsALatticeOfTheWholeFile)
{
  MemoryDisk disk;
  const auto volume = WriteMetaImage(disk, "/data/scan.mhd", { 2048, 40, 33 });
  for (const int ranks : { 1, 3 })
  {
    const std::uint64_t before = disk.GetBytesRead(".raw");
    for (const SourceSample& sample : ReadSamplesOf(disk, "/data/scan.mhd", { 1000, 8000 }, ranks))
    {
      EXPECT_EQ(sample.Text, "one of 128 x 2 x 2 samples");
      EXPECT_FALSE(sample.IsWhole);
      ExpectSample(sample, volume, { 0, 0, 0 }, { 128, 2, 2 });
      const GridGeometry& grid = sample.Volume->GetHeader().Grid;
      EXPECT_EQ(grid.Spacing, (std::array<double, 3>{ 256, 6, 8 }));
      EXPECT_EQ(grid.Origin, (std::array<double, 3>{ 10, 20, 30 }));
    }
    EXPECT_LT(
      disk.GetBytesRead(".raw") - before, disk.GetFile("/data/scan.mhd.raw").size() * 2 / 3);
  }
}

TEST(SourceSample, OfRowsShowsTheWholeFileHoweverLittleTimeThereIs)
{
  MemoryDisk disk;
  const auto volume = WriteMetaImage(disk, "/data/scan.mhd", { 64, 64, 64 });
  const auto samples = ReadSamplesOf(disk, "/data/scan.mhd", { 0, 4096 }, 2);
  EXPECT_EQ(samples[0].Text, "one of 4 x 4 x 32 samples");
  ExpectSample(samples[1], volume, { 0, 0, 0 }, { 4, 4, 32 });
}

TEST(SourceSample, OfChunksIsABoxInTheMiddleUntilThereIsTimeForAll)
{
  MemoryDisk disk;
  const auto volume = MakeVolume<std::int16_t>(GrowingSize);
  WriteZarr(disk, GrowingSource, volume, GrowingChunk);
  for (const int ranks : { 1, 4 })
  {
    const auto first = ReadSamplesOf(disk, GrowingSource, { 0, 20000 }, ranks);
    EXPECT_EQ(first[0].Text, "one of 2 x 1 x 1 samples, the middle 3 %");
    ExpectSample(first[0], volume, { 32, 22, 20 }, { 2, 1, 1 });
    const auto all = ReadSamplesOf(disk, GrowingSource, { 1000, 20000 }, ranks);
    EXPECT_EQ(all[0].Text, "one of 4 x 2 x 2 samples");
    ExpectSample(all[0], volume, { 0, 0, 0 }, { 4, 2, 2 });
    EXPECT_FALSE(all[0].IsWhole);
    const auto whole = ReadSamplesOf(disk, GrowingSource, { 1000, 1000000 }, ranks);
    EXPECT_TRUE(whole[0].IsWhole);
    ExpectSample(whole[0], volume, { 0, 0, 0 }, { 1, 1, 1 });
  }
}

TEST(SourceSample, OfAStreamIsItsFirstSlicesUntilThereIsTimeForAll)
{
  MemoryDisk disk;
  const std::string source = "/data/scan.nrrd";
  const auto volume = WriteGzipNrrd(disk, source);
  for (const int ranks : { 1, 3 })
  {
    const SourceSample first = ReadSamplesOf(disk, source, { 0, 210000 }, ranks)[0];
    EXPECT_NE(first.Text.find("one of 4 x 4 x 4 samples, the first "), std::string::npos)
      << first.Text;
    EXPECT_LT(first.Share, 0.9);
    ExpectSample(first, volume, { 0, 0, 0 }, { 4, 4, 4 });
    const auto all = ReadSamplesOf(disk, source, { 1000, 210000 }, ranks);
    EXPECT_EQ(all.back().Text, "one of 4 x 4 x 4 samples");
    ExpectSample(all.back(), volume, { 0, 0, 0 }, { 4, 4, 4 });
  }
}

TEST(SourceSample, OfAPyramidIsItsOwnCoarseLevel)
{
  MemoryDisk disk;
  const auto fine = MakeVolume<std::int16_t>({ 40, 40, 40 });
  const auto coarse = MakeVolume<std::int16_t>({ 20, 20, 20 });
  WriteZarr(disk, GrowingSource + "/0", fine, GrowingChunk);
  WriteZarr(disk, GrowingSource + "/1", coarse, GrowingChunk);
  disk.SetFile(GrowingSource + "/.zgroup", MakeBytes("{\"zarr_format\": 2}"));
  disk.SetFile(GrowingSource + "/.zattrs",
    MakeBytes(
      R"({"multiscales": [{"axes": [{"name": "z"}, {"name": "y"}, {"name": "x"}], "datasets": [
      {"path": "0", "coordinateTransformations": [{"type": "scale", "scale": [1, 1, 1]}]},
      {"path": "1", "coordinateTransformations": [{"type": "scale", "scale": [2, 2, 2]},
        {"type": "translation", "translation": [0.5, 0.5, 0.5]}]}]}]})"));
  const auto sample = ReadSamplesOf(disk, GrowingSource, { 1000, 10000 }, 1)[0];
  EXPECT_EQ(sample.Text, "level 1 of the file, whose samples are averages");
  EXPECT_FALSE(sample.IsWhole);
  ExpectSample(sample, coarse, { 0, 0, 0 }, { 1, 1, 1 });
  EXPECT_EQ(sample.Volume->GetHeader().Grid.Spacing, (std::array<double, 3>{ 2, 2, 2 }));
  EXPECT_EQ(sample.Volume->GetHeader().Grid.Origin, (std::array<double, 3>{ 0.5, 0.5, 0.5 }));
  const auto coarsest = ReadSamplesOf(disk, GrowingSource, { 1000, 1000 }, 1)[0];
  EXPECT_EQ(
    coarsest.Text, "level 1 of the file, whose samples are averages, one of 2 x 2 x 2 samples");
}

TEST(SourceSample, OfADamagedFileIsOneErrorOnAllRanks)
{
  MemoryDisk disk;
  WriteMetaImage(disk, "/data/scan.mhd", { 64, 64, 64 });
  disk.GetFile("/data/scan.mhd.raw").resize(1000);
  const auto statuses = ThreadCommunicator::Collect(3,
    [&](Communicator& ranks)
    { return ReadSourceSample(ranks, disk, FindIndex(disk, "/data/scan.mhd"), {}).GetStatus(); });
  for (const Status& status : statuses)
  {
    ExpectMessage(status, "/data/scan.mhd");
  }
}

TEST(SourceSample, IsAbortedOnAllRanks)
{
  MemoryDisk disk;
  WriteMetaImage(disk, "/data/scan.mhd", { 64, 64, 64 });
  const auto statuses = ThreadCommunicator::Collect(3,
    [&](Communicator& ranks)
    {
      const bool goesOn = ranks.GetRank() != 1;
      return ReadSourceSample(ranks, disk, FindIndex(disk, "/data/scan.mhd"), { 1000, 4096 },
        [goesOn](double) { return goesOn; })
        .GetStatus();
    });
  for (const Status& status : statuses)
  {
    EXPECT_EQ(status.GetCode(), StatusCode::Aborted);
  }
}

namespace
{

class GrowingIndexTest : public testing::TestWithParam<int>
{
protected:
  GrowingIndexTest() { WriteZarr(this->Disk, GrowingSource, this->Volume, GrowingChunk); }

  static std::unique_ptr<GrowingIndex> Begin(Communicator& ranks, MemoryDisk& disk)
  {
    return std::make_unique<GrowingIndex>(
      ranks, disk, FindIndex(disk, GrowingSource), SourceSample{}, GrowingMemory);
  }

  const SampleVolume<std::int16_t> Volume = MakeVolume<std::int16_t>(GrowingSize);
  MemoryDisk Disk;
};

/// Indexes a file of which a part has been sampled; checks that each larger sample, the last one of the
/// whole file included, has the samples of the file.
void GrowSamples(MemoryDisk& disk, const std::string& source, int ranks,
  const std::vector<SourceSample>& first, const SampleVolume<std::int16_t>& volume, Index3 step)
{
  const auto grow = [&](Communicator& all)
  {
    GrowingIndex growing(all, disk, FindIndex(disk, source),
      first[static_cast<std::size_t>(all.GetRank())], GrowingMemory);
    double share = growing.GetSample().Share;
    for (bool hasEnded = false; !hasEnded || share < 1;)
    {
      hasEnded = hasEnded || growing.Advance(all, 0.001);
      if (growing.HasLargerSample(all))
      {
        EXPECT_TRUE(growing.EnlargeSample(all).IsOk());
        EXPECT_GT(growing.GetSample().Share, share);
        share = growing.GetSample().Share;
        ExpectSample(growing.GetSample(), volume, { 0, 0, 0 }, step);
      }
    }
  };
  ThreadCommunicator::Run(ranks, grow);
}

} // namespace

TEST_P(GrowingIndexTest, IsTheIndexThatIsWrittenAtOnce)
{
  MemoryDisk atOnce;
  WriteZarr(atOnce, GrowingSource, this->Volume, GrowingChunk);
  ThreadCommunicator::Run(this->GetParam(),
    [&](Communicator& ranks)
    {
      EXPECT_TRUE(
        WriteSourceIndex(ranks, atOnce, FindIndex(atOnce, GrowingSource), GrowingMemory).IsOk());
      const auto growing = Begin(ranks, this->Disk);
      while (!growing->Advance(ranks, 0.01))
      {
      }
      EXPECT_TRUE(growing->GetStatus().IsOk()) << growing->GetStatus().GetMessage();
      EXPECT_GT(growing->GetProgress(), 0.9);
      EXPECT_GE(growing->EstimateSeconds(), 0);
    });
  EXPECT_EQ(this->Disk.Copy(), atOnce.Copy());
}

TEST_P(GrowingIndexTest, GivesLargerSamplesOfWhatAllRanksHaveIndexed)
{
  const auto first = ReadSamplesOf(this->Disk, GrowingSource, { 0, 20000 }, this->GetParam());
  EXPECT_LT(first[0].Share, 0.1);
  GrowSamples(this->Disk, GrowingSource, this->GetParam(), first, this->Volume, { 4, 2, 2 });
}

TEST_P(GrowingIndexTest, OfAStreamGivesLargerSamplesOfItsFirstSlices)
{
  const std::string source = "/data/scan.nrrd";
  const auto volume = WriteGzipNrrd(this->Disk, source);
  const auto first = ReadSamplesOf(this->Disk, source, { 0, 210000 }, this->GetParam());
  EXPECT_LT(first[0].Share, 0.9);
  GrowSamples(this->Disk, source, this->GetParam(), first, volume, { 4, 4, 4 });
}

TEST_P(GrowingIndexTest, OfAStreamHasExactLayersBeforeItsEnd)
{
  const std::string source = "/data/scan.nrrd";
  const auto volume = WriteGzipNrrd(this->Disk, source);
  const auto index = FindIndex(this->Disk, source);
  const double isovalue = volume.At(100, 100, 90);
  std::mutex mutex;
  std::map<std::int64_t, std::size_t>
    found; // active blocks of all ranks, by slices that are finished
  const auto check = [&](FinishedLayers& finished, std::int64_t slices)
  {
    const auto blocks = Require(finished.FindBlocks({ 0, 0, { isovalue } }, { 0 }, slices, 0, 1));
    for (std::size_t n = 0; n < blocks->GetNumberOfBlocks(); ++n)
    {
      const BlockSamples samples = Require(blocks->Acquire(n));
      const VertexBox box = blocks->GetVertices(n);
      const SampleVolume<std::int16_t> expected(box.GetSize(),
        [&](auto i, auto j, auto k)
        { return volume.At(box.Low[0] + i, box.Low[1] + j, box.Low[2] + k); });
      for (const SampleView& view : { samples.Scalars, samples.Attributes[0].Components[0] })
      {
        std::vector<std::int16_t> read(expected.Samples.size());
        CopyBox(view, box, box, read.data());
        EXPECT_EQ(read, expected.Samples);
      }
    }
    const std::lock_guard<std::mutex> lock(mutex);
    found[slices] += blocks->GetNumberOfBlocks();
  };
  ThreadCommunicator::Run(this->GetParam(),
    [&](Communicator& ranks)
    {
      FinishedLayers finished(this->Disk, OpenForeignVolume, index.Path);
      std::thread reader(
        [&]
        {
          for (std::int64_t slices = 0; slices < 199;)
          {
            const bool hasEnded = finished.HasEnded();
            if (finished.CountSlices() > slices)
            {
              slices = std::min(slices + 32, std::int64_t{ 199 });
              check(finished, slices);
            }
            else if (hasEnded)
            {
              break;
            }
            else
            {
              std::this_thread::sleep_for(std::chrono::milliseconds(1));
            }
          }
        });
      const auto written = WriteSourceIndex(
        ranks, this->Disk, index, std::uint64_t{ 24 } << 20, {}, nullptr, &finished);
      EXPECT_TRUE(written.IsOk()) << written.GetStatus().GetMessage();
      finished.End();
      reader.join();
    });
  const BlockGrid grid({ 256, 256, 200 }, 32);
  for (const auto& [slices, blocks] : found)
  {
    std::size_t active = 0;
    for (std::int64_t block = 0; block < grid.GetNumberOfBlocks(); ++block)
    {
      const VertexBox box = grid.GetVertices(block);
      const SampleVolume<std::int16_t> samples(box.GetSize(),
        [&](auto i, auto j, auto k)
        { return volume.At(box.Low[0] + i, box.Low[1] + j, box.Low[2] + k); });
      const auto [least, most] =
        std::minmax_element(samples.Samples.begin(), samples.Samples.end());
      active += box.Low[2] < slices && *least < isovalue && *most >= isovalue ? 1 : 0;
    }
    EXPECT_EQ(blocks, active) << slices;
  }
  EXPECT_EQ(found.size(), 7u);
}

TEST_P(GrowingIndexTest, LeavesTheOlderIndexAsItWasWhereverItIsDropped)
{
  ThreadCommunicator::Run(this->GetParam(),
    [&](Communicator& ranks)
    {
      EXPECT_TRUE(
        WriteSourceIndex(ranks, this->Disk, FindIndex(this->Disk, GrowingSource), GrowingMemory)
          .IsOk());
    });
  const SourceIndex index = FindIndex(this->Disk, GrowingSource);
  for (int advances = 0; advances < 12; ++advances)
  {
    ThreadCommunicator::Run(this->GetParam(),
      [&](Communicator& ranks)
      {
        const auto growing = Begin(ranks, this->Disk);
        for (int advance = 0; advance < advances; ++advance)
        {
          if (growing->Advance(ranks, 0))
          {
            break;
          }
        }
      });
    EXPECT_EQ(Require(FindIndexState(this->Disk, index)), IndexState::Current);
    EXPECT_EQ(ReadSamples(*Require(BlockedVolume::Open(
                index.Path, this->Disk, std::make_shared<BlockCache>(1 << 24), OpenForeignVolume))),
      this->Volume.Samples);
  }
}

TEST_P(GrowingIndexTest, CanBeStopped)
{
  ThreadCommunicator::Run(this->GetParam(),
    [&](Communicator& ranks)
    {
      const auto growing = Begin(ranks, this->Disk);
      growing->Stop();
      while (!growing->Advance(ranks, 0.01))
      {
      }
      EXPECT_EQ(growing->GetStatus().GetCode(), StatusCode::Aborted);
    });
  EXPECT_FALSE(this->Disk.Exists(GrowingSource + ".bvol"));
}

TEST_P(GrowingIndexTest, IsKeptInMemoryByOneRankThatCannotWriteIt)
{
  this->Disk.FailFromWrite(0);
  ThreadCommunicator::Run(this->GetParam(),
    [&](Communicator& ranks)
    {
      std::shared_ptr<BlockedVolume> volume;
      {
        const auto growing = Begin(ranks, this->Disk);
        while (!growing->Advance(ranks, 0.01))
        {
        }
        if (ranks.GetSize() > 1)
        {
          ExpectMessage(growing->GetStatus(), "No space left on device");
          return;
        }
        ASSERT_TRUE(growing->GetStatus().IsOk()) << growing->GetStatus().GetMessage();
        EXPECT_TRUE(growing->IsCurrent());
        EXPECT_TRUE(growing->IsInMemory());
        volume = Require(growing->Open({}));
        EXPECT_EQ(ReadSamples(*volume), this->Volume.Samples);
        this->Disk.SetFile(GrowingSource + "/more", { 1 });
        EXPECT_FALSE(growing->IsCurrent());
      }
      EXPECT_TRUE(volume->GetHeader().IsInPlace()) << "it needs nothing else";
    });
  EXPECT_FALSE(this->Disk.Exists(GrowingSource + ".bvol"));
}

TEST_P(GrowingIndexTest, TellsAllRanksWhyItFailed)
{
  this->Disk.FailFromWrite(3);
  ThreadCommunicator::Run(this->GetParam(),
    [&](Communicator& ranks)
    {
      const auto growing = Begin(ranks, this->Disk);
      while (!growing->Advance(ranks, 0.01))
      {
      }
      ExpectMessage(growing->GetStatus(), "No space left on device");
    });
  EXPECT_FALSE(this->Disk.Exists(GrowingSource + ".bvol"));
}

INSTANTIATE_TEST_SUITE_P(Ranks, GrowingIndexTest, testing::Values(1, 3));
