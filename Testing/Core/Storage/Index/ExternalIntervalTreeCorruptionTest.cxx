// SPDX-License-Identifier: BSD-3-Clause
#include "Fixtures/LongTests.h"
#include "Fixtures/Require.h"
#include "Fixtures/ResealedPages.h"
#include "IntervalSets.h"

#include <memory>

using namespace isosurface;

namespace
{

using Bytes = MemoryDisk::Bytes;

constexpr std::size_t PageSize = PagedFile::DefaultPageSize;

Bytes MakeTreeBytes(const IntervalVector& intervals)
{
  MemoryDisk disk;
  EXPECT_TRUE(WriteTree(disk, "tree", intervals).IsOk());
  return disk.GetFile("tree");
}

Result<std::unique_ptr<ExternalIntervalTree>> OpenBytes(MemoryDisk& disk, Bytes bytes)
{
  disk.SetFile("tree", std::move(bytes));
  return ExternalIntervalTree::Open(disk, "tree", 0);
}

} // namespace

TEST(ExternalIntervalTreeCorruption, NoChangedByteGivesAWrongAnswer)
{
  // A root with leaves and all kinds of lists, in a few pages.
  IntervalVector intervals = MakeIntervalSets()[0].MakeAll(420);
  const Bytes good = MakeTreeBytes(intervals);
  ASSERT_LE(good.size(), 10 * PageSize);
  MemoryDisk disk;
  PageStatistics statistics;
  const auto whole = Require(OpenBytes(disk, good));
  ASSERT_TRUE(whole->Verify(statistics).IsOk());
  int errors = 0;
  // All bytes take half a minute with sanitizers; with 5 each of the eight bits has its turn, too.
  constexpr int step = LongTests ? 1 : 5;
  for (std::size_t offset = 0; offset < good.size(); offset += step)
  {
    Bytes bad = good;
    bad[offset] ^= static_cast<std::uint8_t>(1u << (offset % 8));
    const auto tree = OpenBytes(disk, std::move(bad));
    if (!tree.IsOk())
    {
      ASSERT_NE(tree.GetStatus().GetMessage().find("tree"), std::string::npos);
      ++errors;
      continue;
    }
    ASSERT_FALSE((*tree)->Verify(statistics).IsOk()) << "byte " << offset;
    std::vector<int> seen(intervals.size(), 0);
    const Status status = (*tree)->FindOverlapping(
      0, MaximumKey, [&](const KeyInterval& interval) { ++seen.at(interval.Payload); }, statistics);
    const bool complete = std::all_of(seen.begin(), seen.end(), [](int n) { return n == 1; });
    ASSERT_TRUE(complete || !status.IsOk()) << "byte " << offset;
    errors += !status.IsOk();
    const ValueKey key = intervals[offset % intervals.size()].Minimum;
    std::uint64_t expected = 0;
    for (const KeyInterval& interval : intervals)
    {
      expected += interval.Minimum <= key && key <= interval.Maximum;
    }
    std::uint64_t found = 0;
    const Status stabbed = (*tree)->FindStabbed(
      key, [&](const KeyInterval&) { ++found; }, statistics);
    ASSERT_TRUE(!stabbed.IsOk() || found == expected) << "byte " << offset;
  }
  EXPECT_GT(errors, static_cast<int>(PageSize) / step);
}

TEST(ExternalIntervalTreeCorruption, EveryTruncationIsAnError)
{
  const Bytes good = MakeTreeBytes(MakeIntervalSets()[0].MakeAll(420));
  MemoryDisk disk;
  for (std::size_t size = 0; size < good.size(); size += LongTests ? 1 : PageSize / 256)
  {
    const auto tree =
      OpenBytes(disk, Bytes(good.begin(), good.begin() + static_cast<std::ptrdiff_t>(size)));
    ASSERT_FALSE(tree.IsOk()) << size;
    ASSERT_EQ(tree.GetStatus().GetCode(), StatusCode::Corrupt) << size;
  }
  Bytes longer = good;
  longer.resize(good.size() + PageSize);
  EXPECT_EQ(OpenBytes(disk, longer).GetStatus().GetCode(), StatusCode::Corrupt);
}

TEST(ExternalIntervalTreeCorruption, NewerVersionsAreUnsupportedAndOtherFilesCorrupt)
{
  const Bytes good = MakeTreeBytes({ { 1, 2, 3 } });
  MemoryDisk disk;
  for (const std::size_t offset : { 8, 32 }) // of the paged file, of the tree
  {
    Bytes newer = good;
    ++newer[offset];
    ResealPages(newer);
    const auto tree = OpenBytes(disk, newer);
    ExpectError(tree.GetStatus(), StatusCode::Unsupported, "newer version");
  }
  for (const std::size_t offset : { 0, 24 }) // magic, kind
  {
    Bytes other = good;
    other[offset] = 'x';
    ResealPages(other);
    EXPECT_EQ(OpenBytes(disk, other).GetStatus().GetCode(), StatusCode::Corrupt);
  }
  EXPECT_EQ(
    ExternalIntervalTree::Open(disk, "nowhere", 0).GetStatus().GetCode(), StatusCode::NotFound);
}

TEST(ExternalIntervalTreeCorruption, AFileWithoutItsFirstPageNeverOpens)
{
  Bytes bytes = MakeTreeBytes({ { 1, 2, 3 } });
  std::fill(bytes.begin(), bytes.begin() + PageSize, std::uint8_t(0));
  MemoryDisk disk;
  EXPECT_EQ(OpenBytes(disk, bytes).GetStatus().GetCode(), StatusCode::Corrupt);
}

TEST(ExternalIntervalTreeCorruption, HostilePagesWithMatchingChecksumsNeitherCrashNorHang)
{
  std::mt19937_64 random(11);
  MemoryDisk disk;
  int errors = 0;
  const auto sets = MakeIntervalSets();
  for (std::size_t set = 0; set < sets.size(); set += 2)
  {
    const IntervalVector intervals = sets[set].MakeAll(8000);
    const Bytes good = MakeTreeBytes(intervals);
    for (int iteration = 0; iteration < 150; ++iteration)
    {
      Bytes bad = good;
      const std::size_t changes = 1 + random() % 6;
      for (std::size_t change = 0; change < changes; ++change)
      {
        // Prefers nodes, which are the last pages, and the first half of a page.
        const std::size_t pages = bad.size() / PageSize;
        const std::size_t page = random() % 3 ? pages - 1 - random() % 2 : random() % pages;
        const std::size_t offset = page * PageSize + random() % (random() % 2 ? 4080 : 400);
        const std::size_t width = std::size_t(1) << random() % 4;
        const std::uint64_t value = random() >> (random() % 64);
        std::memcpy(bad.data() + offset, &value, width);
      }
      ResealPages(bad);
      const std::uint64_t limit = 2 * (64 + 16 * (bad.size() / PageSize)) + 2;
      const auto tree = OpenBytes(disk, std::move(bad));
      if (!tree.IsOk())
      {
        ++errors;
        continue;
      }
      PageStatistics statistics;
      const ValueKey low = MakeQueryKey(intervals, random);
      const ValueKey high = std::max(low, MakeQueryKey(intervals, random));
      bool right = true;
      const auto visit = [&](const KeyInterval& interval)
      { right = right && interval.Minimum <= high && interval.Maximum >= low; };
      errors += !(*tree)->FindStabbed(low, visit, statistics).IsOk();
      errors += !(*tree)->FindOverlapping(low, high, visit, statistics).IsOk();
      ASSERT_TRUE(right) << "an interval that does not overlap the query";
      ASSERT_LE(statistics.PageReads, limit);
    }
  }
  EXPECT_GT(errors, 180);
}

TEST(ExternalIntervalTreeCorruption, AQueryEndsIfManyReferencesLeadToTheSamePages)
{
  // All children of a node are the previous node: 28^n paths to the last of n nodes.
  const IntervalVector intervals = MakeIntervalSets()[4].MakeAll(200000);
  Bytes bytes = MakeTreeBytes(intervals);
  constexpr std::size_t childOffset = 36, slabSize = 50;
  std::uint32_t before = 0;
  std::uint16_t height = 0;
  for (std::size_t page = 1; page < bytes.size() / PageSize && height < 30; ++page)
  {
    std::uint8_t* node = bytes.data() + page * PageSize;
    if (std::memcmp(node, "NODE", 4) != 0)
    {
      continue;
    }
    ++height;
    StoreLittleEndian(node + 4, height);
    const auto slabs = LoadLittleEndian<std::uint16_t>(node + 6);
    for (std::size_t slab = 0; slab < slabs; ++slab)
    {
      std::uint8_t* child = node + 8 + 8u * slabs + slab * slabSize + childOffset;
      StoreLittleEndian(child, before);
      StoreLittleEndian(child + 4, std::uint16_t(0));
      StoreLittleEndian(child + 6, std::uint32_t(before == 0 ? 0 : 1));
      StoreLittleEndian(child + 10, std::uint16_t(height - 1));
    }
    before = static_cast<std::uint32_t>(page);
  }
  ASSERT_GT(height, 10);
  StoreLittleEndian(bytes.data() + 32 + 32, before);
  StoreLittleEndian(bytes.data() + 32 + 42, height);
  ResealPages(bytes);
  MemoryDisk disk;
  const auto tree = Require(OpenBytes(disk, bytes));
  PageStatistics statistics;
  const Status status = tree->FindOverlapping(
    0, MaximumKey, [](const KeyInterval&) {}, statistics);
  EXPECT_EQ(status.GetCode(), StatusCode::Corrupt);
  EXPECT_LE(statistics.PageReads, 64 + 16 * tree->GetPageCount());
}

TEST(ExternalIntervalTreeCorruption, AQueryEndsIfManyListsAreTheSameRecords)
{
  // The current page is not read again, so the limit on pages does not end the query.
  Bytes bytes = MakeTreeBytes(MakeIntervalSets()[4].MakeAll(1000));
  std::uint8_t* root = bytes.data() + bytes.size() - PageSize;
  ASSERT_EQ(std::memcmp(root, "NODE", 4), 0);
  constexpr std::size_t slabSize = 50, multislabSize = 14, windowOffset = 48;
  const auto slabs = LoadLittleEndian<std::uint16_t>(root + 6);
  std::uint8_t* slab = root + 8 + 8u * slabs;
  for (std::size_t index = 0; index < slabs; ++index)
  {
    StoreLittleEndian(slab + windowOffset, std::uint16_t(0xffff));
    slab += slabSize;
  }
  const std::size_t multislabs =
    static_cast<std::size_t>(root + PageSize - 8 - slab) / multislabSize;
  for (std::size_t index = 0; index < multislabs; ++index)
  {
    std::uint8_t* multislab = slab + index * multislabSize;
    StoreLittleEndian(multislab, std::uint16_t(1));
    StoreLittleEndian(multislab + 2, std::uint16_t(slabs - 2));
    StoreLittleEndian(multislab + 4, std::uint32_t(1));
    StoreLittleEndian(multislab + 8, std::uint16_t(0));
    StoreLittleEndian(multislab + 10, std::uint32_t(200));
  }
  StoreLittleEndian(root + 8, static_cast<std::uint16_t>(multislabs));
  StoreLittleEndian(root + 10, std::uint16_t(0));
  ResealPages(bytes);
  MemoryDisk disk;
  const auto tree = Require(OpenBytes(disk, bytes));
  PageStatistics statistics;
  const Status status = tree->FindStabbed(
    5005, [](const KeyInterval&) {}, statistics);
  ExpectError(status, StatusCode::Corrupt, "more intervals than its pages hold");
}

TEST(ExternalIntervalTreeCorruption, VerifyFindsEveryForgedBound)
{
  // Bounds leave out whole lists: one that is too tight makes intervals vanish from answers.
  constexpr std::size_t minimumOffset = 32 + 16, maximumOffset = 32 + 24, slabSize = 50;
  MemoryDisk disk;
  PageStatistics statistics;
  for (const auto& set : MakeIntervalSets())
  {
    const Bytes good = MakeTreeBytes(set.MakeAll(3000));
    const auto whole = Require(OpenBytes(disk, good));
    const Status status = whole->Verify(statistics);
    ASSERT_TRUE(status.IsOk()) << status.GetMessage();
    std::vector<std::size_t> bounds = { minimumOffset, maximumOffset };
    for (std::size_t page = 1; page < good.size() / PageSize; ++page)
    {
      const std::uint8_t* node = good.data() + page * PageSize;
      if (std::memcmp(node, "NODE", 4) != 0)
      {
        continue;
      }
      const auto slabs = LoadLittleEndian<std::uint16_t>(node + 6);
      for (std::size_t slab = 0; slab < slabs; ++slab)
      {
        const std::size_t offset = 8 + 8u * slabs + slab * slabSize;
        for (const std::size_t list : { offset, offset + 18 })
        {
          if (LoadLittleEndian<std::uint32_t>(node + list + 6) > 0)
          {
            bounds.push_back(page * PageSize + list + 10);
          }
        }
      }
    }
    for (const std::size_t bound : bounds)
    {
      for (const int change : { -1, 1 })
      {
        Bytes bad = good;
        StoreLittleEndian(bad.data() + bound,
          LoadLittleEndian<std::uint64_t>(bad.data() + bound) + static_cast<std::uint64_t>(change));
        ResealPages(bad);
        const auto tree = Require(OpenBytes(disk, std::move(bad)));
        ASSERT_EQ(tree->Verify(statistics).GetCode(), StatusCode::Corrupt) << "at " << bound;
      }
    }
  }
}

TEST(ExternalIntervalTreeCorruption, WhatVerifiesAnswersRightly)
{
  std::mt19937_64 random(17);
  MemoryDisk disk;
  int sound = 0;
  int damaged = 0;
  for (const auto& set : MakeIntervalSets())
  {
    const IntervalVector intervals = set.MakeAll(1500);
    const Bytes good = MakeTreeBytes(intervals);
    for (int turn = 0; turn < 60; ++turn)
    {
      Bytes bad = good;
      const std::size_t pages = bad.size() / PageSize;
      const std::size_t page =
        random() % 3 ? pages - 1 - random() % std::min<std::size_t>(2, pages) : random() % pages;
      const std::size_t offset = page * PageSize + random() % (PageSize - 8);
      bad[offset] ^= static_cast<std::uint8_t>(1u << random() % 8);
      ResealPages(bad);
      const auto tree = OpenBytes(disk, std::move(bad));
      PageStatistics statistics;
      if (!tree.IsOk() || !(*tree)->Verify(statistics).IsOk())
      {
        ++damaged;
        continue;
      }
      ++sound;
      // What the tree holds by now: an interval in a leaf may have become another one.
      IntervalVector held;
      ASSERT_TRUE(
        (*tree)
          ->FindOverlapping(
            0, MaximumKey, [&](const KeyInterval& one) { held.push_back(one); }, statistics)
          .IsOk());
      for (int query = 0; query < 100; ++query)
      {
        std::uint64_t found = 0;
        const ValueKey low = MakeQueryKey(intervals, random);
        const ValueKey high = query % 2 ? low : std::max(low, MakeQueryKey(intervals, random));
        std::uint64_t expected = 0;
        for (const KeyInterval& interval : held)
        {
          expected += interval.Overlaps(low, high) ? 1 : 0;
        }
        const Status status = (*tree)->FindOverlapping(
          low, high, [&](const KeyInterval&) { ++found; }, statistics);
        ASSERT_TRUE(status.IsOk()) << status.GetMessage();
        ASSERT_EQ(found, expected) << "byte " << offset;
      }
    }
  }
  EXPECT_GT(damaged, 100);
  EXPECT_GT(sound, 20) << "zeros at the ends of pages have no meaning";
}

TEST(ExternalIntervalTreeCorruption, VerifyFindsIntervalsThatNoReferenceLeadsTo)
{
  Bytes bytes = MakeTreeBytes(MakeIntervalSets()[4].MakeAll(1000));
  std::uint8_t* root = bytes.data() + bytes.size() - PageSize;
  ASSERT_EQ(std::memcmp(root, "NODE", 4), 0);
  const auto slabs = LoadLittleEndian<std::uint16_t>(root + 6);
  StoreLittleEndian(root + 8 + 8u * slabs + 36 + 6, std::uint32_t(0)); // the first child's count
  ResealPages(bytes);
  MemoryDisk disk;
  const auto tree = Require(OpenBytes(disk, bytes));
  PageStatistics statistics;
  EXPECT_EQ(tree->Verify(statistics).GetCode(), StatusCode::Corrupt);
}

TEST(ExternalIntervalTreeCorruption, AQueryReturnsTheErrorOfAFailingDisk)
{
  MemoryDisk disk;
  const auto tree = Require(OpenBytes(disk, MakeTreeBytes(MakeIntervalSets()[0].MakeAll(5000))));
  disk.FailFromRead(3);
  PageStatistics statistics;
  EXPECT_EQ(tree
              ->FindOverlapping(
                0, MaximumKey, [](const KeyInterval&) {}, statistics)
              .GetCode(),
    StatusCode::IoError);
}
