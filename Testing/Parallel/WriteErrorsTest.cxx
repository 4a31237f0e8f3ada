// SPDX-License-Identifier: BSD-3-Clause
// A write that fails on any rank fails on all of them, and leaves what was there as it was.
#include "EventCounter.h"
#include "FileSizeLimit.h"
#include "ParallelVolumes.h"

#include "vtkCommand.h"
#include "vtkExecutive.h"
#include "vtkMultiProcessController.h"

using namespace isosurface;

namespace
{

vtkSmartPointer<vtkImageData> MakeImageToKeep()
{
  return MakeImage({ 0, 40, 0, 36, 0, 44 }, VTK_UNSIGNED_CHAR, MakeNoise(250, 3));
}

vtkSmartPointer<vtkImageData> MakeImageToWrite()
{
  return MakeImage({ 0, 40, 0, 40, 0, 44 }, VTK_FLOAT, MakeNoise(250, 4));
}

// A dataset that a write is to fail to replace.
class WriteErrors : public testing::Test
{
protected:
  WriteErrors()
    : Folder(testing::UnitTest::GetInstance()->current_test_info()->name())
    , Path(this->Folder.GetPath("volume.bvol"))
  {
    WriteFromPieces(MakeImageToKeep(), PieceSource::SUB_EXTENTS, this->Path, { 16, 3, 0 });
    this->Before = GetRank() == 0 ? ComputeFingerprint(this->Path) : 0;
    this->Source->SetImage(MakeImageToWrite());
    this->Writer->SetInputConnection(this->Source->GetOutputPort());
    this->Writer->SetFileName(this->Path.c_str());
    this->Writer->SetBlockSize(16);
    this->Writer->SetNumberOfStores(7);
    GetRanks()->Barrier();
  }

  // Collective: Write() fails with one message, or none if `reason` is empty.
  void ExpectFailure(const std::string& reason, const std::string& file = "volume.bvol")
  {
    const ErrorCounter errors(this->Writer);
    EXPECT_EQ(this->Writer->Write(), 0);
    if (reason.empty())
    {
      EXPECT_EQ(errors.Messages, std::vector<std::string>());
    }
    else
    {
      EXPECT_TRUE(errors.Messages.size() == 1 &&
        errors.Messages[0].find(reason) != std::string::npos &&
        errors.Messages[0].find(file) != std::string::npos)
        << testing::PrintToString(errors.Messages);
    }
    OnFirstRank([&]
      { EXPECT_EQ(ComputeFingerprint(this->Path), this->Before) << "the old files have changed"; });
  }

  // Collective: now that the cause is mended, the same writer works.
  void ExpectSuccess()
  {
    this->Writer->Modified();
    const ExpectNoErrors errors(this->Writer);
    EXPECT_EQ(this->Writer->Write(), 1);
    ContourPipeline pipeline(this->Path);
    ExpectSurfaceOf(pipeline.Update({ 120.0 }), MakeImageToWrite(), 120.0);
  }

  const SharedFolder Folder;
  const std::string Path;
  vtkNew<PieceSource> Source;
  vtkNew<vtkBlockedVolumeWriter> Writer;
  std::uint64_t Before = 0;
};

TEST_F(WriteErrors, NoFileNameOnOneRank)
{
  this->Writer->SetFileName(GetRank() == GetNumberOfRanks() - 1 ? "" : this->Path.c_str());
  this->ExpectFailure("No file name is set", "");
  this->Writer->SetFileName(this->Path.c_str());
  this->ExpectSuccess();
}

TEST_F(WriteErrors, FolderThatCannotBe)
{
  const std::string file = this->Folder.GetPath("file");
  OnFirstRank([&] { WriteBytes(file, "not a folder"); });
  this->Writer->SetFileName((file + "/new.bvol").c_str());
  this->ExpectFailure("Not a directory", "/file/.new.bvol.stores");
  this->Writer->SetFileName(this->Path.c_str());
  this->ExpectSuccess();
}

TEST_F(WriteErrors, NoPointArrays)
{
  vtkNew<vtkImageData> image;
  image->SetExtent(0, 9, 0, 9, 0, 9);
  this->Writer->SetInputData(image);
  this->ExpectFailure("no numeric point array", "");
  this->Writer->SetInputConnection(this->Source->GetOutputPort());
  this->ExpectSuccess();
}

TEST_F(WriteErrors, FullDiskOnOneRank)
{
  for (int failing = 0; failing < GetNumberOfRanks(); ++failing)
  {
    const FileSizeLimit limit(failing == GetRank() ? 10000 : FileSizeLimit::Unlimited);
    this->Writer->Modified();
    this->ExpectFailure("File too large", ".stores/");
  }
  this->ExpectSuccess();
}

TEST_F(WriteErrors, StopByOneRank)
{
  for (const double after : { 0.0, 0.3, 0.92 })
  {
    const bool isMine = GetRank() == GetNumberOfRanks() - 1;
    {
      const ProgressKeeper stop(this->Writer, StopAbove(this->Writer, isMine ? after : 1));
      this->Writer->Modified();
      this->ExpectFailure("");
    }
    this->Writer->SetAbortExecute(0);
  }
  this->ExpectSuccess();
}

} // namespace
