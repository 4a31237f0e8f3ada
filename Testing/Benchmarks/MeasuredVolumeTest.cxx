// SPDX-License-Identifier: BSD-3-Clause
#include "Volumes/MeasuredVolume.h"
#include "Fixtures/ActiveBlocks.h"
#include "Volumes/LargeVolume.h"

#include "Formats/Plain/RawVolume.h"
#include "Storage/Store/BlockedVolume.h"
#include "Storage/Writing/BlockedVolumeWriter.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <string>
#include <unistd.h>

using namespace isosurface;

namespace
{

/// A rough ball of int16 samples, on disk.
class MeasuredVolumeTest : public ::testing::Test
{
protected:
  void SetUp() override
  {
    this->Folder =
      (std::filesystem::temp_directory_path() / ("measured-volume-" + std::to_string(::getpid())))
        .string();
    std::filesystem::create_directories(this->Folder);
    std::vector<std::int16_t> samples;
    for (int vertex = 0; vertex < 20 * 20 * 20; ++vertex)
    {
      const double x = vertex % 20 - 9.0;
      const double y = vertex / 20 % 20 - 10.0;
      const double z = vertex / 400 - 8.0;
      samples.push_back(static_cast<std::int16_t>(
        std::lround(std::max(-300.0, 1000 - 12 * (x * x + y * y + z * z)) + vertex % 7)));
    }
    std::ofstream(this->Folder + "/scan.raw", std::ios::binary)
      .write(reinterpret_cast<const char*>(samples.data()),
        static_cast<std::streamsize>(2 * samples.size()));
    RawVolume scan;
    scan.Grid.Extent = { 0, 19, 0, 19, 0, 19 };
    scan.Type = ValueType::Int16;
    scan.Paths = { this->Folder + "/scan.raw" };
    LargeVolumeSettings settings;
    settings.Dimensions = { 90, 75, 81 };
    settings.Type = ValueType::Int16;
    const auto large = LargeVolume::Open(GetLocalFileSystem(), scan, settings);
    ASSERT_TRUE(large.IsOk());
    ASSERT_TRUE(large->Write(GetLocalFileSystem(), this->Folder + "/large.mhd", 2).IsOk());
  }
  void TearDown() override { std::filesystem::remove_all(this->Folder); }

  std::string Folder;
};

} // namespace

TEST_F(MeasuredVolumeTest, FindsTheLoadsOfVolumesThatAreWritten)
{
  const std::string oneStore = this->Folder + "/one.bvol";
  ASSERT_TRUE(WriteVolume(this->Folder + "/large.mhd", oneStore, 16, 1, 1).IsOk());
  const auto measured = MeasuredVolume::Read(oneStore, 2);
  ASSERT_TRUE(measured.IsOk()) << measured.GetStatus().GetMessage();

  const auto raw = RawVolume::ReadHeader(GetLocalFileSystem(), this->Folder + "/large.mhd");
  ASSERT_TRUE(raw.IsOk());
  for (const DistributionMethod method : { DistributionMethod::Greedy, DistributionMethod::Random,
         DistributionMethod::Slab, DistributionMethod::Balanced })
  {
    SCOPED_TRACE(GetDistributionName(method));
    BlockedVolumeSettings settings;
    settings.BlockSize = 16;
    settings.NumberOfStores = 6;
    settings.Distribution = method;
    settings.Compression.Codec = SegmentCodec::Lz4;
    SerialCommunicator alone;
    const std::string path = this->Folder + "/six.bvol";
    auto source = raw->Open(GetLocalFileSystem());
    ASSERT_TRUE(BlockedVolumeWriter(alone)
                  .Write(path, raw->Grid, { { "a", raw->Type } }, **source, settings)
                  .IsOk());
    auto volume = BlockedVolume::Open(path);
    ASSERT_TRUE(volume.IsOk());
    const StoreLoads loads = measured->Spectra.Distribute(measured->Distribute(method, 6), 6);
    for (std::uint32_t store = 0; store < 6; ++store)
    {
      const auto spectrum = (*volume)->GetStoreSpectrum(0, 0, store);
      ASSERT_TRUE(spectrum.IsOk());
      ASSERT_TRUE((*spectrum)->Bins == loads.Bins);
      for (std::size_t bin = 0; bin < loads.Bins.Count; ++bin)
      {
        ASSERT_EQ(loads.Stores[store][bin].Triangles, (*spectrum)->Triangles[bin]);
      }
      // What a query of this store finds and reads.
      for (std::size_t bin = 0; bin < loads.Bins.Count; bin += 100)
      {
        QueryStatistics statistics;
        const auto active = FindActiveBlocks(**volume,
          { { 0, 0, { loads.Bins.GetEdge(bin) } }, static_cast<int>(store), 6 }, statistics);
        ASSERT_TRUE(active.IsOk());
        EXPECT_EQ(active->size(), loads.Stores[store][bin].ActiveBlocks);
        BlockCache::GetProcessCache()->Clear();
        for (const BlockReference& block : *active)
        {
          ASSERT_TRUE((*volume)->ReadBlock(block, 0, 0, 0, statistics).IsOk());
        }
        EXPECT_EQ(statistics.BytesRead, loads.Stores[store][bin].Bytes);
      }
    }
  }
}

TEST_F(MeasuredVolumeTest, TellsWhatCannotBeRead)
{
  EXPECT_EQ(MeasuredVolume::Read(this->Folder + "/none.bvol", 1).GetStatus().GetCode(),
    StatusCode::NotFound);
  EXPECT_FALSE(WriteVolume(this->Folder + "/none.mhd", this->Folder + "/x.bvol", 16, 1, 1).IsOk());
}
