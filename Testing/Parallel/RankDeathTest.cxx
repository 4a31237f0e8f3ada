// SPDX-License-Identifier: BSD-3-Clause
// What a rank that dies while all write leaves on disk. The tests run one after the other, each in
// a program of its own: the first one takes its ranks down with it.
#include "ParallelVolumes.h"

#include "vtkCommand.h"
#include "vtkMultiProcessController.h"

#include "Store/BlockedVolumeHeader.h"

#include <csignal>
#include <filesystem>

namespace isosurface
{
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

/// The folder that both programs know; not removed in between.
std::string GetFolder()
{
  return std::filesystem::absolute("rank-death-" + std::to_string(GetNumberOfRanks())).string();
}

std::string GetVolume()
{
  return GetFolder() + "/volume.bvol";
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
  EdgeSurface mine;
  mine.Add(pipeline.Update({ 120.0 }));
  EdgeSurface all = GatherSurfaces(mine);
  all.MergeEqualPoints();
  if (GetRank() == 0)
  {
    EXPECT_TRUE(AreEqual(all, ContourByFlyingEdges(image, 120.0)));
  }
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
  if (GetRank() == 0)
  {
    std::filesystem::remove_all(GetFolder());
    std::filesystem::create_directories(GetFolder());
  }
  GetRanks()->Barrier();
  WriteFromPieces(MakeOldImage(), PieceSource::SUB_EXTENTS, GetVolume(), Settings);
  vtkNew<PieceSource> source;
  source->SetImage(MakeNewImage());
  vtkNew<vtkBlockedVolumeWriter> writer;
  writer->SetInputConnection(source->GetOutputPort());
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

TEST(RankDeath, DISABLED_LeavesOldVolumeAndIsClearedAway)
{
  ASSERT_TRUE(std::filesystem::exists(GetVolume())) << "the first program did not write";
  if (GetRank() == 0)
  {
    EXPECT_EQ(CountFiles(GetStoresFolder(GetVolume())), 2) << "nobody died while writing";
  }
  ExpectVolume(MakeOldImage());
  GetRanks()->Barrier();
  WriteFromPieces(MakeNewImage(), PieceSource::SUB_EXTENTS, GetVolume(), Settings);
  ExpectVolume(MakeNewImage());
  GetRanks()->Barrier();
  if (GetRank() == 0)
  {
    EXPECT_EQ(CountFiles(GetStoresFolder(GetVolume())), 1);
    EXPECT_EQ(CountFiles(GetFolder()), 2);
    std::filesystem::remove_all(GetFolder());
  }
}

} // namespace isosurface
