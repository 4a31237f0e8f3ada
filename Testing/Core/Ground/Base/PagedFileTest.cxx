// SPDX-License-Identifier: BSD-3-Clause
#include "Ground/Base/PagedFile.h"

#include "Fixtures/MemoryDisk.h"
#include "Fixtures/Require.h"
#include "Fixtures/ResealedPages.h"

#include <gtest/gtest.h>

#include <atomic>
#include <random>
#include <thread>

using namespace isosurface;

namespace
{

constexpr PagedFile::Kind TestKind = { 'A', ' ', 'T', 'E', 'S', 'T', ' ', ' ' };

/// Page p holds bytes p, p + 1, ...; odd pages are written after all even ones.
void WritePages(MemoryDisk& disk, std::uint32_t pageSize, std::uint32_t count)
{
  auto writer = Require(PagedFileWriter::Create(disk, "pages", pageSize, TestKind));
  for (std::uint32_t page = 1; page <= count; ++page)
  {
    const auto number = Require(writer->AllocatePage());
    ASSERT_EQ(number, page);
  }
  std::vector<std::uint8_t> payload(writer->GetPayloadSize());
  for (const std::uint32_t odd : { 0u, 1u })
  {
    for (std::uint32_t page = 1; page <= count; ++page)
    {
      for (std::size_t index = 0; index < payload.size(); ++index)
      {
        payload[index] = static_cast<std::uint8_t>(page + index);
      }
      if (page % 2 == odd)
      {
        ASSERT_TRUE(writer->WritePage(page, payload.data()).IsOk());
      }
    }
  }
  PagedFile::ClientArea area = {};
  area.front() = 17;
  area.back() = 71;
  ASSERT_TRUE(writer->Finish(area).IsOk());
}

Result<std::unique_ptr<PagedFileReader>> OpenPages(MemoryDisk& disk, std::size_t cacheBytes)
{
  return PagedFileReader::Open(std::move(*disk.OpenForReading("pages")), TestKind, cacheBytes);
}

} // namespace

TEST(PagedFile, ReadsWhatWasWrittenForEveryPageSize)
{
  for (const std::uint32_t pageSize : { 4096u, 8192u, 16384u })
  {
    MemoryDisk disk;
    WritePages(disk, pageSize, 100);
    auto reader = Require(OpenPages(disk, 0));
    EXPECT_EQ(reader->GetPageSize(), pageSize);
    EXPECT_EQ(reader->GetPageCount(), 101u);
    EXPECT_EQ(disk.GetFile("pages").size(), 101u * pageSize);
    EXPECT_EQ(reader->GetClientArea().front(), 17);
    EXPECT_EQ(reader->GetClientArea().back(), 71);
    PageStatistics statistics;
    for (std::uint32_t page = 1; page <= 100; ++page)
    {
      const auto bytes = Require(reader->ReadPage(page, statistics));
      for (std::size_t index = 0; index < reader->GetPayloadSize(); ++index)
      {
        ASSERT_EQ((*bytes)[index], static_cast<std::uint8_t>(page + index));
      }
    }
    EXPECT_EQ(statistics.PageReads, 100u);
    EXPECT_EQ(reader->ReadPage(101, statistics).GetStatus().GetCode(), StatusCode::Corrupt);
  }
}

TEST(PagedFile, TheCacheEvictsTheLeastRecentlyUsedPage)
{
  MemoryDisk disk;
  WritePages(disk, 4096, 10);
  auto reader = OpenPages(disk, 2 * 4096 + 1000); // two pages with their overhead
  ASSERT_TRUE(reader.IsOk());
  PageStatistics statistics;
  const auto read = [&](std::uint64_t page)
  { EXPECT_TRUE((*reader)->ReadPage(page, statistics).IsOk()); };
  read(1);
  read(2);
  read(1); // hit
  read(3); // evicts 2
  read(1); // hit
  read(2); // evicts 3
  EXPECT_EQ(statistics.PageReads, 4u);
  EXPECT_EQ(statistics.CacheHits, 2u);
}

TEST(PagedFile, APageInTheWrongPlaceIsCorrupt)
{
  MemoryDisk disk;
  WritePages(disk, 4096, 10);
  auto& bytes = disk.GetFile("pages");
  std::copy_n(bytes.begin() + 3 * 4096, 4096, bytes.begin() + 4 * 4096);
  auto reader = Require(OpenPages(disk, 0));
  PageStatistics statistics;
  EXPECT_TRUE(reader->ReadPage(3, statistics).IsOk());
  const auto page = reader->ReadPage(4, statistics);
  ASSERT_FALSE(page.IsOk());
  EXPECT_EQ(page.GetStatus().GetMessage(), "pages: page 4: wrong checksum");
}

// 474 sums fit page 0: one page a group; two, the last group of one; eight.
TEST(PagedFile, AResealedPageIsFoundWhereItIsRead)
{
  for (const std::uint32_t count : { 1u, 474u, 475u, 948u, 2000u })
  {
    MemoryDisk disk;
    WritePages(disk, 4096, count);
    const auto good = disk.GetFile("pages");
    const std::uint32_t group = count <= 474 ? 1 : count <= 948 ? 2 : 8;
    ASSERT_EQ(LoadLittleEndian<std::uint64_t>(good.data() + 288), group);
    for (const std::uint32_t forged : { 1u, count / 2 + 1, count })
    {
      disk.SetFile("pages", good);
      auto& bytes = disk.GetFile("pages");
      bytes[std::size_t{ forged } * 4096 + 100] ^= 1;
      ResealPage(bytes, forged);
      auto reader = Require(OpenPages(disk, 0));
      PageStatistics statistics;
      for (std::uint32_t page = 1; page <= count; ++page)
      {
        const auto read = reader->ReadPage(page, statistics);
        ASSERT_EQ(read.IsOk(), (page - 1) / group != (forged - 1) / group)
          << page << " of " << count << ", " << forged << " is forged";
        if (!read.IsOk())
        {
          ExpectError(read.GetStatus(), StatusCode::Corrupt,
            "pages: page " + std::to_string(page) + ": th"); // this is, or the pages are
        }
      }
    }
  }
}

TEST(PagedFile, TheSealStandsForEveryByte)
{
  for (const std::uint32_t count : { 0u, 3u, 1000u })
  {
    MemoryDisk disk;
    WritePages(disk, 4096, count);
    auto& bytes = disk.GetFile("pages");
    const auto good = bytes;
    const auto seal = LoadLittleEndian<std::uint64_t>(good.data() + 4096 - 8);
    EXPECT_TRUE(Require(OpenPages(disk, 0))->CheckSeal(seal).IsOk());
    for (std::size_t at = 32; at < bytes.size(); at += bytes.size() / 50 + 1)
    {
      bytes[at] ^= 1;
      ResealPages(bytes);
      const auto reader = OpenPages(disk, 0);
      EXPECT_TRUE(!reader.IsOk() || bytes == good || !(*reader)->CheckSeal(seal).IsOk()) << at;
      bytes = good;
    }
    RemoveSums(bytes);
    const auto unsealed = Require(OpenPages(disk, 0));
    ExpectError(unsealed->CheckSeal(LoadLittleEndian<std::uint64_t>(bytes.data() + 4096 - 8)),
      StatusCode::Corrupt, "pages: page 0: this is not the file that was written");
  }
}

TEST(PagedFile, GroupsThatPage0CannotHaveAreCorrupt)
{
  MemoryDisk disk;
  WritePages(disk, 4096, 1000);
  for (const std::uint64_t group : { std::uint64_t{ 1 }, std::uint64_t{ 2 }, std::uint64_t{ 3 },
         std::uint64_t{ 8 }, std::uint64_t{ 1 } << 63 })
  {
    auto& bytes = disk.GetFile("pages");
    StoreLittleEndian(bytes.data() + 288, group);
    ResealPage(bytes, 0);
    ExpectError(OpenPages(disk, 0).GetStatus(), StatusCode::Corrupt, "cannot be in groups of");
  }
}

TEST(PagedFile, ThreadsShareOneCache)
{
  MemoryDisk disk;
  WritePages(disk, 4096, 500); // in groups of two
  auto reader = Require(OpenPages(disk, 200 * 4400));
  std::atomic<int> faults(0);
  std::vector<std::thread> threads;
  for (unsigned seed = 0; seed < 4; ++seed)
  {
    threads.emplace_back(
      [&, seed]
      {
        std::mt19937 random(seed);
        PageStatistics statistics;
        for (int index = 0; index < 2000; ++index)
        {
          const std::uint32_t number = 1 + random() % 500;
          const auto page = reader->ReadPage(number, statistics);
          faults += !page.IsOk() || (**page)[0] != static_cast<std::uint8_t>(number);
        }
        faults += statistics.PageReads + statistics.CacheHits != 2000;
      });
  }
  for (std::thread& thread : threads)
  {
    thread.join();
  }
  EXPECT_EQ(faults, 0);
}
