// SPDX-License-Identifier: BSD-3-Clause
#include "Fixtures/ActiveBlocks.h"
#include "Storage/Store/BlockedVolume.h"

#include "Fixtures/VolumeOnDisk.h"
#include "Ground/Base/Checksum.h"
#include "Ground/Base/Coding.h"
#include "Storage/Store/BlockDirectory.h"

using namespace isosurface;

namespace
{

const std::string Folder = HidePath(VolumePath + ".stores") + "/000001";

/// Opens the volume and does all that a reader can do; the first error.
Status ReadAll(MemoryDisk& disk)
{
  ISOSURFACE_ASSIGN_OR_RETURN(
    const auto opened, BlockedVolume::Open(VolumePath, disk, std::make_shared<BlockCache>(0)));
  BlockedVolume& volume = *opened;
  QueryStatistics statistics;
  for (int level = 0; level < volume.GetNumberOfLevels(); ++level)
  {
    if (volume.GetSpectrumLevel(level) != level)
    {
      continue;
    }
    for (const double isovalue : { 1.0, 20.0, 50.0, 90.0 })
    {
      ISOSURFACE_RETURN_IF_ERROR(
        FindActiveBlocks(volume, { { 0, 0, { isovalue } } }, statistics, level).GetStatus());
    }
    ISOSURFACE_ASSIGN_OR_RETURN(const auto share, volume.ListBlocks(0, statistics, level));
    for (const BlockReference& block : share)
    {
      ISOSURFACE_RETURN_IF_ERROR(volume.ReadBlock(block, 0, 0, level, statistics).GetStatus());
    }
    ISOSURFACE_RETURN_IF_ERROR(volume.GetSpectrum(0, 0, level).GetStatus());
  }
  return Status::Ok();
}

class BlockedVolumeCorruption : public ::testing::Test
{
protected:
  void SetUp() override
  {
    WriteVolumeOk(this->Disk, MakeVolume<std::uint8_t>({ 40, 33, 20 }), MakeSettings(16, 2));
    this->Intact = this->Disk.Copy();
    ASSERT_TRUE(ReadAll(this->Disk).IsOk()) << ReadAll(this->Disk).GetMessage();
  }

  void ExpectCorrupt(const std::string& path)
  {
    const Status status = ReadAll(this->Disk);
    ASSERT_EQ(status.GetCode(), StatusCode::Corrupt) << path << ' ' << status.GetMessage();
    ExpectMessage(status, path);
    this->Disk.GetFile(path) = this->Intact.at(path);
  }

  MemoryDisk Disk;
  std::map<std::string, MemoryDisk::Bytes> Intact;
};

} // namespace

TEST_F(BlockedVolumeCorruption, WrongLengthsAreDetectedInEveryFile)
{
  for (const auto& file : this->Intact)
  {
    for (const double share : { 0.0, 0.3, 0.9 })
    {
      this->Disk.GetFile(file.first)
        .resize(static_cast<std::size_t>(share * static_cast<double>(file.second.size())));
      this->ExpectCorrupt(file.first);
    }
    this->Disk.GetFile(file.first).resize(file.second.size() - 1);
    if (file.first.find(".json") == std::string::npos && file.first != VolumePath)
    {
      this->ExpectCorrupt(file.first);
      this->Disk.GetFile(file.first).resize(file.second.size() + 4096);
      this->ExpectCorrupt(file.first);
    }
    this->Disk.GetFile(file.first) = file.second;
  }
}

TEST_F(BlockedVolumeCorruption, FlippedBitsAreDetectedWhereTheyAreRead)
{
  for (const auto& file : this->Intact)
  {
    const std::size_t step = file.second.size() / 150 + 1;
    std::size_t found = 0;
    for (std::size_t position = 0; position < file.second.size(); position += step)
    {
      this->Disk.GetFile(file.first)[position] ^= 1;
      const Status status = ReadAll(this->Disk);
      found += !status.IsOk();
      EXPECT_TRUE(status.IsOk() || status.GetCode() == StatusCode::Corrupt ||
        status.GetCode() == StatusCode::Unsupported || status.GetCode() == StatusCode::NotFound)
        << status.GetMessage();
      EXPECT_TRUE(status.IsOk() || status.GetMessage().find("volume.bvol") != std::string::npos)
        << status.GetMessage();
      this->Disk.GetFile(file.first)[position] = file.second[position];
    }
    // The padding between records, and tree pages that no query visits, are not read.
    EXPECT_GT(found, 0u) << file.first;
  }
}

TEST_F(BlockedVolumeCorruption, EveryDamagedByteOfABlockIsDetected)
{
  const std::string path = Folder + "/store-00000/blocks";
  const auto opened = OpenVolume(this->Disk, 0);
  QueryStatistics statistics;
  const auto share = Require(opened->ListBlocks(0, statistics));
  QueryStatistics one;
  ASSERT_TRUE(opened->ReadBlock(share[0], 0, 0, 0, one).IsOk());
  for (std::size_t position = 0; position < one.BytesRead; position += 3)
  {
    this->Disk.GetFile(path)[position] ^= 128;
    const auto block = opened->ReadBlock(share[0], 0, 0, 0, statistics);
    ExpectError(block.GetStatus(), StatusCode::Corrupt, path + ": block ");
    this->Disk.GetFile(path)[position] = this->Intact.at(path)[position];
  }
  // A whole record in the place of another one is found, too.
  MemoryDisk::Bytes& bytes = this->Disk.GetFile(path);
  ASSERT_GE(share.size(), 2u);
  ASSERT_EQ(share[1].Ordinal, 1u);
  const std::size_t record = (one.BytesRead + 4095) / 4096 * 4096;
  std::copy_n(bytes.begin() + static_cast<std::ptrdiff_t>(record), record, bytes.begin());
  EXPECT_FALSE(opened->ReadBlock(share[0], 0, 0, 0, statistics).IsOk());
}

TEST_F(BlockedVolumeCorruption, ExchangedFilesAreDetected)
{
  for (const char* name : { "/blocks", "/directory", "/array-0.tree", "" })
  {
    for (const auto& file : this->Intact)
    {
      if (file.first.find(Folder + "/store-00000") != std::string::npos &&
        (*name == 0 || file.first.find(name) != std::string::npos))
      {
        std::string other = file.first;
        other.replace(other.find("store-00000"), 11, "store-00001");
        this->Disk.GetFile(file.first) = this->Intact.at(other);
      }
    }
    const Status status = ReadAll(this->Disk);
    // A tree of another store with as many blocks is consistent in itself.
    if (std::string(name) != "/array-0.tree")
    {
      EXPECT_EQ(status.GetCode(), StatusCode::Corrupt) << name << status.GetMessage();
    }
    for (const auto& file : this->Intact)
    {
      this->Disk.GetFile(file.first) = file.second;
    }
  }
}

TEST_F(BlockedVolumeCorruption, AMissingStoreIsNamed)
{
  ASSERT_TRUE(this->Disk.RemoveAll(Folder + "/store-00001").IsOk());
  const Status status = ReadAll(this->Disk);
  ExpectError(status, StatusCode::NotFound, Folder + "/store-00001: this store");
  // The other store's rank goes on.
  const auto opened = OpenVolume(this->Disk);
  QueryStatistics statistics;
  EXPECT_TRUE(FindActiveBlocks(*opened, { { 0, 0, { 50 } }, 0, 2 }, statistics).IsOk());
}

TEST_F(BlockedVolumeCorruption, DamagedOverviewsLeaveTheFinerLevelsReadable)
{
  const std::string overview = Folder + "/overview-1";
  ASSERT_TRUE(this->Disk.RemoveAll(overview + "/store-00000").IsOk());
  const Status status = ReadAll(this->Disk);
  ExpectError(status, StatusCode::NotFound, overview + "/store-00000: this store");
  const auto opened = OpenVolume(this->Disk);
  QueryStatistics statistics;
  EXPECT_TRUE(opened->ListBlocks(0, statistics, 1).IsOk());
  EXPECT_FALSE(opened->ListBlocks(0, statistics, 2).IsOk());
  EXPECT_TRUE(opened->GetSpectrum(0, 0, 1).IsOk());
  ASSERT_TRUE(this->Disk.RemoveAll(overview).IsOk());
  EXPECT_FALSE(opened->GetSpectrum(0, 0, 2).IsOk());
  EXPECT_TRUE(opened->ListBlocks(0, statistics).IsOk());
}

TEST_F(BlockedVolumeCorruption, ExchangedOverviewsAreDetected)
{
  // The volume's own store has as many files, of another grid.
  for (const char* name : { "/blocks", "/directory", "/array-0.tree" })
  {
    const std::string path = Folder + "/overview-1/store-00000" + name;
    this->Disk.GetFile(path) = this->Intact.at(Folder + "/store-00000" + name);
    this->ExpectCorrupt(path);
  }
}

TEST_F(BlockedVolumeCorruption, ALengthThatNoMemoryHasIsAnError)
{
  this->Disk.SetBeforeRead([] { std::vector<std::uint64_t>().reserve(~std::size_t{ 0 }); });
  const Status status = ReadAll(this->Disk);
  EXPECT_EQ(status.GetCode(), StatusCode::OutOfMemory);
  EXPECT_EQ(status.GetMessage(), VolumePath + ": there is not enough memory to read it");
}

TEST(BlockDirectoryCorruption, WrongNumbersOfEntriesAreDetected)
{
  constexpr std::size_t pageSize = 4096, countOffset = 32;
  MemoryDisk disk;
  ASSERT_TRUE(BlockDirectory::Write(disk, "/data/directory", 5, 77, {}).IsOk());
  EXPECT_TRUE(BlockDirectory::Open(disk, "/data/directory", 0, 5, 77, 0).IsOk());
  std::uint8_t* page = disk.GetFile("/data/directory").data();
  // So many that a sum of them and anything begins at 0 again.
  for (const std::uint64_t below : { 0, 1, 50, 112, 113 })
  {
    const std::uint64_t count = MemoryDisk::Never - below;
    StoreLittleEndian(page + countOffset, count);
    StoreLittleEndian(page + pageSize - 8, ComputeChecksum(page, pageSize - 8, 0));
    EXPECT_EQ(BlockDirectory::Open(disk, "/data/directory", count, 5, 77, 0).GetStatus().GetCode(),
      StatusCode::Corrupt)
      << below;
  }
}
