// SPDX-License-Identifier: BSD-3-Clause
// The bytes that a source of stored blocks reads ahead, against those that it reads later.
#include "Fixtures/ActiveBlocks.h"
#include "Fixtures/VolumeOnDisk.h"
#include "Storage/Store/StoredBlockSource.h"
#include "Storage/Record/BlockRecord.h"

using namespace isosurface;

namespace
{

class ReadAhead : public testing::Test
{
protected:
  void SetUp() override
  {
    WriteVolumeOk(this->Disk, MakeVolume<std::uint8_t>({ 200, 150, 130 }), MakeSettings(16, 2), 1);
    this->Opened = OpenVolume(this->Disk);
  }

  /// Acquires all active blocks; returns the requests to the disk.
  std::vector<MemoryDisk::Access> AcquireAll(double isovalue, int level)
  {
    QueryStatistics statistics;
    auto active = FindActiveBlocks(*this->Opened, { { 0, 0, { isovalue } } }, statistics, level);
    EXPECT_TRUE(active.IsOk()) << active.GetStatus().GetMessage();
    const std::size_t before = this->Disk.GetAccesses("/blocks").size();
    StoredBlockSource source(*this->Opened, 0, 0, level, std::move(*active));
    for (std::size_t block = 0; block < source.GetNumberOfBlocks(); ++block)
    {
      const auto samples = source.Acquire(block);
      EXPECT_TRUE(samples.IsOk()) << samples.GetStatus().GetMessage();
    }
    const auto accesses = this->Disk.GetAccesses("/blocks");
    return { accesses.begin() + static_cast<std::ptrdiff_t>(before), accesses.end() };
  }

  MemoryDisk Disk;
  std::shared_ptr<BlockedVolume> Opened;
};

bool Covers(const MemoryDisk::Access& outer, const MemoryDisk::Access& inner)
{
  return outer.Path == inner.Path && outer.Begin <= inner.Begin && inner.End <= outer.End;
}

} // namespace

TEST_F(ReadAhead, CoversEachReadBeforeItAndLittleElse)
{
  for (const int level : { 1, 0 })
  {
    std::vector<MemoryDisk::Access> ahead;
    std::uint64_t bytesAhead = 0;
    std::uint64_t bytesRead = 0;
    std::size_t reads = 0;
    for (const MemoryDisk::Access& access : this->AcquireAll(50, level))
    {
      if (access.IsPrefetch)
      {
        ahead.push_back(access);
        bytesAhead += access.End - access.Begin;
        continue;
      }
      ++reads;
      bytesRead += access.End - access.Begin;
      EXPECT_TRUE(std::any_of(ahead.begin(), ahead.end(),
        [&](const MemoryDisk::Access& range) { return Covers(range, access); }))
        << access.Path << " from " << access.Begin;
    }
    EXPECT_GT(reads, 20u);
    EXPECT_GE(bytesAhead, bytesRead);
    EXPECT_LE(bytesAhead, bytesRead + reads * BlockRecord::Alignment) << "only padding besides";
  }
}

TEST_F(ReadAhead, RequestsNeighboursTogether)
{
  std::size_t prefetches = 0;
  std::size_t reads = 0;
  for (const MemoryDisk::Access& access : this->AcquireAll(50, 0))
  {
    ++(access.IsPrefetch ? prefetches : reads);
  }
  EXPECT_GT(prefetches, 0u);
  EXPECT_LT(2 * prefetches, reads);
}

TEST_F(ReadAhead, SkipsBlocksInTheCache)
{
  EXPECT_FALSE(this->AcquireAll(50, 0).empty());
  EXPECT_TRUE(this->AcquireAll(50, 0).empty());
}
