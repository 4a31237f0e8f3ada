// SPDX-License-Identifier: BSD-3-Clause
#include "Ground/Base/Coding.h"
#include "Storage/Record/RecordCodec.h"

#include "Fixtures/VolumeOnDisk.h"

#include <cmath>
#include <cstring>

using namespace isosurface;

namespace
{

constexpr SegmentCodec Codecs[] = { SegmentCodec::None, SegmentCodec::Lz4, SegmentCodec::Zstd };

/// A block's record, to be encoded and decoded.
struct TestRecord
{
  template <typename T>
  TestRecord(const SampleVolume<T>& volume, int blockSize, std::int64_t block)
    : Grid(volume.GetDimensions(), blockSize)
    , Block(block)
    , Types{ ValueTypeOf<T>::Value }
    , Layout(Grid, block, Types)
    , Record(static_cast<std::size_t>(BlockRecord::AlignUp(Layout.Size)))
  {
    std::memset(this->Record.GetData(), 0, this->Record.GetSize());
    const int levels = this->Grid.GetNumberOfLevels();
    for (int level = 0; level < levels; ++level)
    {
      std::uint8_t* to = this->Record.GetData() + BlockRecord::SegmentHeaderSize +
        this->Layout.Offsets[static_cast<std::size_t>(levels - 1 - level)];
      const BlockSegment segment(this->Grid, block, level);
      segment.VisitRows(segment.GetBox(),
        [&](const SegmentRow& row)
        {
          for (std::int64_t n = 0; n < row.Count; ++n)
          {
            const T sample =
              volume.At((row.I + n * row.Step) << level, row.J << level, row.K << level);
            std::memcpy(to, &sample, sizeof(T));
            to += sizeof(T);
          }
        });
    }
  }

  void Encode(const BlockCompression& compression)
  {
    EncodeRecord(compression, this->Grid, this->Block, this->Types, this->Layout, this->Record);
  }

  std::uint8_t* GetSegment(std::size_t index)
  {
    return this->Record.GetData() + this->Layout.Offsets[index];
  }

  /// Decodes copies of the segments that end where memory ends, so that a sanitizer sees any read
  /// beyond them.
  Result<std::shared_ptr<DecodedBlock>> Decode(int level)
  {
    std::vector<std::vector<std::uint8_t>> copies;
    std::vector<const std::uint8_t*> segments;
    std::vector<std::uint32_t> stored;
    for (int index = 0; index < this->Grid.GetNumberOfLevels() - level; ++index)
    {
      const std::uint8_t* from = this->GetSegment(static_cast<std::size_t>(index));
      stored.push_back(this->Layout.Lengths[static_cast<std::size_t>(index)]);
      copies.emplace_back(from, from + BlockRecord::SegmentHeaderSize + stored.back());
      segments.push_back(copies.back().data());
    }
    return DecodeLevel(this->Grid, this->Block, 0, level, this->Types[0], segments, stored);
  }

  BlockGrid Grid;
  std::int64_t Block;
  std::vector<ValueType> Types;
  BlockRecordLayout Layout;
  Buffer<std::uint8_t> Record;
};

template <typename T>
void ExpectDecodes(TestRecord& record, const SampleVolume<T>& volume)
{
  for (int level = 0; level < record.Grid.GetNumberOfLevels(); ++level)
  {
    const auto decoded = Require(record.Decode(level));
    const SampleView& view = decoded->View;
    std::size_t wrong = 0;
    VisitVertices(view.Available,
      [&](const Index3& vertex)
      {
        const auto [i, j, k] = vertex;
        const T expected = volume.At(i << level, j << level, k << level);
        wrong += std::memcmp(view.At<T>(vertex), &expected, sizeof(T)) != 0;
      });
    ASSERT_EQ(wrong, 0u) << "level " << level;
  }
}

/// Volumes of one type: smooth, noise of any bits (NaN payloads among it), constant, and half each.
template <typename T>
std::vector<SampleVolume<T>> MakeVolumes(const Index3& size)
{
  std::mt19937_64 random(6);
  const auto anyBits = [&]
  {
    const std::uint64_t bits = random();
    T value;
    std::memcpy(&value, &bits, sizeof(T));
    return value;
  };
  const auto smooth = [](auto i, auto j, auto k)
  { return static_cast<T>(60 + 50 * std::sin(0.1 * static_cast<double>(i + 2 * j - k))); };
  const T constant = anyBits();
  return { SampleVolume<T>(size, smooth), SampleVolume<T>(size, [&](auto...) { return anyBits(); }),
    SampleVolume<T>(size, [&](auto...) { return constant; }),
    SampleVolume<T>(
      size, [&](auto i, auto j, auto k) { return i > 20 ? anyBits() : smooth(i, j, k); }) };
}

template <typename T>
class CompressionOfType : public ::testing::Test
{
};
TYPED_TEST_SUITE(CompressionOfType, AllValueTypes, );

} // namespace

TYPED_TEST(CompressionOfType, IsRevertedExactlyByEveryCodec)
{
  const Index3 size{ 70, 36, 35 };
  for (const auto& volume : MakeVolumes<TypeParam>(size))
  {
    for (const int blockSize : { 16, 32, 64 })
    {
      const BlockGrid grid(size, blockSize);
      for (const std::int64_t block : { std::int64_t{ 0 }, grid.GetNumberOfBlocks() - 1 })
      {
        for (const SegmentCodec codec : Codecs)
        {
          TestRecord record(volume, blockSize, block);
          record.Encode({ codec, 1 });
          ExpectDecodes(record, volume);
          if (this->HasFatalFailure())
          {
            FAIL() << GetCodecName(codec) << ", blocks of " << blockSize;
          }
        }
      }
    }
  }
}

TYPED_TEST(CompressionOfType, StoresNoiseUncompressedAndConstantsInAFewBytes)
{
  const auto volumes = MakeVolumes<TypeParam>({ 70, 36, 35 });
  for (const SegmentCodec codec : { SegmentCodec::Lz4, SegmentCodec::Zstd })
  {
    TestRecord noise(volumes[1], 32, 0);
    const TestRecord plain(volumes[1], 32, 0);
    noise.Encode({ codec, 0 });
    EXPECT_EQ(noise.Layout.Lengths, plain.Layout.Lengths);
    EXPECT_EQ(noise.Layout.Size, plain.Layout.Size);
    TestRecord constant(volumes[2], 32, 0);
    const std::uint64_t before = constant.Layout.Size;
    constant.Encode({ codec, 0 });
    EXPECT_LT(constant.Layout.Size, 600 + before / 100);
  }
}

TEST(BlockCompression, EachCodecHasANameAndIsTested)
{
  for (const SegmentCodec codec : Codecs)
  {
    EXPECT_EQ(FindCodec(GetCodecName(codec)), codec);
  }
  EXPECT_EQ(GetCodecName(static_cast<SegmentCodec>(std::size(Codecs))), nullptr);
  EXPECT_FALSE(FindCodec("LZ4").has_value());
}

TEST(BlockCompression, IsExactAtEveryLevelOfACodec)
{
  const auto volume = MakeVolume<std::int16_t>({ 35, 35, 35 });
  for (const SegmentCodec codec : { SegmentCodec::Lz4, SegmentCodec::Zstd })
  {
    std::uint64_t least = TestRecord(volume, 32, 0).Layout.Size;
    for (int level = 0; BlockCompression{ codec, level }.IsValid(); ++level)
    {
      TestRecord record(volume, 32, 0);
      record.Encode({ codec, level });
      ExpectDecodes(record, volume);
      // Higher levels try harder, but need not succeed with every block.
      EXPECT_LT(record.Layout.Size, least + least / 5);
      least = std::min(least, record.Layout.Size);
    }
  }
  EXPECT_FALSE((BlockCompression{ SegmentCodec::Lz4, 13 }.IsValid()));
  EXPECT_FALSE((BlockCompression{ SegmentCodec::Zstd, 20 }.IsValid()));
  EXPECT_FALSE((BlockCompression{ SegmentCodec::Zstd, -1 }.IsValid()));
  EXPECT_TRUE((BlockCompression{ SegmentCodec::None, 5 }.IsValid()));
}

TEST(BlockCompression, WritesTheSameBytesWhateverWasCompressedBefore)
{
  const auto smooth = MakeVolume<float>({ 70, 70, 70 });
  const auto other = MakeVolumes<float>({ 70, 70, 70 });
  for (const SegmentCodec codec : { SegmentCodec::Lz4, SegmentCodec::Zstd })
  {
    for (const int level : { 1, 3, 9 })
    {
      TestRecord expected(smooth, 32, 0);
      std::thread([&] { expected.Encode({ codec, level }); }).join();
      for (const auto& volume : other)
      {
        TestRecord(volume, 64, 0).Encode({ codec, level });
        TestRecord(volume, 16, 3).Encode({ SegmentCodec::Zstd, 5 });
        TestRecord again(smooth, 32, 0);
        again.Encode({ codec, level });
        ASSERT_EQ(again.Layout.Size, expected.Layout.Size);
        ASSERT_EQ(
          std::memcmp(again.Record.GetData(), expected.Record.GetData(), expected.Record.GetSize()),
          0);
      }
    }
  }
}

TEST(BlockCompression, FindsItsCodecsByName)
{
  for (const SegmentCodec codec : Codecs)
  {
    EXPECT_EQ(FindCodec(GetCodecName(codec)), codec);
  }
  EXPECT_FALSE(FindCodec("brotli").has_value());
  EXPECT_FALSE(FindCodec("").has_value());
}

TEST(BlockCompression, DamagedBytesGiveAnErrorOrOtherSamples)
{
  // Checksums are not checked here: the codecs see whatever a hostile file may contain.
  std::mt19937 random(8);
  const auto volume = MakeVolume<std::uint16_t>({ 35, 35, 35 });
  for (const SegmentCodec codec : { SegmentCodec::Lz4, SegmentCodec::Zstd })
  {
    std::size_t refused = 0;
    for (int trial = 0; trial < 300; ++trial)
    {
      TestRecord record(volume, 16, 0);
      record.Encode({ codec, 1 });
      const std::size_t segment = record.Layout.Lengths.size() - 1 - random() % 2;
      std::uint8_t* header = record.GetSegment(segment);
      std::uint8_t* payload = header + BlockRecord::SegmentHeaderSize;
      std::uint32_t& stored = record.Layout.Lengths[segment];
      header[13] = static_cast<std::uint8_t>(trial / 3 % 3); // the predictor
      switch (trial % 3)
      {
        case 0:
          payload[random() % stored] ^= static_cast<std::uint8_t>(1u << random() % 8);
          break;
        case 1:
          stored = random() % stored;
          break;
        default:
          for (std::uint32_t byte = 0; byte < stored; ++byte)
          {
            payload[byte] = static_cast<std::uint8_t>(random());
          }
      }
      const auto decoded = record.Decode(0);
      refused += !decoded.IsOk();
      EXPECT_TRUE(decoded.IsOk() || decoded.GetStatus().GetCode() == StatusCode::Corrupt);
    }
    EXPECT_GE(refused, 200u) << GetCodecName(codec);
  }
}

TEST(BlockCompression, RefusesUnknownCodecsAndPredictors)
{
  const auto volume = MakeVolume<std::uint16_t>({ 35, 35, 35 });
  for (int codec = 0; codec < 256; ++codec)
  {
    for (const int predictor : { 0, 1, 2, 3, 16, 18, 32, 48, 255 })
    {
      TestRecord record(volume, 16, 0);
      record.Encode({ SegmentCodec::Zstd, 1 });
      std::uint8_t* header = record.GetSegment(4);
      ASSERT_EQ(header[12], 2);
      header[12] = static_cast<std::uint8_t>(codec);
      header[13] = static_cast<std::uint8_t>(predictor);
      const auto decoded = record.Decode(0);
      const bool isKnown = codec == 0 ? predictor == 0 : codec <= 2 && predictor <= 2;
      if (!isKnown)
      {
        ASSERT_EQ(decoded.GetStatus().GetCode(), StatusCode::Unsupported);
      }
      else if (codec != 2)
      {
        ASSERT_EQ(decoded.GetStatus().GetCode(), StatusCode::Corrupt);
      }
    }
  }
  // There is no level to predict the coarsest one from.
  TestRecord record(MakeVolumes<std::uint8_t>({ 70, 70, 70 })[2], 16, 40);
  record.Encode({ SegmentCodec::Lz4, 1 });
  record.GetSegment(0)[12] = 1;
  record.GetSegment(0)[13] = 2;
  EXPECT_EQ(record.Decode(4).GetStatus().GetCode(), StatusCode::Corrupt);
}

TEST(ByteCodec, RefusesBytesThatDoNotDecodeToTheGivenSize)
{
  const std::vector<std::uint8_t> bytes(10000, 7);
  for (const SegmentCodec codec : { SegmentCodec::Lz4, SegmentCodec::Zstd })
  {
    std::vector<std::uint8_t> code(10000);
    code.resize(CompressBytes(codec, 1, bytes.data(), bytes.size(), code.data(), code.size()));
    ASSERT_FALSE(code.empty());
    for (const std::size_t size : { 0u, 1u, 9999u, 10000u, 10001u, 20000u })
    {
      std::vector<std::uint8_t> back(size);
      const bool isRight = DecompressBytes(codec, code.data(), code.size(), back.data(), size);
      EXPECT_EQ(isRight, size == 10000) << size;
    }
    EXPECT_EQ(CompressBytes(codec, 1, bytes.data(), bytes.size(), code.data(), 3), 0u);
    EXPECT_FALSE(DecompressBytes(codec, code.data(), 0, code.data(), 100));
  }
}
