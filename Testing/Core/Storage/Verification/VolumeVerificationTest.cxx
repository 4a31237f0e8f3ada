// SPDX-License-Identifier: BSD-3-Clause
#include "Fixtures/MemoryDisk.h"
#include "Fixtures/SampleVolume.h"

#include "Storage/Store/BlockStore.h"
#include "Storage/Verification/VolumeVerification.h"
#include "Storage/Writing/BlockedVolumeWriter.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

using namespace isosurface;

namespace
{

const std::string VerifiedPath = "/data/a.bvol";

/// Two arrays, one with NaN, in three stores.
void WriteVolume(MemoryDisk& disk, SegmentCodec codec)
{
  const Index3 size = { 40, 35, 30 };
  const SampleVolume<float> a(size,
    [](auto i, auto j, auto k)
    { return i == j && k == 3 ? std::nan("") : std::sin(0.2 * static_cast<double>(i * j + k)); });
  const SampleVolume<std::int16_t> b(size, [](auto i, auto j, auto k) { return i * 3 + j - k; });
  GridGeometry grid;
  grid.Extent = { 0, size[0] - 1, 0, size[1] - 1, 0, size[2] - 1 };
  VolumePiece piece;
  piece.Box = { { 0, 0, 0 }, size };
  piece.Arrays = { a.GetView(), b.GetView() };
  BlockedVolumeSettings settings;
  settings.BlockSize = 16;
  settings.NumberOfStores = 3;
  settings.Compression.Codec = codec;
  settings.Threads = 1;
  SerialCommunicator alone;
  const auto written =
    BlockedVolumeWriter(alone, disk)
      .Write(VerifiedPath, grid, { { "a", ValueType::Float32 }, { "b", ValueType::Int16 } }, piece,
        settings);
  ASSERT_TRUE(written.IsOk()) << written.GetStatus().GetMessage();
}

VolumeVerification VerifyVolume(MemoryDisk& disk, int threads = 2)
{
  const auto found = VerifyBlockedVolume(VerifiedPath, disk, threads);
  EXPECT_TRUE(found.IsOk());
  return found.IsOk() ? *found : VolumeVerification{};
}

std::vector<std::string> GetMessages(const VolumeVerification& found)
{
  std::vector<std::string> messages;
  for (const Status& fault : found.Faults)
  {
    messages.push_back(fault.GetMessage());
  }
  return messages;
}

} // namespace

TEST(VolumeVerification, FindsNoFaultInANewVolume)
{
  for (const SegmentCodec codec : { SegmentCodec::None, SegmentCodec::Lz4, SegmentCodec::Zstd })
  {
    MemoryDisk disk;
    WriteVolume(disk, codec);
    const VolumeVerification found = VerifyVolume(disk);
    EXPECT_EQ(GetMessages(found), std::vector<std::string>());
    EXPECT_EQ(found.Blocks, 19u); // with the overview's
    EXPECT_EQ(found.Files, disk.GetFiles().size());
  }
}

TEST(VolumeVerification, FindsAnyAlteredByteAndNamesTheFile)
{
  MemoryDisk disk;
  WriteVolume(disk, SegmentCodec::Lz4);
  std::mt19937 random(3);
  for (const auto& file : disk.Copy())
  {
    for (int turn = 0; turn < 20; ++turn)
    {
      MemoryDisk::Bytes& bytes = disk.GetFile(file.first);
      const std::size_t at = random() % bytes.size();
      bytes[at] ^= static_cast<std::uint8_t>(1u << random() % 8);
      const VolumeVerification found = VerifyVolume(disk);
      ASSERT_FALSE(found.Faults.empty()) << file.first << " at " << at;
      EXPECT_EQ(found.Faults[0].GetMessage().find(file.first), 0u) << found.Faults[0].GetMessage();
      bytes = file.second;
    }
  }
}

TEST(VolumeVerification, ReportsEveryFaultWhateverTheNumberOfThreads)
{
  MemoryDisk disk;
  WriteVolume(disk, SegmentCodec::None);
  const std::string stores = HidePath(VerifiedPath + ".stores") + "/000001/";
  disk.GetFile(StoreRecords::GetPath(stores + "store-00000"))[100] ^= 1;
  disk.GetFile(stores + "store-00001/array-1.tree")[5000] ^= 1;
  disk.GetFile(StoreRecords::GetPath(stores + "store-00002"))[100] ^= 1;
  disk.GetFile(stores + "spectra")[30] ^= 1;
  const auto messages = GetMessages(VerifyVolume(disk, 1));
  ASSERT_EQ(messages.size(), 4u);
  EXPECT_NE(messages[0].find("spectra"), std::string::npos);
  EXPECT_NE(messages[1].find("store-00000/blocks"), std::string::npos);
  EXPECT_NE(messages[2].find("store-00001/array-1.tree"), std::string::npos);
  EXPECT_NE(messages[3].find("store-00002/blocks"), std::string::npos);
  EXPECT_EQ(messages, GetMessages(VerifyVolume(disk, 4)));
  ASSERT_TRUE(disk.RemoveAll(stores + "store-00002").IsOk());
  EXPECT_EQ(GetMessages(VerifyVolume(disk)).size(), 4u);
}

TEST(VolumeVerification, FindsStoresOfAnotherVolume)
{
  MemoryDisk disk;
  MemoryDisk other;
  WriteVolume(disk, SegmentCodec::None);
  WriteVolume(other, SegmentCodec::None);
  const std::string stores = HidePath(VerifiedPath + ".stores") + "/000001/";
  for (const char* name : { "/blocks", "/directory", "/array-0.tree", "/array-1.tree" })
  {
    disk.GetFile(stores + "store-00000" + name) = other.GetFile(stores + "store-00001" + name);
  }
  EXPECT_FALSE(VerifyVolume(disk).Faults.empty());
}

TEST(VolumeVerification, StopsOnRequest)
{
  MemoryDisk disk;
  WriteVolume(disk, SegmentCodec::None);
  const auto found = VerifyBlockedVolume(VerifiedPath, disk, 2, [](double) { return false; });
  EXPECT_EQ(found.GetStatus().GetCode(), StatusCode::Aborted);
}
