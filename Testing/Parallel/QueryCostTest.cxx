// SPDX-License-Identifier: BSD-3-Clause
// What a query costs all ranks together is what it must cost.
#include "ParallelVolumes.h"

#include "vtkBlockedVolumeReader.h"
#include "vtkMultiProcessController.h"
#include "vtkStabbingContour.h"

#include <algorithm>
#include <atomic>

#include <mpi.h>

using namespace isosurface;

namespace
{

std::atomic<int> Reductions{ 0 }; ///< of this rank with all others
std::atomic<int> Gathers{ 0 };

constexpr int WarmCache = 256; // MiB

struct Cost
{
  std::uint64_t ActiveBlocks, BlocksRead, BytesRead, BlockCacheHits, TreePagesRead;
};

// Of all ranks.
Cost SumCost(vtkPolyData* mine)
{
  return { SumOverRanks(GetCost(mine, "ActiveBlocks")), SumOverRanks(GetCost(mine, "BlocksRead")),
    SumOverRanks(GetCost(mine, "BytesRead")), SumOverRanks(GetCost(mine, "BlockCacheHits")),
    SumOverRanks(GetCost(mine, "TreePagesRead")) };
}

class QueryCost : public testing::TestWithParam<int>
{
protected:
  QueryCost()
    : Image(MakeClosedVolume({ -41, 28, -7, 53, -90, -8 }, VTK_SHORT))
    // Not compressed, so that the size of a block can be told from the image.
    , Volume("QueryCost-" + std::to_string(GetParam()), this->Image,
        { 16, GetParam(), vtkBlockedVolumeWriter::GREEDY, vtkBlockedVolumeWriter::NONE })
  {
  }
  ~QueryCost() override { ContourPipeline(this->Volume.Path).Reader->SetCacheSize(WarmCache); }

  const vtkSmartPointer<vtkImageData> Image;
  const SharedVolume Volume;
};

TEST_P(QueryCost, WithoutCacheIsTheActiveBlocks)
{
  ContourPipeline pipeline(this->Volume.Path);
  pipeline.Reader->SetCacheSize(0);
  bool isSeveral = false;
  for (const double isovalue : { 200.0, 60.5, 1.0, 0.0, -1.0, 1e4 })
  {
    const ExpectedCost expected = CountActiveBlocks(this->Image, 16, isovalue);
    const Cost cost = SumCost(pipeline.Update({ isovalue }));
    EXPECT_EQ(cost.ActiveBlocks, expected.ActiveBlocks) << "at " << isovalue;
    EXPECT_EQ(cost.BlocksRead, expected.ActiveBlocks) << "at " << isovalue;
    EXPECT_EQ(cost.BlockCacheHits, 0u) << "at " << isovalue;
    EXPECT_GE(cost.BytesRead, expected.StoredBytes) << "at " << isovalue;
    EXPECT_LE(20 * cost.BytesRead, 21 * expected.StoredBytes) << "at " << isovalue;
    isSeveral = isSeveral || expected.ActiveBlocks > 20;
  }
  EXPECT_TRUE(isSeveral);
}

TEST_P(QueryCost, OfSeveralIsovaluesHasEachBlockOnce)
{
  ContourPipeline pipeline(this->Volume.Path);
  pipeline.Reader->SetCacheSize(0);
  const Cost together = SumCost(pipeline.Update({ 60.5, 61.0, 62.0 }));
  EXPECT_EQ(together.BlocksRead, together.ActiveBlocks);
  EXPECT_GE(together.ActiveBlocks, CountActiveBlocks(this->Image, 16, 61.0).ActiveBlocks);
  EXPECT_LE(together.ActiveBlocks, 2 * CountActiveBlocks(this->Image, 16, 61.0).ActiveBlocks);
}

TEST_P(QueryCost, WithWarmCacheIsNothing)
{
  ContourPipeline pipeline(this->Volume.Path);
  pipeline.Reader->SetCacheSize(WarmCache);
  const Cost first = SumCost(pipeline.Update({ 60.5 }));
  EXPECT_EQ(first.BlocksRead, first.ActiveBlocks);
  pipeline.Contour->Modified();
  const Cost second = SumCost(pipeline.Update({ 60.5 }));
  EXPECT_EQ(second.ActiveBlocks, first.ActiveBlocks);
  EXPECT_EQ(second.BlocksRead, 0u);
  EXPECT_EQ(second.BytesRead, 0u);
  EXPECT_EQ(second.BlockCacheHits, first.ActiveBlocks);
  EXPECT_EQ(second.TreePagesRead, 0u);
}

TEST_P(QueryCost, TreePagesAreFew)
{
  ContourPipeline pipeline(this->Volume.Path);
  const Cost cost = SumCost(pipeline.Update({ 60.5 }));
  // A tree of so few blocks is one leaf below its header. Every rank queries all stores.
  EXPECT_GT(cost.TreePagesRead, 0u);
  EXPECT_LE(cost.TreePagesRead, 2u * static_cast<unsigned int>(GetParam() * GetNumberOfRanks()));
  // A rank with stores of its own opens these; where there are more ranks than stores, one.
  ContourPipeline ofLocalStores(this->Volume.Path);
  ofLocalStores.Reader->LocalStoresOn();
  const Cost local = SumCost(ofLocalStores.Update({ 60.5 }));
  const int opened = std::max(GetParam(), GetNumberOfRanks());
  EXPECT_LE(local.TreePagesRead, 2u * static_cast<unsigned int>(opened));
  EXPECT_EQ(local.ActiveBlocks, cost.ActiveBlocks);
}

INSTANTIATE_TEST_SUITE_P(Stores, QueryCost, testing::Values(1, 4, 7));

/// What a click costs all ranks: from the isovalue to the surface, of an input that is there.
class QueryCostOfAClick : public testing::TestWithParam<bool>
{
protected:
  /// The most reductions of the first contour and of another isovalue.
  static int CountReductions(vtkStabbingContour* contour)
  {
    const ExpectNoErrors errors(contour);
    contour->SetController(GetRanks());
    int most = 0;
    for (const double isovalue : { 60.5, 100.5 })
    {
      contour->SetValue(0, isovalue);
      contour->UpdateInformation();
      contour->AllowCoarse(GetParam());
      Reductions = Gathers = 0;
      contour->UpdatePiece(GetRank(), GetNumberOfRanks(), 0);
      contour->AllowCoarse(0);
      std::printf("%d reductions, %d gathers at %g\n", Reductions.load(), Gathers.load(), isovalue);
      most = std::max(most, Reductions.load());
      EXPECT_GT(
        SumOverRanks(static_cast<std::uint64_t>(contour->GetOutput()->GetNumberOfCells())), 0u);
    }
    return most;
  }

  const vtkSmartPointer<vtkImageData> Image =
    MakeClosedVolume({ -3, 107, 5, 114, 0, 101 }, VTK_UNSIGNED_CHAR);
};

TEST_P(QueryCostOfAClick, OnAVolumeIsFourReductions)
{
  const SharedVolume volume("ClickedVolume", this->Image, { 16, 3 });
  ContourPipeline pipeline(volume.Path);
  pipeline.Update({ 30.5 });
  vtkNew<vtkStabbingContour> contour;
  contour->SetInputConnection(pipeline.Reader->GetOutputPort());
  EXPECT_LE(CountReductions(contour), 4);
}

TEST_P(QueryCostOfAClick, OnImagesIsFourReductions)
{
  const auto contour = MakeContour(MakeSource(this->Image), 30.5);
  EXPECT_LE(CountReductions(contour), 4);
}

INSTANTIATE_TEST_SUITE_P(MayBeCoarse, QueryCostOfAClick, testing::Bool());

} // namespace

// The symbols of a program come before those of its libraries.
extern "C" __attribute__((visibility("default"))) int MPI_Allreduce(
  const void* mine, void* all, int count, MPI_Datatype type, MPI_Op operation, MPI_Comm ranks)
{
  ++Reductions;
  return PMPI_Allreduce(mine, all, count, type, operation, ranks);
}

extern "C" __attribute__((visibility("default"))) int MPI_Allgatherv(const void* mine, int count,
  MPI_Datatype type, void* all, const int counts[], const int places[], MPI_Datatype allType,
  MPI_Comm ranks)
{
  ++Gathers;
  return PMPI_Allgatherv(mine, count, type, all, counts, places, allType, ranks);
}
