// SPDX-License-Identifier: BSD-3-Clause
#include "Ground/Base/PagedFile.h"

#include "Fixtures/MemoryDisk.h"
#include "Fixtures/Require.h"

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

TEST(PagedFile, ThreadsShareOneCache)
{
  MemoryDisk disk;
  WritePages(disk, 4096, 50);
  auto reader = Require(OpenPages(disk, 20 * 4400));
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
          const std::uint32_t number = 1 + random() % 50;
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
