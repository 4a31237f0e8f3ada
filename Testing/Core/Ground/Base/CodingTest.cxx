// SPDX-License-Identifier: BSD-3-Clause
#include "Ground/Base/Coding.h"

#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <limits>
#include <vector>

using namespace isosurface;

namespace
{

using Bytes = std::vector<std::uint8_t>;

Bytes MakeVarint(std::uint64_t number)
{
  Bytes bytes;
  AppendVarint(bytes, number);
  return bytes;
}

Bytes MakeSignedVarint(std::int64_t number)
{
  Bytes bytes;
  AppendSignedVarint(bytes, number);
  return bytes;
}

constexpr std::uint64_t Maximum64 = std::numeric_limits<std::uint64_t>::max();

} // namespace

TEST(Coding, LittleEndianValuesHaveTheirLowestByteFirst)
{
  Bytes bytes{ 0xff };
  AppendLittleEndian(bytes, std::uint32_t{ 0x01020304 });
  AppendLittleEndian(bytes, std::int16_t{ -2 });
  AppendLittleEndian(bytes, 1.0);
  EXPECT_EQ(bytes, (Bytes{ 0xff, 4, 3, 2, 1, 0xfe, 0xff, 0, 0, 0, 0, 0, 0, 0xf0, 0x3f }));
  EXPECT_EQ(LoadLittleEndian<std::uint32_t>(bytes.data() + 1), 0x01020304u);

  StoreLittleEndian(bytes.data() + 1, std::uint16_t{ 0x0a0b });
  EXPECT_EQ(LoadLittleEndian<std::uint32_t>(bytes.data() + 1), 0x01020a0bu);
}

// The bytes of 12857 and 624485 are the examples of the DWARF standard and of Wikipedia (LEB128).
TEST(Coding, VarintsAreLeb128)
{
  EXPECT_EQ(MakeVarint(0), (Bytes{ 0 }));
  EXPECT_EQ(MakeVarint(127), (Bytes{ 0x7f }));
  EXPECT_EQ(MakeVarint(128), (Bytes{ 0x80, 1 }));
  EXPECT_EQ(MakeVarint(12857), (Bytes{ 57 + 0x80, 100 }));
  EXPECT_EQ(MakeVarint(624485), (Bytes{ 0xe5, 0x8e, 0x26 }));
  EXPECT_EQ(
    MakeVarint(Maximum64), (Bytes{ 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 1 }));
  EXPECT_EQ(MakeVarint(Maximum64).size(), MaximumVarintSize);
}

TEST(Coding, SignedVarintsAreInZigzagOrder)
{
  EXPECT_EQ(MakeSignedVarint(0), (Bytes{ 0 }));
  EXPECT_EQ(MakeSignedVarint(-1), (Bytes{ 1 }));
  EXPECT_EQ(MakeSignedVarint(1), (Bytes{ 2 }));
  EXPECT_EQ(MakeSignedVarint(-2), (Bytes{ 3 }));
  EXPECT_EQ(MakeSignedVarint(-64), (Bytes{ 0x7f }));
  EXPECT_EQ(MakeSignedVarint(64), (Bytes{ 0x80, 1 }));
  EXPECT_EQ(MakeSignedVarint(std::numeric_limits<std::int64_t>::min()), MakeVarint(Maximum64));
  EXPECT_EQ(MakeSignedVarint(std::numeric_limits<std::int64_t>::max()), MakeVarint(Maximum64 - 1));
}

TEST(Coding, ReaderGivesBackWhatWasAppended)
{
  Bytes bytes;
  for (int bits = 0; bits < 64; ++bits)
  {
    const std::uint64_t number = Maximum64 >> bits;
    AppendVarint(bytes, number);
    AppendVarint(bytes, number + 1);
    AppendSignedVarint(bytes, static_cast<std::int64_t>(number));
    AppendSignedVarint(bytes, static_cast<std::int64_t>(0 - number));
  }
  AppendLittleEndian(bytes, -0.25F);
  bytes.insert(bytes.end(), { 5, 0, 6, 0, 7, 8 });

  ByteReader reader(bytes);
  for (int bits = 0; bits < 64; ++bits)
  {
    const std::uint64_t number = Maximum64 >> bits;
    EXPECT_EQ(reader.ReadVarint(), number);
    EXPECT_EQ(reader.ReadVarint(), number + 1);
    EXPECT_EQ(reader.ReadSignedVarint(), static_cast<std::int64_t>(number));
    EXPECT_EQ(reader.ReadSignedVarint(), static_cast<std::int64_t>(0 - number));
  }
  EXPECT_EQ(reader.Read<float>(), -0.25F);
  std::array<std::uint16_t, 2> pair{};
  reader.ReadAll(pair);
  EXPECT_EQ(pair, (std::array<std::uint16_t, 2>{ 5, 6 }));
  EXPECT_EQ(reader.GetRemaining(), 2u);
  EXPECT_EQ(reader.ReadBytes(2), bytes.data() + bytes.size() - 2);
  EXPECT_EQ(reader.GetRemaining(), 0u);
  EXPECT_FALSE(reader.HasFailed());
}

TEST(Coding, ReaderFailsAtTheEndAndReadsZerosFromThenOn)
{
  const Bytes bytes{ 1, 2, 3 };
  ByteReader reader(bytes);
  EXPECT_EQ(reader.Read<std::uint32_t>(), 0u);
  EXPECT_TRUE(reader.HasFailed());
  EXPECT_EQ(reader.GetRemaining(), 0u);
  EXPECT_EQ(reader.Read<std::uint8_t>(), 0u) << "though three bytes were there";
  EXPECT_EQ(reader.ReadVarint(), 0u);
  EXPECT_EQ(reader.ReadSignedVarint(), 0);
  EXPECT_EQ(reader.ReadBytes(0), nullptr);
  EXPECT_TRUE(reader.HasFailed());

  ByteReader bulk(bytes);
  EXPECT_EQ(bulk.ReadBytes(std::numeric_limits<std::size_t>::max()), nullptr);
  EXPECT_TRUE(bulk.HasFailed());

  ByteReader empty(nullptr, 0);
  EXPECT_FALSE(empty.HasFailed());
  EXPECT_EQ(empty.ReadVarint(), 0u);
  EXPECT_TRUE(empty.HasFailed());
}

TEST(Coding, ReaderRejectsAVarintThatIsCutOff)
{
  const Bytes bytes = MakeVarint(Maximum64);
  for (std::size_t size = 0; size < bytes.size(); ++size)
  {
    ByteReader reader(bytes.data(), size);
    EXPECT_EQ(reader.ReadVarint(), 0u);
    EXPECT_TRUE(reader.HasFailed()) << size;
  }
}

TEST(Coding, ReaderRejectsAVarintOfMoreThan64Bits)
{
  const Bytes tooLarge{ 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 2 };
  const Bytes tooLong{ 0x80, 0x80, 0x80, 0x80, 0x80, 0x80, 0x80, 0x80, 0x80, 0x80, 0 };
  for (const Bytes& bytes : { tooLarge, tooLong })
  {
    ByteReader reader(bytes);
    EXPECT_EQ(reader.ReadVarint(), 0u);
    EXPECT_TRUE(reader.HasFailed());
    EXPECT_EQ(reader.GetRemaining(), 0u);
  }
}

TEST(Coding, ReaderRejectsAVarintThatDoesNotFitItsType)
{
  const auto isRead = [](std::uint64_t number, auto type)
  {
    const Bytes bytes = MakeVarint(number);
    ByteReader reader(bytes);
    const auto value = reader.ReadVarint<decltype(type)>();
    EXPECT_EQ(static_cast<std::uint64_t>(value), reader.HasFailed() ? 0 : number);
    return !reader.HasFailed();
  };
  EXPECT_TRUE(isRead(0xffffffffu, std::uint32_t{}));
  EXPECT_FALSE(isRead(0x100000000u, std::uint32_t{}));
  EXPECT_TRUE(isRead(Maximum64 >> 1, std::int64_t{}));
  EXPECT_FALSE(isRead((Maximum64 >> 1) + 1, std::int64_t{}));
  EXPECT_TRUE(isRead(255, std::uint8_t{}));
  EXPECT_FALSE(isRead(256, std::uint8_t{}));
}
