// SPDX-License-Identifier: BSD-3-Clause
#include "Fixtures/SampleFiles.h"

#include "Fixtures/MemoryDisk.h"
#include "Formats/Source/ArraySource.h"
#include "Formats/Source/ConvertedSource.h"
#include "Formats/Source/FolderFiles.h"
#include "Formats/Source/PermutedSource.h"
#include "Formats/Zarr/ZarrCodec.h"
#include "Ground/Volume/VolumeName.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <memory>
#include <string>

using namespace isosurface;

namespace
{

/// An array in memory that follows the contract of StoredArray, sample by sample.
class MemoryArray : public StoredArray
{
public:
  MemoryArray(Numbers shape)
    : Shape(std::move(shape))
  {
  }

  const std::string& GetName() const override { return this->Name; }
  const Numbers& GetShape() const override { return this->Shape; }
  ValueType GetType() const override { return ValueType::Int32; }
  std::uint64_t GetHeldBytes() const override { return 100; }

  /// The sample at a place is the number of the place.
  static std::int32_t At(const Numbers& shape, const Numbers& place)
  {
    std::int64_t number = 0;
    for (std::size_t axis = 0; axis < shape.size(); ++axis)
    {
      number = number * shape[axis] + place[axis];
    }
    return static_cast<std::int32_t>(number);
  }

  Status Read(const Numbers& low, const Numbers& size, std::uint8_t* to) override
  {
    std::int64_t count = 1;
    for (const std::int64_t length : size)
    {
      count *= length;
    }
    for (std::int64_t sample = 0; sample < count; ++sample)
    {
      Numbers place(size.size());
      std::int64_t rest = sample;
      for (std::size_t axis = size.size(); axis-- > 0; rest /= size[axis])
      {
        place[axis] = low[axis] + rest % size[axis];
      }
      const std::int32_t value = At(this->Shape, place);
      std::memcpy(to + sample * 4, &value, 4);
    }
    return Status::Ok();
  }

private:
  std::string Name = "/data/a:array";
  Numbers Shape;
};

} // namespace

TEST(ArraySource, AxesOfAnyOrderTimesAndChannelsAreFound)
{
  // x, c, z, t, y.
  const StoredArray::Numbers shape = { 5, 2, 4, 3, 6 };
  const auto axes = Require(ArrayAxes::Parse("xczty", 5));
  const auto parts = Require(MakeVolumeArrays("a", std::make_shared<MemoryArray>(shape), axes, 2));
  ASSERT_EQ(parts.size(), 2U);
  EXPECT_EQ(parts[1].Name, "a 1");
  ArraySource source(parts);
  EXPECT_EQ(source.GetHeldBytes(), 100U); // of one array
  EXPECT_EQ(source.GetBox().GetSize(), (Index3{ 5, 6, 4 }));
  const VertexBox box = { { 1, 2, 1 }, { 4, 6, 3 } };
  const auto slab = Require(source.Read(box));
  ASSERT_TRUE(slab.Fits({ ValueType::Int32, ValueType::Int32 }, box));
  VisitVertices({ { 1, 2, 1 }, { 4, 6, 3 } },
    [&](const Index3& vertex)
    {
      const auto [i, j, k] = vertex;
      for (std::int64_t channel = 0; channel < 2; ++channel)
      {
        EXPECT_EQ(*slab.Arrays[static_cast<std::size_t>(channel)].At<std::int32_t>({ i, j, k }),
          MemoryArray::At(shape, { i, channel, k, 2, j }));
      }
    });
}

TEST(ArraySource, TheFastestAxisOfChannelsIsComponents)
{
  const StoredArray::Numbers shape = { 3, 4, 5, 3 };
  const auto axes = ArrayAxes::Parse("zyxc", 4);
  const auto parts = MakeVolumeArrays("v", std::make_shared<MemoryArray>(shape), *axes, 0);
  ASSERT_EQ(parts->size(), 1U);
  EXPECT_EQ((*parts)[0].Channels, 3);
  ArraySource source(*parts);
  const auto slab = source.Read(source.GetBox());
  ASSERT_EQ(slab->Arrays.size(), 3U);
  EXPECT_EQ(*slab->Arrays[2].At<std::int32_t>({ 4, 1, 2 }), MemoryArray::At(shape, { 2, 1, 4, 2 }));
}

TEST(ArraySource, AxesThatMakeNoVolumeAreErrors)
{
  for (const auto& [letters, rank] : { std::pair<const char*, std::size_t>{ "", 2 }, { "", 6 },
         { "zy", 3 }, { "zyy", 3 }, { "zyt", 3 }, { "zyxq", 4 } })
  {
    EXPECT_FALSE(ArrayAxes::Parse(letters, rank).IsOk()) << letters;
  }
  const auto axes = Require(ArrayAxes::Parse("", 4));
  EXPECT_EQ(axes.Time, 0);
  const auto array = std::make_shared<MemoryArray>(StoredArray::Numbers{ 2, 3, 4, 5 });
  const auto parts = MakeVolumeArrays("a", array, axes, 2);
  EXPECT_EQ(
    parts.GetStatus().GetMessage(), "/data/a:array: has 2 time steps, and none of number 2");
}

TEST(ArraySource, MoreTimeStepsThanAFileMayHaveAreRefused)
{
  const auto axes = Require(ArrayAxes::Parse("tzyx", 4));
  for (const std::int64_t more : { 0, 1 })
  {
    const auto array =
      std::make_shared<MemoryArray>(StoredArray::Numbers{ MaximumTimeSteps + more, 2, 2, 2 });
    EXPECT_EQ(MakeVolumeArrays("a", array, axes, 0).IsOk(), more == 0);
  }
}

TEST(ArraySource, RowsOfChunksThatTheCacheHoldsAreReadAtOnce)
{
  class ChunkedArray : public MemoryArray
  {
  public:
    ChunkedArray(Numbers chunk, std::uint64_t cacheBytes)
      : MemoryArray({ 64, 60, 70 })
      , Chunk(std::move(chunk))
      , CacheBytes(cacheBytes)
    {
    }
    Numbers GetChunk() const override { return this->Chunk; }
    std::uint64_t GetCacheBytes() const override { return this->CacheBytes; }

  private:
    Numbers Chunk;
    std::uint64_t CacheBytes;
  };
  const auto find = [](const StoredArray::Numbers& chunk, std::uint64_t cacheBytes)
  {
    const auto array = std::make_shared<ChunkedArray>(chunk, cacheBytes);
    return ArraySource(*MakeVolumeArrays("a", array, *ArrayAxes::Parse("", 3), 0)).GetRowsAtOnce();
  };
  constexpr std::int64_t any = std::numeric_limits<std::int64_t>::max();
  // A row has 3 chunks of 16 KiB, a layer 4 rows (the last one in part).
  const StoredArray::Numbers chunk = { 8, 16, 32 };
  EXPECT_EQ(find(chunk, 4 * 49152), any);
  EXPECT_EQ(find(chunk, 4 * 49152 - 1), 48);
  EXPECT_EQ(find(chunk, 49152), 16);
  EXPECT_EQ(find(chunk, 100), 16);
  EXPECT_EQ(find({ 1, 16, 32 }, 100), any);
  EXPECT_EQ(find({}, 0), any);
}

TEST(ConvertedSource, ScalesRowsWithAndWithoutGaps)
{
  const auto axes = ArrayAxes::Parse("xyz", 3);
  const StoredArray::Numbers shape = { 5, 4, 3 };
  const auto parts = MakeVolumeArrays("a", std::make_shared<MemoryArray>(shape), *axes, 0);
  ConvertedSource source(
    std::make_unique<ArraySource>(*parts), ValueType::Int32, { 0.5, -3 }, ValueType::Float32);
  const VertexBox box = { { 1, 0, 1 }, { 5, 3, 3 } };
  const auto slab = Require(source.Read(box));
  for (std::int64_t i = 1; i < 5; ++i)
  {
    EXPECT_EQ(*slab.Arrays[0].At<float>({ i, 2, 1 }),
      0.5F * static_cast<float>(MemoryArray::At(shape, { i, 2, 1 })) - 3);
  }
}

TEST(ConvertedSource, CutsToTheEndsOfAType)
{
  const double from[] = { -1e30, -0.5, 254.9, 256, 1e30, std::nan("") };
  std::uint8_t to[6] = {};
  ScaleSamples(ValueType::Float64, from, 6, {}, ValueType::UInt8, to);
  EXPECT_EQ(std::vector<int>(to, to + 6), (std::vector<int>{ 0, 0, 254, 255, 255, 0 }));
  std::int64_t large = 0;
  ScaleSamples(ValueType::Float64, from + 4, 1, {}, ValueType::Int64, &large);
  EXPECT_EQ(large, std::numeric_limits<std::int64_t>::max());
}

TEST(ConvertedSource, EveryHalfFloatHasItsValue)
{
  for (std::uint32_t bits = 0; bits < 65536; ++bits)
  {
    const float value = WidenHalf(static_cast<std::uint16_t>(bits));
    const int exponent = static_cast<int>(bits >> 10 & 31);
    const auto fraction = static_cast<double>(bits & 1023) / 1024;
    const double sign = bits >> 15 != 0 ? -1 : 1;
    if (exponent == 31)
    {
      EXPECT_TRUE(fraction == 0 ? std::isinf(value) : std::isnan(value));
    }
    else
    {
      EXPECT_EQ(value,
        sign *
          (exponent == 0 ? std::ldexp(fraction, -14) : std::ldexp(1 + fraction, exponent - 15)));
    }
    EXPECT_EQ(std::signbit(value), sign < 0);
  }
}

TEST(PermutedSource, AxesChangePlaces)
{
  const StoredArray::Numbers shape = { 3, 4, 5 };
  const auto parts =
    MakeVolumeArrays("a", std::make_shared<MemoryArray>(shape), *ArrayAxes::Parse("", 3), 0);
  // Its x, y and z become z, x and y.
  PermutedSource source(std::make_unique<ArraySource>(*parts), { 2, 0, 1 });
  EXPECT_EQ(source.GetBox().GetSize(), (Index3{ 4, 3, 5 }));
  const VertexBox box = { { 1, 0, 2 }, { 4, 3, 5 } };
  const auto slab = source.Read(box);
  ASSERT_TRUE(slab->Fits({ ValueType::Int32 }, box));
  EXPECT_EQ(*slab->Arrays[0].At<std::int32_t>({ 3, 1, 4 }), MemoryArray::At(shape, { 1, 3, 4 }));
}

TEST(VolumeName, SplitsAtTheLastColonBeforeWhichSomethingIs)
{
  MemoryDisk disk;
  WriteFile(disk, "/data/a:b.h5", {});
  ASSERT_TRUE(disk.MakeDirectories("/data/z.zarr").IsOk());
  WriteFile(disk, "/data/z.zarr/.zgroup", {});
  const auto parse = [&disk](const std::string& text)
  {
    const VolumeName name = VolumeName::Parse(disk, text);
    return name.Path + "|" + name.Within;
  };
  EXPECT_EQ(parse("/data/a:b.h5"), "/data/a:b.h5|");
  EXPECT_EQ(parse("/data/a:b.h5:/x:y"), "/data/a:b.h5|/x:y");
  EXPECT_EQ(parse("/data/z.zarr:0"), "/data/z.zarr|0");
  EXPECT_EQ(parse("/data/none.h5:/x"), "/data/none.h5:/x|");
  EXPECT_EQ(FindExtension("/data/Z.ZARR/"), ".zarr");
  EXPECT_EQ(FindExtension("/data/a.nii.GZ"), ".nii.gz");
}

TEST(ZarrCodec, ChecksumIsThatOfTheStandard)
{
  // RFC 3720, B.4, and the usual check value.
  const std::vector<std::uint8_t> zeros(32, 0);
  EXPECT_EQ(ComputeCrc32c(zeros.data(), zeros.size()), 0x8a9136aaU);
  const std::string digits = "123456789";
  EXPECT_EQ(ComputeCrc32c(reinterpret_cast<const std::uint8_t*>(digits.data()), digits.size()),
    0xe3069283U);
}
