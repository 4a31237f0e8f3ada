// SPDX-License-Identifier: BSD-3-Clause
// Indices of sources: their names, when they are out of date, and what they have.
#include "Formats/Indexing/SourceIndex.h"
#include "Fixtures/SampleFiles.h"
#include "Fixtures/VolumeOnDisk.h"
#include "Fixtures/ZarrOnDisk.h"
#include "Storage/Sampling/StoredBoxSource.h"

using namespace isosurface;

namespace
{

const std::string SourcePath = "/data/scan.zarr";
constexpr std::uint64_t Memory = std::uint64_t{ 64 } << 20;

SourceIndex Find(MemoryDisk& disk, const std::string& chosen, const std::string& dataset = "",
  const std::string& folder = "")
{
  return SourceIndex::Find(disk, chosen, dataset, "", folder);
}

void WriteOk(MemoryDisk& disk, const SourceIndex& index, int ranks)
{
  ThreadCommunicator::Run(ranks,
    [&](Communicator& communicator)
    {
      const auto written = WriteSourceIndex(communicator, disk, index, Memory);
      EXPECT_TRUE(written.IsOk()) << written.GetStatus().GetMessage();
    });
}

IndexState FindState(MemoryDisk& disk, const SourceIndex& index)
{
  const auto state = FindIndexState(disk, index);
  EXPECT_TRUE(state.IsOk()) << state.GetStatus().GetMessage();
  return state.IsOk() ? *state : IndexState::Missing;
}

} // namespace

TEST(SourceIndex, MetadataAndGroupsBelongToTheOutermostFolder)
{
  MemoryDisk disk;
  disk.SetFile("/data/scan.zarr/.zgroup", MakeBytes("{\"zarr_format\": 2}"));
  disk.SetFile("/data/scan.zarr/labels/0/.zarray", MakeBytes("{}"));
  disk.SetFile("/data/scan.zarr/labels/.zgroup", MakeBytes("{\"zarr_format\": 2}"));
  disk.SetFile("/data/run.h5", MakeBytes("no matter"));
  const SourceIndex whole = Find(disk, "/data/scan.zarr/.zgroup");
  EXPECT_EQ(whole.Source, "/data/scan.zarr");
  EXPECT_EQ(whole.Path, "/data/scan.zarr.bvol");
  EXPECT_EQ(Find(disk, "/data/scan.zarr").Path, whole.Path);
  const SourceIndex label = Find(disk, "/data/scan.zarr/labels/0/.zarray");
  EXPECT_EQ(label.Source, "/data/scan.zarr:labels/0");
  EXPECT_EQ(label.Path, "/data/scan.zarr-labels-0.bvol");
  const SourceIndex run = Find(disk, "/data/run.h5", "/entry/data", "/scratch");
  EXPECT_EQ(run.Source, "/data/run.h5:/entry/data");
  EXPECT_EQ(run.Path, "/scratch/run.h5-entry-data.bvol");
  // rock.bvol is what users call a copy of the folder "rock".
  disk.SetFile("/data/rock/slice1.tif", MakeBytes("II"));
  disk.SetFile("/data/rock.2/slice1.tif", MakeBytes("II"));
  EXPECT_EQ(Find(disk, "/data/rock").Path, "/data/rock.index.bvol");
  EXPECT_EQ(Find(disk, "/data/rock.2").Path, "/data/rock.2.index.bvol");
}

TEST(SourceIndex, VolumesAreOfferedAndOtherFilesAreNot)
{
  MemoryDisk disk;
  WriteZarr(disk, SourcePath, MakeVolume<std::int16_t>({ 40, 33, 36 }), { 16, 11, 20 });
  EXPECT_TRUE(CanBeIndexed(disk, SourcePath));
  EXPECT_TRUE(CanBeIndexed(disk, SourcePath + "/.zarray"));
  const auto offers = [&disk](const std::string& name, const std::string& text, std::size_t samples)
  {
    MemoryDisk::Bytes bytes = MakeBytes(text);
    bytes.resize(bytes.size() + samples);
    disk.SetFile("/data/" + name, bytes);
    return CanBeIndexed(disk, "/data/" + name);
  };
  const std::string volume = "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 4 4 4\nencoding: raw\n\n";
  EXPECT_TRUE(offers("a.nrrd", volume, 64));
  EXPECT_TRUE(offers("damaged.nrrd", volume, 63));
  EXPECT_TRUE(CanBeIndexed(disk, "/data/damaged.nrrd"));
  EXPECT_FALSE(offers("a.txt", volume, 64));
  EXPECT_FALSE(offers(
    "slice.nrrd", "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 8 8 1\nencoding: raw\n\n", 64));
  EXPECT_TRUE(offers(
    "stream.nrrd", "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 4 4 4\nencoding: gzip\n\n", 64));
  EXPECT_FALSE(offers("a.map", "no MRC", 4096));
  EXPECT_FALSE(offers("a.raw", "", 64)) << "nobody knows what it is";
  EXPECT_TRUE(IsRawSource(disk, "/data/a.raw"));
  EXPECT_TRUE(offers("a_4x4x4_uint8.raw", "", 64));
  EXPECT_TRUE(IsRawSource(disk, "/data/a.txt"));
  EXPECT_FALSE(IsRawSource(disk, "/data/a.nrrd"));
  EXPECT_FALSE(CanBeIndexed(disk, "/data")) << "a folder without a volume";
  EXPECT_FALSE(CanBeIndexed(disk, "/data/nothing.zarr"));
}

TEST(SourceIndex, ArraysThatMayBeVolumesAreListed)
{
  MemoryDisk disk;
  const std::string folder = "/data/two.zarr";
  disk.SetFile(folder + "/.zgroup", MakeBytes("{\"zarr_format\": 2}"));
  const auto volume = MakeVolume<std::int16_t>({ 40, 33, 36 });
  WriteZarr(disk, folder + "/a", volume, { 16, 11, 20 });
  WriteZarr(disk, folder + "/b", volume, { 16, 11, 20 });
  disk.SetFile(folder + "/c/.zarray",
    MakeBytes("{\"zarr_format\": 2, \"shape\": [4, 4], \"chunks\": [4, 4], \"dtype\": \"<i2\", "
              "\"compressor\": null, \"fill_value\": 0, \"order\": \"C\", \"filters\": null}"));
  EXPECT_EQ(ListVolumes(disk, folder), (std::vector<std::string>{ "a", "b" }));
  EXPECT_TRUE(CanBeIndexed(disk, folder)) << "one of them has to be chosen";
  EXPECT_FALSE(CanBeIndexed(disk, folder + "/c/.zarray"));
}

TEST(SourceIndex, IsCurrentUntilTheSourceChanges)
{
  const auto volume = MakeVolume<std::int16_t>({ 40, 33, 36 });
  MemoryDisk disk;
  WriteZarr(disk, SourcePath, volume, { 16, 11, 20 });
  const SourceIndex index = Find(disk, SourcePath);
  EXPECT_EQ(FindState(disk, index), IndexState::Missing);
  WriteOk(disk, index, 3);
  EXPECT_EQ(FindState(disk, index), IndexState::Current);
  const auto opened = Require(BlockedVolume::Open(index.Path, disk));
  EXPECT_TRUE(opened->GetHeader().IsInPlace());
  EXPECT_EQ(opened->GetHeader().Grid.GetDimensions(), volume.GetDimensions());
  disk.SetFile(SourcePath + "/more", { 1 });
  EXPECT_EQ(FindState(disk, index), IndexState::Changed);
  WriteOk(disk, index, 2);
  EXPECT_EQ(FindState(disk, index), IndexState::Current);
}

TEST(SourceIndex, OfAStreamHasItsSamplesUntilTheStreamChanges)
{
  const std::string source = "/data/scan.nrrd";
  const std::string header =
    "NRRD0004\ntype: short\nendian: little\ndimension: 3\nsizes: 40 33 36\nencoding: gzip\n\n";
  MemoryDisk disk;
  const auto setStream = [&](const SampleVolume<std::int16_t>& volume)
  {
    MemoryDisk::Bytes bytes = MakeBytes(header);
    const MemoryDisk::Bytes stream = Deflate(MakeBytes(volume));
    bytes.insert(bytes.end(), stream.begin(), stream.end());
    disk.SetFile(source, bytes);
  };
  const auto first = MakeVolume<std::int16_t>({ 40, 33, 36 });
  const auto second = MakeVolume<std::int16_t>({ 40, 33, 36 }, 2);
  const SourceIndex index = Find(disk, source);
  const auto expectVolume = [&](const SampleVolume<std::int16_t>& volume, int ranks)
  {
    WriteOk(disk, index, ranks);
    EXPECT_EQ(FindState(disk, index), IndexState::Current);
    const MemoryDisk::Bytes kept = disk.GetFile(source);
    EXPECT_TRUE(disk.RemoveAll(source).IsOk());
    const auto opened = Require(BlockedVolume::Open(index.Path, disk));
    EXPECT_FALSE(opened->GetHeader().IsInPlace());
    ExpectSamples(*Require(StoredBoxSource::Make(opened, 0, { 0 }, 2)), volume);
    EXPECT_EQ(FindState(disk, index), IndexState::Changed);
    disk.SetFile(source, kept);
  };
  setStream(first);
  expectVolume(first, 1);
  setStream(second);
  disk.SetModified(source, 7);
  EXPECT_EQ(FindState(disk, index), IndexState::Changed);
  expectVolume(second, 3);
  ExpectError(FindIndexState(disk, { "/data/other.nrrd", "", index.Path }).GetStatus(),
    StatusCode::InvalidArgument, "is no index of /data/other.nrrd");
}

TEST(SourceIndex, IsNeverMadeOfAnotherVolume)
{
  const auto volume = MakeVolume<std::int16_t>({ 40, 33, 36 });
  MemoryDisk disk;
  WriteVolumeOk(disk, volume, MakeSettings(16, 1));
  const SourceIndex index = { SourcePath, "", VolumePath };
  WriteZarr(disk, SourcePath, volume, { 16, 16, 16 });
  const auto copied = FindIndexState(disk, index);
  ExpectError(copied.GetStatus(), StatusCode::InvalidArgument, VolumePath);
  // Nor is the index of one source that of another.
  const SourceIndex mine = Find(disk, SourcePath);
  WriteOk(disk, mine, 1);
  WriteZarr(disk, "/data/other.zarr", volume, { 16, 16, 16 });
  const auto other = FindIndexState(disk, { "/data/other.zarr", "", mine.Path });
  EXPECT_EQ(other.GetStatus().GetCode(), StatusCode::InvalidArgument);
}

TEST(SourceIndex, StopAndErrorsLeaveNothing)
{
  MemoryDisk disk;
  const SourceIndex index = Find(disk, SourcePath);
  ThreadCommunicator::Run(2,
    [&](Communicator& communicator)
    {
      const auto missing = WriteSourceIndex(communicator, disk, index, Memory);
      ExpectMessage(missing.GetStatus(), "scan.zarr");
    });
  WriteZarr(disk, SourcePath, MakeVolume<std::int16_t>({ 40, 33, 36 }), { 16, 16, 16 });
  ThreadCommunicator::Run(2,
    [&](Communicator& communicator)
    {
      const bool stops = communicator.GetRank() == 1;
      const auto stopped =
        WriteSourceIndex(communicator, disk, index, Memory, [stops](double) { return !stops; });
      EXPECT_EQ(stopped.GetStatus().GetCode(), StatusCode::Aborted);
    });
  EXPECT_EQ(FindState(disk, index), IndexState::Missing);
}
