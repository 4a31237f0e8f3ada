// SPDX-License-Identifier: BSD-3-Clause
#include "Ground/Base/Coding.h"
#include "Storage/Record/BlockRecord.h"
#include "Storage/Store/BlockedVolume.h"
#include "Storage/Writing/BlockedVolumeWriter.h"

#include "Fixtures/VolumeOnDisk.h"

using namespace isosurface;

namespace
{

BlockedVolumeSettings MakeCompressed(SegmentCodec codec, int level = 0)
{
  BlockedVolumeSettings settings = MakeSettings(16, 3);
  settings.Compression = { codec, level };
  return settings;
}

} // namespace

TEST(BlockedVolumeCompression, GivesTheSameBytesOnAnyRanksThreadsAndRounds)
{
  const auto volume = MakeVolume<std::int16_t>({ 70, 49, 52 });
  for (const auto& settings : { MakeCompressed(SegmentCodec::Lz4),
         MakeCompressed(SegmentCodec::Zstd), MakeCompressed(SegmentCodec::Zstd, 7) })
  {
    BlockedVolumeSettings alone = settings;
    alone.Threads = 1;
    MemoryDisk expected;
    WriteVolumeOk(expected, volume, alone);
    for (const int ranks : { 1, 2, 5 })
    {
      BlockedVolumeSettings other = settings;
      other.Threads = 1 + ranks;
      other.MemoryLimit = (8u << 20) * static_cast<unsigned>(ranks);
      MemoryDisk disk;
      WriteVolumeOk(disk, volume, other, ranks, OverlappingColumns);
      ASSERT_TRUE(disk.Copy() == expected.Copy()) << ranks;
    }
  }
}

TEST(BlockedVolumeCompression, ReadsBackWithFewerBytesAtEveryLevel)
{
  const auto volume = MakeVolume<std::uint16_t>({ 129, 70, 66 });
  std::vector<std::uint64_t> plain;
  for (const SegmentCodec codec : { SegmentCodec::None, SegmentCodec::Lz4, SegmentCodec::Zstd })
  {
    BlockedVolumeSettings settings = MakeCompressed(codec);
    settings.BlockSize = 32;
    MemoryDisk disk;
    const auto opened = WriteAndOpen(disk, volume, settings, 2);
    EXPECT_EQ(opened->GetHeader().Compression.Codec, codec);
    for (int level = 0; level < opened->GetNumberOfLevels(); ++level)
    {
      QueryStatistics statistics;
      ExpectReadsBack(*opened, volume, level, statistics);
      if (codec == SegmentCodec::None)
      {
        plain.push_back(statistics.BytesRead);
      }
      else if (level < 3)
      {
        EXPECT_LT(statistics.BytesRead, plain[static_cast<std::size_t>(level)] * 3 / 4) << level;
      }
      else
      {
        EXPECT_LE(statistics.BytesRead, plain[static_cast<std::size_t>(level)]) << level;
      }
    }
  }
}

TEST(BlockedVolumeCompression, GivesUncompressedVolumesNoLevel)
{
  MemoryDisk disk;
  WriteVolumeOk(disk, MakeVolume<std::uint8_t>({ 20, 20, 20 }), MakeSettings(16, 1));
  const MemoryDisk::Bytes& header = disk.GetFile(VolumePath);
  const std::string text(header.begin(), header.end());
  EXPECT_NE(text.find("\"compression\": \"none\""), std::string::npos) << text;
  EXPECT_EQ(text.find("compressionLevel"), std::string::npos);
}

TEST(BlockedVolumeCompression, RefusesLevelsThatACodecDoesNotHave)
{
  MemoryDisk disk;
  const auto volume = MakeVolume<std::uint8_t>({ 20, 20, 20 });
  for (const auto& settings :
    { MakeCompressed(SegmentCodec::Lz4, 13), MakeCompressed(SegmentCodec::Zstd, -3) })
  {
    const auto result = WriteVolume(disk, volume, settings)[0];
    ASSERT_EQ(result.GetStatus().GetCode(), StatusCode::InvalidArgument);
    ExpectMessage(result.GetStatus(), "the compression level is beyond");
  }
  EXPECT_TRUE(disk.GetFiles().empty());
}

TEST(BlockedVolumeCompression, HostileSegmentsWithRightChecksumsAreRefused)
{
  const auto volume = MakeVolume<std::uint8_t>({ 20, 20, 20 });
  const std::string path = HidePath(VolumePath + ".stores") + "/000001/store-00000/blocks";
  for (const SegmentCodec codec : { SegmentCodec::Lz4, SegmentCodec::Zstd })
  {
    BlockedVolumeSettings settings = MakeCompressed(codec);
    settings.NumberOfStores = 1;
    MemoryDisk disk;
    WriteVolumeOk(disk, volume, settings);
    const MemoryDisk::Bytes intact = disk.GetFile(path);
    const auto opened = OpenVolume(disk, 0);
    QueryStatistics statistics;
    const auto blocks = Require(opened->ListBlocks(0, statistics));
    ASSERT_EQ(blocks[0].Ordinal, 0u);
    // The last segment of the first record, which begins where the levels above it end.
    QueryStatistics coarse;
    QueryStatistics fine;
    ASSERT_TRUE(opened->ReadBlock(blocks[0], 0, 0, 1, coarse).IsOk());
    ASSERT_TRUE(opened->ReadBlock(blocks[0], 0, 0, 0, fine).IsOk());
    const std::size_t begin = coarse.BytesRead;
    const auto stored =
      static_cast<std::uint32_t>(fine.BytesRead - begin - BlockRecord::SegmentHeaderSize);
    std::mt19937 random(9);
    for (int trial = 0; trial < 300; ++trial)
    {
      MemoryDisk::Bytes& bytes = disk.GetFile(path);
      bytes = intact;
      std::uint8_t* segment = bytes.data() + begin;
      ASSERT_EQ(segment[12], static_cast<std::uint8_t>(codec));
      SegmentCoding coding = *LoadSegmentCoding(segment);
      segment[BlockRecord::SegmentHeaderSize + random() % std::min(stored, 40u)] ^=
        static_cast<std::uint8_t>(1 + random() % 255);
      if (trial % 3 == 1)
      {
        coding.Codec = static_cast<SegmentCodec>(trial % 5);
      }
      if (trial % 3 == 2)
      {
        coding.Predictor = static_cast<SamplePredictor>(random() % 256);
      }
      SealSegment(segment, stored, coding, { blocks[0].Block, 0, 0 });
      const auto block = opened->ReadBlock(blocks[0], 0, 0, 0, statistics);
      if (!block.IsOk())
      {
        const Status& status = block.GetStatus();
        EXPECT_TRUE(
          status.GetCode() == StatusCode::Corrupt || status.GetCode() == StatusCode::Unsupported);
        EXPECT_EQ(status.GetMessage().find(path + ": block "), 0u) << status.GetMessage();
      }
    }
  }
}
