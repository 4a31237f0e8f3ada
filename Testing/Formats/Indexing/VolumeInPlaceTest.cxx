// SPDX-License-Identifier: BSD-3-Clause
// Volumes in place. The oracle is the volume that has copies of the same samples.
#include "Fixtures/ActiveBlocks.h"
#include "Fixtures/LongTests.h"
#include "Fixtures/PlainContour.h"
#include "Fixtures/Require.h"
#include "Fixtures/VolumeOnDisk.h"
#include "Fixtures/ZarrOnDisk.h"
#include "Formats/Opener/ForeignVolume.h"
#include "Ranks/Query/StoredField.h"
#include "Storage/Sampling/StoredBoxSource.h"
#include "Storage/Store/StoredBlockSource.h"
#include "Storage/Verification/VolumeRepair.h"
#include "Storage/Verification/VolumeVerification.h"
#include "Storage/Writing/SourceRelocation.h"

using namespace isosurface;

namespace
{

constexpr double Isovalue = 30;
const std::string InPlaceSource = "/data/scan.zarr";
const Index3 Size = { 70, 45, 51 };

std::shared_ptr<BlockedVolume> OpenInPlace(
  FileSystem& disk, std::uint64_t cacheBytes = std::uint64_t{ 1 } << 28)
{
  return OpenVolume(disk, cacheBytes, OpenForeignVolume);
}

/// A disk with a source and the volume in place that was made of it.
struct InPlaceDisk
{
  explicit InPlaceDisk(const Index3& chunk, int ranks = 1, std::uint32_t stores = 1,
    const SampleVolume<std::int16_t>& samples = MakeVolume<std::int16_t>(Size))
    : Volume(samples)
  {
    WriteZarr(this->Disk, InPlaceSource, this->Volume, chunk);
    this->Write(MakeSettings(16, stores), ranks);
  }

  static SourceRecord MakeWanted()
  {
    SourceRecord wanted;
    wanted.Arrays = { "scan" };
    return wanted;
  }

  Result<SourceRecord> Describe()
  {
    return DescribeSource(this->Disk, OpenForeignVolume, VolumePath, InPlaceSource, MakeWanted(),
      MakeGeometry(this->Volume.GetDimensions()), { { "density", ValueType::Int16 } });
  }

  void Write(BlockedVolumeSettings settings, int ranks = 1)
  {
    settings.InPlace = Require(this->Describe());
    WriteVolumeOk(this->Disk, this->Volume, settings, ranks);
  }

  VolumeVerification Verify()
  {
    return Require(VerifyBlockedVolume(VolumePath, this->Disk, 2, {}, OpenForeignVolume));
  }

  SampleVolume<std::int16_t> Volume;
  MemoryDisk Disk;
};

/// The surface of all ranks, and what it took.
PlainSurface Contour(BlockedVolume& volume, int ranks, bool isDealt, QueryStatistics& statistics)
{
  volume.SetLocalStores(!isDealt);
  std::vector<PlainSurface> surfaces;
  for (int rank = 0; rank < ranks; ++rank)
  {
    auto active = FindActiveBlocks(volume, { { 0, 0, { Isovalue } }, rank, ranks }, statistics);
    StoredBlockSource source(volume, 0, 0, 0, Require(std::move(active)));
    surfaces.push_back(MakePlain(
      Require(ExtractSurface(volume.GetHeader().Grid, source, MakePlainRequest({ Isovalue }), 2))));
    statistics.Add(source.GetStatistics());
  }
  return UniteRanks(surfaces);
}

PlainSurface ContourCopy(const SampleVolume<std::int16_t>& volume)
{
  MemoryDisk disk;
  WriteVolumeOk(disk, volume, MakeSettings(16, 1));
  QueryStatistics statistics;
  return Contour(*OpenInPlace(disk), 1, false, statistics);
}

/// The error of a query, "" if there is none.
std::string FindError(BlockedVolume& volume)
{
  QueryStatistics statistics;
  auto active = FindActiveBlocks(volume, { { 0, 0, { Isovalue } } }, statistics);
  for (std::size_t block = 0; active.IsOk() && block < active->size(); ++block)
  {
    const auto read = volume.ReadBlock((*active)[block], 0, 0, 0, statistics);
    if (!read.IsOk())
    {
      return read.GetStatus().GetMessage();
    }
  }
  return active.GetStatus().GetMessage();
}

} // namespace

TEST(VolumeInPlace, WithoutAnOpenerIsOneClearError)
{
  InPlaceDisk made({ 33, 20, 11 });
  const std::string reason = "/data/scan.zarr: has the samples of " + VolumePath +
    ", but this program reads no files of its format";
  EXPECT_EQ(FindError(*OpenVolume(made.Disk)), reason);
  const auto found = Require(VerifyBlockedVolume(VolumePath, made.Disk, 2));
  ASSERT_EQ(found.Faults.size(), 1u);
  EXPECT_EQ(found.Faults[0].GetMessage().find(reason), 0u);
}

TEST(VolumeInPlace, SurfacesAreThoseOfTheCopiedVolume)
{
  const PlainSurface expected = ContourCopy(MakeVolume<std::int16_t>(Size));
  ASSERT_GT(expected.Triangles.size(), 1000u);
  // Not cubes, not divisors, smaller and larger than blocks, slices, the whole volume.
  for (const Index3& chunk :
    { Index3{ 33, 20, 11 }, Index3{ 7, 9, 50 }, Index3{ 70, 45, 1 }, Index3{ 128, 64, 64 } })
  {
    InPlaceDisk made(chunk, 2, 3);
    for (const int ranks : GetNumbersOfRanks())
    {
      for (const bool isDealt : { false, true })
      {
        QueryStatistics statistics;
        EXPECT_EQ(Contour(*OpenInPlace(made.Disk), ranks, isDealt, statistics), expected)
          << chunk[0] << " x " << chunk[1] << " x " << chunk[2] << ", " << ranks << " ranks";
      }
    }
    QueryStatistics statistics;
    EXPECT_EQ(Contour(*OpenInPlace(made.Disk, 0), 1, false, statistics), expected)
      << "without a cache";
  }
}

TEST(VolumeInPlace, ALostOrDamagedStoreIsReadFromItsReplicaAndRestored)
{
  const PlainSurface expected = ContourCopy(MakeVolume<std::int16_t>(Size));
  InPlaceDisk made({ 33, 20, 11 });
  BlockedVolumeSettings settings = MakeSettings(16, 3);
  settings.NumberOfReplicas = 2;
  made.Write(settings);
  const auto files = made.Disk.Copy();
  const std::string store = HidePath(VolumePath + ".stores") + "/000002/store-00001";
  const std::vector<std::function<void()>> damages = {
    [&] { EXPECT_TRUE(made.Disk.RemoveAll(store).IsOk()); },
    [&] { made.Disk.GetFile(store + "/blocks")[2] ^= 1; },
    [&] { made.Disk.GetFile(store + "/directory").resize(4096); },
  };
  for (const auto& damage : damages)
  {
    damage();
    for (const bool isDealt : { false, true })
    {
      const auto volume = OpenInPlace(made.Disk);
      QueryStatistics statistics;
      EXPECT_EQ(Contour(*volume, 2, isDealt, statistics), expected);
      SerialCommunicator alone;
      EXPECT_NE(
        Require(volume->ShareStoreFaults(alone)).Warning.find("store 1:"), std::string::npos);
    }
    EXPECT_FALSE(made.Verify().Faults.empty());
    const auto repaired = Require(RepairBlockedVolume(VolumePath, made.Disk, 2));
    EXPECT_TRUE(repaired.Refused.empty());
    EXPECT_TRUE(made.Disk.Copy() == files);
    EXPECT_TRUE(made.Verify().Faults.empty());
  }
  // A source that is missing is no fault of the stores.
  ASSERT_TRUE(made.Disk.RemoveAll(InPlaceSource).IsOk());
  const auto volume = OpenInPlace(made.Disk);
  QueryStatistics statistics;
  const auto active = FindActiveBlocks(*volume, { { 0, 0, { Isovalue } } }, statistics);
  ASSERT_FALSE(active.IsOk());
  EXPECT_EQ(active.GetStatus().GetMessage().find("nor can"), std::string::npos)
    << active.GetStatus().GetMessage();
  SerialCommunicator alone;
  EXPECT_FALSE(Require(volume->ShareStoreFaults(alone)).IsNew);
}

TEST(VolumeInPlace, StoresHaveHeadersOfSegmentsAlone)
{
  InPlaceDisk made({ 33, 20, 11 });
  const auto volume = OpenInPlace(made.Disk);
  const BlockedVolumeHeader& header = volume->GetHeader();
  ASSERT_TRUE(header.IsInPlace());
  EXPECT_EQ(header.NumberOfLevels, 1);
  const auto blocks = static_cast<std::uint64_t>(volume->GetBlockGrid().GetNumberOfBlocks());
  ASSERT_EQ(blocks, 5u * 3 * 4);
  EXPECT_EQ(header.TimeSteps[0].Stores[0].Bytes, 4096u) << "60 times 16 bytes, and zeros";
  EXPECT_EQ(header.TimeSteps[0].Source->Path, "scan.zarr") << "seen from the header's folder";
  // The records are those of a volume of one level that has its samples: so are all checksums.
  EXPECT_TRUE(made.Verify().Faults.empty());
}

TEST(VolumeInPlace, ALargeSurfaceFollowsACoarserOneSoonerThanThatOfACopyDoes)
{
  InPlaceDisk made({ 33, 20, 11 });
  MemoryDisk copy;
  WriteVolumeOk(copy, made.Volume, MakeSettings(16, 1));
  const auto inPlace = OpenInPlace(made.Disk);
  const auto copied = OpenInPlace(copy);
  const double each = *copied->EstimateTriangles(0, 0, Isovalue, 0);
  const auto isDirect = [&](const std::shared_ptr<BlockedVolume>& volume, double triangles)
  {
    ExtractionTask task;
    task.Volume = volume;
    task.Query.Isovalues.assign(static_cast<std::size_t>(triangles / each), Isovalue);
    StoredField field;
    field.Ask(task, {});
    SerialCommunicator alone;
    return Require(field.FindFirst(alone, {}, 0)).IsDirect;
  };
  EXPECT_TRUE(isDirect(inPlace, 0.9 * DirectSurfaceTrianglesInPlace));
  EXPECT_FALSE(isDirect(inPlace, 1.1 * DirectSurfaceTrianglesInPlace));
  EXPECT_TRUE(isDirect(copied, 1.1 * DirectSurfaceTrianglesInPlace));
}

TEST(VolumeInPlace, ChunksThatBlocksShareAreDecodedOnce)
{
  const Index3 chunk = { 33, 20, 11 };
  // A ball in a corner.
  InPlaceDisk made(chunk, 1, 1,
    SampleVolume<std::int16_t>(Size,
      [](auto i, auto j, auto k)
      { return 130 - (i - 12) * (i - 12) - (j - 12) * (j - 12) - (k - 14) * (k - 14); }));
  const auto volume = OpenInPlace(made.Disk);
  QueryStatistics statistics;
  const auto active = Require(FindActiveBlocks(*volume, { { 0, 0, { Isovalue } } }, statistics));
  std::set<Index3> touched;
  for (const BlockReference& block : active)
  {
    const VertexBox box = volume->GetBlockGrid().GetGhostedVertices(block.Block, 0);
    VisitVertices(box,
      [&](const Index3& vertex)
      {
        const auto [i, j, k] = vertex;
        touched.insert({ i / chunk[0], j / chunk[1], k / chunk[2] });
      });
  }
  ASSERT_LT(touched.size(), 3u * 3 * 5) << "the surface misses some chunks";
  QueryStatistics first;
  Contour(*volume, 1, false, first);
  EXPECT_EQ(first.BlocksRead, touched.size());
  QueryStatistics second;
  Contour(*volume, 1, false, second);
  EXPECT_EQ(second.BlocksRead, 0u) << "all chunks are in the cache";
}

TEST(VolumeInPlace, AMissingOrChangedSourceIsOneClearError)
{
  InPlaceDisk made({ 33, 20, 11 });
  EXPECT_EQ(FindError(*OpenInPlace(made.Disk)), "");

  made.Disk.SetModified(InPlaceSource + "/0.0.0", 99);
  EXPECT_NE(
    FindError(*OpenInPlace(made.Disk)).find("scan.zarr: was changed since"), std::string::npos);
  EXPECT_NE(FindError(*OpenInPlace(made.Disk)).find("modified at another time"), std::string::npos);
  made.Disk.SetModified(InPlaceSource + "/0.0.0", 1);

  made.Disk.SetFile(InPlaceSource + "/more", { 1 });
  EXPECT_NE(FindError(*OpenInPlace(made.Disk)).find("another number of files"), std::string::npos);
  ASSERT_TRUE(made.Disk.RemoveAll(InPlaceSource + "/more").IsOk());
  EXPECT_EQ(FindError(*OpenInPlace(made.Disk)), "");

  MemoryDisk::Bytes& metadata = made.Disk.GetFile(InPlaceSource + "/.zarray");
  const MemoryDisk::Bytes good = metadata;
  const std::string text(metadata.begin(), metadata.end());
  metadata[text.find(">i2")] = '<';
  EXPECT_NE(FindError(*OpenInPlace(made.Disk)).find("stored otherwise"), std::string::npos);
  metadata = good;

  // No time tells that a chunk has other samples now.
  made.Disk.GetFile(InPlaceSource + "/1.1.1")[1000] ^= 1;
  const std::string error = FindError(*OpenInPlace(made.Disk));
  EXPECT_NE(error.find("scan.zarr: was changed since"), std::string::npos) << error;
  EXPECT_NE(error.find("has other samples"), std::string::npos) << error;
  EXPECT_GT(made.Verify().FaultCount, 0u);

  ASSERT_TRUE(made.Disk.RemoveAll(InPlaceSource).IsOk());
  EXPECT_NE(
    FindError(*OpenInPlace(made.Disk)).find("is missing; name its new place"), std::string::npos);
  EXPECT_EQ(made.Verify().FaultCount, 1u) << "the rest is sound";
  const auto volume = OpenInPlace(made.Disk);
  EXPECT_TRUE(volume->GetSpectrum(0, 0).IsOk());
  QueryStatistics statistics;
  EXPECT_TRUE(FindActiveBlocks(*volume, { { 0, 0, { Isovalue } } }, statistics, 1).IsOk());
}

TEST(VolumeInPlace, AVolumeThatIsOpenTellsThatItsSourceWasChanged)
{
  InPlaceDisk made({ 33, 20, 11 });
  const auto volume = OpenInPlace(made.Disk);
  EXPECT_TRUE(volume->CheckSource(0).IsOk()) << "nothing was read";
  QueryStatistics statistics;
  Contour(*volume, 1, false, statistics);
  EXPECT_TRUE(volume->CheckSource(0).IsOk());
  made.Disk.SetModified(InPlaceSource + "/0.0.0", 99);
  const Status changed = volume->CheckSource(0);
  EXPECT_EQ(changed.GetCode(), StatusCode::Corrupt);
  EXPECT_NE(changed.GetMessage().find("scan.zarr: was changed since"), std::string::npos);
  EXPECT_NE(changed.GetMessage().find("modified at another time"), std::string::npos);
  made.Disk.SetModified(InPlaceSource + "/0.0.0", 1);
  EXPECT_TRUE(volume->CheckSource(0).IsOk());
}

TEST(VolumeInPlace, TimeStepsAreAppendedInPlaceOrRefused)
{
  MemoryDisk disk;
  const auto volume = MakeVolume<std::int16_t>(Size);
  WriteZarr(disk, InPlaceSource, volume, { 33, 20, 11 });
  const auto record = Require(DescribeSource(disk, OpenForeignVolume, VolumePath, InPlaceSource,
    InPlaceDisk::MakeWanted(), MakeGeometry(Size), { { "density", ValueType::Int16 } }));
  BlockedVolumeSettings settings = MakeSettings(16, 1);
  settings.Time = 1;
  settings.InPlace = record;
  WriteVolumeOk(disk, volume, settings);
  settings.Time = 2;
  settings.Append = true;
  WriteVolumeOk(disk, volume, settings);
  settings.Time = 3;
  settings.InPlace.reset();
  const auto copied = WriteVolume(disk, volume, settings);
  ExpectError(copied[0].GetStatus(), StatusCode::InvalidArgument, "it is indexed in place");
  const auto opened = OpenInPlace(disk);
  ASSERT_EQ(opened->GetHeader().TimeSteps.size(), 2u);
  QueryStatistics statistics;
  EXPECT_TRUE(FindActiveBlocks(*opened, { { 1, 0, { Isovalue } } }, statistics).IsOk());

  MemoryDisk other;
  settings.Append = false;
  WriteVolumeOk(other, volume, settings);
  settings.Append = true;
  settings.Time = 4;
  settings.InPlace = record;
  EXPECT_EQ(
    WriteVolume(other, volume, settings)[0].GetStatus().GetCode(), StatusCode::InvalidArgument);
}

TEST(VolumeInPlace, IsWrittenAnewAsACopy)
{
  InPlaceDisk made({ 33, 20, 11 });
  auto source = Require(StoredBoxSource::Make(OpenInPlace(made.Disk), 0, { 0 }, 2));
  MemoryDisk anew;
  ThreadCommunicator::Run(1,
    [&](Communicator& ranks)
    {
      const auto written = BlockedVolumeWriter(ranks, anew)
                             .Write(VolumePath, MakeGeometry(Size),
                               { { "density", ValueType::Int16 } }, *source, MakeSettings(16, 2));
      EXPECT_TRUE(written.IsOk()) << written.GetStatus().GetMessage();
    });
  MemoryDisk copied;
  WriteVolumeOk(copied, made.Volume, MakeSettings(16, 2));
  EXPECT_EQ(anew.Copy(), copied.Copy());
}

TEST(VolumeInPlace, SourcesThatCanOnlyBeReadInOrderAreRefused)
{
  MemoryDisk disk;
  const std::string header = "ObjectType = Image\nNDims = 3\nDimSize = 4 4 4\nElementType = "
                             "MET_UCHAR\nCompressedData = True\nElementDataFile = LOCAL\n";
  disk.SetFile("/data/a.mha", MemoryDisk::Bytes(header.begin(), header.end()));
  GridGeometry grid;
  grid.Extent = { 0, 3, 0, 3, 0, 3 };
  const auto record = DescribeSource(disk, OpenForeignVolume, VolumePath, "/data/a.mha", {}, grid,
    { { "density", ValueType::UInt8 } });
  BlockedVolumeSettings settings;
  settings.InPlace = Require(record);
  auto opened = Require(OpenForeignVolume(disk, "/data/a.mha"));
  ThreadCommunicator::Run(2,
    [&](Communicator& ranks)
    {
      const auto written = BlockedVolumeWriter(ranks, disk)
                             .Write(VolumePath, grid, opened.Arrays, *opened.Source, settings);
      ExpectError(written.GetStatus(), StatusCode::Unsupported, "/data/a.mha");
      ExpectError(written.GetStatus(), StatusCode::Unsupported, "only be read in order");
    });
}

TEST(VolumeInPlace, HeadersWithImpossibleSourcesAreRefused)
{
  InPlaceDisk made({ 33, 20, 11 });
  const auto good = OpenInPlace(made.Disk)->GetHeader();
  const auto parse = [](const BlockedVolumeHeader& header)
  { return BlockedVolumeHeader::Parse(header.Format(), VolumePath).GetStatus().GetCode(); };
  EXPECT_EQ(parse(good), StatusCode::Ok);
  BlockedVolumeHeader bad = good;
  (*bad.TimeSteps[0].Source->Chunk)[1] = 0;
  EXPECT_EQ(parse(bad), StatusCode::Corrupt);
  bad.TimeSteps[0].Source->Chunk.reset();
  EXPECT_EQ(parse(bad), StatusCode::Corrupt);
  bad = good;
  bad.TimeSteps[0].CopyOf = bad.TimeSteps[0].Source;
  EXPECT_EQ(parse(bad), StatusCode::Ok);
  bad.TimeSteps[0].CopyOf->Arrays.clear();
  EXPECT_EQ(parse(bad), StatusCode::Corrupt);
  bad = good;
  bad.TimeSteps[0].Source->Path.clear();
  EXPECT_EQ(parse(bad), StatusCode::Corrupt);
  bad = good;
  bad.TimeSteps[0].Source->Arrays.push_back("one more");
  EXPECT_EQ(parse(bad), StatusCode::Corrupt);
  bad = good;
  bad.NumberOfLevels = 2;
  EXPECT_EQ(parse(bad), StatusCode::Corrupt);
}
