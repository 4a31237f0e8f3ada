// SPDX-License-Identifier: BSD-3-Clause
// A store that is lost or damaged between two queries: the surface of all ranks is whole, one rank
// warns.
#include "EventCounter.h"
#include "ParallelVolumes.h"

#include "Ground/Base/FileSystem.h"
#include "vtkBlockedVolumeReader.h"
#include "vtkDistributeIsosurface.h"
#include "vtkMultiProcessController.h"
#include "vtkNew.h"
#include "vtkPolyData.h"
#include "vtkStabbingContour.h"

#include <filesystem>
#include <fstream>

using namespace isosurface;

namespace
{

constexpr double ReplicatedIsovalue = 120.0;

void FlipBytes(const std::string& path)
{
  std::fstream file(path, std::ios::in | std::ios::out | std::ios::binary);
  const auto size = static_cast<std::streamoff>(std::filesystem::file_size(path));
  for (std::streamoff at = 100; at < size; at += 4096)
  {
    file.seekp(at);
    file.put('\x55');
  }
}

class ReplicasOnRanks : public testing::TestWithParam<bool>
{
protected:
  // Spoils store 2 of 5 between two queries.
  void Check(const std::string& name, const std::function<void(const std::string&)>& spoil)
  {
    const bool isLocal = this->GetParam();
    const SharedFolder folder("Replicas" + name + (isLocal ? "Local" : "Shared"));
    const std::string path = folder.GetPath("volume.bvol");
    const auto image = MakeImage({ 0, 40, 0, 20, 0, 33 }, VTK_UNSIGNED_CHAR, MakeNoise(250, 3));
    VolumeSettings settings = { 16, 5 };
    settings.NumberOfReplicas = 2;
    WriteFromPieces(image, PieceSource::SUB_EXTENTS, path, settings);
    ContourPipeline pipeline(path);
    pipeline.Reader->SetLocalStores(isLocal);
    const MessageKeeper warnings(pipeline.Contour, vtkCommand::WarningEvent);
    // A cache without room: the next query reads again.
    pipeline.Reader->SetCacheSize(0);
    const EdgeSurface first = GatherSurface(pipeline.Update({ ReplicatedIsovalue }));
    EXPECT_EQ(warnings.Messages, std::vector<std::string>());
    OnFirstRank([&] { spoil(HidePath(path + ".stores") + "/000001/store-00002"); });
    const EdgeSurface second = GatherSurface(pipeline.Update({ ReplicatedIsovalue + 10 }));
    const EdgeSurface third = GatherSurface(pipeline.Update({ ReplicatedIsovalue }));
    std::string told;
    for (const std::string& message : warnings.Messages)
    {
      told += message;
    }
    const std::vector<std::string> all = GatherTexts(told);
    EXPECT_NE(all[0].find("store 2: lost or damaged"), std::string::npos) << all[0];
    EXPECT_LE(warnings.Messages.size(), GetRank() == 0 ? 1u : 0u);
    if (GetRank() == 0)
    {
      EXPECT_TRUE(AreEqual(first, ContourByFlyingEdges(image, ReplicatedIsovalue)));
      EXPECT_TRUE(AreEqual(second, ContourByFlyingEdges(image, ReplicatedIsovalue + 10)));
      EXPECT_TRUE(AreEqual(third, ContourByFlyingEdges(image, ReplicatedIsovalue)));
    }
    pipeline.Reader->SetCacheSize(1024);
  }
};

TEST_P(ReplicasOnRanks, ALostStoreIsReadElsewhere)
{
  // Renamed and emptied, as no reader can have it open any more.
  this->Check("Lost",
    [](const std::string& store)
    {
      for (const auto& file : std::filesystem::recursive_directory_iterator(store))
      {
        if (file.is_regular_file())
        {
          std::filesystem::resize_file(file, 0);
        }
      }
      std::filesystem::remove_all(store);
    });
}

// Consumers that read the blocks themselves learn of a damaged store while they do.
TEST_P(ReplicasOnRanks, ADistributedSurfaceIsWholeToo)
{
  const bool isLocal = this->GetParam();
  const SharedFolder folder(std::string("ReplicasDistributed") + (isLocal ? "Local" : "Shared"));
  const std::string path = folder.GetPath("volume.bvol");
  const auto image = MakeImage({ 0, 40, 0, 20, 0, 33 }, VTK_UNSIGNED_CHAR, MakeNoise(250, 3));
  VolumeSettings settings = { 16, 5 };
  settings.NumberOfReplicas = 2;
  WriteFromPieces(image, PieceSource::SUB_EXTENTS, path, settings);
  OnFirstRank([&] { FlipBytes(HidePath(path + ".stores") + "/000001/store-00002/blocks"); });
  ContourPipeline pipeline(path);
  pipeline.Reader->SetLocalStores(isLocal);
  pipeline.Contour->SetValue(0, ReplicatedIsovalue);
  vtkNew<vtkDistributeIsosurface> distribute;
  distribute->SetInputConnection(pipeline.Contour->GetOutputPort());
  const MessageKeeper warnings(distribute, vtkCommand::WarningEvent);
  // A rank alone takes the contour's surface, and its warning.
  const MessageKeeper warningsOfContour(pipeline.Contour, vtkCommand::WarningEvent);
  distribute->UpdatePiece(GetRank(), GetNumberOfRanks(), 0);
  const auto triangles =
    SumOverRanks(static_cast<std::uint64_t>(distribute->GetOutput()->GetNumberOfPolys()));
  const std::size_t expected = ContourByFlyingEdges(image, ReplicatedIsovalue).Triangles.size();
  EXPECT_EQ(triangles, expected);
  EXPECT_EQ(warnings.Messages.size() + warningsOfContour.Messages.size(), GetRank() == 0 ? 1u : 0u);
}

std::string NameOfStores(const testing::TestParamInfo<bool>& info)
{
  return info.param ? "Local" : "Shared";
}

INSTANTIATE_TEST_SUITE_P(Stores, ReplicasOnRanks, testing::Bool(), NameOfStores);

} // namespace
