// SPDX-License-Identifier: BSD-3-Clause
#include "Fixtures/CodedVolumes.h"

#include "Ground/Base/Checksum.h"
#include "Ground/Base/Coding.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <tuple>
#include <vector>

using namespace isosurface;

namespace
{

std::vector<std::uint8_t> EncodeSmall(EdgeIndexMode mode, EdgeIndexProfile profile)
{
  const auto volume = MakeWaves<std::uint8_t>({ 20, 12, 10 }, 0.5);
  TestBlockSource<std::uint8_t> source(volume, 16);
  return *EncodeSurface(MakeHeader(volume, { 120.5 }, mode, profile), source, 1);
}

bool Decodes(const std::vector<std::uint8_t>& bytes)
{
  // In memory of their own size, so that a read behind their end is found.
  const std::unique_ptr<std::uint8_t[]> copy(new std::uint8_t[bytes.size()]);
  std::copy(bytes.begin(), bytes.end(), copy.get());
  return DecodeSurface(copy.get(), bytes.size(), MakeRequest({}), 1).IsOk();
}

} // namespace

TEST(EdgeIndexCorruption, EveryFlippedByteIsFound)
{
  for (const auto profile : { EdgeIndexProfile::Small, EdgeIndexProfile::Working })
  {
    const std::vector<std::uint8_t> good = EncodeSmall(EdgeIndexMode::Lossless, profile);
    ASSERT_TRUE(Decodes(good));
    for (std::size_t n = 0; n < good.size(); ++n)
    {
      std::vector<std::uint8_t> bad = good;
      bad[n] = static_cast<std::uint8_t>(~bad[n]);
      EXPECT_FALSE(Decodes(bad)) << n;
      bad[n] = static_cast<std::uint8_t>(good[n] ^ 1u << (n % 8));
      EXPECT_FALSE(Decodes(bad)) << n;
    }
  }
}

TEST(EdgeIndexCorruption, EveryCutIsFoundUnlessItLeavesWholeBlocks)
{
  for (const auto profile : { EdgeIndexProfile::Small, EdgeIndexProfile::Working })
  {
    const std::vector<std::uint8_t> good = EncodeSmall(EdgeIndexMode::Bounded, profile);
    int decoded = 0;
    for (std::size_t size = 0; size < good.size(); ++size)
    {
      decoded += Decodes(std::vector<std::uint8_t>(good.begin(), good.begin() + size)) ? 1 : 0;
    }
    EXPECT_EQ(decoded, 2); // the header alone, and with the first of two blocks
  }
}

TEST(EdgeIndexCorruption, CodesThatNoEncoderWroteDecodeWithoutHarm)
{
  for (const EdgeIndexMode mode :
    { EdgeIndexMode::Lossless, EdgeIndexMode::Bounded, EdgeIndexMode::Quantized })
  {
    for (const EdgeIndexProfile profile : AllProfiles)
    {
      const std::vector<std::uint8_t> good = EncodeSmall(mode, profile);
      std::size_t first = 0;
      const auto header = Require(EdgeIndexHeader::Parse(good.data(), good.size(), first));
      std::size_t used = 0;
      const auto parsed =
        Require(EdgeIndexRecord::Parse(header, good.data() + first, good.size() - first, used));
      for (std::size_t n = 0; n < parsed.CodeSize; ++n)
      {
        std::vector<std::uint8_t> code(parsed.Code, parsed.Code + parsed.CodeSize);
        code[n] = static_cast<std::uint8_t>(code[n] + 1 + n % 200);
        EdgeIndexRecord record = parsed;
        record.Code = code.data();
        std::vector<std::uint8_t> bytes(good.begin(), good.begin() + first);
        record.Append(bytes); // with the right checksum
        Decodes(bytes);
        record.CodeSize = n;
        bytes.resize(first);
        record.Append(bytes);
        Decodes(bytes);
      }
    }
  }
}

// With the right checksum, so that the decoder itself has to find it.
TEST(EdgeIndexCorruption, ACodeOfTheProfileWorkingThatIsCutOffOrGoesOnIsCorrupt)
{
  for (const EdgeIndexMode mode : { EdgeIndexMode::Lossless, EdgeIndexMode::Bounded })
  {
    const std::vector<std::uint8_t> good = EncodeSmall(mode, EdgeIndexProfile::Working);
    std::size_t first = 0;
    const auto header = Require(EdgeIndexHeader::Parse(good.data(), good.size(), first));
    std::size_t used = 0;
    const auto parsed =
      Require(EdgeIndexRecord::Parse(header, good.data() + first, good.size() - first, used));
    std::vector<std::uint8_t> code(parsed.Code, parsed.Code + parsed.CodeSize);
    code.push_back(0);
    for (std::size_t size = 0; size <= code.size(); ++size)
    {
      EdgeIndexRecord record = parsed;
      record.Code = code.data();
      record.CodeSize = size;
      std::vector<std::uint8_t> bytes(good.begin(), good.begin() + first);
      record.Append(bytes);
      EXPECT_EQ(Decodes(bytes), size == parsed.CodeSize) << size;
    }
  }
}

TEST(EdgeIndexCorruption, NormalsThatAreNotInTheStreamAreRefused)
{
  const std::vector<std::uint8_t> good =
    EncodeSmall(EdgeIndexMode::Lossless, EdgeIndexProfile::Small);
  ContourRequest request;
  request.Normals = true;
  EXPECT_EQ(DecodeSurface(good.data(), good.size(), request, 1).GetStatus().GetCode(),
    StatusCode::InvalidArgument);
}

TEST(EdgeIndexCorruption, AProfileThatTheFormatDoesNotHaveIsCorrupt)
{
  std::vector<std::uint8_t> bytes = EncodeSmall(EdgeIndexMode::Lossless, EdgeIndexProfile::Small);
  std::size_t size = 0;
  ASSERT_TRUE(EdgeIndexHeader::Parse(bytes.data(), bytes.size(), size).IsOk());
  bytes[18] = 4;
  StoreLittleEndian(bytes.data() + size - 8, ComputeChecksum(bytes.data(), size - 8));
  EXPECT_EQ(EdgeIndexHeader::Parse(bytes.data(), bytes.size(), size).GetStatus().GetCode(),
    StatusCode::Corrupt);
}

TEST(EdgeIndexCorruption, AUnitThatTheVersionDoesNotHaveIsCorrupt)
{
  std::vector<std::uint8_t> bytes = EncodeSmall(EdgeIndexMode::Lossless, EdgeIndexProfile::Small);
  std::size_t size = 0;
  ASSERT_TRUE(EdgeIndexHeader::Parse(bytes.data(), bytes.size(), size).IsOk());
  const std::size_t header = size;
  for (const auto& [version, unit, isValid] : { std::tuple(2, 0, true), std::tuple(2, 11, true),
         std::tuple(2, 12, false), std::tuple(1, 1, false) })
  {
    bytes[8] = static_cast<std::uint8_t>(version);
    bytes[234] = static_cast<std::uint8_t>(unit);
    StoreLittleEndian(bytes.data() + header - 8, ComputeChecksum(bytes.data(), header - 8));
    const auto parsed = EdgeIndexHeader::Parse(bytes.data(), bytes.size(), size);
    EXPECT_EQ(parsed.GetStatus().GetCode(), isValid ? StatusCode::Ok : StatusCode::Corrupt)
      << version << ", " << unit;
    EXPECT_TRUE(!isValid || parsed->Geometry.Unit == static_cast<LengthUnit>(unit));
  }
}

TEST(EdgeIndexCorruption, ClosingAndIslandsThatTheVersionDoesNotHaveAreCorrupt)
{
  std::vector<std::uint8_t> bytes = EncodeSmall(EdgeIndexMode::Lossless, EdgeIndexProfile::Small);
  std::size_t header = 0;
  ASSERT_TRUE(EdgeIndexHeader::Parse(bytes.data(), bytes.size(), header).IsOk());
  for (const auto& [version, closing, isValid] : { std::tuple(3, 0, true), std::tuple(3, 1, true),
         std::tuple(3, 2, true), std::tuple(3, 3, false), std::tuple(2, 1, false),
         std::tuple(3, 4, true), std::tuple(3, 6, true), std::tuple(3, 7, false),
         std::tuple(3, 8, false), std::tuple(2, 4, false) })
  {
    bytes[8] = static_cast<std::uint8_t>(version);
    bytes[235] = static_cast<std::uint8_t>(closing);
    StoreLittleEndian(bytes.data() + header - 8, ComputeChecksum(bytes.data(), header - 8));
    std::size_t size = 0;
    const auto parsed = EdgeIndexHeader::Parse(bytes.data(), bytes.size(), size);
    EXPECT_EQ(parsed.GetStatus().GetCode(), isValid ? StatusCode::Ok : StatusCode::Corrupt)
      << version << ", " << closing;
    EXPECT_TRUE(!isValid || parsed->ClosedSides.IsEmpty() == ((closing & 3) == 0));
    EXPECT_TRUE(!isValid || parsed->LacksIslands == (closing > 3));
  }
}

TEST(EdgeIndexCorruption, OtherVersionsAreUnsupported)
{
  for (const std::uint8_t version : { 0, 4, 5, 255 })
  {
    std::vector<std::uint8_t> bytes = EncodeSmall(EdgeIndexMode::Lossless, EdgeIndexProfile::Small);
    ASSERT_EQ(bytes[8], 1);
    bytes[8] = version;
    const Status status = DecodeSurface(bytes.data(), bytes.size(), {}, 1).GetStatus();
    ExpectError(status, StatusCode::Unsupported, "version " + std::to_string(version));
  }
}
