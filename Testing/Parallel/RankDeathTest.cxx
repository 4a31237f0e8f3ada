// SPDX-License-Identifier: BSD-3-Clause
// What a rank that dies while all write leaves on disk. The tests run one after the other, each in
// a program of its own: the first one takes its ranks down with it.
#include "ParallelVolumes.h"

#include "vtkCommand.h"
#include "vtkDistributeIsosurface.h"
#include "vtkEdgeIndexWriter.h"
#include "vtkMultiProcessController.h"
#include "vtkStabbingContour.h"

#include "Storage/Store/BlockedVolumeHeader.h"

#include <csignal>
#include <filesystem>

using namespace isosurface;

namespace
{

vtkSmartPointer<vtkImageData> MakeOldImage()
{
  return MakeImage({ 0, 40, 0, 36, 0, 44 }, VTK_UNSIGNED_CHAR, MakeNoise(250, 3));
}

vtkSmartPointer<vtkImageData> MakeNewImage()
{
  return MakeImage({ 0, 50, 0, 40, 0, 44 }, VTK_FLOAT, MakeNoise(250, 4));
}

const VolumeSettings Settings = { 16, 5, 0 };

/// The folder that both programs know; not removed in between. Programs of other names may run at
/// the same time.
std::string GetFolder(const std::string& name = "")
{
  const std::string ranks = std::to_string(GetNumberOfRanks());
  return std::filesystem::absolute("rank-death-" + name + ranks).string();
}

std::string GetVolume(const std::string& name = "")
{
  return GetFolder(name) + "/volume.bvol";
}

std::ptrdiff_t CountFiles(const std::string& folder)
{
  return std::distance(
    std::filesystem::directory_iterator(folder), std::filesystem::directory_iterator());
}

/// Collective: the volume opens, and its isosurface is that of the image.
void ExpectVolume(vtkImageData* image)
{
  ContourPipeline pipeline(GetVolume());
  ExpectSurfaceOf(pipeline.Update({ 120.0 }), image, 120.0);
}

/// Kills this rank as if the system had, when a share of the writing is done.
struct Death
{
  double After;
  void Run(vtkObject*, unsigned long, void* share)
  {
    if (*static_cast<double*>(share) > this->After)
    {
      std::raise(SIGKILL);
    }
  }
};

} // namespace

TEST(RankDeath, DISABLED_WhileAllWrite)
{
  OnFirstRank(
    [&]
    {
      std::filesystem::remove_all(GetFolder());
      std::filesystem::create_directories(GetFolder());
    });
  WriteFromPieces(MakeOldImage(), PieceSource::SUB_EXTENTS, GetVolume(), Settings);
  vtkNew<vtkBlockedVolumeWriter> writer;
  writer->SetInputConnection(MakeSource(MakeNewImage())->GetOutputPort());
  writer->SetFileName(GetVolume().c_str());
  writer->SetBlockSize(Settings.BlockSize);
  writer->SetNumberOfStores(Settings.NumberOfStores);
  Death death{ 0.5 };
  if (GetRank() == GetNumberOfRanks() - 1)
  {
    writer->AddObserver(vtkCommand::ProgressEvent, &death, &Death::Run);
  }
  writer->Write();
}

namespace
{

/// A contour of a volume of its own. The last rank dies as soon as an algorithm tells of progress.
struct MortalContour
{
  explicit MortalContour(const std::string& name)
    : Pipeline(MakeVolume(name))
  {
    this->Pipeline.Contour->SetValue(0, 120.0);
    this->Kill(this->Pipeline.Contour);
  }

  static std::string MakeVolume(const std::string& name)
  {
    OnFirstRank(
      [&]
      {
        std::filesystem::remove_all(GetFolder(name));
        std::filesystem::create_directories(GetFolder(name));
      });
    WriteFromPieces(MakeOldImage(), PieceSource::SUB_EXTENTS, GetVolume(name), Settings);
    return GetVolume(name);
  }

  void Kill(vtkObject* algorithm)
  {
    if (GetRank() == GetNumberOfRanks() - 1)
    {
      algorithm->AddObserver(vtkCommand::ProgressEvent, &this->Now, &Death::Run);
    }
  }

  Death Now{ 0.0 };
  ContourPipeline Pipeline;
};

} // namespace

TEST(RankDeath, DISABLED_WhileAllContour)
{
  MortalContour mortal("contour");
  mortal.Pipeline.Contour->UpdatePiece(GetRank(), GetNumberOfRanks(), 0);
}

TEST(RankDeath, DISABLED_WhileAllContourInBalance)
{
  MortalContour mortal("balance");
  mortal.Pipeline.Contour->DynamicBalanceOn();
  mortal.Pipeline.Contour->UpdatePiece(GetRank(), GetNumberOfRanks(), 0);
}

TEST(RankDeath, DISABLED_WhileAllDistribute)
{
  MortalContour mortal("distribute");
  vtkNew<vtkDistributeIsosurface> distribute;
  distribute->SetInputConnection(mortal.Pipeline.Contour->GetOutputPort());
  mortal.Kill(distribute);
  distribute->UpdatePiece(GetRank(), GetNumberOfRanks(), 0);
}

TEST(RankDeath, DISABLED_WhileAllWriteAnEdgeIndexFile)
{
  MortalContour mortal("edge-index");
  vtkNew<vtkEdgeIndexWriter> writer;
  writer->SetInputConnection(mortal.Pipeline.Contour->GetOutputPort());
  writer->SetFileName((GetFolder("edge-index") + "/surface.eix").c_str());
  mortal.Kill(writer);
  writer->Write();
}

TEST(RankDeath, DISABLED_LeavesOldVolumeAndIsClearedAway)
{
  ASSERT_TRUE(std::filesystem::exists(GetVolume())) << "the first program did not write";
  if (GetRank() == 0)
  {
    EXPECT_EQ(CountFiles(GetStoresFolder(GetLocalFileSystem(), GetVolume())), 2)
      << "nobody died while writing";
  }
  ExpectVolume(MakeOldImage());
  GetRanks()->Barrier();
  WriteFromPieces(MakeNewImage(), PieceSource::SUB_EXTENTS, GetVolume(), Settings);
  ExpectVolume(MakeNewImage());
  GetRanks()->Barrier();
  if (GetRank() == 0)
  {
    EXPECT_EQ(CountFiles(GetStoresFolder(GetLocalFileSystem(), GetVolume())), 1);
    EXPECT_EQ(CountFiles(GetFolder()), 2);
    std::filesystem::remove_all(GetFolder());
  }
}
