// SPDX-License-Identifier: BSD-3-Clause
#include "Fixtures/VolumeOnDisk.h"

#include "Storage/Verification/VolumeRepair.h"
#include "Storage/Verification/VolumeVerification.h"

using namespace isosurface;

namespace
{

const std::string Folder = HidePath(VolumePath + ".stores") + "/000001/";

const SampleVolume<std::uint8_t>& GetSamples()
{
  static const auto samples = MakeVolume<std::uint8_t>({ 60, 44, 38 });
  return samples;
}

void WriteReplicated(
  MemoryDisk& disk, std::uint32_t replicas, SegmentCodec codec = SegmentCodec::None)
{
  BlockedVolumeSettings settings = MakeSettings(16, 4);
  settings.NumberOfReplicas = replicas;
  settings.Compression.Codec = codec;
  WriteVolumeOk(disk, GetSamples(), settings);
}

VolumeVerification Verify(MemoryDisk& disk)
{
  const auto found = VerifyBlockedVolume(VolumePath, disk, 2);
  EXPECT_TRUE(found.IsOk()) << found.GetStatus().GetMessage();
  return *found;
}

VolumeRepair Repair(MemoryDisk& disk)
{
  const auto done = RepairBlockedVolume(VolumePath, disk, 2);
  EXPECT_TRUE(done.IsOk()) << done.GetStatus().GetMessage();
  return done.IsOk() ? *done : VolumeRepair();
}

void Remove(MemoryDisk& disk, const std::string& name)
{
  ASSERT_TRUE(disk.RemoveAll(Folder + name).IsOk());
}

void Flip(MemoryDisk& disk, const std::string& name, std::size_t at)
{
  disk.GetFile(Folder + name).at(at) ^= 0x40;
}

using Damage = std::function<void(MemoryDisk&)>;

// What two replicas can make good.
const std::vector<std::pair<const char*, Damage>>& GetDamages()
{
  static const std::vector<std::pair<const char*, Damage>> damages = {
    { "a lost store", [](MemoryDisk& disk) { Remove(disk, "store-00001"); } },
    { "a lost store of an overview",
      [](MemoryDisk& disk) { Remove(disk, "overview-1/store-00001"); } },
    { "a lost replica", [](MemoryDisk& disk) { Remove(disk, "store-00001/replica-1"); } },
    { "a lost tree", [](MemoryDisk& disk) { Remove(disk, "store-00001/array-0.tree"); } },
    { "a truncated store",
      [](MemoryDisk& disk) { disk.GetFile(Folder + "store-00002/blocks").resize(5000); } },
    { "an empty store",
      [](MemoryDisk& disk) { disk.GetFile(Folder + "store-00002/blocks").clear(); } },
    { "a flipped bit of a block",
      [](MemoryDisk& disk) { Flip(disk, "store-00000/blocks", 9000); } },
    { "a flipped bit of padding",
      [](MemoryDisk& disk)
      {
        MemoryDisk::Bytes& blocks = disk.GetFile(Folder + "store-00000/blocks");
        blocks.back() ^= 1;
      } },
    { "a flipped bit of a directory",
      [](MemoryDisk& disk) { Flip(disk, "store-00003/directory", 4100); } },
    { "different blocks of both replicas",
      [](MemoryDisk& disk)
      {
        Flip(disk, "store-00000/blocks", 9000);
        MemoryDisk::Bytes& other = disk.GetFile(Folder + "store-00001/replica-1/blocks");
        other[other.size() - 4000] ^= 1;
      } },
    { "different pages of both replicas",
      [](MemoryDisk& disk)
      {
        Flip(disk, "store-00000/directory", 10);
        Flip(disk, "store-00001/replica-1/directory", 4100);
        Flip(disk, "store-00000/array-0.tree", 10);
      } },
    { "a lost directory here, a truncated store there",
      [](MemoryDisk& disk)
      {
        Remove(disk, "store-00000/directory");
        disk.GetFile(Folder + "store-00001/replica-1/blocks").resize(20000);
      } },
  };
  return damages;
}

} // namespace

TEST(VolumeRepair, RestoresEveryByteOfWhatTwoReplicasHaveTogether)
{
  for (const SegmentCodec codec : { SegmentCodec::None, SegmentCodec::Zstd })
  {
    for (const auto& [name, damage] : GetDamages())
    {
      MemoryDisk disk;
      WriteReplicated(disk, 2, codec);
      const auto files = disk.Copy();
      damage(disk);
      const VolumeVerification before = Verify(disk);
      EXPECT_GT(before.FaultCount, 0u) << name;
      ASSERT_FALSE(before.Repairs.empty()) << name;
      for (const std::string& repair : before.Repairs)
      {
        EXPECT_NE(repair.find("--repair can restore it"), std::string::npos) << repair;
      }
      const VolumeRepair done = Repair(disk);
      EXPECT_FALSE(done.Restored.empty()) << name;
      EXPECT_TRUE(done.Refused.empty()) << name;
      EXPECT_TRUE(disk.Copy() == files) << name;
      EXPECT_EQ(Verify(disk).FaultCount, 0u) << name;
    }
  }
}

TEST(VolumeRepair, LeavesASoundVolumeAlone)
{
  MemoryDisk disk;
  WriteReplicated(disk, 3);
  const auto files = disk.Copy();
  EXPECT_EQ(Verify(disk).FaultCount, 0u);
  EXPECT_TRUE(Repair(disk).Restored.empty());
  EXPECT_TRUE(disk.Copy() == files);
}

TEST(VolumeRepair, RefusesBlocksThatNoReplicaHasAndRestoresTheRest)
{
  MemoryDisk disk;
  WriteReplicated(disk, 2);
  const auto files = disk.Copy();
  for (const char* name : { "store-00000/blocks", "store-00001/replica-1/blocks" })
  {
    Flip(disk, name, 100);
  }
  Remove(disk, "store-00003/array-0.tree");
  const VolumeVerification found = Verify(disk);
  ASSERT_EQ(found.Repairs.size(), 3u);
  EXPECT_NE(found.Repairs[0].find("cannot restore all of it"), std::string::npos);
  EXPECT_NE(found.Repairs[2].find("can restore it"), std::string::npos);
  const VolumeRepair done = Repair(disk);
  ASSERT_EQ(done.Refused.size(), 1u);
  ExpectMessage(done.Refused[0], "no replica has block ");
  EXPECT_EQ(done.Restored, std::vector<std::string>{ Folder + "store-00003" });
  EXPECT_TRUE(disk.GetFile(Folder + "store-00003/array-0.tree") ==
    files.at(Folder + "store-00003/array-0.tree"));
}

TEST(VolumeRepair, RefusesAStoreThatIsLostWithItsReplicas)
{
  MemoryDisk disk;
  WriteReplicated(disk, 2);
  Remove(disk, "store-00001");
  Remove(disk, "store-00002");
  const VolumeRepair done = Repair(disk);
  ASSERT_EQ(done.Refused.size(), 1u);
  ExpectMessage(done.Refused[0], "store-00001");
  // What the two had besides is there again.
  EXPECT_TRUE(disk.Exists(Folder + "store-00001/replica-1/blocks"));
  EXPECT_TRUE(disk.Exists(Folder + "store-00002/blocks"));
}

TEST(VolumeRepair, NeedsReplicas)
{
  MemoryDisk disk;
  WriteReplicated(disk, 1);
  const auto done = RepairBlockedVolume(VolumePath, disk, 1);
  ExpectMessage(done.GetStatus(), "without replicas");
}

TEST(VolumeRepair, GoesOnAfterItWasKilledAtAnyTime)
{
  MemoryDisk sound;
  WriteReplicated(sound, 2);
  const auto files = sound.Copy();
  std::uint64_t failures = 0;
  for (std::uint64_t write = 0;; ++write)
  {
    MemoryDisk disk;
    WriteReplicated(disk, 2);
    Remove(disk, "store-00001");
    Flip(disk, "store-00003/blocks", 5000);
    disk.FailFromWrite(write);
    const auto first = RepairBlockedVolume(VolumePath, disk, 1);
    disk.FailFromWrite(MemoryDisk::Never);
    if (first.IsOk())
    {
      break;
    }
    ++failures;
    // Whatever was there is there, and a query finds it.
    for (const auto& [path, bytes] : files)
    {
      const bool isDamaged =
        path.find("store-00001") != std::string::npos || path == Folder + "store-00003/blocks";
      ASSERT_TRUE(isDamaged || (disk.Exists(path) && disk.GetFile(path) == bytes)) << path;
    }
    Repair(disk);
    ASSERT_TRUE(disk.Copy() == files) << write;
  }
  EXPECT_GT(failures, 20u);
}

TEST(VolumeRepair, RestoresTheStoresOfAllTimeSteps)
{
  MemoryDisk disk;
  BlockedVolumeSettings settings = MakeSettings(16, 3);
  settings.NumberOfReplicas = 2;
  settings.Append = true;
  for (const double time : { 1.0, 2.0 })
  {
    settings.Time = time;
    WriteVolumeOk(disk, GetSamples(), settings);
  }
  const auto files = disk.Copy();
  for (const char* step : { "000001", "000002" })
  {
    ASSERT_TRUE(
      disk.RemoveAll(HidePath(VolumePath + ".stores") + "/" + step + "/store-00002").IsOk());
  }
  EXPECT_EQ(Repair(disk).Restored.size(), 4u);
  EXPECT_TRUE(disk.Copy() == files);
}
