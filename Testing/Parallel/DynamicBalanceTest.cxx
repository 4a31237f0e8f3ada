// SPDX-License-Identifier: BSD-3-Clause
// Ranks that take blocks from others' shares: the surface of all is that of the whole volume, and
// each block is read once, whichever rank is slow.
#include "EventCounter.h"
#include "ParallelVolumes.h"

#include "ControllerCommunicator.h"

#include "Ground/Base/FileSystem.h"
#include "vtkBlockedVolumeReader.h"
#include "vtkCommand.h"
#include "vtkMultiProcessController.h"
#include "vtkPolyData.h"
#include "vtkStabbingContour.h"

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <thread>

using namespace isosurface;

namespace
{

constexpr double Isovalue = 120.0;

/// Sleeps whenever the contour of the first rank tells of progress.
struct Slowness
{
  void Sleep(vtkObject*, unsigned long, void*)
  {
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
};

/// The surface of all ranks, on rank 0, and what all have read.
struct Balanced
{
  EdgeSurface All;
  std::uint64_t ActiveBlocks = 0;
  std::uint64_t BlocksRead = 0;
};

Balanced Extract(ContourPipeline& pipeline, double isovalue)
{
  vtkPolyData* mine = pipeline.Update({ isovalue });
  Balanced balanced;
  balanced.All = GatherSurface(mine);
  balanced.ActiveBlocks = SumOverRanks(GetCost(mine, "ActiveBlocks"));
  balanced.BlocksRead = SumOverRanks(GetCost(mine, "BlocksRead"));
  return balanced;
}

class DynamicBalance : public testing::Test
{
protected:
  DynamicBalance()
    : Image(MakeClosedVolume({ 0, 149, -20, 100, 0, 90 }, VTK_FLOAT))
    , Volume("DynamicBalance", this->Image, { 16, 3 })
  {
  }

  const vtkSmartPointer<vtkImageData> Image;
  const SharedVolume Volume;
};

} // namespace

TEST_F(DynamicBalance, GivesTheSurfaceOfTheWholeVolumeAndReadsEachBlockOnce)
{
  for (const bool isSlow : { false, true })
  {
    ContourPipeline pipeline(this->Volume.Path);
    pipeline.Reader->SetCacheSize(0);
    ContourPipeline fixed(this->Volume.Path);
    fixed.Reader->SetCacheSize(0);
    pipeline.Contour->DynamicBalanceOn();
    Slowness slowness;
    if (isSlow && GetRank() == 0)
    {
      pipeline.Contour->AddObserver(vtkCommand::ProgressEvent, &slowness, &Slowness::Sleep);
    }
    for (const double isovalue : { Isovalue, 60.5 })
    {
      const Balanced balanced = Extract(pipeline, isovalue);
      const Balanced expected = Extract(fixed, isovalue);
      EXPECT_EQ(balanced.ActiveBlocks, expected.ActiveBlocks);
      EXPECT_EQ(balanced.BlocksRead, balanced.ActiveBlocks);
      if (GetRank() == 0)
      {
        EXPECT_TRUE(AreEqual(balanced.All, ContourByFlyingEdges(this->Image, isovalue)));
        EXPECT_TRUE(AreEqual(balanced.All, expected.All));
      }
    }
  }
}

TEST_F(DynamicBalance, GivesTheSurfaceWithinABudgetAndAfterRefinement)
{
  ContourPipeline pipeline(this->Volume.Path);
  pipeline.Contour->DynamicBalanceOn();
  pipeline.Contour->SetTimeBudget(1000);
  const Balanced within = Extract(pipeline, Isovalue);
  pipeline.Contour->SetTimeBudget(0);
  pipeline.Contour->ProgressiveOn();
  Balanced refined = Extract(pipeline, Isovalue);
  int passes = 1;
  for (; !pipeline.Contour->GetFinal() && passes < 9; ++passes)
  {
    pipeline.Contour->Refine();
    refined = Extract(pipeline, Isovalue);
  }
  EXPECT_GT(passes, 1);
  if (GetRank() == 0)
  {
    const EdgeSurface expected = ContourByFlyingEdges(this->Image, Isovalue);
    EXPECT_TRUE(AreEqual(within.All, expected));
    EXPECT_TRUE(AreEqual(refined.All, expected));
  }
}

TEST_F(DynamicBalance, HasNoEffectWhereStoresAreLocal)
{
  ContourPipeline fixed(this->Volume.Path);
  ContourPipeline pipeline(this->Volume.Path);
  fixed.Reader->LocalStoresOn();
  pipeline.Reader->LocalStoresOn();
  pipeline.Contour->DynamicBalanceOn();
  const auto expected = GetCost(fixed.Update({ Isovalue }), "ActiveBlocks");
  EXPECT_EQ(GetCost(pipeline.Update({ Isovalue }), "ActiveBlocks"), expected);
}

TEST_F(DynamicBalance, ReadsALostStoreElsewhere)
{
  const std::string path = this->Volume.Folder.GetPath("replicas.bvol");
  VolumeSettings settings = { 16, 4 };
  settings.NumberOfReplicas = 2;
  WriteFromPieces(this->Image, PieceSource::SUB_EXTENTS, path, settings);
  ContourPipeline pipeline(path);
  pipeline.Contour->DynamicBalanceOn();
  pipeline.Reader->SetCacheSize(0);
  const EventCounter warnings(pipeline.Contour, vtkCommand::WarningEvent);
  Extract(pipeline, 60.5);
  OnFirstRank(
    [&] { std::filesystem::remove_all(HidePath(path + ".stores") + "/000001/store-00001"); });
  ExpectSurfaceOf(pipeline.Update({ Isovalue }), this->Image, Isovalue);
}

TEST_F(DynamicBalance, ALostStoreIsAnErrorOnAllRanksAndTheNextVolumeWorks)
{
  ContourPipeline pipeline(this->Volume.Path);
  pipeline.Contour->DynamicBalanceOn();
  pipeline.Contour->SetValue(0, Isovalue);
  OnFirstRank(
    [&]
    {
      std::filesystem::rename(HidePath(this->Volume.Path + ".stores") + "/000001/store-00001",
        HidePath(this->Volume.Path + ".stores") + "/000001/aside");
    });
  {
    const ErrorCounter errors(pipeline.Contour);
    pipeline.Contour->UpdatePiece(GetRank(), GetNumberOfRanks(), 0);
    EXPECT_EQ(errors.Messages.size(), 1u);
  }
  OnFirstRank(
    [&]
    {
      std::filesystem::rename(HidePath(this->Volume.Path + ".stores") + "/000001/aside",
        HidePath(this->Volume.Path + ".stores") + "/000001/store-00001");
    });
  pipeline.Contour->Modified();
  ExpectSurfaceOf(pipeline.Update({ Isovalue }), this->Image, Isovalue);
}

TEST_F(DynamicBalance, IsAnErrorOnAllRanksIfOneAloneHasIt)
{
  ContourPipeline pipeline(this->Volume.Path);
  pipeline.Contour->SetDynamicBalance(GetRank() == 0 ? 1 : 0);
  pipeline.Contour->SetValue(0, Isovalue);
  const ErrorCounter errors(pipeline.Contour);
  pipeline.Contour->UpdatePiece(GetRank(), GetNumberOfRanks(), 0);
  EXPECT_EQ(errors.Messages.size(), GetNumberOfRanks() == 1 ? 0u : 1u);
}

// While the first rank does nothing but call LetOthersIn.
TEST(DynamicBalanceCounters, AreRaisedAndReadByAllRanksAtOnce)
{
  ControllerCommunicator ranks(GetRanks());
  const int size = GetNumberOfRanks();
  for (int turn = 0; turn < 3; ++turn)
  {
    const auto counters = ranks.MakeCounters(true);
    ASSERT_EQ(counters != nullptr, size > 1);
    if (!counters)
    {
      return;
    }
    constexpr std::uint64_t additions = 500;
    const std::uint64_t all = additions * static_cast<std::uint64_t>(size - 1);
    std::vector<std::uint64_t> values;
    for (std::uint64_t n = 0; GetRank() > 0 && n < additions; ++n)
    {
      for (int rank = 0; rank < size; ++rank)
      {
        const auto before = counters->Add(rank, (std::uint64_t{ 1 } << 32) + 1);
        ASSERT_TRUE(before.IsOk()) << before.GetStatus().GetMessage();
        EXPECT_EQ(*before >> 32, *before & 0xffffffff);
      }
    }
    std::vector<int> numbers;
    for (int rank = 0; rank < size; ++rank)
    {
      numbers.push_back(rank);
    }
    do
    {
      counters->LetOthersIn();
      const auto read = counters->Read(numbers);
      ASSERT_TRUE(read.IsOk());
      values = *read;
    } while (std::any_of(
      values.begin(), values.end(), [&](std::uint64_t value) { return value >> 32 < all; }));
    EXPECT_EQ(values, std::vector<std::uint64_t>(values.size(), (all << 32) + all));
  }
}

// The first rank has no more use for them when the others begin.
TEST(DynamicBalanceCounters, AreReachedOnARankThatIsReadyAndZeroAtEachUse)
{
  ControllerCommunicator ranks(GetRanks());
  for (int turn = 0; turn < 20; ++turn)
  {
    auto counters = ranks.MakeCounters(true);
    ASSERT_EQ(counters != nullptr, GetNumberOfRanks() > 1);
    if (!counters)
    {
      return;
    }
    if (GetRank() == 0)
    {
      EXPECT_EQ(*counters->Add(1, 0), 0u);
      counters.reset();
    }
    else
    {
      const auto before = counters->Add(0, 1);
      ASSERT_TRUE(before.IsOk());
      EXPECT_LT(*before, static_cast<std::uint64_t>(GetNumberOfRanks() - 1)) << "turn " << turn;
    }
  }
}

TEST(DynamicBalanceCounters, AreForAllRanksOrNoneAndOneUseAtATime)
{
  ControllerCommunicator ranks(GetRanks());
  EXPECT_FALSE(ranks.MakeCounters(GetRank() > 0));
  EXPECT_FALSE(ranks.MakeCounters(false));
  const auto counters = ranks.MakeCounters(true);
  EXPECT_EQ(counters != nullptr, GetNumberOfRanks() > 1);
  EXPECT_FALSE(ranks.MakeCounters(true));
}

TEST(DynamicBalanceCounters, GoWithTheirCommunicator)
{
  for (int turn = 0; turn < 3; ++turn)
  {
    const auto again = vtk::TakeSmartPointer(GetRanks()->PartitionController(0, GetRank()));
    ControllerCommunicator ranks(again);
    auto counters = ranks.MakeCounters(true);
    EXPECT_EQ(counters != nullptr, GetNumberOfRanks() > 1);
    if (counters)
    {
      EXPECT_TRUE(counters->Add(0, 1).IsOk());
    }
  }
}

TEST(DynamicBalanceCounters, AreNotThereForAPartOfTheRanks)
{
  const auto part =
    vtk::TakeSmartPointer(GetRanks()->PartitionController(GetRank() % 2, GetRank()));
  ControllerCommunicator ranks(part);
  EXPECT_FALSE(ranks.MakeCounters(true));
}
