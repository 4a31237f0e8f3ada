// SPDX-License-Identifier: BSD-3-Clause
// A store that is lost or damaged costs nothing but speed, if other stores have its blocks.
#include "Fixtures/LocalDisk.h"
#include "Fixtures/LongTests.h"
#include "Fixtures/PlainContour.h"
#include "Fixtures/VolumeOnDisk.h"

#include "Ranks/Query/LevelExtraction.h"
#include "Ranks/Sharing/StoreRecovery.h"

#include <algorithm>
#include <map>

using namespace isosurface;

namespace
{

constexpr double ReplicatedIsovalue = 30;
constexpr std::uint32_t Stores = 5;
const Index3 Size = { 60, 44, 38 };
const std::string Folder = HidePath(VolumePath + ".stores") + "/000001";

const SampleVolume<std::int16_t>& GetSamples()
{
  static const auto samples = MakeVolume<std::int16_t>(Size);
  return samples;
}

BlockedVolumeSettings MakeReplicated(std::uint32_t replicas, std::uint32_t stores = Stores)
{
  BlockedVolumeSettings settings = MakeSettings(16, stores);
  settings.NumberOfReplicas = replicas;
  return settings;
}

std::string StorePath(std::uint32_t store)
{
  MemoryDisk empty;
  return GetStoreFolder(empty, VolumePath, "000001", store);
}

// Flips a byte of the first record of a replica, or of all pages.
void FlipBytes(MemoryDisk& disk, const std::string& folder, std::size_t step = 0)
{
  MemoryDisk::Bytes& blocks = disk.GetFile(folder + "/blocks");
  for (std::size_t at = 100; at < blocks.size(); at += step)
  {
    blocks[at] ^= 1;
    if (step == 0)
    {
      break;
    }
  }
}

// The ranks of a run, each with the volume open, for several queries.
class RankGroup
{
public:
  struct Answer
  {
    PlainSurface Surface;
    std::vector<Status> Statuses;
    std::vector<std::string> Warnings;
    std::vector<std::uint64_t> Triangles;
  };

  // `isLocal`: each rank reaches the stores of its own alone.
  RankGroup(MemoryDisk& disk, int ranks, bool isDealt, bool isLocal, std::uint32_t stores = Stores)
    : Ranks(ranks)
  {
    for (int rank = 0; rank < ranks; ++rank)
    {
      this->Disks.push_back(std::make_unique<LocalDisk>(disk,
        [=](const std::string& path)
        {
          const std::size_t store = path.find("/store-");
          const auto number = store == std::string::npos ? 0 : std::stoi(path.substr(store + 7, 5));
          const int all = static_cast<int>(stores);
          const bool isMine = number % ranks == rank || (rank >= all && rank % all == number);
          return !isLocal || store == std::string::npos || isMine;
        }));
      this->Volumes.push_back(OpenVolume(*this->Disks.back()));
      this->Volumes.back()->SetLocalStores(!isDealt);
    }
  }

  Answer Query(double isovalue = ReplicatedIsovalue, int level = 0)
  {
    const auto size = static_cast<std::size_t>(this->Ranks);
    std::vector<PlainSurface> parts(size);
    Answer answer;
    answer.Statuses.resize(size);
    answer.Warnings.resize(size);
    answer.Triangles.resize(size);
    ThreadCommunicator::Run(this->Ranks,
      [&](Communicator& ranks)
      {
        const auto rank = static_cast<std::size_t>(ranks.GetRank());
        const auto& volume = this->Volumes[rank];
        SurfaceQuery query{ { 0, 0, { isovalue } }, ranks.GetRank(), ranks.GetSize() };
        ContourRequest request = MakePlainRequest(query.Isovalues);
        ExtractionOutcome outcome;
        answer.Statuses[rank] = RunWithReplicas(
          ranks, [&volume] { return volume.get(); }, answer.Warnings[rank],
          [&] {
            return ExtractLevel({ volume, query, request, 2, {} }, level, outcome);
          });
        answer.Triangles[rank] = outcome.Extracted.NumberOfTriangles;
        parts[rank] = MakePlain(outcome.Extracted);
      });
    answer.Surface = UniteRanks(parts);
    return answer;
  }

private:
  int Ranks;
  std::vector<std::unique_ptr<LocalDisk>> Disks;
  std::vector<std::shared_ptr<BlockedVolume>> Volumes;
};

// The surface of the volume without replicas.
const PlainSurface& GetExpected(double isovalue = ReplicatedIsovalue)
{
  static std::map<double, PlainSurface> known;
  if (known.count(isovalue) == 0)
  {
    MemoryDisk disk;
    WriteVolumeOk(disk, GetSamples(), MakeSettings(16, Stores));
    known[isovalue] = RankGroup(disk, 1, false, false).Query(isovalue).Surface;
  }
  return known[isovalue];
}

// All is well, and all ranks have been told the same.
void ExpectWhole(const RankGroup::Answer& answer, const std::string& warning)
{
  for (std::size_t rank = 0; rank < answer.Statuses.size(); ++rank)
  {
    EXPECT_TRUE(answer.Statuses[rank].IsOk()) << answer.Statuses[rank].GetMessage();
    EXPECT_EQ(answer.Warnings[rank], answer.Warnings[0]);
  }
  EXPECT_EQ(answer.Warnings[0].empty(), warning.empty());
  EXPECT_NE(answer.Warnings[0].find(warning), std::string::npos) << answer.Warnings[0];
  EXPECT_FALSE(answer.Surface.Triangles.empty());
}

struct Ways
{
  int Ranks;
  bool IsDealt;
  bool IsLocal;
};

// Ranks that share blocks, ranks that share stores that all reach, ranks that reach those of their
// own alone.
const std::vector<Ways>& GetWays()
{
  static const std::vector<Ways> ways = []
  {
    std::vector<Ways> all;
    for (const int ranks : GetNumbersOfRanks())
    {
      all.push_back({ ranks, true, false });
      if (ranks > 1) // one reads all in any way
      {
        all.insert(all.end(), { { ranks, false, false }, { ranks, false, true } });
      }
    }
    return all;
  }();
  return ways;
}

std::ostream& operator<<(std::ostream& out, const Ways& way)
{
  return out << way.Ranks << " ranks, dealt " << way.IsDealt << ", local " << way.IsLocal;
}

void ExpectWholeInAllWays(
  MemoryDisk& disk, const std::string& warning, double isovalue = ReplicatedIsovalue)
{
  for (const Ways& way : GetWays())
  {
    const auto answer = RankGroup(disk, way.Ranks, way.IsDealt, way.IsLocal).Query(isovalue);
    ExpectWhole(answer, warning);
    EXPECT_TRUE(answer.Surface == GetExpected(isovalue)) << way;
  }
}

} // namespace

TEST(Replicas, OneReplicaGivesTheBytesOfAVolumeWithout)
{
  MemoryDisk without;
  MemoryDisk with;
  WriteVolumeOk(without, GetSamples(), MakeSettings(16, Stores));
  WriteVolumeOk(with, GetSamples(), MakeReplicated(1));
  EXPECT_TRUE(without.Copy() == with.Copy());
}

TEST(Replicas, AReplicaHasTheBytesOfItsStoreInTheNextFolders)
{
  MemoryDisk without;
  WriteVolumeOk(without, GetSamples(), MakeSettings(16, Stores));
  for (const int ranks : { 1, 3 })
  {
    MemoryDisk disk;
    WriteVolumeOk(disk, GetSamples(), MakeReplicated(3), ranks);
    const auto files = disk.Copy();
    std::size_t replicas = 0;
    for (const auto& [path, bytes] : without.Copy())
    {
      const std::size_t store = path.find("/000001/store-");
      if (store == std::string::npos)
      {
        continue;
      }
      EXPECT_TRUE(files.at(path) == bytes) << path;
      const int number = std::stoi(path.substr(store + 14, 5));
      for (const int replica : { 1, 2 })
      {
        char folder[64];
        std::snprintf(folder, sizeof(folder), "/000001/store-%05d/replica-%d",
          (number + replica) % static_cast<int>(Stores), replica);
        const std::string copy = path.substr(0, store) + folder + path.substr(path.rfind('/'));
        EXPECT_TRUE(files.at(copy) == bytes) << copy;
        ++replicas;
      }
    }
    EXPECT_EQ(replicas, 2 * 3 * Stores);
  }
}

TEST(Replicas, TheSurfaceIsTheSameOnAnyRanksWhetherStoresAreLocalOrNot)
{
  MemoryDisk disk;
  WriteVolumeOk(disk, GetSamples(), MakeReplicated(2));
  ExpectWholeInAllWays(disk, "");
}

TEST(Replicas, AStoreThatIsLostBetweenTwoQueriesIsReadElsewhereWithOneWarning)
{
  for (const Ways& way : GetWays())
  {
    MemoryDisk disk;
    WriteVolumeOk(disk, GetSamples(), MakeReplicated(2));
    RankGroup group(disk, way.Ranks, way.IsDealt, way.IsLocal);
    ExpectWhole(group.Query(ReplicatedIsovalue + 3), "");
    // Those that are open stay readable, as on Linux: new ranks have none open.
    ASSERT_TRUE(disk.RemoveAll(StorePath(2)).IsOk());
    RankGroup later(disk, way.Ranks, way.IsDealt, way.IsLocal);
    const auto open = group.Query();
    ExpectWhole(open, "");
    EXPECT_TRUE(open.Surface == GetExpected()) << way;
    const auto first = later.Query();
    ExpectWhole(first, "store 2:");
    EXPECT_NE(first.Warnings[0].find("--repair"), std::string::npos);
    EXPECT_TRUE(first.Surface == GetExpected()) << way;
    const auto second = later.Query(ReplicatedIsovalue + 3);
    ExpectWhole(second, "");
    EXPECT_TRUE(second.Surface == GetExpected(ReplicatedIsovalue + 3)) << way;
  }
}

TEST(Replicas, DamagedAndTruncatedStoresAreReadElsewhere)
{
  const std::vector<std::function<void(MemoryDisk&)>> damages = {
    [](MemoryDisk& disk) { FlipBytes(disk, StorePath(1), 4096); },
    [](MemoryDisk& disk) { disk.GetFile(StorePath(1) + "/blocks").resize(8192); },
    [](MemoryDisk& disk) { disk.GetFile(StorePath(1) + "/directory")[5000] ^= 1; },
    [](MemoryDisk& disk) { disk.GetFile(StorePath(1) + "/array-0.tree")[5000] ^= 1; },
    [](MemoryDisk& disk) { EXPECT_TRUE(disk.RemoveAll(StorePath(1) + "/array-0.tree").IsOk()); },
    [](MemoryDisk& disk) { EXPECT_TRUE(disk.RemoveAll(StorePath(1) + "/blocks").IsOk()); },
  };
  for (std::size_t damage = 0; damage < damages.size(); ++damage)
  {
    MemoryDisk disk;
    WriteVolumeOk(disk, GetSamples(), MakeReplicated(2));
    damages[damage](disk);
    for (const Ways& way : GetWays())
    {
      RankGroup group(disk, way.Ranks, way.IsDealt, way.IsLocal);
      const auto answer = group.Query();
      ExpectWhole(answer, "store 1:");
      EXPECT_TRUE(answer.Surface == GetExpected()) << damage << ", " << way;
      ExpectWhole(group.Query(), "");
    }
  }
}

TEST(Replicas, ReplicasThatMissDifferentBlocksGiveTheWholeSurface)
{
  MemoryDisk disk;
  WriteVolumeOk(disk, GetSamples(), MakeReplicated(2));
  FlipBytes(disk, StorePath(1));
  MemoryDisk::Bytes& other = disk.GetFile(StorePath(2) + "/replica-1/blocks");
  other[other.size() - 4000] ^= 1;
  ExpectWholeInAllWays(disk, "store 1", 50);
}

TEST(Replicas, DamagedSpectraCostBalanceAlone)
{
  MemoryDisk disk;
  WriteVolumeOk(disk, GetSamples(), MakeReplicated(2));
  disk.GetFile(Folder + "/spectra")[200] ^= 1;
  ExpectWholeInAllWays(disk, "");
}

TEST(Replicas, ABlockThatAllReplicasHaveLostIsOneErrorOnAllRanks)
{
  MemoryDisk disk;
  WriteVolumeOk(disk, GetSamples(), MakeReplicated(2));
  FlipBytes(disk, StorePath(1), 4096);
  FlipBytes(disk, StorePath(2) + "/replica-1", 4096);
  for (const Ways& way : GetWays())
  {
    const auto answer = RankGroup(disk, way.Ranks, way.IsDealt, way.IsLocal).Query();
    std::string named;
    for (const Status& status : answer.Statuses)
    {
      ASSERT_FALSE(status.IsOk()) << way;
      named += status.GetMessage();
    }
    EXPECT_NE(named.find("blocks: block"), std::string::npos) << named;
  }
}

TEST(Replicas, CoarseLevelsSurviveTheLossOfAStoreOfAnOverview)
{
  MemoryDisk disk;
  WriteVolumeOk(disk, GetSamples(), MakeReplicated(2));
  const auto expected = RankGroup(disk, 2, true, false).Query(ReplicatedIsovalue, 2);
  ASSERT_TRUE(disk.RemoveAll(Folder + "/overview-1/store-00000").IsOk());
  const auto answer = RankGroup(disk, 2, true, false).Query(ReplicatedIsovalue, 2);
  ExpectWhole(answer, "store 0 of overview 1");
  EXPECT_TRUE(answer.Surface == expected.Surface);
}

TEST(Replicas, LocalRanksAreEvenerWithReplicasAndLoseLittleWithAStore)
{
  const auto samples = SampleVolume<std::int16_t>({ 193, 97, 97 },
    [](auto i, auto j, auto k)
    { return static_cast<std::int16_t>(i * i / 40 + (j - 48) * (j - 48) / 8 + k); });
  const auto measure = [&](std::uint32_t replicas, bool isLost)
  {
    MemoryDisk disk;
    BlockedVolumeSettings settings = MakeReplicated(replicas, 8);
    settings.Distribution = DistributionMethod::Random;
    WriteVolumeOk(disk, samples, settings);
    if (isLost)
    {
      EXPECT_TRUE(disk.RemoveAll(StorePath(3)).IsOk());
    }
    const auto answer = RankGroup(disk, 8, false, true, 8).Query(200);
    for (const Status& status : answer.Statuses)
    {
      EXPECT_TRUE(status.IsOk()) << status.GetMessage();
    }
    std::uint64_t sum = 0;
    for (const std::uint64_t triangles : answer.Triangles)
    {
      sum += triangles;
    }
    return 8.0 *
      static_cast<double>(*std::max_element(answer.Triangles.begin(), answer.Triangles.end())) /
      static_cast<double>(sum);
  };
  const double alone = measure(1, false);
  EXPECT_GT(alone, 1.4);
  EXPECT_LT(measure(2, false), 1.2);
  // Seven ranks have the work of eight; whole stores would leave one with twice as much.
  EXPECT_LT(measure(2, true), 8.0 / 7.0 + 0.15);
}

TEST(Replicas, AnAppendedTimeStepHasThoseOfTheVolume)
{
  MemoryDisk disk;
  BlockedVolumeSettings settings = MakeReplicated(2);
  settings.Time = 1;
  WriteVolumeOk(disk, GetSamples(), settings);
  settings.Append = true;
  settings.NumberOfReplicas = 0;
  settings.Time = 2;
  WriteVolumeOk(disk, GetSamples(), settings);
  EXPECT_TRUE(
    disk.Exists(HidePath(VolumePath + ".stores") + "/000002/store-00001/replica-1/blocks"));
  settings.NumberOfReplicas = 3;
  settings.Time = 3;
  const auto refused = WriteVolume(disk, GetSamples(), settings);
  ExpectMessage(refused[0].GetStatus(), "each block in 2 stores");
}

TEST(Replicas, MoreReplicasThanStoresAreRefused)
{
  MemoryDisk disk;
  const auto refused = WriteVolume(disk, GetSamples(), MakeReplicated(3, 2));
  ExpectMessage(refused[0].GetStatus(), "3 replicas take as many stores; there are 2");
  EXPECT_TRUE(disk.GetFiles().empty());
}
