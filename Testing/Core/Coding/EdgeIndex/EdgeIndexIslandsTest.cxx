// SPDX-License-Identifier: BSD-3-Clause
// Streams and files that lack islands hold what is left of the surface, whole and in pieces.
#include "Fixtures/CodedVolumes.h"
#include "Fixtures/EdgeIndexFileWriter.h"
#include "Fixtures/MemoryDisk.h"

#include "Coding/EdgeIndex/EdgeIndexFile.h"
#include "Ground/Base/Checksum.h"
#include "Ground/Base/Coding.h"

#include <gtest/gtest.h>

#include <array>
#include <set>

using namespace isosurface;

namespace
{

const std::string IslandsPath = "/data/surface.eix";
const std::vector<double> IslandIsovalues = { 150, 60 };

using Triangles = std::set<std::array<std::int64_t, 3>>;

/// By ids, of the whole surface or of several pieces.
void AddTriangles(const Surface& surface, Triangles& triangles)
{
  for (std::size_t n = 0; n < surface.NumberOfTriangles; ++n)
  {
    std::array<std::int64_t, 3> ids{};
    for (std::size_t corner = 0; corner < 3; ++corner)
    {
      ids[corner] =
        surface.GlobalIds[static_cast<std::size_t>(surface.Connectivity[3 * n + corner])];
    }
    EXPECT_TRUE(triangles.insert(ids).second) << "a triangle in two pieces";
  }
}

/// Shells within shells, with dust between them: bodies in cavities of bodies.
SampleVolume<std::uint8_t> MakeShells()
{
  std::mt19937 random(5);
  return SampleVolume<std::uint8_t>({ 41, 38, 35 },
    [&](auto i, auto j, auto k)
    {
      const double r = std::sqrt(
        static_cast<double>((i - 20) * (i - 20) + (j - 18) * (j - 18) + (k - 17) * (k - 17)));
      return 105 + 80 * std::cos(0.9 * r) + (random() % 97 == 0 ? 60 : 0);
    });
}

template <typename T>
void ExpectRest(const SampleVolume<T>& volume, const std::vector<double>& isovalues, int blockSize)
{
  TestBlockSource<T> source(volume, blockSize);
  for (const EdgeIndexProfile profile : AllProfiles)
  {
    EdgeIndexHeader header = MakeHeader(volume, isovalues, EdgeIndexMode::Lossless, profile);
    for (const int closing : { 0, 1, 2 })
    {
      header.ClosedSides = closing > 0 ? GridSides::All() : GridSides();
      header.ClosedSides.AreBeyondInside = closing > 1;
      const Surface expected = LeaveOutIslands(header, source, 3);
      ASSERT_GT(expected.NumberOfTriangles, 0u);
      ExpectSamePoints(expected, EncodeAndDecode(header, source, MakeRequest({}), 2));
    }
  }
}

/// The file of a surface that lacks islands, in memory.
std::unique_ptr<EdgeIndexFile> WriteAndOpen(
  MemoryDisk& disk, const EdgeIndexHeader& header, BlockSource& source)
{
  EXPECT_TRUE(WriteEdgeIndexFile(disk, IslandsPath, header, source, 1).IsOk());
  return Require(EdgeIndexFile::Open(disk, IslandsPath));
}

/// A stream whose only record is that of a block which lacks islands. `change` may change it, or append its bytes.
template <typename Change>
Status DecodeChanged(const Change& change)
{
  const auto volume = MakeShells();
  TestBlockSource<std::uint8_t> source(volume, 64);
  EdgeIndexHeader header =
    MakeHeader(volume, { 150 }, EdgeIndexMode::Lossless, EdgeIndexProfile::Small);
  LeaveOutIslands(header, source, 3);
  const auto good = Require(EncodeSurface(header, source, 1));
  std::size_t first = 0;
  const auto parsed = Require(EdgeIndexHeader::Parse(good.data(), good.size(), first));
  std::size_t used = 0;
  auto record =
    Require(EdgeIndexRecord::Parse(parsed, good.data() + first, good.size() - first, used));
  EXPECT_TRUE(record.Block.LacksIslands);
  std::vector<std::uint8_t> bytes(good.begin(), good.begin() + first);
  change(record, bytes);
  if (bytes.size() == first)
  {
    record.Append(bytes);
  }
  return DecodeSurface(bytes.data(), bytes.size(), MakeRequest({}), 1).GetStatus();
}

} // namespace

TEST(EdgeIndexIslands, WhatIsLeftIsDecodedBitForBitOpenAndClosed)
{
  ExpectRest(MakeShells(), IslandIsovalues, 8);
  ExpectRest(MakeShells(), IslandIsovalues, 24);
  ExpectRest(MakeWaves<std::int16_t>({ 18, 40, 21 }, 3), { 3000, 3001, -9000 }, 24);
  ExpectRest(MakeWaves<float>({ 21, 18, 40 }, 3), { 0.25, -0.5 }, 8);
  // Samples of the isovalue, so that points of a closed surface meet on vertices.
  std::mt19937 random(11);
  ExpectRest(MakeRandomVolume<std::uint8_t>(random, { 24, 20, 19 }, 4), { 1, 2 }, 8);
}

TEST(EdgeIndexIslands, EveryModeLeavesOutTheSameIslands)
{
  const auto volume = MakeShells();
  TestBlockSource<std::uint8_t> source(volume, 16);
  for (const EdgeIndexMode mode :
    { EdgeIndexMode::Bounded, EdgeIndexMode::Quantized, EdgeIndexMode::Smallest })
  {
    for (const EdgeIndexProfile profile : AllProfiles)
    {
      EdgeIndexHeader header = MakeHeader(volume, IslandIsovalues, mode, profile);
      const Surface expected = LeaveOutIslands(header, source, 4);
      ExpectSameTopology(expected, EncodeAndDecode(header, source, MakeRequest({})));
    }
  }
}

TEST(EdgeIndexIslands, PiecesBoxesIsovaluesAndThePreviewLackThemToo)
{
  const auto volume = MakeShells();
  TestBlockSource<std::uint8_t> source(volume, 8);
  MemoryDisk disk;
  EdgeIndexHeader header =
    MakeHeader(volume, IslandIsovalues, EdgeIndexMode::Smallest, EdgeIndexProfile::Small);
  header.PreviewLevel = 1;
  const Surface expected = LeaveOutIslands(header, source, 3);
  Triangles all;
  AddTriangles(expected, all);
  const auto file = WriteAndOpen(disk, header, source);
  EXPECT_TRUE(file->Verify(2).IsOk());
  const Surface withoutIds = Require(file->Read({}, ContourRequest(), 2));
  EXPECT_EQ(withoutIds.NumberOfTriangles, expected.NumberOfTriangles);
  EXPECT_TRUE(withoutIds.GlobalIds.IsEmpty());
  EXPECT_TRUE(file->GetHeader().LacksIslands);
  for (const int pieces : { 1, 2, 7 })
  {
    Triangles read;
    EdgeIndexSelection selection;
    selection.NumberOfPieces = pieces;
    for (selection.Piece = 0; selection.Piece < pieces; ++selection.Piece)
    {
      AddTriangles(Require(file->Read(selection, MakeRequest({}), 1)), read);
    }
    EXPECT_TRUE(read == all) << pieces;
  }
  Triangles second;
  EdgeIndexSelection isovalue;
  isovalue.Isovalues = { 1 };
  AddTriangles(Require(file->Read(isovalue, MakeRequest({}), 1)), second);
  EXPECT_EQ(second.size(), expected.Parts[1].NumberOfCells);
  EdgeIndexSelection box;
  box.Box = VertexBox{ { 9, 9, 9 }, { 15, 15, 15 } };
  Triangles within;
  AddTriangles(Require(file->Read(box, MakeRequest({}), 1)), within);
  EXPECT_GT(within.size(), 0u);
  EXPECT_TRUE(std::includes(all.begin(), all.end(), within.begin(), within.end()));

  EdgeIndexSelection preview;
  preview.Preview = true;
  const Surface coarse = Require(file->Read(preview, MakeRequest({}), 1));
  PreviewBlocks coarseBlocks(source, 1);
  EdgeIndexHeader ofPreview = header.MakePreview();
  ExpectSameTopology(LeaveOutIslands(ofPreview, coarseBlocks, 3), coarse);
}

TEST(EdgeIndexIslands, TheDirectoryCountsThePointsThatAreKept)
{
  const auto volume = MakeShells();
  TestBlockSource<std::uint8_t> source(volume, 64);
  MemoryDisk disk;
  EdgeIndexHeader header =
    MakeHeader(volume, { 150 }, EdgeIndexMode::Lossless, EdgeIndexProfile::Small);
  const Surface expected = LeaveOutIslands(header, source, 2);
  const auto file = WriteAndOpen(disk, header, source);
  ASSERT_EQ(file->GetEntries().size(), 1u);
  EXPECT_EQ(file->GetEntries()[0].Block.NumberOfPoints, expected.NumberOfPoints);
}

TEST(EdgeIndexIslands, BlocksThatKeepAllHaveNoMoreBytesAndOnesThatKeepNoneHaveNoRecord)
{
  const auto volume = MakeShells();
  TestBlockSource<std::uint8_t> source(volume, 8);
  EdgeIndexHeader header =
    MakeHeader(volume, { 150 }, EdgeIndexMode::Lossless, EdgeIndexProfile::Small);
  const auto whole = Require(EncodeSurface(header, source, 1));
  LeaveOutIslands(header, source, 1000000); // all but the second
  const Surface rest = EncodeAndDecode(header, source, MakeRequest({}));
  const auto lacking = Require(EncodeSurface(header, source, 1));
  EXPECT_LT(rest.NumberOfTriangles,
    Require(ExtractSurface(volume.Geometry, source, MakeRequest({ 150 }), 1)).NumberOfTriangles);
  EXPECT_LT(lacking.size(), whole.size() + 3 * source.Blocks.size());
  header.KeptIds = std::make_shared<const std::vector<std::int64_t>>();
  std::vector<std::uint8_t> headerBytes;
  header.Append(headerBytes);
  EXPECT_EQ(Require(EncodeSurface(header, source, 1)), headerBytes);
}

TEST(EdgeIndexIslands, DustWithinABlockTakesNoBytes)
{
  const auto ball = [](auto i, auto j, auto k)
  { return 200 - ((i - 20) * (i - 20) + (j - 18) * (j - 18) + (k - 17) * (k - 17)) / 2; };
  SampleVolume<std::int16_t> clean({ 41, 38, 35 }, ball);
  SampleVolume<std::int16_t> dusty = clean;
  for (std::int64_t n = 8; n < 27; n += 3)
  {
    dusty.At(n, 2, 2) = dusty.At(n, 35, 30) = 150;
    dusty.At(20, 18, n) = -50; // pores
  }
  dusty.At(19, 18, 17) = dusty.At(20, 17, 17) = -50;
  for (const EdgeIndexMode mode : { EdgeIndexMode::Lossless, EdgeIndexMode::Smallest })
  {
    EdgeIndexHeader header = MakeHeader(clean, { 100 }, mode, EdgeIndexProfile::Small);
    TestBlockSource<std::int16_t> cleanSource(clean, 64);
    TestBlockSource<std::int16_t> dustySource(dusty, 64);
    const Surface expected =
      Require(ExtractSurface(clean.Geometry, cleanSource, MakeRequest({ 100 }), 1));
    auto bytes = Require(EncodeSurface(header, cleanSource, 1));
    std::vector<std::int64_t> ids(expected.GlobalIds.begin(), expected.GlobalIds.end());
    std::sort(ids.begin(), ids.end());
    header.LacksIslands = true;
    header.KeptIds = std::make_shared<const std::vector<std::int64_t>>(ids);
    const auto lacking = Require(EncodeSurface(header, dustySource, 1));
    ASSERT_EQ(lacking.size(), bytes.size());
    std::size_t headerSize = 0;
    Require(EdgeIndexHeader::Parse(bytes.data(), bytes.size(), headerSize));
    EXPECT_TRUE(std::equal(bytes.begin() + headerSize, bytes.end(), lacking.begin() + headerSize));
  }
}

TEST(EdgeIndexIslands, WrongNumbersOfIslandsAndBitsBeyondThemAreCorrupt)
{
  EXPECT_TRUE(DecodeChanged([](EdgeIndexRecord&, auto&) {}).IsOk());
  ExpectError(DecodeChanged([](EdgeIndexRecord& record, auto&) { record.AreKept.push_back(true); }),
    StatusCode::Corrupt, "islands, and has");
  ExpectError(DecodeChanged([](EdgeIndexRecord& record, auto&) { record.AreKept.resize(2); }),
    StatusCode::Corrupt, "tells of 2 islands, and has");
  const std::string untold = "does not tell which of its islands are kept";
  for (const bool all : { false, true })
  {
    ExpectError(DecodeChanged([all](EdgeIndexRecord& record, auto&)
                  { record.AreKept.assign(record.AreKept.size(), all); }),
      StatusCode::Corrupt, untold);
  }
  ExpectError(DecodeChanged([](EdgeIndexRecord& record, auto&) { record.AreKept.clear(); }),
    StatusCode::Corrupt, untold);
  // A record without the flag keeps all.
  EXPECT_TRUE(DecodeChanged(
    [](EdgeIndexRecord& record, auto&) {
      record.Block.LacksIslands = false;
    }).IsOk());
  // One of eight bits is 1 beyond the two islands that the count tells of then.
  ExpectError(DecodeChanged(
                [](EdgeIndexRecord& record, std::vector<std::uint8_t>& bytes)
                {
                  const std::size_t first = bytes.size();
                  record.AreKept = { true, false, false, false, false, false, false, true };
                  record.Append(bytes);
                  const std::size_t end = bytes.size() - 4;
                  const std::size_t count = end - record.CodeSize - 2;
                  ASSERT_EQ(bytes[count], 8);
                  bytes[count] = 2;
                  std::size_t body = first;
                  while (bytes[body++] > 127)
                  {
                  }
                  StoreLittleEndian(bytes.data() + end,
                    static_cast<std::uint32_t>(ComputeChecksum(bytes.data() + body, end - body)));
                }),
    StatusCode::Corrupt, untold);
}

TEST(EdgeIndexIslands, PartsOfOneIslandThatAreKeptAndLeftOutAreCorrupt)
{
  const auto volume = MakeShells();
  TestBlockSource<std::uint8_t> source(volume, 16);
  EdgeIndexHeader header =
    MakeHeader(volume, { 150 }, EdgeIndexMode::Lossless, EdgeIndexProfile::Small);
  LeaveOutIslands(header, source, 3);
  const auto good = Require(EncodeSurface(header, source, 1));
  std::size_t at = 0;
  const auto parsed = Require(EdgeIndexHeader::Parse(good.data(), good.size(), at));
  std::vector<std::uint8_t> bytes(good.begin(), good.begin() + at);
  bool isFlipped = false;
  for (std::size_t used = 0; at < good.size(); at += used)
  {
    auto record = Require(EdgeIndexRecord::Parse(parsed, good.data() + at, good.size() - at, used));
    if (record.Block.LacksIslands && !isFlipped)
    {
      record.AreKept.flip();
      isFlipped = true;
    }
    record.Append(bytes);
  }
  ExpectError(DecodeSurface(bytes.data(), bytes.size(), MakeRequest({}), 1).GetStatus(),
    StatusCode::Corrupt, "its blocks keep and leave out parts of one island");
}

TEST(EdgeIndexIslands, AClosedSurfaceMustBeLossless)
{
  const auto volume = MakeShells();
  TestBlockSource<std::uint8_t> source(volume, 16);
  EdgeIndexHeader header =
    MakeHeader(volume, { 150 }, EdgeIndexMode::Smallest, EdgeIndexProfile::Small);
  header.ClosedSides = GridSides::All();
  EXPECT_TRUE(header.Check().IsOk());
  header.LacksIslands = true;
  ExpectError(header.Check(), StatusCode::InvalidArgument, "must be lossless");
}
