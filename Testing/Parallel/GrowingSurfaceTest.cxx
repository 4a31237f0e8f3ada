// SPDX-License-Identifier: BSD-3-Clause
// The surface of a file while it is indexed: exact where it is indexed, behind that of a sample. On any
// number of ranks.
#include "ControllerCommunicator.h"
#include "ParallelVolumes.h"

#include "vtkBlockedVolumeHandle.h"
#include "vtkBlockedVolumeReader.h"
#include "vtkStabbingContour.h"

#include "vtkDataArray.h"
#include "vtkNew.h"
#include "vtkObjectFactory.h"
#include "vtkPointData.h"
#include "vtkPolyData.h"

#include "Formats/Opener/ForeignVolume.h"
#include "Ground/Base/FileSystem.h"
#include "Ranks/Query/Refinement.h"
#include "Ranks/Query/SightedBox.h"
#include "Storage/Store/BlockedVolume.h"
#include "Storage/Store/FinishedLayers.h"
#include "Storage/Store/SourceRecord.h"
#include "Storage/Writing/BlockedVolumeWriter.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <set>
#include <thread>
#include <utility>

using namespace isosurface;

namespace
{

/// Reads a sample of a file, of which a part is indexed.
class SampleReader : public vtkBlockedVolumeReader
{
public:
  static SampleReader* New();
  vtkTypeMacro(SampleReader, vtkBlockedVolumeReader);

  void Show(const std::string& sample, std::shared_ptr<FinishedLayers> finished)
  {
    vtkNew<vtkBlockedVolumeHandle> standIn;
    standIn->SetVolume(*BlockedVolume::Open(sample));
    standIn->SetSample("a sample", "");
    standIn->SetFinished(std::move(finished));
    this->SetStandIn(standIn);
  }
};
vtkStandardNewMacro(SampleReader);

/// The triangles in some slices of cells of a grid, and their points. One within a face of cells
/// belongs to the cell before it.
EdgeSurface KeepSlices(const EdgeSurface& surface, vtkImageData* image, int begin, int end)
{
  const int* size = image->GetDimensions();
  const auto findSlice = [&](std::int64_t edge) { return edge / 3 / (size[0] * size[1]); };
  EdgeSurface kept;
  std::set<std::int64_t> edges;
  for (const EdgeSurface::Triangle& triangle : surface.Triangles)
  {
    std::int64_t slice = findSlice(*std::min_element(triangle.begin(), triangle.end()));
    const bool isFlat = std::all_of(triangle.begin(), triangle.end(),
      [&](std::int64_t edge) { return edge % 3 != 2 && findSlice(edge) == slice; });
    slice -= isFlat ? 1 : 0;
    if (slice >= begin && slice < end)
    {
      kept.Triangles.push_back(triangle);
      edges.insert(triangle.begin(), triangle.end());
    }
  }
  std::copy_if(surface.Points.begin(), surface.Points.end(), std::back_inserter(kept.Points),
    [&](const EdgePoint& point) { return edges.count(point.Edge) > 0; });
  return kept;
}

class GrowingSurface : public testing::Test
{
protected:
  static constexpr double Isovalue = 60.5;
  static constexpr RefinementStage Growing = RefinementStage::Growing;
  static constexpr RefinementStage Ready = RefinementStage::Ready;

  /// An index that is not in place has the samples of the file.
  explicit GrowingSurface(bool isInPlace = true)
  {
    OnFirstRank(
      [&]
      {
        this->WriteSamples(this->Source);
        this->WriteSamples(this->OtherSource);
        WriteVolume(this->Sample, this->Folder.GetPath("sample.bvol"));
      });
    this->WriteIndex(isInPlace);
    this->Reader->Show(this->Folder.GetPath("sample.bvol"), this->Finished);
  }

  void WriteSamples(const std::string& path) const
  {
    const int* size = this->Image->GetDimensions();
    std::ofstream(path, std::ios::binary)
      .write(static_cast<const char*>(this->Image->GetScalarPointer()),
        static_cast<std::streamsize>(2) * size[0] * size[1] * size[2]);
  }
  SourceRecord Describe(const std::string& source, const OpenedVolume& volume) const
  {
    return *DescribeSource(
      GetLocalFileSystem(), OpenForeignVolume, this->Index, source, {}, volume.Grid, volume.Arrays);
  }

  /// Writes the index in several rounds, goes on after a stop, and keeps what is told then.
  void WriteIndex(bool isInPlace)
  {
    auto volume = OpenForeignVolume(GetLocalFileSystem(), this->Source, {});
    ASSERT_TRUE(volume.IsOk()) << volume.GetStatus().GetMessage();
    BlockedVolumeSettings settings;
    settings.BlockSize = 16;
    settings.Distribution = isInPlace ? DistributionMethod::Slab : DistributionMethod::Random;
    (isInPlace ? settings.InPlace : settings.CopyOf) = this->Describe(this->Source, *volume);
    settings.Compression.Codec = SegmentCodec::Lz4;
    settings.JournalSeconds = 0;
    settings.MemoryLimit = std::uint64_t{ 2 } << 20;
    settings.Threads = 1;
    int rounds = 0;
    settings.WhenFinished = [&](const BlockedVolumeHeader& header, const FinishedBlocks& blocks)
    {
      ASSERT_EQ(blocks.Ranges.size(), 1u);
      const std::vector<KeyRange>& ranges = blocks.Ranges.front();
      EXPECT_GT(ranges.size(), 0u);
      this->Ranges.insert(this->Ranges.end(), ranges.begin(), ranges.end());
      for (const auto& [folder, entries] : blocks.Records)
      {
        std::vector<BlockDirectoryEntry>& all = this->Records[folder];
        all.insert(all.end(), entries.begin(), entries.end());
      }
      EXPECT_TRUE(blocks.Records.empty() || !isInPlace);
      this->Header = header;
      ++rounds;
    };
    ControllerCommunicator ranks(GetRanks());
    const auto write = [&](double end)
    {
      this->Ranges.clear();
      this->Records.clear();
      rounds = 0;
      return BlockedVolumeWriter(ranks)
        .Write(this->Index, volume->Grid, volume->Arrays, *volume->Source, settings,
          [end](double share) { return share < end; })
        .GetStatus();
    };
    EXPECT_EQ(write(0.5).GetCode(), StatusCode::Aborted);
    EXPECT_LT(this->Ranges.size(), 6u * 5 * 7);
    const Status written = write(2);
    EXPECT_TRUE(written.IsOk()) << written.GetMessage();
    EXPECT_GT(rounds, 1);
    EXPECT_EQ(this->Ranges.size(), 6u * 5 * 7);
    if (isInPlace && GetRank() == GetNumberOfRanks() - 1)
    {
      this->Header.TimeSteps.back().Source = this->Describe(this->OtherSource, *volume);
    }
  }

  /// Tells that so many blocks more are finished.
  void Finish(std::ptrdiff_t blocks)
  {
    const auto begin = this->Ranges.begin() + this->Told;
    this->Finished->Add(
      this->Header, { { { begin, begin + blocks } }, std::exchange(this->Records, {}) });
    this->Told += blocks;
  }

  vtkPolyData* Update()
  {
    this->Contour->UpdatePiece(GetRank(), GetNumberOfRanks(), 0);
    return this->Contour->GetOutput();
  }
  RefinementStage Prepare()
  {
    this->Contour->PrepareRefinement(1000);
    return Refinement::FromValues(this->Contour->GetRefinement()).Stage;
  }
  /// The stage when no more is awaited.
  RefinementStage PrepareToTheEnd()
  {
    RefinementStage stage = this->Prepare();
    for (int tries = 0; stage == Growing && tries < 1000; ++tries)
    {
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
      stage = this->Prepare();
    }
    return stage;
  }
  /// Shows what more there is.
  vtkPolyData* Grow()
  {
    EXPECT_EQ(this->PrepareToTheEnd(), Ready);
    this->Contour->Refine();
    this->Update();
    this->Prepare(); // from now on it rests as long as it was awaited
    return this->Contour->GetOutput();
  }

  /// Expects the exact surface in the first slices, and that of the sample behind them.
  void ExpectParts(vtkPolyData* mine, int slices)
  {
    const std::int64_t ids = 3 * static_cast<std::int64_t>(this->Image->GetNumberOfPoints());
    const EdgeSurface exact = GatherSurface(mine, 0, ids);
    const EdgeSurface behind = GatherSurface(mine, ids);
    if (GetRank() == 0)
    {
      EXPECT_GT(exact.Triangles.size(), 100u);
      EXPECT_TRUE(AreEqual(
        exact, KeepSlices(ContourByFlyingEdges(this->Image, Isovalue), this->Image, 0, slices)));
      EXPECT_TRUE(AreEqual(behind,
        KeepSlices(ContourByFlyingEdges(this->Sample, Isovalue), this->Sample, slices / 4, 1000)));
      EXPECT_EQ(behind.Triangles.empty(), slices > 90) << "the surface is closed";
    }
  }

  const SharedFolder Folder{ "GrowingSurface" };
  const vtkSmartPointer<vtkImageData> Image = MakeClosedVolume({ 0, 90, 0, 70, 0, 100 }, VTK_SHORT);
  const vtkSmartPointer<vtkImageData> Sample = SubsampleImage(this->Image, 2);
  const std::string Source = this->Folder.GetPath("scan_91x71x101_int16.raw");
  const std::string OtherSource =
    this->Folder.GetPath("other_91x71x101_int16.raw"); ///< of the last rank
  const std::string Index = this->Folder.GetPath("scan.bvol");
  const std::shared_ptr<FinishedLayers> Finished =
    std::make_shared<FinishedLayers>(GetLocalFileSystem(), OpenForeignVolume, this->Index);
  BlockedVolumeHeader Header;                                      ///< of the index
  std::vector<KeyRange> Ranges;                                    ///< of all blocks
  std::map<std::string, std::vector<BlockDirectoryEntry>> Records; ///< of all blocks of this rank
  std::ptrdiff_t Told = 0;                                         ///< of them
  const vtkNew<SampleReader> Reader;
  const vtkSmartPointer<vtkStabbingContour> Contour = MakeContour(this->Reader, Isovalue);
  const ExpectNoErrors ReaderErrors{ this->Reader };
  const ExpectNoErrors ContourErrors{ this->Contour };
};

TEST_F(GrowingSurface, IsExactWhereTheFileIsIndexedAndThatOfTheSampleBehind)
{
  ShowByHand(this->Contour);
  ExpectSurfaceOf(this->Contour->GetOutput(), this->Sample, Isovalue);
  EXPECT_EQ(this->Prepare(), Growing) << "nothing is indexed";
  this->Finish(29);
  EXPECT_EQ(this->Prepare(), Growing) << "a layer has 30 blocks";
  this->Finish(71);
  vtkPolyData* mine = this->Grow();
  this->ExpectParts(mine, 48);
  EXPECT_GT(mine->GetNumberOfPolys(), 0) << "each rank has a part";
  EXPECT_EQ(this->Prepare(), Growing) << "nothing more is indexed";
  EXPECT_NEAR(Refinement::FromValues(this->Contour->GetRefinement()).Share, 0.48, 1e-9);
  this->Finish(110);
  this->Finished->End();
  this->ExpectParts(this->Grow(), 96); // twice as deep
  mine = this->Grow();
  this->ExpectParts(mine, 100);
  EXPECT_EQ(this->Prepare(), RefinementStage::None) << "it is complete";
  vtkSmartPointer<vtkStabbingContour> ofIndex = MakeContour(MakeReader(this->Index), Isovalue);
  ofIndex->UpdatePiece(GetRank(), GetNumberOfRanks(), 0);
  const EdgeSurface grown = GatherSurface(mine);
  EXPECT_TRUE(AreEqual(grown, GatherSurface(ofIndex->GetOutput())));
}

/// The triangles in the cells of a box of vertices, or those elsewhere, and their points. One in a face of cells
/// belongs to the cell before it.
EdgeSurface KeepCells(
  const EdgeSurface& surface, vtkImageData* image, const VertexBox& box, bool isWithin)
{
  const int* size = image->GetDimensions();
  EdgeSurface kept;
  std::set<std::int64_t> edges;
  for (const EdgeSurface::Triangle& triangle : surface.Triangles)
  {
    bool isInside = true;
    for (std::size_t axis = 0; axis < 3; ++axis)
    {
      const std::int64_t stride = axis == 0 ? 1 : axis == 1 ? size[0] : size[0] * size[1];
      const auto find = [&](std::int64_t edge) { return edge / 3 / stride % size[axis]; };
      std::int64_t cell = size[axis];
      for (const std::int64_t edge : triangle)
      {
        cell = std::min(cell, find(edge));
      }
      const bool isFlat = std::all_of(triangle.begin(), triangle.end(),
        [&](std::int64_t edge)
        { return edge % 3 != static_cast<std::int64_t>(axis) && find(edge) == cell; });
      cell -= isFlat ? 1 : 0;
      isInside = isInside && cell >= box.Low[axis] && cell < box.High[axis] - 1;
    }
    if (isInside == isWithin)
    {
      kept.Triangles.push_back(triangle);
      edges.insert(triangle.begin(), triangle.end());
    }
  }
  std::copy_if(surface.Points.begin(), surface.Points.end(), std::back_inserter(kept.Points),
    [&](const EdgePoint& point) { return edges.count(point.Edge) > 0; });
  return kept;
}

/// At the faces of a box that was read alone, normals are one-sided.
EdgeSurface DropNormals(EdgeSurface surface)
{
  for (EdgePoint& point : surface.Points)
  {
    point.Normal = {};
  }
  return surface;
}

/// How far the nearest point of a surface is along x, within a tenth of what is seen there.
double FindNearest(vtkPolyData* mine, const Sight& sight)
{
  std::vector<std::uint64_t> nearest = { 1'000'000 };
  for (vtkIdType point = 0; point < mine->GetNumberOfPoints(); ++point)
  {
    double place[3];
    mine->GetPoint(point, place);
    const double along = place[0] - sight.Eye[0];
    if (std::hypot(place[1] - sight.Eye[1], place[2] - sight.Eye[2]) <=
      0.1 * sight.FindRadius(along))
    {
      nearest[0] = std::min(nearest[0], static_cast<std::uint64_t>(1000 * along));
    }
  }
  ControllerCommunicator(GetRanks()).ReduceMinimum(nearest);
  return static_cast<double>(nearest[0]) / 1000;
}

TEST_F(GrowingSurface, IsExactFirstWhereAPersonLooks)
{
  BlockedVolumeHeader planned = this->Header;
  planned.TimeSteps.back().Source->Chunk = Index3{ 8, 8, 8 };
  this->Finished->Begin(planned);
  const double* const bounds = this->Image->GetBounds();
  Sight sight;
  sight.Eye = { bounds[0] - 100, (bounds[2] + bounds[3]) / 2, (bounds[4] + bounds[5]) / 2 };
  sight.Direction = { 1, 0, 0 };
  sight.Widening = 0.5;
  ShowByHand(this->Contour);
  EXPECT_EQ(this->Prepare(), Growing) << "nobody looks";
  const std::int64_t ids = 3 * static_cast<std::int64_t>(this->Image->GetNumberOfPoints());
  const double distance = FindNearest(this->Contour->GetOutput(), sight);
  this->Finished->LookAlong(sight);
  vtkPolyData* mine = this->Grow();
  const EdgeSurface exact = GatherSurface(mine, 0, ids);
  const EdgeSurface around = GatherSurface(mine, ids);
  const EdgeSurface whole = ContourByFlyingEdges(this->Image, Isovalue);
  if (GetRank() == 0)
  {
    const SightedBox box =
      FindSightedBox(planned, sight, distance, {}, this->Image->GetNumberOfPoints() / 16,
        (*BlockedVolume::Open(this->Folder.GetPath("sample.bvol")))->GetHeader().Grid, nullptr);
    EXPECT_FALSE(box.Exact.IsEmpty());
    EXPECT_GT(exact.Triangles.size(), 100u);
    EXPECT_TRUE(
      AreEqual(DropNormals(exact), DropNormals(KeepCells(whole, this->Image, box.Exact, true))));
    EXPECT_TRUE(AreEqual(around,
      KeepCells(ContourByFlyingEdges(this->Sample, Isovalue), this->Sample, box.Sampled, false)));
  }
  EXPECT_EQ(this->Prepare(), Growing) << "no more is looked at";
  this->Finish(100);
  const EdgeSurface layers = GatherSurface(this->Grow(), 0, ids);
  EXPECT_TRUE(GetRank() > 0 ||
    layers.Triangles.size() > KeepSlices(whole, this->Image, 0, 48).Triangles.size())
    << "the box is kept";
}

/// The index of a stream, which can only be read in order, has its samples.
class GrowingSurfaceOfCopies : public GrowingSurface
{
protected:
  GrowingSurfaceOfCopies()
    : GrowingSurface(false)
  {
  }
};

TEST_F(GrowingSurfaceOfCopies, IsExactWhereTheFileIsCopiedAndThatOfTheSampleBehind)
{
  ShowByHand(this->Contour);
  this->Finish(100);
  this->ExpectParts(this->Grow(), 48);
  this->Finish(110);
  this->Finished->End();
  this->ExpectParts(this->Grow(), 96);
  this->ExpectParts(this->Grow(), 100);
  EXPECT_EQ(this->Prepare(), RefinementStage::None) << "it is complete";
}

TEST_F(GrowingSurfaceOfCopies, StaysAsItIsOnAllRanksWhenTheCopyIsDamaged)
{
  ShowByHand(this->Contour);
  this->Finish(100);
  this->Grow();
  OnFirstRank(
    [&]
    {
      for (const auto& entry :
        std::filesystem::recursive_directory_iterator(HidePath(this->Index + ".stores")))
      {
        if (entry.path().filename() == "blocks")
        {
          std::filesystem::resize_file(entry.path(), 1000);
        }
      }
    });
  this->Finish(110);
  EXPECT_EQ(this->PrepareToTheEnd(), RefinementStage::None);
  this->ExpectParts(this->Contour->GetOutput(), 48);
}

TEST_F(GrowingSurface, WaitsForTheRankThatHasBeenToldTheLeast)
{
  ShowByHand(this->Contour);
  this->Finish(GetRank() == 0 ? 0 : 100);
  EXPECT_EQ(this->Prepare(), Growing);
  EXPECT_EQ(this->Prepare(), Growing);
  this->Finish(GetRank() == 0 ? 100 : 0);
  this->ExpectParts(this->Grow(), 48);
}

TEST_F(GrowingSurface, BeginsAnewAfterAChangeAndInterpolatesArrays)
{
  this->Finish(100);
  ShowByHand(this->Contour);
  this->Grow();
  const char* const array = "density";
  this->Contour->SetValue(0, 30.5);
  this->Contour->ComputeScalarsOff();
  this->Contour->AddInterpolatedArray(array);
  ShowByHand(this->Contour);
  ExpectSurfaceOf(this->Contour->GetOutput(), this->Sample, 30.5);
  vtkPolyData* mine = this->Grow();
  EXPECT_GT(mine->GetNumberOfPolys(), 100);
  double range[2];
  mine->GetPointData()->GetArray(array)->GetRange(range);
  EXPECT_NEAR(range[0], 30.5, 1e-4);
  EXPECT_NEAR(range[1], 30.5, 1e-4);
}

TEST_F(GrowingSurface, StaysThatOfTheSampleForWhomeverTheWindowDoesNotAskFor)
{
  this->Finish(100);
  ExpectSurfaceOf(this->Update(), this->Sample, Isovalue);
  EXPECT_EQ(this->Prepare(), RefinementStage::None);
}

TEST_F(GrowingSurface, StaysAsItIsOnAllRanksWhenTheSourceIsChanged)
{
  ShowByHand(this->Contour);
  OnFirstRank(
    [&]
    {
      std::ofstream(this->Source, std::ios::binary) << "something else";
      std::ofstream(this->OtherSource, std::ios::binary) << "something else";
    });
  this->Finish(100);
  EXPECT_EQ(this->PrepareToTheEnd(), RefinementStage::None);
  ExpectSurfaceOf(this->Contour->GetOutput(), this->Sample, Isovalue);
}

TEST_F(GrowingSurface, StaysAsItIsOnAllRanksWhenTheLastOneFailsLater)
{
  ShowByHand(this->Contour);
  this->Finish(100);
  this->Grow();
  OnFirstRank([&] { std::filesystem::resize_file(this->OtherSource, 1000); });
  this->Finish(110);
  EXPECT_EQ(this->PrepareToTheEnd(), RefinementStage::None);
  OnFirstRank([&] { this->WriteSamples(this->OtherSource); });
  EXPECT_EQ(this->PrepareToTheEnd(), RefinementStage::None) << "it is not tried again";
  // Each rank's piece becomes that of another rank.
  const int ranks = GetNumberOfRanks();
  this->Contour->UpdatePiece((GetRank() + 1) % ranks, ranks, 0);
  this->ExpectParts(this->Contour->GetOutput(), 48);
}

} // namespace
