// SPDX-License-Identifier: BSD-3-Clause
// Whatever is wrong on one rank: one message on all of them, nobody waits for ever, and all is well
// again once the cause is mended.
#include "ParallelVolumes.h"
#include "VolumeDamage.h"

#include "Ground/Base/FileSystem.h"
#include "vtkBlockedVolumeReader.h"
#include "vtkContourSpectrum.h"
#include "vtkExecutive.h"
#include "vtkMultiProcessController.h"
#include "vtkPartitionedDataSet.h"
#include "vtkStabbingContour.h"

#include <filesystem>

using namespace isosurface;

namespace
{

constexpr double ReadIsovalue = 120.0; // of noise: every block is active

// A reader with a contour behind it, whose errors are caught.
struct ListenedPipeline
{
  explicit ListenedPipeline(const std::string& path)
    : Pipeline(path)
    , ReaderErrors(this->Pipeline.Reader)
    , ContourErrors(this->Pipeline.Contour)
  {
    this->Pipeline.Contour->SetValue(0, ReadIsovalue);
  }

  // Collective; gives the messages of both classes.
  std::vector<std::string> Update()
  {
    this->ReaderErrors.Messages.clear();
    this->ContourErrors.Messages.clear();
    this->Pipeline.Contour->UpdatePiece(GetRank(), GetNumberOfRanks(), 0);
    std::vector<std::string> messages = this->ReaderErrors.Messages;
    messages.insert(
      messages.end(), this->ContourErrors.Messages.begin(), this->ContourErrors.Messages.end());
    return messages;
  }

  vtkIdType GetNumberOfPolys() { return this->Pipeline.Contour->GetOutput()->GetNumberOfPolys(); }

  ContourPipeline Pipeline;
  ErrorCounter ReaderErrors;
  ErrorCounter ContourErrors;
};

vtkSmartPointer<vtkImageData> MakeImageToRead()
{
  return MakeImage({ 0, 40, 0, 36, 0, 44 }, VTK_UNSIGNED_CHAR, MakeNoise(250, 3));
}

std::size_t CountTriangles(vtkImageData* image)
{
  return GetRank() == 0 ? ContourByFlyingEdges(image, ReadIsovalue).Triangles.size() : 0;
}

class ReadErrors : public testing::TestWithParam<VolumeDamage>
{
};

TEST_P(ReadErrors, AreToldOnceByEveryRank)
{
  const auto image = MakeImageToRead();
  const SharedVolume volume("ReadErrors-" + GetParam().Name, image, { 16, 3, 1 });
  OnFirstRank(
    [&]
    {
      std::filesystem::create_directory(volume.Folder.GetPath("good"));
      CopyVolume(volume.Path, volume.Folder.GetPath("good/volume.bvol"));
      GetParam().Apply(volume.Path);
    });

  ListenedPipeline listened(volume.Path);
  const std::vector<std::string> messages = listened.Update();
  EXPECT_TRUE(IsOneMessageAbout(messages, GetParam())) << testing::PrintToString(messages);
  EXPECT_EQ(listened.GetNumberOfPolys(), 0);
  GetRanks()->Barrier();

  OnFirstRank(
    [&]
    {
      std::filesystem::remove(volume.Path);
      std::filesystem::remove_all(HidePath(volume.Path + ".stores"));
      CopyVolume(volume.Folder.GetPath("good/volume.bvol"), volume.Path);
    });
  listened.Pipeline.Reader->Modified();
  EXPECT_EQ(listened.Update(), std::vector<std::string>());
  const auto triangles = SumOverRanks(static_cast<std::uint64_t>(listened.GetNumberOfPolys()));
  EXPECT_EQ(triangles, SumOverRanks(CountTriangles(image)));
}

std::string NameOfDamage(const testing::TestParamInfo<VolumeDamage>& info)
{
  return info.param.Name;
}

INSTANTIATE_TEST_SUITE_P(Damages, ReadErrors, testing::ValuesIn(MakeDamages()), NameOfDamage);

TEST(ReadErrorsOfOneRank, AreToldOnceByEveryRank)
{
  const auto image = MakeImageToRead();
  const SharedVolume volume("ReadErrorsOfOneRank", image, { 16, 3, 1 });
  ListenedPipeline listened(volume.Path);
  for (int failing = 0; failing < GetNumberOfRanks(); ++failing)
  {
    const std::string wrong = volume.Folder.GetPath("wrong.bvol");
    listened.Pipeline.Reader->SetFileName((failing == GetRank() ? wrong : volume.Path).c_str());
    listened.Pipeline.Reader->Modified();
    const std::vector<std::string> messages = listened.Update();
    EXPECT_TRUE(IsOneMessageAbout(messages, { "", {}, "wrong.bvol", "No such file" }))
      << testing::PrintToString(messages);

    listened.Pipeline.Reader->SetFileName(volume.Path.c_str());
    listened.Pipeline.Reader->Modified();
    EXPECT_EQ(listened.Update(), std::vector<std::string>());
    EXPECT_GT(SumOverRanks(static_cast<std::uint64_t>(listened.GetNumberOfPolys())), 0u);
  }
}

// An empty folder on one rank in place of the dataset: the user changes the isovalue, and again.
TEST(ReadErrorsOfOneRank, AreToldAtEveryFurtherIsovalue)
{
  const auto image = MakeImageToRead();
  const SharedVolume volume("FurtherIsovalues", image, { 16, 3, 1 });
  for (int failing = 0; failing < GetNumberOfRanks(); ++failing)
  {
    ListenedPipeline listened(volume.Path);
    const std::string wrong = volume.Folder.GetPath("empty/volume.bvol");
    listened.Pipeline.Reader->SetFileName((failing == GetRank() ? wrong : volume.Path).c_str());
    for (const double isovalue : { ReadIsovalue, 90.0, 60.0 })
    {
      listened.Pipeline.Contour->SetValue(0, isovalue);
      const std::vector<std::string> messages = listened.Update();
      EXPECT_TRUE(IsOneMessageAbout(messages, { "", {}, "empty/volume.bvol", "No such file" }))
        << "at " << isovalue << ": " << testing::PrintToString(messages);
      EXPECT_EQ(listened.GetNumberOfPolys(), 0);
    }
    listened.Pipeline.Reader->SetFileName(volume.Path.c_str());
    listened.Pipeline.Reader->Modified(); // on all ranks, as a reload does
    listened.Pipeline.Contour->SetValue(0, ReadIsovalue);
    EXPECT_EQ(listened.Update(), std::vector<std::string>());
    EXPECT_EQ(SumOverRanks(static_cast<std::uint64_t>(listened.GetNumberOfPolys())),
      SumOverRanks(CountTriangles(image)));
  }
}

TEST(ReadErrorsOfOneRank, AreToldAtEveryFurtherSpectrum)
{
  const SharedVolume volume("FurtherSpectra", MakeImageToRead(), { 16, 3, 1 });
  const int last = GetNumberOfRanks() - 1;
  const auto reader =
    MakeReader((GetRank() == last ? volume.Folder.GetPath("wrong.bvol") : volume.Path));
  vtkNew<vtkContourSpectrum> spectrum;
  spectrum->SetInputConnection(reader->GetOutputPort());
  const ExpectNoErrors ofSpectrum(spectrum);
  for (const int quantity : { 1, 0 })
  {
    const ErrorCounter errors(reader);
    spectrum->SetStoreQuantity(quantity);
    spectrum->UpdatePiece(GetRank(), GetNumberOfRanks(), 0);
    EXPECT_TRUE(IsOneMessageAbout(errors.Messages, { "", {}, "wrong.bvol", "No such file" }))
      << testing::PrintToString(errors.Messages);
  }
}

// The ranks of one job may see different disks under one volume.Path.
TEST(RanksThatSeeDifferentVolumes, AreToldAndGiveNoSurface)
{
  if (GetNumberOfRanks() == 1)
  {
    GTEST_SKIP() << "one rank agrees with itself";
  }
  const SharedFolder folder("DifferentVolumes");
  const std::string mine = folder.GetPath("mine.bvol");
  const std::string other = folder.GetPath("other.bvol");
  WriteFromPieces(MakeImageToRead(), PieceSource::SUB_EXTENTS, mine, { 16, 3, 1 });
  WriteFromPieces(MakeImage({ 0, 40, 0, 36, 0, 44 }, VTK_UNSIGNED_CHAR, MakeNoise(250, 4)),
    PieceSource::SUB_EXTENTS, other, { 16, 3, 1 });
  for (int odd = 1; odd < GetNumberOfRanks(); ++odd)
  {
    ListenedPipeline listened(odd == GetRank() ? other : mine);
    const std::string reason =
      "different files under this path, or the same one before and after it was written; reload it "
      "(rank " +
      std::to_string(odd) + " differs";
    for (const double isovalue : { ReadIsovalue, 90.0 })
    {
      listened.Pipeline.Contour->SetValue(0, isovalue);
      const std::vector<std::string> messages = listened.Update();
      EXPECT_TRUE(IsOneMessageAbout(messages, { "", {}, ".bvol", reason }))
        << testing::PrintToString(messages);
      EXPECT_EQ(listened.GetNumberOfPolys(), 0);
    }
    // Reloaded, all of them see the same one.
    listened.Pipeline.Reader->SetFileName(mine.c_str());
    listened.Pipeline.Reader->Modified();
    EXPECT_EQ(listened.Update(), std::vector<std::string>());
    EXPECT_GT(SumOverRanks(static_cast<std::uint64_t>(listened.GetNumberOfPolys())), 0u);
  }
}

TEST(ReadErrorsOfOneRank, MissingFileNameIsToldByEveryRank)
{
  const SharedVolume volume("NoFileName", MakeImageToRead(), { 16, 3, 1 });
  ListenedPipeline listened(volume.Path);
  const int last = GetNumberOfRanks() - 1;
  listened.Pipeline.Reader->SetFileName(GetRank() == last ? "" : volume.Path.c_str());
  const std::vector<std::string> messages = listened.Update();
  EXPECT_TRUE(IsOneMessageAbout(messages, { "", {}, "", "No file name is set" }))
    << testing::PrintToString(messages);
}

TEST(ReadErrorsOfOneRank, ArrayThatIsNotThereIsToldByEveryRank)
{
  const SharedVolume volume("NoArray", MakeImageToRead(), { 16, 3, 1 });
  ListenedPipeline listened(volume.Path);
  const int last = GetNumberOfRanks() - 1;
  SelectPoints(listened.Pipeline.Contour, GetRank() == last ? "pressure" : "density");
  const std::vector<std::string> messages = listened.Update();
  EXPECT_TRUE(IsOneMessageAbout(messages, { "", {}, "volume.bvol", "no array \"pressure\"" }))
    << testing::PrintToString(messages);

  SelectPoints(listened.Pipeline.Contour, "density");
  listened.Pipeline.Contour->Modified();
  EXPECT_EQ(listened.Update(), std::vector<std::string>());
  EXPECT_GT(SumOverRanks(static_cast<std::uint64_t>(listened.GetNumberOfPolys())), 0u);
}

TEST(ReadErrorsOfOneRank, BlocksOfOneRankFailOnAll)
{
  // The reader alone, no contour: ranks that have read their blocks do not keep them.
  const SharedVolume volume("BlocksOfOneRank", MakeImageToRead(), { 16, 7, 1 });
  OnFirstRank([&] { FlipBit(GetFirstStore(volume.Path) + "/blocks", 2000); });
  ListenedPipeline listened(volume.Path);
  vtkBlockedVolumeReader* reader = listened.Pipeline.Reader;
  reader->UpdatePiece(GetRank(), GetNumberOfRanks(), 0);
  EXPECT_TRUE(
    IsOneMessageAbout(listened.ReaderErrors.Messages, { "", {}, "store-00000/blocks", "checksum" }))
    << testing::PrintToString(listened.ReaderErrors.Messages);
  EXPECT_EQ(reader->GetOutput()->GetNumberOfPartitions(), 0u);
}

} // namespace
