// SPDX-License-Identifier: BSD-3-Clause
#include "Fixtures/SampleFiles.h"

#include "Formats/Opener/ForeignVolume.h"
#include "Storage/Store/SourceRecord.h"

using namespace isosurface;

namespace
{

RawVolume DescribeRaw(const Index3& size, ValueType type)
{
  RawVolume raw;
  raw.Grid.Extent = { 0, size[0] - 1, 0, size[1] - 1, 0, size[2] - 1 };
  raw.Type = type;
  raw.Paths = { "/data/a.raw" };
  return raw;
}

template <typename T>
void ExpectRoundTrip(bool isBigEndian)
{
  const auto volume = MakeRamp<T>({ 9, 7, 5 });
  MemoryDisk disk;
  Bytes bytes(13, 0xee);
  const Bytes samples = MakeBytes(volume, isBigEndian);
  bytes.insert(bytes.end(), samples.begin(), samples.end());
  WriteFile(disk, "/data/a.raw", bytes);
  RawVolume raw = DescribeRaw(volume.GetDimensions(), ValueTypeOf<T>::Value);
  raw.Offset = 13;
  raw.IsBigEndian = isBigEndian;
  const auto source = Require(raw.Open(disk));
  ExpectSamples(*source, volume);
  EXPECT_EQ(source->GetReadBytes({ { 0, 0, 1 }, { 9, 7, 3 } }), 126 * sizeof(T));
}

} // namespace

TEST(RawVolume, ReadsEveryTypeInBothByteOrders)
{
  for (const bool isBigEndian : { false, true })
  {
    ExpectRoundTrip<std::int8_t>(isBigEndian);
    ExpectRoundTrip<std::uint16_t>(isBigEndian);
    ExpectRoundTrip<std::int32_t>(isBigEndian);
    ExpectRoundTrip<std::uint64_t>(isBigEndian);
    ExpectRoundTrip<float>(isBigEndian);
    ExpectRoundTrip<double>(isBigEndian);
  }
}

TEST(RawVolume, ReadsSlicesOfAMultipleOf4096BytesIntoASlabWithGaps)
{
  for (const bool isBigEndian : { false, true })
  {
    const auto volume = MakeRamp<std::uint16_t>({ 64, 32, 5 });
    MemoryDisk disk;
    WriteFile(disk, "/data/a.raw", MakeBytes(volume, isBigEndian));
    RawVolume raw = DescribeRaw(volume.GetDimensions(), ValueType::UInt16);
    raw.IsBigEndian = isBigEndian;
    const auto source = Require(raw.Open(disk));
    ExpectSamples(*source, volume);
    const VertexBox three = { { 0, 0, 1 }, { 64, 32, 4 } };
    const auto slab = Require(source->Read(three));
    const std::int64_t pitch = slab.Arrays[0].Stride[2];
    EXPECT_NE(pitch * 2 % 4096, 0);
    EXPECT_EQ(source->GetReadBytes(three), static_cast<std::uint64_t>(2 * pitch + 64 * 32) * 2);
  }
}

TEST(RawVolume, ReadsAFileForEachSliceOrSlab)
{
  const auto volume = MakeRamp<std::uint16_t>({ 9, 7, 12 });
  const Bytes samples = MakeBytes(volume);
  for (const std::size_t count : { 12u, 4u })
  {
    MemoryDisk disk;
    RawVolume raw = DescribeRaw(volume.GetDimensions(), ValueType::UInt16);
    raw.Paths.clear();
    raw.EndsWithSamples = count == 4;
    const std::size_t size = samples.size() / count;
    for (std::size_t file = 0; file < count; ++file)
    {
      const auto from = samples.begin() + static_cast<std::ptrdiff_t>(file * size);
      const std::size_t header = count == 4 ? 100 : 0;
      Bytes bytes(header + size, 0xee);
      std::copy_n(from, size, bytes.begin() + static_cast<std::ptrdiff_t>(header));
      raw.Paths.push_back("/data/" + std::to_string(file) + ".raw");
      WriteFile(disk, raw.Paths.back(), bytes);
    }
    const auto source = Require(raw.Open(disk));
    ExpectSamples(*source, volume);
    ASSERT_TRUE(disk.RemoveAll(raw.Paths[2]).IsOk());
    const auto missing = source->Read(source->GetBox());
    ExpectMessage(missing.GetStatus(), raw.Paths[2]);
    raw.Paths.pop_back();
    EXPECT_FALSE(raw.Open(disk).IsOk());
  }
}

TEST(RawVolume, MissingAndTruncatedFilesAreErrors)
{
  MemoryDisk disk;
  RawVolume raw = DescribeRaw({ 9, 7, 5 }, ValueType::Float32);
  EXPECT_EQ(raw.Open(disk).GetStatus().GetCode(), StatusCode::NotFound);
  WriteFile(disk, "/data/a.raw", Bytes(9 * 7 * 5 * 4 - 1));
  const auto source = raw.Open(disk);
  ExpectError(source.GetStatus(), StatusCode::Corrupt, "/data/a.raw: truncated");
  const std::int64_t huge = std::int64_t{ 1 } << 40;
  EXPECT_FALSE(DescribeRaw({ huge, huge, 1 }, ValueType::UInt8).Open(disk).IsOk());
  EXPECT_FALSE(DescribeRaw({ 0, 7, 5 }, ValueType::UInt8).Open(disk).IsOk());
  raw.Paths.clear();
  EXPECT_FALSE(raw.Open(disk).IsOk());
}

TEST(RawSamples, AreDescribedByTheNameOfTheVolumeOrOfTheFile)
{
  const auto volume = MakeRamp<std::uint16_t>({ 9, 7, 5 });
  MemoryDisk disk;
  Bytes bytes(13, 0xee);
  const Bytes swapped = MakeBytes(volume, true);
  bytes.insert(bytes.end(), swapped.begin(), swapped.end());
  WriteFile(disk, "/data/a.dat", bytes);
  WriteFile(disk, "/data/a b_9x7x5_uint16.raw", MakeBytes(volume, false));
  for (const char* name : { "/data/a.dat:9x7x5,uint16,big-endian,header-bytes=13",
         "/data/a b_9x7x5_uint16.raw", "/data/a b_9x7x5_uint16.raw:9x7x5,uint16" })
  {
    const auto opened = Require(OpenForeignVolume(disk, name));
    ExpectSamples(*opened.Source, volume);
  }
  const auto listed = Require(ListForeignVolumes(disk, "/data/a b_9x7x5_uint16.raw"));
  ASSERT_EQ(listed.size(), 1u);
  EXPECT_EQ(listed[0].Name, "9x7x5,uint16");
  EXPECT_EQ(listed[0].Shape, "5 x 7 x 9");
}

TEST(RawSamples, TakeNoAxesUnlessAVolumeInPlaceNamesThem)
{
  MemoryDisk disk;
  WriteFile(disk, "/data/a.dat", Bytes(630));
  VolumeChoice choice;
  choice.Axes = "zyx";
  for (const char* name : { "/data/a.dat:9x7x5,uint16", "/data/a.mhd", "/data/a.nrrd",
         "/data/a.nii", "/data/a.mrc", "/data/a.dcm" })
  {
    ExpectError(OpenForeignVolume(disk, name, choice).GetStatus(), StatusCode::InvalidArgument,
      std::string(name) + ": cannot be read with the axes \"zyx\": those of ");
  }
  // A volume that release 1.0.0 has written may name axes that were without effect.
  SourceRecord record;
  record.Axes = "zyx";
  EXPECT_TRUE(
    OpenForeignVolume(disk, "/data/a.dat:9x7x5,uint16", record.MakeChoice({ "raw" })).IsOk());
}

TEST(RawSamples, InAGzipStreamAreDescribedInTheSameWay)
{
  MemoryDisk disk;
  const auto volume = MakeRamp<std::uint16_t>({ 9, 7, 5 });
  Bytes bytes = MakeBytes(volume, false);
  WriteFile(disk, "/data/a_9x7x5_uint16.raw.gz", Deflate(bytes));
  for (const char* name :
    { "/data/a_9x7x5_uint16.raw.gz", "/data/a_9x7x5_uint16.raw.gz:9x7x5,uint16" })
  {
    ExpectSamples(*Require(OpenForeignVolume(disk, name)).Source, volume);
  }
  bytes.insert(bytes.begin(), 100, std::uint8_t{ 7 });
  WriteFile(disk, "/data/b_9x7x5_uint16.raw.gz", Deflate(bytes));
  ExpectSamples(
    *Require(OpenForeignVolume(disk, "/data/b_9x7x5_uint16.raw.gz:9x7x5,uint16,header-bytes=100"))
       .Source,
    volume);
  const auto longer = OpenForeignVolume(disk, "/data/b_9x7x5_uint16.raw.gz");
  ASSERT_FALSE(longer.IsOk());
  EXPECT_NE(longer.GetStatus().GetMessage().find("say what its samples are"), std::string::npos);
  for (const std::size_t size : { 0, 3, 40 }) // no stream, and a truncated one
  {
    Bytes part = Deflate(bytes);
    part.resize(size);
    WriteFile(disk, "/data/c_9x7x5_uint16.raw.gz", part);
    EXPECT_FALSE(OpenForeignVolume(disk, "/data/c_9x7x5_uint16.raw.gz").IsOk());
    auto opened = OpenForeignVolume(disk, "/data/c_9x7x5_uint16.raw.gz:9x7x5,uint16");
    EXPECT_FALSE(opened.IsOk() && opened->Source->Read(opened->Source->GetBox()).IsOk());
  }
}

TEST(RawSamples, WithoutADescriptionAreAnErrorThatTellsHow)
{
  MemoryDisk disk;
  WriteFile(disk, "/data/a_9x7x5_uint16.raw", Bytes(629)); // 9 x 7 x 5 samples are 630 bytes
  ExpectError(OpenForeignVolume(disk, "/data/a_9x7x5_uint16.raw").GetStatus(), StatusCode::Corrupt,
    "truncated: has 629 bytes, and its name says 630");
  for (const char* within : { ":9x7x5", ":9x7,uint16", ":9x7x0,uint16", ":9x7x5,uint15",
         ":9x7x5,uint8,little", ":9x7x5,uint8,header-bytes=-1", ":9x7x5x2,uint8" })
  {
    const auto opened = OpenForeignVolume(disk, std::string("/data/a_9x7x5_uint16.raw") + within);
    ExpectError(opened.GetStatus(), StatusCode::InvalidArgument, "512x512x300,uint16");
  }
  const auto truncated = OpenForeignVolume(disk, "/data/a_9x7x5_uint16.raw:9x7x5,uint16");
  ExpectError(truncated.GetStatus(), StatusCode::Corrupt, "truncated");
}
