// SPDX-License-Identifier: BSD-3-Clause
#include "Storage/Writing/BlockedVolumeWriter.h"
#include "Fixtures/ActiveBlocks.h"

#include "Fixtures/LongTests.h"
#include "Fixtures/VolumeOnDisk.h"
#include "Storage/Spectrum/BlockMeasure.h"
#include "Storage/Spectrum/BlockWorkload.h"

#include <atomic>

#include <unistd.h>

using namespace isosurface;

namespace
{

constexpr DistributionMethod Methods[] = { DistributionMethod::Greedy, DistributionMethod::Random,
  DistributionMethod::Slab, DistributionMethod::Balanced };

std::size_t CountFolders(const MemoryDisk& disk)
{
  std::set<std::string> generations;
  const std::string prefix = HidePath(VolumePath + ".stores") + "/";
  for (const std::string& folder : disk.GetFolders())
  {
    if (folder.compare(0, prefix.size(), prefix) == 0)
    {
      generations.insert(folder.substr(prefix.size(), 6));
    }
  }
  return generations.size();
}

bool HasPartialHeader(const MemoryDisk& disk)
{
  return disk.GetFiles().count(VolumePath + ".partial") != 0;
}

/// Whether all samples can be read and are those of the volume.
template <typename T>
bool IsReadable(MemoryDisk& disk, const SampleVolume<T>& volume)
{
  const auto opened = OpenVolume(disk);
  QueryStatistics statistics;
  bool equal = true;
  for (const BlockReference& reference : Require(opened->ListBlocks(0, statistics)))
  {
    const auto block = Require(opened->ReadBlock(reference, 0, 0, 0, statistics));
    VisitVertices(block->View.Box,
      [&](const Index3& vertex)
      { equal = equal && *block->View.At<T>(vertex) == volume.At(vertex); });
  }
  return equal;
}

/// A source that counts the samples that are read from it.
class CountingSource : public MemorySource
{
public:
  CountingSource(const SampleView& samples, bool hasCheapRows)
    : MemorySource({ samples.Box, { samples } })
    , IsByRows(hasCheapRows)
  {
  }
  bool HasCheapRows() const override { return this->IsByRows; }
  Result<BoxSamples> Read(const VertexBox& box) override
  {
    this->Samples += box.GetNumberOfVertices();
    this->Largest = std::max(this->Largest, box.GetNumberOfVertices());
    return MemorySource::Read(box);
  }

  std::int64_t Samples = 0;
  std::int64_t Largest = 0; ///< of a read

private:
  bool IsByRows;
};

} // namespace

TEST(BlockedVolumeWriter, ReadsEachSampleOnceUnlessRangesDecideWhereBlocksAre)
{
  const auto volume = MakeVolume<float>({ 70, 49, 52 });
  const std::int64_t samples = volume.GetView().Box.GetNumberOfVertices();
  for (const DistributionMethod method : Methods)
  {
    for (const std::uint32_t stores : { 1u, 3u })
    {
      const bool isDecided = stores > 1 &&
        (method == DistributionMethod::Greedy || method == DistributionMethod::Balanced);
      CountingSource source(volume.GetView(), false);
      MemoryDisk disk;
      SerialCommunicator serial;
      ASSERT_TRUE(
        BlockedVolumeWriter(serial, disk)
          .Write(VolumePath, MakeGeometry(volume.GetDimensions()),
            { { "density", ValueType::Float32 } }, source, MakeSettings(16, stores, method))
          .IsOk());
      EXPECT_EQ(source.Samples, isDecided ? 2 * samples : samples)
        << GetDistributionName(method) << ", " << stores << " stores";
    }
  }
}

TEST(BlockedVolumeWriter, FailsOnAllRanksIfASourceChangesOrIsAnotherOneSomewhere)
{
  const auto volume = MakeVolume<float>({ 40, 33, 36 });
  const std::string path = "/data/scan.raw";
  for (const bool isChanged : { true, false })
  {
    MemoryDisk disk;
    disk.SetFile(path, MemoryDisk::Bytes(100));
    const auto write = [&](Communicator& ranks, bool isFaulty)
    {
      BlockedVolumeSettings settings = MakeSettings(16, 2, DistributionMethod::Slab);
      settings.Files = Require(SourceFiles::Find(disk, { path }));
      settings.Files.State.Modified += isFaulty && !isChanged ? ranks.GetRank() : 0;
      MemorySource source({ volume.GetView().Box, { volume.GetView() } });
      return BlockedVolumeWriter(ranks, disk)
        .Write(VolumePath, MakeGeometry(volume.GetDimensions()),
          { { "density", ValueType::Float32 } }, source, settings,
          [&](double)
          {
            if (isFaulty && isChanged && ranks.GetRank() == 0)
            {
              disk.SetModified(path, 7);
            }
            return true;
          })
        .GetStatus();
    };
    const auto writeAll = [&](bool isFaulty)
    {
      return ThreadCommunicator::Collect(
        3, [&](Communicator& ranks) { return write(ranks, isFaulty); });
    };
    for (const Status& status : writeAll(false))
    {
      ASSERT_TRUE(status.IsOk()) << status.GetMessage();
    }
    const auto before = disk.Copy();
    for (const Status& status : writeAll(true))
    {
      EXPECT_NE(status.GetMessage().find(isChanged ? path + ": was changed while it was read"
                                                   : "the ranks see different files"),
        std::string::npos)
        << status.GetMessage();
    }
    EXPECT_EQ(disk.Copy(), before);
  }
}

TEST(BlockedVolumeWriter, WritesTheSameBytesRowByRow)
{
  const auto volume = MakeVolume<std::int16_t>({ 70, 149, 52 });
  BlockedVolumeSettings settings = MakeSettings(16, 2, DistributionMethod::Slab);
  settings.Threads = 1;
  MemoryDisk disks[2];
  for (const bool isByRows : { false, true })
  {
    CountingSource source(volume.GetView(), isByRows);
    SerialCommunicator serial;
    ASSERT_TRUE(BlockedVolumeWriter(serial, disks[isByRows ? 1 : 0])
                  .Write(VolumePath, MakeGeometry(volume.GetDimensions()),
                    { { "density", ValueType::Int16 } }, source, settings)
                  .IsOk());
    const std::int64_t samples = volume.GetView().Box.GetNumberOfVertices();
    EXPECT_EQ(source.Largest < samples / 4, isByRows);
    EXPECT_LT(source.Samples, samples * 7 / 4);
  }
  EXPECT_TRUE(disks[0].Copy() == disks[1].Copy());
}

TEST(BlockedVolumeWriter, WritesTheSameBytesOnAnyNumberOfRanks)
{
  const auto volume = MakeVolume<std::int16_t>({ 70, 49, 52 });
  const Layout layouts[] = { SlabOfEach, WholeOnAll, OverlappingColumns, WholeOnLast };
  const auto numbersOfRanks = LongTests ? std::vector<int>{ 2, 3, 4, 7 } : std::vector<int>{ 3, 7 };
  std::size_t next = 0;
  for (const DistributionMethod method : Methods)
  {
    for (const std::uint32_t stores : { 1u, 4u, 7u })
    {
      BlockedVolumeSettings settings = MakeSettings(16, stores, method);
      settings.MemoryLimit = 6000000;
      MemoryDisk expected;
      WriteVolumeOk(expected, volume, settings);
      for (const int ranks : numbersOfRanks)
      {
        SCOPED_TRACE(std::string(GetDistributionName(method)) + ", " + std::to_string(stores) +
          " stores, " + std::to_string(ranks) + " ranks");
        MemoryDisk disk;
        WriteVolumeOk(disk, volume, settings, ranks, layouts[next++ % 4]);
        ASSERT_TRUE(disk.Copy() == expected.Copy());
      }
    }
  }
}

TEST(BlockedVolumeWriter, WritesTheSameBytesInAnyMemoryAndThreads)
{
  const auto volume = MakeVolume<float>({ 70, 70, 70 });
  BlockedVolumeSettings settings = MakeSettings(16, 3);
  settings.Threads = 1;
  MemoryDisk expected;
  WriteVolumeOk(expected, volume, settings);
  settings.Threads = 4;
  std::uint64_t most = 0;
  for (const std::uint64_t bytes : { 3800000ull, 6000000ull, 1000000000ull })
  {
    for (const Layout& layout : { Layout(OverlappingColumns), Layout(WholeOnAll) })
    {
      settings.MemoryLimit = bytes;
      MemoryDisk disk;
      for (const auto& result : WriteVolume(disk, volume, settings, 3, layout))
      {
        ASSERT_TRUE(result.IsOk()) << result.GetStatus().GetMessage();
        EXPECT_EQ(result->Blocks, 125u);
        EXPECT_LE(result->MemoryBytes, bytes);
        most = std::max(most, result->Rounds);
        EXPECT_LE(result->Rounds, bytes == 1000000000ull ? 4u : 125u);
      }
      EXPECT_TRUE(disk.Copy() == expected.Copy());
    }
  }
  EXPECT_GT(most, 8u);
}

TEST(BlockedVolumeWriter, RefusesAMemoryLimitThatIsTooSmall)
{
  for (const std::uint64_t bytes : { 1000ull, 1000000ull })
  {
    BlockedVolumeSettings settings = MakeSettings(16, 3);
    settings.MemoryLimit = bytes;
    MemoryDisk disk;
    for (const auto& result : WriteVolume(disk, MakeVolume<float>({ 50, 50, 50 }), settings, 3))
    {
      ExpectMessage(result.GetStatus(), "memory limit");
    }
    EXPECT_TRUE(disk.GetFiles().empty());
  }
}

TEST(BlockedVolumeWriter, WritesTheSpectrumOfTheWholeVolumeAndOfEachStore)
{
  const auto volume = MakeVolume<std::uint8_t>({ 60, 44, 37 });
  MemoryDisk disk;
  const auto opened = WriteAndOpen(disk, volume, MakeSettings(16, 4), 3);
  const auto total = Require(opened->GetSpectrum(0, 0));
  BlockWorkload whole(total->Bins);
  whole.Count(volume.GetView());
  WorkloadSpectrum expected(total->Bins);
  whole.MoveTo(expected);
  EXPECT_EQ(total->Triangles, expected.Triangles);
  EXPECT_EQ(total->ActiveCells, expected.ActiveCells);
  BlockMeasure measure(total->Bins, MakeGeometry(volume.GetDimensions()));
  measure.Count(volume.GetView());
  MeasureSums sums(total->Bins);
  measure.MoveTo(sums);
  sums.SetMeasures(expected);
  for (std::size_t bin = 0; bin < expected.Area.size(); ++bin)
  {
    // Each store's numbers are rounded.
    EXPECT_NEAR(static_cast<double>(total->Area[bin]), static_cast<double>(expected.Area[bin]), 4);
    EXPECT_NEAR(
      static_cast<double>(total->Volume[bin]), static_cast<double>(expected.Volume[bin]), 4);
  }
  WorkloadSpectrum sum(total->Bins);
  for (std::uint32_t store = 0; store < 4; ++store)
  {
    const auto spectrum = Require(opened->GetStoreSpectrum(0, 0, store));
    EXPECT_TRUE(sum.Add(*spectrum));
  }
  for (std::size_t quantity = 0; quantity < WorkloadSpectrum::NumberOfQuantities; ++quantity)
  {
    EXPECT_EQ(*sum.GetQuantities()[quantity], *total->GetQuantities()[quantity]) << quantity;
  }
  EXPECT_EQ(sum.AreaUnit, total->AreaUnit);
  EXPECT_FALSE(opened->GetStoreSpectrum(0, 0, 4).IsOk());
  EXPECT_FALSE(opened->GetSpectrum(1, 0).IsOk());
}

TEST(BlockedVolumeWriter, WritesTheBlocksAndBytesThatAQueryReads)
{
  for (const SegmentCodec codec : { SegmentCodec::None, SegmentCodec::Zstd })
  {
    BlockedVolumeSettings settings = MakeSettings(16, 3);
    settings.Compression.Codec = codec;
    MemoryDisk disk;
    WriteVolumeOk(disk, MakeVolume<float>({ 60, 44, 37 }), settings, 2);
    for (std::uint32_t store = 0; store < 3; ++store)
    {
      const auto spectrum = Require(OpenVolume(disk)->GetStoreSpectrum(0, 0, store));
      for (std::size_t bin = 0; bin < spectrum->Bins.Count; bin += 97)
      {
        // A rank of three reads one of three stores.
        const auto opened = OpenVolume(disk);
        QueryStatistics statistics;
        const auto active = Require(FindActiveBlocks(*opened,
          { { 0, 0, { spectrum->Bins.GetEdge(bin) } }, static_cast<int>(store), 3 }, statistics));
        for (const BlockReference& block : active)
        {
          ASSERT_TRUE(opened->ReadBlock(block, 0, 0, 0, statistics).IsOk());
        }
        EXPECT_EQ(spectrum->ActiveBlocks[bin], statistics.ActiveBlocks);
        EXPECT_EQ(spectrum->Bytes[bin], statistics.BytesRead);
      }
    }
  }
}

TEST(BlockedVolumeWriter, TakesAsManyStoresAsThereAreRanksByDefault)
{
  MemoryDisk disk;
  WriteVolumeOk(disk, MakeVolume<std::uint8_t>({ 20, 20, 20 }), MakeSettings(16, 0), 3);
  EXPECT_EQ(OpenVolume(disk)->GetHeader().NumberOfStores, 3u);
}

TEST(BlockedVolumeWriter, RefusesPiecesThatDoNotCoverTheGrid)
{
  MemoryDisk disk;
  const auto results =
    WriteVolume(disk, MakeVolume<std::uint8_t>({ 20, 20, 20 }), MakeSettings(16, 2), 3,
      [](int rank, int ranks, const Index3& size)
      {
        VertexBox box = SlabOfEach(rank, ranks, size);
        box.High[0] -= rank == 1 ? 1 : 0;
        return box;
      });
  for (const auto& result : results)
  {
    ExpectError(result.GetStatus(), StatusCode::InvalidArgument, "7860 of 8000");
  }
  EXPECT_TRUE(disk.GetFiles().empty());
}

TEST(BlockedVolumeWriter, RefusesInvalidArgumentsInTheWordsOfWhoGaveThem)
{
  const auto volume = MakeVolume<std::uint8_t>({ 20, 20, 20 });
  MemoryDisk disk;
  ExpectError(WriteVolume(disk, volume, MakeSettings(48, 2))[0].GetStatus(),
    StatusCode::InvalidArgument, "the block size, 48, is not 16, 32 or 64");
  ExpectError(WriteVolume(disk, volume, MakeSettings(16, 1u << 30))[0].GetStatus(),
    StatusCode::InvalidArgument, "the number of stores, 1073741824, is not from 1 to 4096");
  SerialCommunicator serial;
  BlockedVolumeWriter writer(serial, disk);
  const VolumePiece piece{ { { 0, 0, 0 }, volume.GetDimensions() }, { volume.GetView() } };
  const auto write = [&](const GridGeometry& grid, const std::vector<ArrayDescription>& arrays)
  { return writer.Write(VolumePath, grid, arrays, piece, MakeSettings(16, 1)).GetStatus(); };
  const GridGeometry grid = MakeGeometry(volume.GetDimensions());
  const ArrayDescription array = { "a", ValueType::UInt8 };
  GridGeometry infinite = grid;
  infinite.Spacing[1] = std::nan("");
  GridGeometry flat = grid;
  flat.Spacing[2] = 0;
  const struct
  {
    GridGeometry Grid;
    std::vector<ArrayDescription> Arrays;
    const char* Reason;
  } refused[] = {
    { infinite, { array }, "the grid has an origin, spacing or direction that is not finite" },
    { flat, { array }, "the grid has a spacing of 0" },
    { GridGeometry{}, { array }, "the grid is empty" },
    { grid, {}, "the arrays do not have from 1 to" },
    { grid, { { "a", ValueType::UInt16 } }, "samples do not fit the grid or the arrays" },
    { grid, { array, array }, "two arrays have the name \"a\"" },
    { grid, { { "\xff", ValueType::UInt8 } }, "is not UTF-8" },
    { MakeGeometry({ 10, 20, 20 }), { array }, "piece does not fit" },
  };
  for (const auto& bad : refused)
  {
    ExpectError(write(bad.Grid, bad.Arrays), StatusCode::InvalidArgument, bad.Reason);
  }
  EXPECT_TRUE(disk.GetFiles().empty());
  EXPECT_TRUE(write(grid, { array }).IsOk());
}

TEST(BlockedVolumeWriter, RefusesRanksThatDisagree)
{
  const auto volume = MakeVolume<std::uint8_t>({ 20, 20, 20 });
  MemoryDisk disk;
  std::atomic<int> refused{ 0 };
  ThreadCommunicator::Run(3,
    [&](Communicator& communicator)
    {
      BlockedVolumeSettings settings = MakeSettings(16, 2);
      settings.RandomSeed += communicator.GetRank() == 2 ? 1 : 0;
      refused +=
        !BlockedVolumeWriter(communicator, disk)
           .Write(VolumePath, MakeGeometry(volume.GetDimensions()), { { "a", ValueType::UInt8 } },
             { { { 0, 0, 0 }, volume.GetDimensions() }, { volume.GetView() } }, settings)
           .IsOk();
    });
  EXPECT_EQ(refused, 3);
}

TEST(BlockedVolumeWriter, WarnsBeforeItWritesToADiskWithoutRoom)
{
  for (const int blockSize : { 16, 32, 64 })
  {
    const auto volume = MakeVolume<std::uint16_t>({ 150, 66, 90 });
    BlockedVolumeSettings settings = MakeSettings(blockSize, 2);
    settings.NumberOfReplicas = 2;
    MemoryDisk disk;
    std::string warning;
    std::size_t files = 0;
    settings.Warn = [&](const std::string& text)
    {
      warning = text;
      files = disk.GetFiles().size();
    };
    EXPECT_TRUE(WriteVolume(disk, volume, settings)[0].IsOk());
    EXPECT_EQ(warning, "") << "nobody knows how much room there is";
    std::uint64_t written = 0;
    for (const auto& file : disk.GetFiles())
    {
      const std::string& path = file.first;
      written += path.substr(path.rfind('/') + 1) == "blocks" ? file.second->size() : 0;
    }
    MemoryDisk small;
    small.SetFreeBytes(written - 1);
    settings.Warn = [&](const std::string& text)
    {
      warning = text;
      files = small.GetFiles().size();
    };
    EXPECT_TRUE(WriteVolume(small, volume, settings)[0].IsOk()) << "it is only a warning";
    EXPECT_NE(warning.find("volume.bvol: takes up to "), std::string::npos) << warning;
    EXPECT_EQ(files, 0u);
    warning = "";
    MemoryDisk large;
    large.SetFreeBytes(written);
    EXPECT_TRUE(WriteVolume(large, volume, settings)[0].IsOk());
    EXPECT_EQ(warning, "");
  }
}

TEST(BlockedVolumeWriter, LeavesTheOldVolumeWhenTheDiskIsFull)
{
  const auto before = MakeVolume<std::uint8_t>({ 40, 30, 20 });
  const auto after = MakeVolume<std::uint8_t>({ 40, 30, 20 }, 2);
  for (const int ranks : { 1, 3 })
  {
    MemoryDisk disk;
    WriteVolumeOk(disk, before, MakeSettings(16, 2), ranks);
    const auto files = disk.Copy();
    std::uint64_t failures = 0;
    for (std::uint64_t write = 0;; ++write)
    {
      disk.FailFromWrite(write);
      const auto results = WriteVolume(disk, after, MakeSettings(16, 2), ranks);
      const bool isDone = results[0].IsOk();
      for (const auto& result : results)
      {
        ASSERT_EQ(result.IsOk(), isDone) << write;
      }
      if (isDone)
      {
        break;
      }
      ++failures;
      const bool isVisible = disk.GetFile(VolumePath) != files.at(VolumePath);
      if (isVisible)
      {
        // Only the last step can fail after the rename: making the name durable.
        EXPECT_TRUE(IsReadable(disk, after));
        EXPECT_LE(CountFolders(disk), 2u);
        continue;
      }
      ASSERT_TRUE(disk.Copy() == files) << "write " << write << " failed, but left something";
    }
    EXPECT_GT(failures, 20u);
    EXPECT_TRUE(IsReadable(disk, after));
    EXPECT_EQ(CountFolders(disk), 1u);
    EXPECT_FALSE(HasPartialHeader(disk));
  }
}

TEST(BlockedVolumeWriter, CleansUpAfterKilledRuns)
{
  const auto volume = MakeVolume<std::uint8_t>({ 20, 20, 20 });
  MemoryDisk disk;
  WriteVolumeOk(disk, volume, MakeSettings(16, 2));
  // A killed run leaves a generation without a header, and an incomplete header.
  const std::string leftover = HidePath(VolumePath + ".stores") + "/000007";
  ASSERT_TRUE(disk.MakeDirectories(leftover + "/store-00000").IsOk());
  ASSERT_TRUE(disk.CreateForWriting(leftover + "/store-00000/blocks").IsOk());
  ASSERT_TRUE(disk.CreateForWriting(VolumePath + ".partial").IsOk());
  ASSERT_TRUE(disk.MakeDirectories(HidePath(VolumePath + ".stores") + "/notes").IsOk());
  EXPECT_TRUE(IsReadable(disk, volume));
  WriteVolumeOk(disk, volume, MakeSettings(16, 2));
  EXPECT_TRUE(IsReadable(disk, volume));
  EXPECT_FALSE(disk.Exists(leftover));
  EXPECT_FALSE(HasPartialHeader(disk));
  EXPECT_TRUE(disk.Exists(HidePath(VolumePath + ".stores") + "/000008"));
  EXPECT_TRUE(disk.Exists(HidePath(VolumePath + ".stores") + "/notes"));
}

TEST(BlockedVolumeWriter, StopsOnAllRanksWhenOneIsAsked)
{
  const auto volume = MakeVolume<std::uint8_t>({ 60, 60, 60 });
  BlockedVolumeSettings settings = MakeSettings(16, 2);
  settings.MemoryLimit = 2000000;
  for (const double limit : { 0.0, 0.1, 0.4, 0.7, 0.93 })
  {
    MemoryDisk disk;
    std::atomic<double> told{ 0 };
    const auto results = WriteVolume(disk, volume, settings, 3, SlabOfEach,
      [&](double share)
      {
        // Any rank may be the one that was told most.
        for (double most = told; share > most && !told.compare_exchange_weak(most, share);)
        {
        }
        return share <= limit;
      });
    for (const auto& result : results)
    {
      ASSERT_FALSE(result.IsOk());
      EXPECT_EQ(result.GetStatus().GetCode(), StatusCode::Aborted);
    }
    EXPECT_GT(told, limit);
    EXPECT_TRUE(disk.GetFiles().empty());
    EXPECT_EQ(CountFolders(disk), 0u);
  }
}

namespace
{

/// Fails from a given read on.
class FailingSource : public MemorySource
{
public:
  FailingSource(const VolumePiece& piece, int reads)
    : MemorySource(piece)
    , Reads(reads)
  {
  }
  Result<BoxSamples> Read(const VertexBox& box) override
  {
    if (this->Reads-- <= 0)
    {
      return Status(StatusCode::IoError, "samples.raw: cannot read: Input/output error");
    }
    return MemorySource::Read(box);
  }

private:
  int Reads;
};

} // namespace

TEST(BlockedVolumeWriter, LeavesTheOldVolumeWhenARankCannotRead)
{
  const auto volume = MakeVolume<std::uint8_t>({ 60, 60, 60 });
  MemoryDisk disk;
  WriteVolumeOk(disk, volume, MakeSettings(16, 2));
  const auto files = disk.Copy();
  BlockedVolumeSettings settings = MakeSettings(16, 3);
  settings.MemoryLimit = 2000000;
  for (const Layout& layout : { Layout(SlabOfEach), Layout(WholeOnAll) })
  {
    for (const int reads : { 0, 1, 2, 3 })
    {
      std::atomic<int> failed{ 0 };
      std::atomic<int> told{ 0 };
      ThreadCommunicator::Run(3,
        [&](Communicator& communicator)
        {
          const VertexBox box = layout(communicator.GetRank(), 3, volume.GetDimensions());
          const PieceOfVolume<std::uint8_t> part(volume, box);
          FailingSource source({ box, { part.View } }, communicator.GetRank() == 1 ? reads : 1000);
          const auto written = BlockedVolumeWriter(communicator, disk)
                                 .Write(VolumePath, MakeGeometry(volume.GetDimensions()),
                                   { { "density", ValueType::UInt8 } }, source, settings);
          failed += written.IsOk() ? 0 : 1;
          const std::string& message = written.GetStatus().GetMessage();
          told += message.find("samples.raw") != std::string::npos ? 1 : 0;
        });
      EXPECT_EQ(failed, 3) << reads;
      EXPECT_EQ(told, 3) << reads;
      EXPECT_TRUE(disk.Copy() == files);
    }
  }
}

TEST(BlockedVolumeWriter, WritesToTheLocalDisk)
{
  const std::string folder =
    ::testing::TempDir() + "isosurface-writer-test-" + std::to_string(::getpid());
  FileSystem& files = GetLocalFileSystem();
  ASSERT_TRUE(files.RemoveAll(folder).IsOk());
  ASSERT_TRUE(files.MakeDirectories(folder).IsOk());
  const auto volume = MakeVolume<std::uint16_t>({ 40, 30, 20 });
  SerialCommunicator serial;
  const auto written = Require(BlockedVolumeWriter(serial).Write(folder + "/a.bvol",
    MakeGeometry(volume.GetDimensions()), { { "a", ValueType::UInt16 } },
    { { { 0, 0, 0 }, volume.GetDimensions() }, { volume.GetView() } }, MakeSettings(16, 2)));
  const auto opened = Require(BlockedVolume::Open(folder + "/a.bvol"));
  QueryStatistics statistics;
  const auto active = Require(FindActiveBlocks(*opened, { { 0, 0, { 50 } } }, statistics));
  ASSERT_FALSE(active.empty());
  EXPECT_TRUE(opened->ReadBlock(active[0], 0, 0, 0, statistics).IsOk());
  ASSERT_TRUE(files.RemoveAll(folder).IsOk());
}
