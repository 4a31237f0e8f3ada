// SPDX-License-Identifier: BSD-3-Clause
#include "Fixtures/CodedVolumes.h"

#include "Fixtures/MemoryDisk.h"

#include "Coding/EdgeIndex/EdgeIndexFile.h"
#include "Coding/EdgeIndex/EdgeIndexWriteJob.h"
#include "Fixtures/EdgeIndexFileWriter.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <map>
#include <random>
#include <set>
#include <string>
#include <vector>

#include <unistd.h>

using namespace isosurface;

namespace
{

const std::string Path = "/data/surface.eix";
const std::string PartialPath = EdgeIndexFileWriter::GetPartialPath(Path);

template <typename T>
EdgeIndexHeader MakeFileHeader(const SampleVolume<T>& volume, const std::vector<double>& isovalues,
  EdgeIndexMode mode = EdgeIndexMode::Lossless)
{
  EdgeIndexHeader header = MakeHeader(volume, isovalues, mode, EdgeIndexProfile::Working);
  header.Array = "density";
  header.Source = "a test's volume";
  header.Time = 2.5;
  header.PreviewLevel = 2;
  return header;
}

template <typename T>
void WriteFile(MemoryDisk& disk, const EdgeIndexHeader& header, const SampleVolume<T>& volume,
  int blockSize, int threads = 1)
{
  TestBlockSource<T> source(volume, blockSize);
  const Status status = WriteEdgeIndexFile(disk, Path, header, source, threads);
  ASSERT_TRUE(status.IsOk()) << status.GetMessage();
}

std::unique_ptr<EdgeIndexFile> OpenFile(MemoryDisk& disk, const std::string& path = Path)
{
  return Require(EdgeIndexFile::Open(disk, path));
}

/// A small file with two isovalues and a preview.
MemoryDisk::Bytes WriteSmallFile(MemoryDisk& disk)
{
  const auto volume = MakeWaves<std::uint8_t>({ 34, 9, 6 }, 0.2);
  const EdgeIndexHeader header = MakeFileHeader(volume, { 120.5, 150 });
  WriteFile(disk, header, volume, 16);
  return disk.GetFile(Path);
}

using PointsById = std::map<std::int64_t, std::array<float, 3>>;

/// The points of a file that is decoded block by block. Each point must have one place in all blocks.
PointsById ReadBlockByBlock(const EdgeIndexFile& file)
{
  PointsById points;
  EdgeIndexSelection selection;
  selection.NumberOfPieces = static_cast<int>(file.GetEntries().size());
  for (; selection.Piece < selection.NumberOfPieces; ++selection.Piece)
  {
    const auto piece = Require(file.Read(selection, MakeRequest({}), 1));
    for (std::size_t n = 0; n < piece.NumberOfPoints; ++n)
    {
      const float* point = piece.Points.GetData() + 3 * n;
      const std::array<float, 3> place = { point[0], point[1], point[2] };
      EXPECT_EQ(points.emplace(piece.GlobalIds[n], place).first->second, place)
        << piece.GlobalIds[n];
    }
  }
  return points;
}

/// One half is noise of four values, which take fewer bits than the places of its crossings.
SampleVolume<std::int16_t> MakeHalfNoisy()
{
  auto volume = MakeWaves<std::int16_t>({ 50, 34, 30 }, 0);
  std::mt19937 random(3);
  for (std::size_t n = 0; n < volume.Samples.size(); ++n)
  {
    volume.Samples[n] =
      n % 50 < 26 ? volume.Samples[n] : static_cast<std::int16_t>(99 + random() % 4);
  }
  return volume;
}

std::size_t CountBlocks(const EdgeIndexFile& file, bool preview)
{
  return static_cast<std::size_t>(std::count_if(file.GetEntries().begin(), file.GetEntries().end(),
    [preview](const EdgeIndexEntry& entry) { return entry.Block.IsPreview == preview; }));
}

} // namespace

TEST(EdgeIndexFile, HoldsTheExtractedSurfaceAndItsProvenance)
{
  auto volume = MakeWaves<std::int16_t>({ 70, 40, 30 }, 0.1);
  Displace(volume);
  const std::vector<double> isovalues = { 100.5, 4000, -3000 };
  MemoryDisk disk;
  WriteFile(disk, MakeFileHeader(volume, isovalues), volume, 16);
  const auto file = OpenFile(disk);
  EXPECT_TRUE(file->IsComplete());
  const EdgeIndexHeader& header = file->GetHeader();
  EXPECT_EQ(header.Geometry, volume.Geometry);
  EXPECT_EQ(header.Isovalues, isovalues);
  EXPECT_EQ(header.Array, "density");
  EXPECT_EQ(header.Source, "a test's volume");
  EXPECT_EQ(header.Time, 2.5);
  EXPECT_EQ(header.NumberOfBlocks, 5u * 3 * 2);

  TestBlockSource<std::int16_t> source(volume, 16);
  const ContourRequest request = MakeRequest(isovalues);
  const auto expected = ExtractSurface(volume.Geometry, source, request, 1);
  const auto read = Require(file->Read({}, request, 2));
  ExpectSamePoints(*expected, read);
  EXPECT_TRUE(file->Verify(2).IsOk());

  EdgeIndexSelection one;
  one.Isovalues = { 1 };
  const auto second = Require(file->Read(one, request, 1));
  const SurfacePart& part = expected->Parts[1];
  ASSERT_EQ(second.NumberOfPoints, part.NumberOfPoints);
  for (std::size_t n = 0; n < part.NumberOfPoints; ++n)
  {
    ASSERT_EQ(second.GlobalIds[n], expected->GlobalIds[part.FirstPoint + n]);
  }
}

TEST(EdgeIndexFile, PointsOnFacesHaveOnePlaceInAllBlocksInEveryMode)
{
  const auto volume = MakeHalfNoisy();
  for (const EdgeIndexProfile profile : AllProfiles)
  {
    for (const EdgeIndexMode mode : { EdgeIndexMode::Lossless, EdgeIndexMode::Bounded,
           EdgeIndexMode::Quantized, EdgeIndexMode::Smallest })
    {
      EdgeIndexHeader header = MakeFileHeader(volume, { 100.5 }, mode);
      header.Settings.Profile = profile;
      header.PreviewLevel = 0;
      MemoryDisk disk;
      WriteFile(disk, header, volume, 16);
      const auto file = OpenFile(disk);
      const auto valued = std::count_if(file->GetEntries().begin(), file->GetEntries().end(),
        [](const EdgeIndexEntry& entry) { return entry.Block.Coding == CodedGeometry::Values; });
      if (mode == EdgeIndexMode::Smallest)
      {
        EXPECT_GT(valued, 3);
        EXPECT_LT(valued, static_cast<std::ptrdiff_t>(file->GetEntries().size()) - 3);
      }
      EXPECT_GT(ReadBlockByBlock(*file).size(), 1000u);
    }
  }
}

TEST(EdgeIndexFile, SmallestKeepsPointsInsideOfLosslessBlocks)
{
  const auto volume = MakeHalfNoisy();
  MemoryDisk disk;
  EdgeIndexHeader header = MakeFileHeader(volume, { 100.5 }, EdgeIndexMode::Smallest);
  WriteFile(disk, header, volume, 16);
  const auto file = OpenFile(disk);
  const PointsById points = ReadBlockByBlock(*file);
  header.Settings.Mode = EdgeIndexMode::Lossless;
  WriteFile(disk, header, volume, 16);
  const auto lossless = OpenFile(disk);
  std::size_t moved = 0;
  std::size_t kept = 0;
  for (const EdgeIndexEntry& entry : file->GetEntries())
  {
    EdgeIndexSelection selection;
    selection.Box = entry.Block.Vertices;
    const auto block = Require(lossless->Read(selection, MakeRequest({}), 1));
    for (std::size_t n = 0; n < block.NumberOfPoints &&
         entry.Block.Coding == CodedGeometry::Values && !entry.Block.IsPreview;
         ++n)
    {
      const std::array<float, 3>& place = points.at(block.GlobalIds[n]);
      const bool isSame = std::equal(place.begin(), place.end(), block.Points.GetData() + 3 * n);
      const std::int64_t vertex = block.GlobalIds[n] / 3;
      const Index3 at = { vertex % 50, vertex / 50 % 34, vertex / (50 * 34) };
      bool isOnFace = false;
      for (std::size_t axis = 0; axis < 3; ++axis)
      {
        isOnFace = isOnFace ||
          (static_cast<std::int64_t>(axis) != block.GlobalIds[n] % 3 &&
            (at[axis] == entry.Block.Vertices.Low[axis] ||
              at[axis] == entry.Block.Vertices.High[axis] - 1));
      }
      EXPECT_TRUE(isSame || isOnFace);
      ++(isSame ? kept : moved);
    }
  }
  EXPECT_GT(kept, 1000u);
  EXPECT_GT(moved, 100u);
}

TEST(EdgeIndexFile, SmallestWithAnErrorBelowTheRoundingOfCoordinatesIsLossless)
{
  const auto volume = MakeHalfNoisy();
  EdgeIndexHeader header = MakeFileHeader(volume, { 100.5 }, EdgeIndexMode::Smallest);
  header.Settings.MaximumError = 0.000001;
  EXPECT_FALSE(header.Check().IsOk());
  header.TakeLosslessIfBoundIsTooFine();
  EXPECT_EQ(header.Settings.Mode, EdgeIndexMode::Lossless);
  EXPECT_TRUE(header.Check().IsOk());
  for (const double error : { 0.0, -1.0, 0.6, 0.01 }) // wrong ones stay an error
  {
    header.Settings.Mode = EdgeIndexMode::Smallest;
    header.Settings.MaximumError = error;
    header.TakeLosslessIfBoundIsTooFine();
    EXPECT_EQ(header.Settings.Mode, EdgeIndexMode::Smallest);
  }
}

TEST(EdgeIndexFile, PartsAreInTheOrderInWhichTheirIsovaluesAreAskedFor)
{
  const auto volume = MakeWaves<std::int16_t>({ 70, 40, 30 }, 0.1);
  MemoryDisk disk;
  WriteFile(disk, MakeFileHeader(volume, { 100.5, 4000, -3000 }), volume, 16);
  const auto file = OpenFile(disk);
  EdgeIndexSelection selection;
  selection.Isovalues = { 2, 0, 2 };
  TestBlockSource<std::int16_t> source(volume, 16);
  const ContourRequest request = MakeRequest({ -3000, 100.5, -3000 });
  const auto expected = ExtractSurface(volume.Geometry, source, request, 1);
  const auto read = Require(file->Read(selection, request, 2));
  ASSERT_EQ(read.Parts.size(), 3u);
  for (std::size_t n = 0; n < 3; ++n)
  {
    EXPECT_EQ(read.Parts[n].Isovalue, expected->Parts[n].Isovalue);
    EXPECT_EQ(read.Parts[n].FirstPoint, expected->Parts[n].FirstPoint);
    EXPECT_EQ(read.Parts[n].FirstCell, expected->Parts[n].FirstCell);
  }
  ASSERT_EQ(read.NumberOfPoints, expected->NumberOfPoints);
  EXPECT_TRUE(std::equal(read.Points.begin(), read.Points.end(), expected->Points.begin()));
  ASSERT_EQ(read.Connectivity.GetSize(), expected->Connectivity.GetSize());
  for (std::size_t n = 0; n < read.Connectivity.GetSize(); ++n)
  {
    ASSERT_EQ(read.Connectivity[n], expected->Connectivity[n]);
  }
}

TEST(EdgeIndexFile, ThreadsDoNotChangeTheBytes)
{
  const auto volume = MakeWaves<float>({ 60, 50, 40 }, 0.1);
  const EdgeIndexHeader header = MakeFileHeader(volume, { 0.05, 0.4 });
  MemoryDisk one;
  MemoryDisk three;
  WriteFile(one, header, volume, 16, 1);
  WriteFile(three, header, volume, 16, 3);
  EXPECT_EQ(one.GetFile(Path), three.GetFile(Path));
}

TEST(EdgeIndexFile, ABoxReadsOnlyTheBlocksThatItOverlaps)
{
  const auto volume = MakeWaves<std::uint8_t>({ 129, 65, 65 }, 0.2);
  MemoryDisk disk;
  WriteFile(disk, MakeFileHeader(volume, { 120.5 }), volume, 16);
  const auto file = OpenFile(disk);
  for (const VertexBox& box : { VertexBox{ { 16, 16, 16 }, { 33, 33, 33 } },
         VertexBox{ { 20, 3, 40 }, { 22, 4, 50 } }, VertexBox{ { 32, 0, 0 }, { 33, 65, 65 } } })
  {
    TestBlockSource<std::uint8_t> source(volume, 16);
    source.Blocks.clear();
    const BlockGrid grid(volume.GetDimensions(), 16);
    for (std::int64_t block = 0; block < grid.GetNumberOfBlocks(); ++block)
    {
      const VertexBox common = grid.GetVertices(block).Intersect(box);
      bool meets = !common.IsEmpty();
      for (std::size_t axis = 0; axis < 3; ++axis)
      {
        meets = meets && (common.GetSize()[axis] > 1 || box.GetSize()[axis] == 1);
      }
      if (meets)
      {
        source.Blocks.push_back(block);
      }
    }
    const ContourRequest request = MakeRequest({ 120.5 });
    const auto expected = ExtractSurface(volume.Geometry, source, request, 1);
    EdgeIndexSelection selection;
    selection.Box = box;
    const auto selected = Require(file->Select(selection));
    std::uint64_t bytes = 0;
    for (const std::size_t entry : selected)
    {
      bytes += file->GetEntries()[entry].Size;
    }
    const std::uint64_t before = disk.GetBytesRead(Path);
    const auto read = Require(file->Read(selection, request, 1));
    EXPECT_EQ(disk.GetBytesRead(Path) - before, bytes);
    ASSERT_GT(expected->NumberOfPoints, 0u);
    ExpectSamePoints(*expected, read);
  }
}

TEST(EdgeIndexFile, ThePreviewIsTheSurfaceOfEveryFourthVertex)
{
  auto volume = MakeWaves<std::uint8_t>({ 71, 67, 50 }, 0.2);
  Displace(volume);
  volume.Geometry.Spacing = { 1, 1, 1 };
  SampleVolume<std::uint8_t> coarse(
    { 18, 17, 13 }, [&](auto i, auto j, auto k) { return volume.At(4 * i, 4 * j, 4 * k); });
  coarse.Geometry = volume.Geometry.Coarsen(2);
  const ContourRequest request = MakeRequest({ 120.5, 90 });
  MemoryDisk disk;
  WriteFile(disk, MakeFileHeader(volume, { 120.5, 90 }), volume, 32);
  const auto file = OpenFile(disk);
  TestBlockSource<std::uint8_t> source(coarse, 8);
  // The last block on z has 17 vertices, that on y two: too few for a cell of the preview.
  const auto expected = ExtractSurface(coarse.Geometry, source, request, 1);
  EdgeIndexSelection selection;
  selection.Preview = true;
  const auto read = Require(file->Read(selection, request, 1));
  ExpectSameTopology(*expected, read);
  for (std::size_t n = 0; n < expected->Points.GetSize(); ++n)
  {
    ASSERT_NEAR(expected->Points[n], read.Points[n], 4 * 0.0501);
  }
  EXPECT_LT(static_cast<double>(disk.GetFile(Path).size()),
    1.25 *
      static_cast<double>(EncodeSurface(
        MakeHeader(volume, { 120.5, 90 }, EdgeIndexMode::Lossless, EdgeIndexProfile::Working),
        *std::make_unique<TestBlockSource<std::uint8_t>>(volume, 32), 1)
                            ->size()));
}

TEST(EdgeIndexFile, ThePreviewIsTheSameInAllProfiles)
{
  const auto volume = MakeWaves<std::uint8_t>({ 65, 65, 65 }, 0.2);
  EdgeIndexHeader header = MakeFileHeader(volume, { 120.5, 150 });
  std::array<MemoryDisk::Bytes, 2> previews;
  std::array<MemoryDisk::Bytes, 2> surfaces;
  for (const auto profile : { EdgeIndexProfile::Small, EdgeIndexProfile::Working })
  {
    header.Settings.Profile = profile;
    MemoryDisk disk;
    WriteFile(disk, header, volume, 32);
    const auto file = OpenFile(disk);
    EXPECT_TRUE(file->Verify(1).IsOk());
    const std::size_t n = profile == EdgeIndexProfile::Working ? 1 : 0;
    for (std::size_t entry = 0; entry < file->GetEntries().size(); ++entry)
    {
      std::vector<std::uint8_t> record;
      ASSERT_TRUE(file->ReadRecord(entry, record).IsOk());
      auto& bytes = file->GetEntries()[entry].Block.IsPreview ? previews[n] : surfaces[n];
      bytes.insert(bytes.end(), record.begin(), record.end());
    }
  }
  EXPECT_FALSE(previews[0].empty());
  EXPECT_EQ(previews[0], previews[1]);
  EXPECT_NE(surfaces[0], surfaces[1]);
}

TEST(EdgeIndexFile, PiecesMakeTheWholeSurface)
{
  const auto volume = MakeWaves<std::uint8_t>({ 64, 48, 40 }, 0.2);
  MemoryDisk disk;
  WriteFile(disk, MakeFileHeader(volume, { 120.5, 150 }), volume, 16);
  const auto file = OpenFile(disk);
  const ContourRequest request = MakeRequest({});
  const auto whole = Require(file->Read({}, request, 1));
  for (const int pieces : { 1, 2, 7, 100 })
  {
    std::size_t triangles = 0;
    std::size_t most = 0;
    std::set<std::int64_t> ids;
    for (int piece = 0; piece < pieces; ++piece)
    {
      EdgeIndexSelection selection;
      selection.Piece = piece;
      selection.NumberOfPieces = pieces;
      const auto part = Require(file->Read(selection, request, 1));
      triangles += part.NumberOfTriangles;
      most = std::max(most, part.NumberOfTriangles);
      ids.insert(part.GlobalIds.begin(), part.GlobalIds.end());
    }
    EXPECT_EQ(triangles, whole.NumberOfTriangles);
    EXPECT_EQ(ids, std::set<std::int64_t>(whole.GlobalIds.begin(), whole.GlobalIds.end()));
    if (pieces < 10)
    {
      EXPECT_LT(most, 2 * whole.NumberOfTriangles / static_cast<std::size_t>(pieces));
    }
  }
}

TEST(EdgeIndexFile, AFileThatIsStillBeingWrittenGivesItsCompleteBlocks)
{
  const auto volume = MakeWaves<std::uint8_t>({ 64, 48, 40 }, 0.2);
  TestBlockSource<std::uint8_t> source(volume, 16);
  EdgeIndexHeader header = MakeFileHeader(volume, { 120.5 });
  header.NumberOfBlocks = source.GetNumberOfBlocks();
  MemoryDisk disk;
  auto writer = Require(EdgeIndexFileWriter::Create(disk, Path, header));
  EdgeIndexEncoder encoder(header);
  for (std::size_t block = 0; block < 5; ++block)
  {
    std::vector<std::uint8_t> bytes;
    const auto samples = source.Acquire(block);
    ASSERT_TRUE(
      encoder.EncodeBlock(source.GetLatticeCoordinates(block), *samples, 0, bytes).IsOk());
    ASSERT_TRUE(writer->Append(bytes.data(), bytes.size()).IsOk());
  }
  EXPECT_FALSE(disk.Exists(Path));
  const auto file = OpenFile(disk, PartialPath);
  EXPECT_FALSE(file->IsComplete());
  EXPECT_NE(file->GetMissing().find("of at most 36"), std::string::npos) << file->GetMissing();
  EXPECT_EQ(file->Verify(1).GetCode(), StatusCode::Corrupt);
  TestBlockSource<std::uint8_t> part(volume, 16);
  part.Blocks.resize(5);
  const ContourRequest request = MakeRequest({ 120.5 });
  const auto expected = ExtractSurface(volume.Geometry, part, request, 1);
  const auto read = Require(file->Read({}, request, 1));
  ExpectSameTopology(*expected, read);
}

TEST(EdgeIndexFile, EveryCutLeavesTheBlocksBeforeIt)
{
  MemoryDisk disk;
  const MemoryDisk::Bytes whole = WriteSmallFile(disk);
  const auto file = OpenFile(disk);
  const std::vector<EdgeIndexEntry> entries = file->GetEntries();
  ASSERT_GE(CountBlocks(*file, false), 3u);
  ASSERT_GE(CountBlocks(*file, true), 3u);
  for (std::size_t size = 0; size < whole.size(); ++size)
  {
    disk.GetFile(Path).assign(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size));
    const auto cut = EdgeIndexFile::Open(disk, Path);
    if (size < entries.front().Offset)
    {
      EXPECT_EQ(cut.GetStatus().GetCode(), StatusCode::Corrupt) << size;
      continue;
    }
    ASSERT_TRUE(cut.IsOk()) << size;
    EXPECT_FALSE((*cut)->IsComplete()) << size;
    const auto complete = std::count_if(entries.begin(), entries.end(),
      [size](const EdgeIndexEntry& entry) { return entry.Offset + entry.Size <= size; });
    ASSERT_EQ((*cut)->GetEntries().size(), static_cast<std::size_t>(complete)) << size;
  }
}

TEST(EdgeIndexFile, AShortFileIsCutOffOnlyIfItHasTheMagicNumber)
{
  MemoryDisk disk;
  const MemoryDisk::Bytes good = WriteSmallFile(disk);
  const std::string text = "A note that has nothing to do with surfaces.";
  disk.GetFile(Path).assign(text.begin(), text.end());
  const Status other = EdgeIndexFile::Open(disk, Path).GetStatus();
  ExpectError(other, StatusCode::Corrupt, "not an edge-index stream");
  for (const std::ptrdiff_t size : { 9, 12, 100, 263 })
  {
    disk.GetFile(Path).assign(good.begin(), good.begin() + size);
    const Status status = EdgeIndexFile::Open(disk, Path).GetStatus();
    ExpectError(status, StatusCode::Corrupt, "cut off");
  }
}

TEST(EdgeIndexFile, EveryFlippedByteIsFound)
{
  MemoryDisk disk;
  const MemoryDisk::Bytes whole = WriteSmallFile(disk);
  for (std::size_t n = 0; n < whole.size(); ++n)
  {
    for (const unsigned flip : { 255u, 1u << (n % 8) })
    {
      disk.GetFile(Path) = whole;
      disk.GetFile(Path)[n] = static_cast<std::uint8_t>(whole[n] ^ flip);
      const auto file = EdgeIndexFile::Open(disk, Path);
      EXPECT_FALSE(file.IsOk() && (*file)->Verify(1).IsOk()) << n;
    }
  }
}

TEST(EdgeIndexFile, ADamagedDirectoryLosesNoBlock)
{
  MemoryDisk disk;
  const MemoryDisk::Bytes whole = WriteSmallFile(disk);
  const std::size_t blocks = OpenFile(disk)->GetEntries().size();
  disk.GetFile(Path).back() ^= 1;
  const auto file = OpenFile(disk);
  EXPECT_FALSE(file->IsComplete());
  EXPECT_NE(file->GetMissing().find("directory"), std::string::npos);
  EXPECT_EQ(file->GetEntries().size(), blocks);
}

TEST(EdgeIndexFile, OpeningReadsHeaderAndDirectoryOnly)
{
  const auto volume = MakeWaves<std::uint8_t>({ 129, 129, 65 }, 0.5);
  MemoryDisk disk;
  WriteFile(disk, MakeFileHeader(volume, { 120.5 }), volume, 32);
  OpenFile(disk);
  EXPECT_LT(disk.GetBytesRead(Path), disk.GetFile(Path).size() / 20);
}

TEST(EdgeIndexFile, AFailedWriteLeavesTheOldFile)
{
  const auto volume = MakeWaves<std::uint8_t>({ 40, 36, 33 }, 0.2);
  const EdgeIndexHeader header = MakeFileHeader(volume, { 120.5 });
  for (std::uint64_t write = 0;; ++write)
  {
    MemoryDisk disk;
    ASSERT_TRUE(disk.CreateForWriting(Path).IsOk());
    disk.GetFile(Path) = { 1, 2, 3 };
    disk.FailFromWrite(write);
    TestBlockSource<std::uint8_t> source(volume, 16);
    const Status status = WriteEdgeIndexFile(disk, Path, header, source, 1);
    EXPECT_FALSE(disk.Exists(PartialPath)) << write;
    if (status.IsOk())
    {
      break;
    }
    EXPECT_EQ(status.GetCode(), StatusCode::IoError);
    if (disk.GetWrites() <= write + 1 && disk.GetFile(Path).size() != 3)
    {
      // Only the folder was not synchronised: the file is there.
      EXPECT_TRUE(OpenFile(disk)->Verify(1).IsOk());
      continue;
    }
    EXPECT_EQ(disk.GetFile(Path).size(), 3u) << write;
  }
}

TEST(EdgeIndexFile, ASecondWriterIsRefusedUntilTheFirstOneIsGone)
{
  FileSystem& disk = GetLocalFileSystem();
  const std::string folder =
    testing::TempDir() + "isosurface-two-writers-" + std::to_string(::getpid());
  ASSERT_TRUE(disk.MakeDirectories(folder).IsOk());
  const std::string path = folder + "/surface.eix";
  const auto volume = MakeWaves<std::uint8_t>({ 40, 36, 33 }, 0.2);
  const EdgeIndexHeader header = MakeFileHeader(volume, { 120.5 });
  const auto write = [&](const std::string& to)
  {
    TestBlockSource<std::uint8_t> source(volume, 16);
    return WriteEdgeIndexFile(disk, to, header, source, 1);
  };
  ASSERT_TRUE(write(path).IsOk());
  const auto size = [&] { return (*disk.OpenForReading(path))->GetSize(); };
  const std::uint64_t whole = size();
  for (const bool isFinished : { false, true })
  {
    auto first = Require(EdgeIndexFileWriter::Create(disk, path, header));

    // A single writer and a job of ranks, while the first one is at work.
    SerialCommunicator alone;
    TestBlockSource<std::uint8_t> source(volume, 16);
    const std::vector<std::int64_t> numbers;
    EdgeIndexWriteJob job(alone, disk, path, header, source, numbers, {});
    for (const Status& status : { write(path), job.Run().GetStatus() })
    {
      EXPECT_EQ(status.GetCode(), StatusCode::IoError);
      EXPECT_EQ(status.GetMessage().find(path), 0u) << status.GetMessage();
      ExpectMessage(status, "another program is writing there");
    }
    EXPECT_EQ(size(), whole) << "the old file was touched";
    EXPECT_TRUE(disk.Exists(EdgeIndexFileWriter::GetPartialPath(path)))
      << "the first writer's file is gone";
    if (isFinished)
    {
      EXPECT_TRUE(first->Finish().IsOk());
      EXPECT_TRUE((*EdgeIndexFile::Open(disk, path))->IsComplete());
      EXPECT_LT(size(), whole) << "a file without blocks";
    }
  }
  EXPECT_TRUE(write(path).IsOk()) << "the lock outlived its holder";
  EXPECT_EQ(size(), whole);
  ASSERT_TRUE(disk.RemoveAll(folder).IsOk());
}

TEST(EdgeIndexFile, SelectionsThatTheFileDoesNotHaveAreRefused)
{
  const auto volume = MakeWaves<std::uint8_t>({ 20, 20, 20 }, 0.2);
  EdgeIndexHeader header = MakeFileHeader(volume, { 120.5 });
  header.PreviewLevel = 0;
  MemoryDisk disk;
  WriteFile(disk, header, volume, 16);
  const auto file = OpenFile(disk);
  const auto expectRefused = [&](const EdgeIndexSelection& selection)
  {
    const Status status = file->Read(selection, MakeRequest({}), 1).GetStatus();
    EXPECT_EQ(status.GetCode(), StatusCode::InvalidArgument) << status.GetMessage();
  };
  EdgeIndexSelection selection;
  selection.Preview = true;
  expectRefused(selection);
  selection = {};
  selection.Isovalues = { 1 };
  expectRefused(selection);
  selection = {};
  selection.Piece = 2;
  selection.NumberOfPieces = 2;
  expectRefused(selection);
  EXPECT_EQ(
    EdgeIndexFile::Open(disk, "/data/none.eix").GetStatus().GetCode(), StatusCode::NotFound);
}

TEST(EdgeIndexFile, InvalidHeadersAreRefused)
{
  const auto volume = MakeWaves<std::uint8_t>({ 20, 20, 20 }, 0.2);
  MemoryDisk disk;
  for (const auto change :
    std::initializer_list<void (*)(EdgeIndexHeader&)>{ [](EdgeIndexHeader& header)
      { header.PreviewLevel = 7; },
      [](EdgeIndexHeader& header) { header.PreviewMaximumError = 0; },
      [](EdgeIndexHeader& header) { header.Array.assign(70000, 'a'); } })
  {
    EdgeIndexHeader header = MakeFileHeader(volume, { 120.5 });
    change(header);
    EXPECT_FALSE(EdgeIndexFileWriter::Create(disk, Path, header).IsOk());
  }
}
