// SPDX-License-Identifier: BSD-3-Clause
// What the reader gives to consumers that know nothing of blocked volumes.
#include "BlockChecks.h"
#include "ScratchFolder.h"
#include "TestVolumes.h"

#include "vtkBlockedVolumeReader.h"

#include "vtkDataArray.h"
#include "vtkInformation.h"
#include "vtkInformationInformationVectorKey.h"
#include "vtkPartitionedDataSet.h"
#include "vtkPointData.h"
#include "vtkStreamingDemandDrivenPipeline.h"
#include "vtkUnsignedCharArray.h"
#include "vtkVersionMacros.h"

#include <algorithm>

using namespace isosurface;

namespace
{

// Lengths that are no multiples of anything; several blocks each way.
const Extent LargeExtent{ -20, 109, 3, 123, 0, 98 };

vtkSmartPointer<vtkImageData> MakeLargeImage()
{
  auto image = MakeImage(LargeExtent, VTK_FLOAT, MakeNoise(30000, 1));
  TurnObliquely(image);
  return image;
}

TEST(BlockedVolumeReader, GivesFinestLevelThatFitsMemoryLimit)
{
  const auto image = MakeLargeImage();
  const ScratchVolume volume(image, { 32, 4 });
  const auto reader = MakeReader(volume.Path);
  const ExpectNoErrors errors(reader);
  int expectedLevel = 0;
  for (const int limit : { 16, 4, 1 })
  {
    reader->SetMemoryLimit(limit);
    const auto blocks = ReadPiece(reader, 0, 1);
    EXPECT_EQ(reader->GetLevel(), expectedLevel) << "of " << limit << " MiB";
    // Samples alone: ghost marks and headers come on top.
    std::size_t bytes = 0;
    for (unsigned int index = 0; index < blocks->GetNumberOfPartitions(); ++index)
    {
      bytes += 4 * static_cast<std::size_t>(blocks->GetPartition(index)->GetNumberOfPoints());
    }
    EXPECT_LE(bytes, static_cast<std::size_t>(limit) << 20);
    const BlockChecks checks{ image, expectedLevel };
    EXPECT_TRUE(checks.HaveValues({ blocks }, "density"));
    EXPECT_TRUE(checks.HaveEachCellOnce({ blocks }));
    ++expectedLevel;
  }
}

#if VTK_VERSION_NUMBER >= VTK_VERSION_CHECK(9, 2, 0) // whose attributes have ranges

TEST(BlockedVolumeReader, TellsRangesOfTheVolumeThroughItsAttributesToo)
{
  const auto image = MakeLargeImage();
  image->SetScalarComponentFromDouble(-19, 4, 1, 0, 1e6); // of level 0 alone
  double expected[2];
  image->GetPointData()->GetScalars()->GetRange(expected);
  const ScratchVolume volume(image, { 32, 4 });
  const auto reader = MakeReader(volume.Path);
  reader->SetMemoryLimit(1);
  const auto blocks = ReadPiece(reader, 1, 2); // with ghosts
  ASSERT_GT(reader->GetLevel(), 0);
  vtkPointData* arrays = blocks->GetPartition(0)->GetPointData();
  double range[2];
  ASSERT_TRUE(arrays->GetRange("density", range, 0));
  EXPECT_EQ(range[0], expected[0]);
  EXPECT_EQ(range[1], expected[1]);
  // A copy that owns its samples knows those alone.
  vtkNew<vtkPointData> copy;
  copy->DeepCopy(arrays);
  ASSERT_TRUE(copy->GetRange("density", range, 0));
  EXPECT_LT(range[1], expected[1]);
}

#endif

TEST(BlockedVolumeReader, TellsRangesOfGhostsWithoutALookAtThem)
{
  const ScratchVolume volume(MakeLargeImage(), { 32, 4 });
  const auto reader = MakeReader(volume.Path);
  const auto blocks = ReadPiece(reader, 1, 2);
  vtkDataSet* part = blocks->GetPartition(0);
  for (vtkUnsignedCharArray* ghosts : { part->GetPointGhostArray(), part->GetCellGhostArray() })
  {
    ASSERT_TRUE(ghosts);
    EXPECT_TRUE(ghosts->GetInformation()->Has(vtkDataArray::PER_COMPONENT()));
    unsigned char* values = ghosts->GetPointer(0);
    const auto [least, most] = std::minmax_element(values, values + ghosts->GetNumberOfValues());
    EXPECT_GT(*most, 0);
    double range[2];
    ghosts->GetRange(range);
    EXPECT_EQ(range[0], *least);
    EXPECT_EQ(range[1], *most);
  }
}

TEST(BlockedVolumeReader, GivesFinerLevelToPiecesThanToWhole)
{
  const ScratchVolume volume(MakeLargeImage(), { 32, 7 });
  const auto reader = MakeReader(volume.Path);
  reader->SetMemoryLimit(2);
  ReadPiece(reader, 0, 1);
  EXPECT_EQ(reader->GetLevel(), 1);
  ReadPiece(reader, 0, 7);
  EXPECT_EQ(reader->GetLevel(), 0);
}

TEST(BlockedVolumeReader, PiecesTogetherHaveEachCellOnce)
{
  const ScratchFolder folder;
  const auto image = MakeImage({ -5, 60, 0, 40, 7, 50 }, VTK_SHORT, MakeNoise(3000, 2));
  for (const int stores : { 1, 4 })
  {
    const std::string path = folder.GetPath(std::to_string(stores) + ".bvol");
    WriteVolume(image, path, { 16, stores, vtkBlockedVolumeWriter::RANDOM });
    for (const int pieces : { 1, 2, 3, 7 })
    {
      const auto reader = MakeReader(path);
      std::vector<vtkSmartPointer<vtkPartitionedDataSet>> kept;
      std::vector<vtkPartitionedDataSet*> all;
      for (int piece = 0; piece < pieces; ++piece)
      {
        kept.push_back(ReadPiece(reader, piece, pieces));
        all.push_back(kept.back());
        EXPECT_LE(kept.back()->GetNumberOfPartitions(), 1u) << "one image a piece";
      }
      EXPECT_TRUE((BlockChecks{ image }.HaveEachCellOnce(all))) << stores << ", " << pieces;
      EXPECT_TRUE((BlockChecks{ image }.HaveValues(all, "density"))) << stores << ", " << pieces;
    }
  }
}

TEST(BlockedVolumeReader, GivesSelectedArraysAlone)
{
  const auto image = MakeImage({ 0, 30, 0, 20, 0, 20 }, VTK_SHORT, MakeNoise(3000, 2));
  const auto other = MakeImage({ 0, 30, 0, 20, 0, 20 }, VTK_DOUBLE, MakeNoise(99, 3));
  other->GetPointData()->GetScalars()->SetName("pressure");
  image->GetPointData()->AddArray(other->GetPointData()->GetScalars());
  const ScratchVolume volume(image);

  const auto reader = MakeReader(volume.Path);
  reader->UpdateInformation();
  ASSERT_EQ(reader->GetNumberOfPointArrays(), 2);
  EXPECT_STREQ(reader->GetPointArrayName(0), "density");
  EXPECT_STREQ(reader->GetPointArrayName(1), "pressure");
  auto names = [&]()
  {
    const auto blocks = ReadPiece(reader, 0, 1);
    std::vector<std::string> found;
    vtkPointData* points = blocks->GetPartition(0)->GetPointData();
    for (int index = 0; index < points->GetNumberOfArrays(); ++index)
    {
      found.emplace_back(points->GetArrayName(index));
    }
    for (const std::string& name : found)
    {
      EXPECT_TRUE((BlockChecks{ image }.HaveValues({ blocks }, name.c_str()))) << name;
    }
    return found;
  };
  using Names = std::vector<std::string>;
  EXPECT_EQ(names(), (Names{ "density", "pressure" }));
  reader->SetPointArrayStatus("density", 0);
  EXPECT_EQ(reader->GetPointArrayStatus("density"), 0);
  EXPECT_EQ(names(), (Names{ "pressure" }));
  reader->SetPointArrayStatus("pressure", 0);
  EXPECT_EQ(names(), Names());
  reader->SetPointArrayStatus("density", 1);
  EXPECT_EQ(names(), (Names{ "density" }));
}

TEST(BlockedVolumeReader, CanReadBlockedVolumesAlone)
{
  const ScratchFolder folder;
  const std::string path = folder.GetPath("volume.bvol");
  for (const int stores : { 1, 70 })
  {
    // Many stores make a header in which the format's name stands far behind.
    WriteVolume(MakeImage({ 0, 9, 0, 9, 0, 9 }, VTK_CHAR, MakeNoise(9, 1)), path, { 16, stores });
    EXPECT_TRUE(vtkBlockedVolumeReader::CanReadFile(path.c_str())) << stores;
  }
  EXPECT_FALSE(vtkBlockedVolumeReader::CanReadFile(nullptr));
  EXPECT_FALSE(vtkBlockedVolumeReader::CanReadFile(""));
  EXPECT_FALSE(vtkBlockedVolumeReader::CanReadFile(folder.GetPath("missing.bvol").c_str()));
  EXPECT_FALSE(vtkBlockedVolumeReader::CanReadFile(folder.GetPath("").c_str())) << "a folder";
  const std::string other = folder.GetPath("other.bvol");
  for (const std::string& bytes : { std::string(), std::string("{"), std::string("{}\n"),
         std::string("some text"), std::string(5000, '\0'),
         std::string("\x7f"
                     "ELF\2\1\1\0",
           8),
         std::string("{ \"format\": \"another\" }") })
  {
    WriteBytes(other, bytes);
    EXPECT_FALSE(vtkBlockedVolumeReader::CanReadFile(other.c_str())) << bytes.substr(0, 30);
  }
}

TEST(BlockedVolumeReader, ReadsRewrittenFileWhenModified)
{
  const auto first = MakeImage({ 0, 30, 0, 20, 0, 20 }, VTK_SHORT, MakeNoise(3000, 2));
  const auto second = MakeImage({ 0, 25, -3, 20, 0, 33 }, VTK_FLOAT, MakeNoise(3000, 3));
  second->GetPointData()->GetScalars()->SetName("pressure");
  const ScratchVolume volume(first);
  const auto reader = MakeReader(volume.Path);
  const ExpectNoErrors errors(reader);
  EXPECT_TRUE((BlockChecks{ first }.HaveValues({ ReadPiece(reader, 0, 1) }, "density")));

  WriteVolume(second, volume.Path, { 32, 2 });
  reader->Modified();
  const auto blocks = ReadPiece(reader, 0, 1);
  EXPECT_TRUE((BlockChecks{ second }.HaveValues({ blocks }, "pressure")));
  EXPECT_TRUE((BlockChecks{ second }.HaveEachCellOnce({ blocks })));
  EXPECT_EQ(reader->GetNumberOfPointArrays(), 1) << "arrays of the old file are gone";

  // The same grid and array with other values: nothing may come from the cache of the old one.
  const auto third = MakeImage({ 0, 25, -3, 20, 0, 33 }, VTK_FLOAT, MakeNoise(3000, 4));
  third->GetPointData()->GetScalars()->SetName("pressure");
  WriteVolume(third, volume.Path, { 32, 2 });
  reader->Modified();
  EXPECT_TRUE((BlockChecks{ third }.HaveValues({ ReadPiece(reader, 0, 1) }, "pressure")));
}

TEST(BlockedVolumeReader, RewrittenFileIsNeverMixedWithOldOne)
{
  const auto first = MakeImage({ 0, 40, 0, 40, 0, 40 }, VTK_SHORT, MakeNoise(3000, 2));
  const auto second = MakeImage({ 0, 40, 0, 40, 0, 40 }, VTK_SHORT, MakeNoise(3000, 3));
  const ScratchVolume volume(first, { 16, 3 });
  const auto reader = MakeReader(volume.Path);
  const ErrorCounter errors(reader);
  reader->UpdateInformation();
  // Nobody tells the reader, which has seen the header of the first one.
  WriteVolume(second, volume.Path, { 16, 3 });
  reader->UpdatePiece(0, 1, 0);
  ExpectOneError(errors, { "rewritten" });
  EXPECT_EQ(reader->GetOutput()->GetNumberOfPartitions(), 0u);
  reader->Modified();
  EXPECT_TRUE((BlockChecks{ second }.HaveValues({ ReadPiece(reader, 0, 1) }, "density")));
}

TEST(BlockedVolumeReader, TellsTimeOfTheOneStep)
{
  const auto image = MakeImage({ 0, 9, 0, 9, 0, 9 }, VTK_SHORT, MakeNoise(3000, 2));
  image->GetInformation()->Set(vtkDataObject::DATA_TIME_STEP(), 2.5);
  const ScratchVolume volume(image);
  const auto reader = MakeReader(volume.Path);
  reader->Update();
  vtkInformation* info = reader->GetOutputInformation(0);
  ASSERT_EQ(info->Length(vtkStreamingDemandDrivenPipeline::TIME_STEPS()), 1);
  EXPECT_EQ(info->Get(vtkStreamingDemandDrivenPipeline::TIME_STEPS(), 0), 2.5);
  EXPECT_EQ(reader->GetOutput()->GetInformation()->Get(vtkDataObject::DATA_TIME_STEP()), 2.5);
}

} // namespace
