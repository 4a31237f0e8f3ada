// SPDX-License-Identifier: BSD-3-Clause
// Trees and directories that are consistent in themselves, but not those that were written. The
// oracle looks at all samples.
#include "Fixtures/ActiveBlocks.h"
#include "Fixtures/BlocksByForce.h"
#include "Fixtures/LongTests.h"
#include "Fixtures/ResealedPages.h"
#include "Fixtures/VolumeOnDisk.h"
#include "Fixtures/ZarrOnDisk.h"
#include "Formats/Opener/ForeignVolume.h"
#include "Storage/Verification/VolumeRepair.h"
#include "Storage/Verification/VolumeVerification.h"

#include <array>
#include <cstring>
#include <optional>
#include <set>

using namespace isosurface;

namespace
{

using ForgedBytes = MemoryDisk::Bytes;

constexpr std::size_t PageBytes = PagedFile::DefaultPageSize;

enum class Kind
{
  Plain,
  Compressed,
  Replicated,
  InPlace
};

/// 210 blocks: the tree of a single store has a node.
const SampleVolume<std::int16_t>& GetForgedSamples()
{
  static const auto samples = MakeVolume<std::int16_t>({ 98, 90, 68 });
  return samples;
}

bool IsTree(const std::string& path)
{
  return path.size() > 5 && path.compare(path.size() - 5, 5, ".tree") == 0;
}

bool IsPaged(const std::string& path)
{
  return IsTree(path) ||
    (path.size() > 10 && path.compare(path.size() - 10, 10, "/directory") == 0);
}

void WriteForged(MemoryDisk& disk, Kind kind, int ranks)
{
  BlockedVolumeSettings settings = MakeSettings(16, kind == Kind::Replicated ? 3 : 1);
  settings.NumberOfReplicas = kind == Kind::Replicated ? 2 : 1;
  settings.Compression.Codec = kind == Kind::Compressed ? SegmentCodec::Zstd : SegmentCodec::None;
  const SampleVolume<std::int16_t>& samples = GetForgedSamples();
  if (kind == Kind::InPlace)
  {
    WriteZarr(disk, "/data/scan.zarr", samples, { 33, 20, 11 });
    SourceRecord wanted;
    wanted.Arrays = { "scan" };
    settings.InPlace =
      Require(DescribeSource(disk, OpenForeignVolume, VolumePath, "/data/scan.zarr", wanted,
        MakeGeometry(samples.GetDimensions()), { { "density", ValueType::Int16 } }));
    settings.JournalSeconds = 0;
  }
  WriteVolumeOk(disk, samples, settings, ranks);
}

/// Makes the volume one of an early writer, which knew no seals.
void RemoveSeals(MemoryDisk& disk)
{
  auto header = Require(BlockedVolumeHeader::Read(disk, VolumePath));
  for (TimeStepDescription& step : header.TimeSteps)
  {
    step.Overviews.push_back(std::move(step.Stores));
    for (std::vector<StoreDescription>& stores : step.Overviews)
    {
      for (StoreDescription& store : stores)
      {
        store.Seals.clear();
      }
    }
    step.Stores = std::move(step.Overviews.back());
    step.Overviews.pop_back();
  }
  const std::string text = header.Format();
  disk.SetFile(VolumePath, ForgedBytes(text.begin(), text.end()));
  for (const auto& file : disk.Copy())
  {
    if (IsPaged(file.first))
    {
      RemoveSums(disk.GetFile(file.first));
    }
  }
}

/// Changes a page, or pages, in one of the ways that keep a file plausible.
void Change(ForgedBytes& bytes, bool isTree, std::mt19937& random)
{
  const auto draw = [&](std::size_t below) { return std::size_t{ random() } % below; };
  const std::size_t pages = bytes.size() / PageBytes;
  std::uint8_t* page = bytes.data() + (1 + draw(pages - 1)) * PageBytes;
  // Records of a tree, or entries of a directory of one or two segments.
  const std::size_t size = isTree ? 20 : 24;
  const std::size_t first = isTree ? 8 : 0;
  std::uint8_t* record = page + first + draw(20) * size;
  switch (random() % 4)
  {
    case 0:
      for (std::size_t flips = 1 + draw(8); flips > 0; --flips)
      {
        page[draw(400)] ^= static_cast<std::uint8_t>(1u << random() % 8);
      }
      return;
    case 1: // a bound, an ordinal, a block, an offset
      record[draw(3) * 8] = static_cast<std::uint8_t>(random());
      return;
    case 2:
      std::swap_ranges(record, record + size, page + first + draw(20) * size);
      return;
    default:
      if (isTree) // the minimum of an interval becomes its maximum: the block is active nowhere
      {
        std::memcpy(record, record + 8, 8);
      }
      else // an entry twice
      {
        std::memcpy(record, page + first + draw(20) * size, size);
      }
  }
}

struct Outcomes
{
  int Right = 0;
  int Refused = 0;
  int Wrong = 0;
};

/// The volume and what its queries must give.
class ForgedVolume
{
public:
  explicit ForgedVolume(Kind kind, int ranks = 1)
  {
    WriteForged(this->Disk, kind, ranks);
    const auto volume = OpenVolume(this->Disk, 0, OpenForeignVolume);
    const SampleVolume<std::int16_t>& all = GetForgedSamples();
    for (int level = 0; level < volume->GetNumberOfLevels(); ++level)
    {
      if (volume->GetSpectrumLevel(level) != level)
      {
        continue;
      }
      const BlockGrid& grid = *volume->FindLevel(level).Grid;
      const SampleVolume<std::int16_t> samples(grid.GetDimensions(),
        [&](auto i, auto j, auto k) { return all.At(i << level, j << level, k << level); });
      for (const double isovalue : { 3.0, 30.0, 80.0 })
      {
        this->Queries.push_back(
          { level, isovalue, FindBlocksByForce(samples, grid, { isovalue }) });
      }
    }
  }

  /// All queries of the disk as it is: "" if each is right, the error of one that fails; nothing if
  /// one is wrong.
  std::optional<std::string> Ask()
  {
    const auto opened = BlockedVolume::Open(
      VolumePath, this->Disk, std::make_shared<BlockCache>(0), OpenForeignVolume);
    if (!opened.IsOk())
    {
      return opened.GetStatus().GetMessage();
    }
    std::string error;
    this->Checked.clear();
    for (const ExpectedQuery& query : this->Queries)
    {
      QueryStatistics statistics;
      const auto active =
        FindActiveBlocks(**opened, { { 0, 0, { query.Isovalue } } }, statistics, query.Level);
      if (!active.IsOk())
      {
        error = active.GetStatus().GetMessage();
        continue;
      }
      Status status;
      const bool isSame = this->HaveSamples(**opened, *active, query.Level, status);
      if (!status.IsOk())
      {
        error = status.GetMessage();
      }
      else if (!isSame || SortBlocks(*active) != query.Blocks)
      {
        return std::nullopt;
      }
    }
    return error;
  }

  /// Forges files, asks, and puts them back; until one gives another surface, if that is wanted.
  Outcomes Forge(int forgeries, unsigned seed, bool endsWithAWrongOne = false)
  {
    std::mt19937 random(seed);
    std::vector<std::string> paths;
    for (const auto& file : this->Disk.GetFiles())
    {
      if (IsPaged(file.first) && file.second->size() > PageBytes)
      {
        paths.push_back(file.first);
      }
    }
    Outcomes outcomes;
    while (outcomes.Right + outcomes.Refused + outcomes.Wrong < forgeries &&
      !(endsWithAWrongOne && outcomes.Wrong > 0))
    {
      const std::string& path = paths[random() % paths.size()];
      const ForgedBytes good = this->Disk.GetFile(path);
      ForgedBytes bad = good;
      Change(bad, IsTree(path), random);
      if (bad == good)
      {
        continue;
      }
      // A forger may not know of the sums, and recompute the checksums of pages alone.
      if (random() % 4 == 0)
      {
        for (std::size_t page = 0; page < bad.size() / PageBytes; ++page)
        {
          ResealPage(bad, page);
        }
      }
      else
      {
        ResealPages(bad);
      }
      this->Disk.SetFile(path, bad);
      const auto answer = this->Ask();
      this->Disk.SetFile(path, good);
      (!answer ? outcomes.Wrong : answer->empty() ? outcomes.Right : outcomes.Refused)++;
      EXPECT_TRUE(!answer || answer->empty() || answer->find("volume.bvol") != std::string::npos)
        << *answer;
    }
    return outcomes;
  }

  MemoryDisk Disk;

private:
  struct ExpectedQuery
  {
    int Level;
    double Isovalue;
    std::vector<std::int64_t> Blocks;
  };

  /// Whether blocks have the samples that belong there; each is read once.
  bool HaveSamples(
    BlockedVolume& volume, const std::vector<BlockReference>& blocks, int level, Status& status)
  {
    const SampleVolume<std::int16_t>& samples = GetForgedSamples();
    const StoredLevel stored = volume.FindLevel(level);
    QueryStatistics statistics;
    bool isSame = true;
    for (const BlockReference& reference : blocks)
    {
      if (!this->Checked.insert({ level, reference.Store, reference.Ordinal, reference.Block })
             .second)
      {
        continue;
      }
      const auto block = volume.ReadBlock(reference, 0, 0, level, statistics);
      if (!block.IsOk())
      {
        status = block.GetStatus();
        return false;
      }
      const SampleView& view = (*block)->View;
      isSame = isSame && view.Box == stored.Grid->GetVertices(reference.Block, stored.Level);
      VisitVertices(view.Box,
        [&](const Index3& at)
        {
          isSame = isSame &&
            *view.At<std::int16_t>(at) ==
              samples.At(at[0] << level, at[1] << level, at[2] << level);
        });
    }
    return isSame;
  }

  std::vector<ExpectedQuery> Queries;
  std::set<std::array<std::int64_t, 4>> Checked; ///< by this Ask()
};

constexpr Kind AllKinds[] = { Kind::Plain, Kind::Compressed, Kind::Replicated, Kind::InPlace };

} // namespace

TEST(ForgedIndex, NoResealedTreeOrDirectoryGivesAnotherSurface)
{
  constexpr int forgeries = LongTests ? 150 : 40;
  Outcomes all;
  for (const Kind kind : AllKinds)
  {
    ForgedVolume volume(kind);
    ASSERT_EQ(volume.Ask(), "");
    const Outcomes found = volume.Forge(forgeries, 1 + static_cast<unsigned>(kind));
    EXPECT_EQ(found.Wrong, 0) << static_cast<int>(kind);
    if (kind == Kind::Replicated)
    {
      EXPECT_EQ(found.Right, forgeries) << "the other replica has the blocks";
    }
    all.Right += found.Right;
    all.Refused += found.Refused;
    ASSERT_EQ(volume.Ask(), "");
  }
  RecordProperty("Right", all.Right);
  RecordProperty("Refused", all.Refused);
  EXPECT_EQ(all.Right + all.Refused, 4 * forgeries);
  EXPECT_GT(all.Refused, 8 * forgeries / 3) << "few pages are read by no query";
}

// So the forgeries are such that they have to be found.
TEST(ForgedIndex, WithoutSealsSomeGiveAnotherSurface)
{
  for (const Kind kind : AllKinds)
  {
    ForgedVolume volume(kind);
    RemoveSeals(volume.Disk);
    ASSERT_EQ(volume.Ask(), "") << "it stays readable";
    const Outcomes found = volume.Forge(50, 1 + static_cast<unsigned>(kind), true);
    EXPECT_GT(found.Wrong, 0) << static_cast<int>(kind);
  }
}

TEST(ForgedIndex, OneErrorNamesTheFileAndTheReason)
{
  for (const int ranks : { 1, 3 })
  {
    ForgedVolume volume(Kind::InPlace, ranks);
    const std::string folder = HidePath(VolumePath + ".stores") + "/000001/store-00000/";
    for (const char* name : { "array-0.tree", "directory" })
    {
      ForgedBytes& bytes = volume.Disk.GetFile(folder + name);
      const ForgedBytes good = bytes;
      bytes[PageBytes + 30] ^= 1;
      ResealPages(bytes);
      const auto answer = volume.Ask();
      ASSERT_TRUE(answer);
      EXPECT_EQ(answer->find(folder + name + ": page 0: this is not the file that was written"), 0u)
        << *answer;
      const auto found =
        Require(VerifyBlockedVolume(VolumePath, volume.Disk, 1, {}, OpenForeignVolume));
      ASSERT_EQ(found.Faults.size(), 1u);
      EXPECT_EQ(found.Faults[0].GetMessage(), *answer);
      bytes = good;
    }
    ASSERT_EQ(volume.Ask(), "");
  }
}

TEST(ForgedIndex, ARepairPutsTheReplicaThatWasWrittenInPlaceOfAForgedOne)
{
  ForgedVolume volume(Kind::Replicated);
  const auto good = volume.Disk.Copy();
  std::mt19937 random(3);
  for (const char* name : { "/array-0.tree", "/directory" })
  {
    for (const std::string& folder : { GetReplicaFolder(volume.Disk, VolumePath, "000001", 1, 0, 3),
           GetReplicaFolder(volume.Disk, VolumePath, "000001", 2, 1, 3) })
    {
      ForgedBytes& bytes = volume.Disk.GetFile(folder + name);
      Change(bytes, IsTree(name), random);
      ResealPages(bytes);
      ASSERT_NE(bytes, good.at(folder + name));
    }
  }
  const auto done = Require(RepairBlockedVolume(VolumePath, volume.Disk, 1));
  EXPECT_EQ(done.Restored.size(), 2u);
  EXPECT_EQ(volume.Disk.Copy(), good);
}

TEST(ForgedIndex, TimeStepsOfAnOldVolumeStayWithoutSealsAndNewOnesHaveThem)
{
  MemoryDisk disk;
  BlockedVolumeSettings settings = MakeSettings(16, 2);
  settings.Append = true;
  settings.Time = 0;
  WriteVolumeOk(disk, GetForgedSamples(), settings);
  RemoveSeals(disk);
  settings.Time = 1;
  WriteVolumeOk(disk, GetForgedSamples(), settings, 3);
  const auto header = Require(BlockedVolumeHeader::Read(disk, VolumePath));
  ASSERT_EQ(header.TimeSteps.size(), 2u);
  for (std::size_t store = 0; store < 2; ++store)
  {
    EXPECT_TRUE(header.TimeSteps[0].Stores[store].Seals.empty());
    EXPECT_EQ(header.TimeSteps[1].Stores[store].Seals.size(), 2u);
  }
  EXPECT_EQ(header.TimeSteps[1].Overviews[0][0].Seals.size(), 2u);
  EXPECT_TRUE(Require(VerifyBlockedVolume(VolumePath, disk, 1)).Faults.empty());
}
