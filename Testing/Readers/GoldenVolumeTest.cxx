// SPDX-License-Identifier: BSD-3-Clause Files of every released format version stay readable, and
// keep their meaning. The numbers compared here were computed when the files were written; neither
// may change together with the code.
#include "BlockChecks.h"
#include "Fixtures/ResealedPages.h"
#include "ScratchFolder.h"
#include "TestVolumes.h"
#include "VolumeDamage.h"

#include "vtkBlockedVolumeReader.h"
#include "vtkStabbingContour.h"

#include "vtkExecutive.h"
#include "vtkInformation.h"
#include "vtkPartitionedDataSet.h"
#include "vtkPointData.h"
#include "vtkPolyData.h"
#include "vtkRectilinearGrid.h"

#include "Formats/Opener/ForeignVolume.h"
#include "RectilinearGrids.h"
#include "Storage/Store/BlockedVolumeHeader.h"
#include "Storage/Verification/VolumeVerification.h"

#include <array>
#include <filesystem>

#include <fcntl.h>
#include <sys/stat.h>

using namespace isosurface;

namespace
{

std::string GetDataPath(const std::string& name)
{
  return std::string(ISOSURFACE_TEST_DATA) + "/" + name;
}

// The contents, computed by a formula in integers.
vtkSmartPointer<vtkImageData> MakeGoldenImage()
{
  const Extent extent{ -3, 17, 5, 21, 0, 17 };
  auto image = MakeImage(extent, VTK_SHORT,
    [](int i, int j, int k) { return (7 * i * i + 11 * j * k + 13 * k) % 40 - 10; });
  const auto other = MakeImage(
    extent, VTK_UNSIGNED_CHAR, [](int i, int j, int k) { return (i * i + j * j + k * k) / 20; });
  other->GetPointData()->GetScalars()->SetName("distance");
  image->GetPointData()->AddArray(other->GetPointData()->GetScalars());
  image->SetOrigin(10, -20, 0.5);
  image->SetSpacing(0.5, 1, 2);
  image->SetDirectionMatrix(0, -1, 0, 1, 0, 0, 0, 0, 1);
  return image;
}

// The same samples, at places that are exact in binary.
vtkSmartPointer<vtkRectilinearGrid> MakeGoldenRectilinearGrid()
{
  const auto image = MakeGoldenImage();
  GridLines lines;
  for (int axis = 0; axis < 3; ++axis)
  {
    for (int n = 0; n < image->GetDimensions()[axis]; ++n)
    {
      lines.Coordinates[static_cast<std::size_t>(axis)].push_back(n * (n + 4) / 8.0 - axis);
    }
  }
  return MakeRectilinearGrid(image, lines);
}

constexpr vtkIdType DensityTriangles = 13488;
constexpr vtkIdType DensityPoints = 8147;
constexpr vtkIdType DistanceTriangles = 941;
constexpr vtkIdType DistancePoints = 514;

// Not compressed: another version of a compression library may find other bytes.
constexpr VolumeSettings GoldenSettings{ 16, 2, vtkBlockedVolumeWriter::GREEDY,
  vtkBlockedVolumeWriter::NONE };

vtkSmartPointer<vtkPolyData> ContourFile(
  const std::string& path, const char* array, double isovalue, int level = 0)
{
  vtkNew<vtkBlockedVolumeReader> reader;
  vtkNew<vtkStabbingContour> contour;
  const ExpectNoErrors readerErrors(reader);
  const ExpectNoErrors errors(contour);
  reader->SetFileName(path.c_str());
  contour->SetInputConnection(reader->GetOutputPort());
  SelectPoints(contour, array);
  contour->SetValue(0, isovalue);
  contour->SetLevel(level);
  contour->Update();
  return contour->GetOutput();
}

const std::string GoldenPath = GetDataPath("blocked-volume/golden.bvol");

TEST(VolumesOfRelease1, HaveTheValuesTheyWereWrittenWith)
{
  const auto reader = MakeReader(GoldenPath);
  const ExpectNoErrors errors(reader);
  const auto blocks = ReadPiece(reader, 0, 1);
  EXPECT_EQ(reader->GetLevel(), 0);
  const auto image = MakeGoldenImage();
  const BlockChecks checks{ image };
  EXPECT_TRUE(checks.HaveValues({ blocks }, "density"));
  EXPECT_TRUE(checks.HaveValues({ blocks }, "distance"));
  EXPECT_TRUE(checks.HaveEachCellOnce({ blocks }));
}

TEST(VolumesOfRelease1, HaveTheSurfaceTheyWereWrittenWith)
{
  const auto density = ContourFile(GoldenPath, "density", 15.5);
  EXPECT_EQ(density->GetNumberOfPolys(), DensityTriangles);
  EXPECT_EQ(density->GetNumberOfPoints(), DensityPoints);
  EXPECT_EQ(GetCost(density, "ActiveBlocks"), 4u);
  const auto distance = ContourFile(GoldenPath, "distance", 12);
  EXPECT_EQ(distance->GetNumberOfPolys(), DistanceTriangles);
  EXPECT_EQ(distance->GetNumberOfPoints(), DistancePoints);

  EXPECT_TRUE(IsSurfaceOf(density, MakeGoldenImage(), 15.5));
}

// What the libraries of compression write may change; what they read may not.
TEST(VolumesOfRelease1, AreReadWithEachCodec)
{
  for (const char* volume : { "lz4.bvol", "zstd.bvol" })
  {
    const std::string path = GetDataPath(std::string("blocked-volume/") + volume);
    const auto header = BlockedVolumeHeader::Read(GetLocalFileSystem(), path);
    ASSERT_TRUE(header.IsOk()) << header.GetStatus().GetMessage();
    EXPECT_NE(header->Compression.Codec, SegmentCodec::None);
    const auto verified = VerifyBlockedVolume(path, GetLocalFileSystem(), 2);
    ASSERT_TRUE(verified.IsOk());
    EXPECT_EQ(verified->FaultCount, 0u);
    EXPECT_TRUE(IsSurfaceOf(ContourFile(path, "density", 15.5), MakeGoldenImage(), 15.5));
    EXPECT_EQ(ContourFile(path, "distance", 12)->GetNumberOfPolys(), DistanceTriangles);
  }
}

TEST(VolumesOfRelease1, HaveTheSurfaceOfTheSubsampledImageAtEveryLevel)
{
  for (int level = 0; level < 5; ++level)
  {
    const auto expected = ContourByFlyingEdges(SubsampleImage(MakeGoldenImage(), level), 15.5);
    EXPECT_TRUE(AreEqual(ToEdges(ContourFile(GoldenPath, "density", 15.5, level)), expected))
      << "level " << level;
  }
}

TEST(VolumesOfRelease1, TakeAnotherTimeStep)
{
  const ScratchFolder folder;
  const std::string path = folder.GetPath("golden.bvol");
  CopyVolume(GoldenPath, path);
  FileSystem& files = GetLocalFileSystem();
  auto before = BlockedVolumeHeader::Read(files, path);
  ASSERT_TRUE(before.IsOk()) << before.GetStatus().GetMessage();
  before->TimeSteps[0].Time = 0;
  WriteBytes(path, before->Format());

  const auto image = MakeGoldenImage();
  image->GetInformation()->Set(vtkDataObject::DATA_TIME_STEP(), 1);
  vtkNew<vtkBlockedVolumeWriter> writer;
  const ExpectNoErrors errors(writer);
  writer->SetInputData(image);
  writer->SetFileName(path.c_str());
  writer->SetBlockSize(16);
  writer->SetCompression(vtkBlockedVolumeWriter::NONE);
  writer->AppendTimeStepOn();
  writer->Write();
  const auto after = BlockedVolumeHeader::Read(files, path);
  ASSERT_TRUE(after.IsOk()) << after.GetStatus().GetMessage();
  EXPECT_EQ(after->NumberOfLevels, before->NumberOfLevels);
  EXPECT_EQ(after->Overviews.size(), before->Overviews.size());
  ASSERT_EQ(after->TimeSteps.size(), 2u);
  for (std::size_t store = 0; store < 2; ++store)
  {
    const StoreDescription& old = after->TimeSteps[0].Stores[store];
    EXPECT_EQ(after->TimeSteps[1].Stores[store].Checksum, old.Checksum);
    EXPECT_EQ(after->TimeSteps[1].Stores[store].Bytes, old.Bytes);
  }
  const auto verified = VerifyBlockedVolume(path, files, 2);
  ASSERT_TRUE(verified.IsOk());
  EXPECT_EQ(verified->FaultCount, 0u);
}

/// Takes the seals off a volume, and what they stand for: the golden ones have none.
void RemoveSeals(const std::string& path)
{
  auto header = BlockedVolumeHeader::Read(GetLocalFileSystem(), path);
  ASSERT_TRUE(header.IsOk()) << header.GetStatus().GetMessage();
  TimeStepDescription& step = header->TimeSteps[0];
  step.Overviews.push_back(step.Stores);
  for (std::vector<StoreDescription>& stores : step.Overviews)
  {
    for (StoreDescription& store : stores)
    {
      EXPECT_FALSE(store.Seals.empty());
      store.Seals.clear();
    }
  }
  step.Stores = step.Overviews.back();
  step.Overviews.pop_back();
  WriteBytes(path, header->Format());
  for (const auto& file : std::filesystem::recursive_directory_iterator(path + ".stores"))
  {
    if (file.path().extension() == ".tree" || file.path().filename() == "directory")
    {
      const std::string text = ReadBytes(file.path().string());
      std::vector<std::uint8_t> bytes(text.begin(), text.end());
      RemoveSums(bytes);
      WriteBytes(file.path().string(), std::string(bytes.begin(), bytes.end()));
    }
  }
}

void ExpectFilesOf(
  vtkDataObject* input, const std::string& volume, int replicas = 0, bool isSealed = false)
{
  const ScratchFolder folder;
  const std::string path = folder.GetPath(volume);
  VolumeSettings settings = GoldenSettings;
  settings.NumberOfReplicas = replicas;
  std::filesystem::create_directory(path + ".stores"); // release 1 did not hide it
  WriteVolume(input, path, settings);
  const std::vector<std::string> names = ListVolumeFiles(GetDataPath("blocked-volume/" + volume));
  if (!isSealed)
  {
    RemoveSeals(path);
  }
  for (const std::string& name : names)
  {
    EXPECT_TRUE(ReadBytes(folder.GetPath(name)) == ReadBytes(GetDataPath("blocked-volume/" + name)))
      << name << " differs: a change of format needs a new version, specification and golden file";
  }
  EXPECT_EQ(ListVolumeFiles(path), names);
}

TEST(VolumesOfRelease1, WithSealsAreWrittenByteForByteToday)
{
  ExpectFilesOf(MakeGoldenImage(), "sealed.bvol", 0, true);
}

TEST(VolumesOfRelease1, WithSealsHaveTheirSurfaceAndNoOtherOnesTrees)
{
  const ScratchFolder folder;
  const std::string path = folder.GetPath("sealed.bvol");
  CopyVolume(GetDataPath("blocked-volume/sealed.bvol"), path);
  const auto verified = VerifyBlockedVolume(path, GetLocalFileSystem(), 2);
  ASSERT_TRUE(verified.IsOk());
  EXPECT_EQ(verified->FaultCount, 0u);
  EXPECT_TRUE(IsSurfaceOf(ContourFile(path, "density", 15.5), MakeGoldenImage(), 15.5));

  // That of the same store without seals, whose own checksums are right.
  const std::string tree = ".stores/000001/store-00000/array-0.tree";
  WriteBytes(path + tree, ReadBytes(GoldenPath + tree));
  const auto reader = MakeReader(path);
  const auto contour = MakeContour(reader, 15.5);
  const ErrorCounter errors(contour);
  contour->Update();
  ASSERT_EQ(errors.Messages.size(), 1u);
  EXPECT_NE(errors.Messages[0].find(path + tree), std::string::npos) << errors.Messages[0];
  EXPECT_EQ(contour->GetOutput()->GetNumberOfPolys(), 0);
}

TEST(VolumesOfRelease1, AreWrittenByteForByteTodayButForTheSeals)
{
  ExpectFilesOf(MakeGoldenImage(), "golden.bvol");
}

TEST(VolumesOfRelease1, OfRectilinearGridsAreWrittenByteForByteTodayButForTheSeals)
{
  ExpectFilesOf(MakeGoldenRectilinearGrid(), "rectilinear.bvol");
}

TEST(VolumesOfRelease1, WithReplicasAreWrittenByteForByteTodayButForTheSeals)
{
  ExpectFilesOf(MakeGoldenImage(), "replicas.bvol", 2);
}

TEST(VolumesOfRelease1, WithReplicasHaveTheirSurfaceWithoutTheFilesOfAStore)
{
  for (const char* lost : { "store-00000", "store-00001" })
  {
    const ScratchFolder folder;
    const std::string path = folder.GetPath("replicas.bvol");
    CopyVolume(GetDataPath("blocked-volume/replicas.bvol"), path);
    std::filesystem::remove_all(path + ".stores/000001/" + lost);
    EXPECT_TRUE(IsSurfaceOf(ContourFile(path, "density", 15.5), MakeGoldenImage(), 15.5)) << lost;
  }
}

TEST(VolumesOfRelease1, OfRectilinearGridsHaveTheSurfaceTheyWereWrittenWith)
{
  const auto surface = ContourFile(GetDataPath("blocked-volume/rectilinear.bvol"), "density", 15.5);
  EXPECT_EQ(surface->GetNumberOfPolys(), DensityTriangles);
  EXPECT_EQ(surface->GetNumberOfPoints(), DensityPoints);
  EdgeSurface surfaces[2];
  surfaces[0].Add(surface);
  surfaces[1].Add(Contour(MakeGoldenRectilinearGrid(), { 15.5 }));
  EXPECT_TRUE(AreEqual(surfaces[0], surfaces[1]));
}

// The samples of "density" in a MetaImage of that time.
TEST(VolumesOfRelease1, AreReadInPlace)
{
  const ScratchFolder folder;
  const std::string path = folder.GetPath("in-place.bvol");
  CopyVolume(GetDataPath("blocked-volume/in-place.bvol"), path);
  const std::string source = folder.GetPath("in-place.mha");
  WriteBytes(source, ReadBytes(GetDataPath("blocked-volume/in-place.mha")));
  const std::array<timespec, 2> times = { timespec{ 1000000000, 0 }, timespec{ 1000000000, 0 } };
  ASSERT_EQ(::utimensat(AT_FDCWD, source.c_str(), times.data(), 0), 0);

  const auto header = BlockedVolumeHeader::Read(GetLocalFileSystem(), path);
  ASSERT_TRUE(header.IsOk()) << header.GetStatus().GetMessage();
  ASSERT_TRUE(header->IsInPlace());
  EXPECT_EQ(header->NumberOfLevels, 1);
  EXPECT_EQ(header->TimeSteps[0].Source->Path, "in-place.mha");
  const auto verified = VerifyBlockedVolume(path, GetLocalFileSystem(), 2, {}, OpenForeignVolume);
  ASSERT_TRUE(verified.IsOk());
  EXPECT_EQ(verified->FaultCount, 0u);

  const auto density = ContourFile(path, "MetaImage", 15.5);
  EXPECT_EQ(density->GetNumberOfPolys(), DensityTriangles);
  EXPECT_EQ(density->GetNumberOfPoints(), DensityPoints);
}

TEST(VolumesOfRelease1, EveryFlippedBitOfTheirHeaderIsNoticed)
{
  const ScratchFolder folder;
  const std::string path = folder.GetPath("golden.bvol");
  CopyVolume(GoldenPath, path);
  const std::string good = ReadBytes(path);
  const auto image = MakeGoldenImage();
  const auto reader = MakeReader(path);
  const ErrorCounter errors(reader);
  int accepted = 0;
  for (std::size_t byte = 0; byte < good.size(); ++byte)
  {
    std::string bad = good;
    bad[byte] ^= static_cast<char>(1 << (byte % 8));
    WriteBytes(path, bad);
    reader->Modified();
    const std::size_t before = errors.Messages.size();
    reader->Update();
    if (errors.Messages.size() == before)
    {
      // At most white space became other white space: the contents must be the same.
      ++accepted;
      EXPECT_TRUE((BlockChecks{ image }.HaveValues({ reader->GetOutput() }, "density"))) << byte;
      continue;
    }
    ASSERT_EQ(errors.Messages.size(), before + 1) << byte;
    ASSERT_NE(errors.Messages.back().find("golden.bvol"), std::string::npos)
      << errors.Messages.back();
    ASSERT_EQ(reader->GetOutput()->GetNumberOfPartitions(), 0u);
  }
  EXPECT_LT(accepted, 20);
}

// Files that every version of the program must refuse, and how.
TEST(BadVolumes, AreRefusedWithFileAndReason)
{
  const std::vector<VolumeDamage> files = {
    { "corrupt-header.bvol", {}, "corrupt-header.bvol", "checksum" },
    { "newer-version.bvol", {}, "newer-version.bvol", "format version 99" },
  };
  for (const VolumeDamage& file : files)
  {
    EXPECT_TRUE(vtkBlockedVolumeReader::CanReadFile(GetDataPath(file.Name).c_str()));
    const auto reader = MakeReader(GetDataPath(file.Name));
    const ErrorCounter errors(reader);
    reader->Update();
    EXPECT_TRUE(IsOneMessageAbout(errors.Messages, file))
      << testing::PrintToString(errors.Messages);
  }
}

} // namespace
