// SPDX-License-Identifier: BSD-3-Clause
// Arrays of several components: each component, and the magnitude, can be read and queried.
#include "Fixtures/ActiveBlocks.h"
#include "Fixtures/BlocksByForce.h"
#include "Fixtures/VolumeOnDisk.h"
#include "Storage/Spectrum/BlockWorkload.h"
#include "Storage/Store/StoredBlockSource.h"
#include "Surface/Contour/SurfaceExtractor.h"

#include <cmath>
#include <limits>

using namespace isosurface;

namespace
{

const Index3 Size = { 37, 21, 34 };

/// A scalar and a vector on one grid.
template <typename T>
struct VectorVolume
{
  explicit VectorVolume(const Index3& size = Size)
    : Scalar(MakeVolume<std::int16_t>(size))
  {
    for (unsigned component = 0; component < 3; ++component)
    {
      this->Components.push_back(MakeVolume<T>(size, component + 1));
    }
  }

  /// The samples of a rank: the components of a vertex are adjacent, as in a vtkDataArray.
  struct Part
  {
    Part(const VectorVolume& volume, const VertexBox& box)
      : Scalar(volume.Scalar, box)
    {
      const Index3 size = box.GetSize();
      VisitVertices(box,
        [&](const Index3& vertex)
        {
          for (const SampleVolume<T>& component : volume.Components)
          {
            this->Tuples.push_back(component.At(vertex));
          }
        });
      this->Piece.Box = box;
      this->Piece.Arrays.push_back(this->Scalar.View);
      for (std::size_t component = 0; component < 3; ++component)
      {
        SampleView view;
        view.Type = ValueTypeOf<T>::Value;
        view.First = this->Tuples.data() + (this->Tuples.empty() ? 0 : component);
        view.Stride = { 3, 3 * size[0], 3 * size[0] * size[1] };
        view.Available = box;
        view.Box = box;
        this->Piece.Arrays.push_back(view);
      }
    }
    PieceOfVolume<std::int16_t> Scalar;
    std::vector<T> Tuples;
    VolumePiece Piece;
  };

  static std::vector<ArrayDescription> Describe()
  {
    return { { "scalar", ValueType::Int16 }, { "vector", ValueTypeOf<T>::Value, 3 } };
  }

  void Write(FileSystem& disk, const BlockedVolumeSettings& settings, int ranks,
    const Layout& layout = SlabOfEach) const
  {
    ThreadCommunicator::Run(ranks,
      [&](Communicator& communicator)
      {
        const Part part(*this, layout(communicator.GetRank(), ranks, this->Scalar.GetDimensions()));
        const auto written = BlockedVolumeWriter(communicator, disk)
                               .Write(VolumePath, MakeGeometry(this->Scalar.GetDimensions()),
                                 Describe(), part.Piece, settings);
        ASSERT_TRUE(written.IsOk()) << written.GetStatus().GetMessage();
      });
  }

  /// As the format has it.
  SampleVolume<double> FindMagnitudes() const
  {
    return SampleVolume<double>(this->Scalar.GetDimensions(),
      [&](auto i, auto j, auto k)
      {
        double sum = 0;
        for (const SampleVolume<T>& component : this->Components)
        {
          const auto value = static_cast<double>(component.At(i, j, k));
          sum += value * value;
        }
        return std::sqrt(sum);
      });
  }

  SampleVolume<std::int16_t> Scalar;
  std::vector<SampleVolume<T>> Components;
};

/// Expects the variable's blocks at all levels to be the subsampled volume.
template <typename T>
void ExpectReadsBack(BlockedVolume& opened, const SampleVolume<T>& volume, std::size_t variable)
{
  QueryStatistics statistics;
  for (int level = 0; level < opened.GetNumberOfLevels(); ++level)
  {
    isosurface::ExpectReadsBack(opened, volume, level, statistics, variable);
  }
}

/// Expects queries and spectrum to be those of the samples themselves.
template <typename T>
void ExpectIndexed(BlockedVolume& opened, const SampleVolume<T>& volume, std::size_t variable)
{
  for (const double isovalue : { 3.0, 4.5, 40.0, 81.25, 150.0, 1e9 })
  {
    QueryStatistics statistics;
    const auto active =
      Require(FindActiveBlocks(opened, { { 0, variable, { isovalue } } }, statistics));
    EXPECT_EQ(SortBlocks(active), FindBlocksByForce(volume, opened.GetBlockGrid(), { isovalue }))
      << "variable " << variable << ", isovalue " << isovalue;
  }
  const auto spectrum = Require(opened.GetSpectrum(0, variable));
  BlockWorkload workload(spectrum->Bins);
  workload.Count(volume.GetView());
  WorkloadSpectrum expected(spectrum->Bins);
  workload.MoveTo(expected);
  EXPECT_GT(spectrum->Bins.Count, 0u);
  EXPECT_EQ(spectrum->Triangles, expected.Triangles);
  EXPECT_EQ(spectrum->ActiveCells, expected.ActiveCells);
}

template <typename T>
class VectorsOfType : public ::testing::Test
{
};
TYPED_TEST_SUITE(VectorsOfType, AllValueTypes, );

} // namespace

TYPED_TEST(VectorsOfType, AreReadAndIndexedByComponentAndByMagnitude)
{
  const VectorVolume<TypeParam> volume;
  MemoryDisk disk;
  BlockedVolumeSettings settings = MakeSettings(16, 3);
  settings.Compression = { SegmentCodec::Zstd, 1 };
  volume.Write(disk, settings, 2, OverlappingColumns);
  const auto opened = OpenVolume(disk);
  ASSERT_EQ(opened->GetVariables().GetCount(), 5u);
  ExpectReadsBack(*opened, volume.Scalar, 0);
  ExpectIndexed(*opened, volume.Scalar, 0);
  for (std::size_t component = 0; component < 3; ++component)
  {
    ExpectReadsBack(*opened, volume.Components[component], 1 + component);
    ExpectIndexed(*opened, volume.Components[component], 1 + component);
  }
  const SampleVolume<double> magnitudes = volume.FindMagnitudes();
  ExpectReadsBack(*opened, magnitudes, 4);
  ExpectIndexed(*opened, magnitudes, 4);
  const auto extremes = std::minmax_element(magnitudes.Samples.begin(), magnitudes.Samples.end());
  const KeyRange& range = opened->GetHeader().TimeSteps[0].Ranges[4];
  EXPECT_EQ(range.Minimum, MakeValueKey(*extremes.first));
  EXPECT_EQ(range.Maximum, MakeValueKey(*extremes.second));
}

TEST(BlockedVolumeComponents, GiveTheSameFilesOnAnyNumberOfRanks)
{
  const VectorVolume<float> volume;
  for (const DistributionMethod method :
    { DistributionMethod::Greedy, DistributionMethod::Balanced })
  {
    BlockedVolumeSettings settings = MakeSettings(16, 3);
    settings.Distribution = method;
    MemoryDisk one;
    volume.Write(one, settings, 1);
    for (int ranks = 2; ranks <= 7; ++ranks)
    {
      for (const Layout& layout : { Layout(SlabOfEach), Layout(WholeOnAll), Layout(WholeOnLast) })
      {
        MemoryDisk disk;
        volume.Write(disk, settings, ranks, layout);
        EXPECT_EQ(disk.Copy(), one.Copy()) << GetDistributionName(method) << ", " << ranks;
      }
    }
  }
}

TEST(BlockedVolumeComponents, HaveATreeEachAndOneForTheMagnitude)
{
  MemoryDisk disk;
  VectorVolume<float>().Write(disk, MakeSettings(16, 1), 1);
  const auto names = Require(disk.List(HidePath(VolumePath + ".stores") + "/000001/store-00000"));
  EXPECT_EQ(names,
    (std::vector<std::string>{ "array-0.tree", "array-1-component-0.tree",
      "array-1-component-1.tree", "array-1-component-2.tree", "array-1-magnitude.tree", "blocks",
      "directory" }));
}

TEST(BlockedVolumeComponents, AreReadAloneButMagnitudesByOneReadOfAll)
{
  const VectorVolume<float> volume;
  MemoryDisk disk;
  volume.Write(disk, MakeSettings(16, 1), 1);
  const auto opened = OpenVolume(disk);
  QueryStatistics statistics;
  const auto share = Require(opened->ListBlocks(0, statistics));
  std::vector<std::uint64_t> bytes;
  // The components of a magnitude do not go to the cache.
  for (const std::size_t variable : { 4, 1, 2, 3 })
  {
    QueryStatistics cost;
    const std::uint64_t reads = disk.GetReads();
    ASSERT_TRUE(opened->ReadBlock(share.front(), 0, variable, 0, cost).IsOk());
    EXPECT_EQ(disk.GetReads() - reads, 1u) << variable;
    EXPECT_EQ(cost.BlocksRead, 1u);
    bytes.push_back(cost.BytesRead);
    QueryStatistics again;
    ASSERT_TRUE(opened->ReadBlock(share.front(), 0, variable, 0, again).IsOk());
    EXPECT_EQ(again.BlockCacheHits, 1u);
  }
  EXPECT_EQ(bytes[0], bytes[1] + bytes[2] + bytes[3]);
}

TEST(BlockedVolumeComponents, AndTheirMagnitudeTakeOneReadInAnyOrder)
{
  const VectorVolume<float> volume;
  MemoryDisk disk;
  volume.Write(disk, MakeSettings(16, 1), 1);
  QueryStatistics statistics;
  for (const std::uint64_t cacheBytes : { std::uint64_t{ 0 }, std::uint64_t{ 1 } << 28 })
  {
    for (const std::vector<std::size_t>& variables :
      std::vector<std::vector<std::size_t>>{ { 4, 1, 2, 3 }, { 3, 4, 2, 1 }, { 2, 4, 4, 2 } })
    {
      const auto opened = OpenVolume(disk, cacheBytes);
      const auto share = Require(opened->ListBlocks(0, statistics));
      QueryStatistics cost;
      const auto blocks = Require(opened->ReadVariables(share.front(), 0, variables, 0, cost));
      EXPECT_LE(cost.BlocksRead, variables.front() == 4 ? 1u : 3u);
      for (std::size_t n = 0; n < variables.size(); ++n)
      {
        const auto alone =
          Require(OpenVolume(disk)->ReadBlock(share.front(), 0, variables[n], 0, statistics));
        EXPECT_EQ(blocks[n]->View.Type, alone->View.Type);
        ASSERT_EQ(blocks[n]->Bytes.GetSize(), alone->Bytes.GetSize());
        EXPECT_EQ(
          std::memcmp(blocks[n]->Bytes.GetData(), alone->Bytes.GetData(), alone->Bytes.GetSize()),
          0);
      }
    }
  }
}

TEST(BlockedVolumeComponents, InTheCacheGiveTheMagnitudeWithoutARead)
{
  const VectorVolume<float> volume;
  MemoryDisk disk;
  volume.Write(disk, MakeSettings(16, 1), 1);
  const auto opened = OpenVolume(disk);
  for (int level = 0; level < opened->GetNumberOfLevels(); ++level)
  {
    QueryStatistics statistics;
    const auto share = Require(opened->ListBlocks(0, statistics, level));
    ASSERT_TRUE(opened->ReadVariables(share.front(), 0, { 1, 2, 3 }, level, statistics).IsOk());
    QueryStatistics cost;
    ASSERT_TRUE(opened->ReadBlock(share.front(), 0, 4, level, cost).IsOk());
    EXPECT_EQ(cost.BlocksRead, 0u) << "level " << level;
  }
}

TEST(BlockedVolumeComponents, BecomeOneArrayOfTuplesOnASurface)
{
  const VectorVolume<float> volume;
  MemoryDisk disk;
  volume.Write(disk, MakeSettings(16, 2), 1);
  const auto opened = OpenVolume(disk);
  for (int level = 0; level < 3; ++level)
  {
    for (const std::size_t component : { 0, 1, 2 })
    {
      // On the surface of a component, the component has the isovalue.
      QueryStatistics statistics;
      auto active =
        Require(FindActiveBlocks(*opened, { { 0, 1 + component, { 40.5 } } }, statistics, level));
      StoredBlockSource source(*opened, 0, 1 + component, level, active);
      source.SetAttributes({ 1, 0 });
      ContourRequest request;
      request.Isovalues = { 40.5 };
      request.Attributes = { { ValueType::Float32, 3 }, { ValueType::Int16, 1 } };
      const auto surface =
        Require(ExtractSurface(opened->GetHeader().Grid.Coarsen(level), source, request, 2));
      ASSERT_GT(surface.NumberOfPoints, 0u);
      const SurfaceAttribute& vectors = surface.Attributes[0];
      ASSERT_EQ(vectors.Bytes.GetSize(), surface.NumberOfPoints * 3 * sizeof(float));
      const auto* values = reinterpret_cast<const float*>(vectors.Bytes.GetData());
      for (std::size_t point = 0; point < surface.NumberOfPoints; ++point)
      {
        ASSERT_NEAR(values[3 * point + component], 40.5f, 1e-4f);
      }
    }
  }
}

TEST(BlockedVolumeComponents, OfNaNAndInfinitiesHaveMagnitudesOfNaNAndInfinity)
{
  VectorVolume<float> volume;
  volume.Components[0].Samples[5] = std::numeric_limits<float>::quiet_NaN();
  volume.Components[1].Samples[5000] = -std::numeric_limits<float>::infinity();
  volume.Components[2].Samples[9000] = std::numeric_limits<float>::max();
  MemoryDisk disk;
  volume.Write(disk, MakeSettings(16, 2), 3);
  const auto opened = OpenVolume(disk);
  const SampleVolume<double> magnitudes = volume.FindMagnitudes();
  ASSERT_TRUE(std::isnan(magnitudes.Samples[5]));
  ASSERT_TRUE(std::isinf(magnitudes.Samples[5000]));
  ExpectIndexed(*opened, magnitudes, 4);
  // All are finite: the magnitude of the maximum float is not infinity.
  EXPECT_EQ(
    opened->GetHeader().TimeSteps[0].Ranges[4].Maximum, MakeValueKey(magnitudes.Samples[9000]));
}

TEST(BlockedVolumeComponents, ReportDamageOfAnyFile)
{
  MemoryDisk disk;
  VectorVolume<std::uint8_t>({ 40, 18, 17 }).Write(disk, MakeSettings(16, 1), 1);
  const auto readAll = [&]() -> Status
  {
    ISOSURFACE_ASSIGN_OR_RETURN(
      const auto opened, BlockedVolume::Open(VolumePath, disk, std::make_shared<BlockCache>(0)));
    QueryStatistics statistics;
    for (const int level : { 0, 2 })
    {
      ISOSURFACE_ASSIGN_OR_RETURN(const auto share, opened->ListBlocks(0, statistics, level));
      for (std::size_t variable = 0; variable < 5; ++variable)
      {
        ISOSURFACE_RETURN_IF_ERROR(
          FindActiveBlocks(*opened, { { 0, variable, { 40.0, 100.0 } } }, statistics, level)
            .GetStatus());
        ISOSURFACE_RETURN_IF_ERROR(opened->GetSpectrum(0, variable, level).GetStatus());
        for (const BlockReference& block : share)
        {
          ISOSURFACE_RETURN_IF_ERROR(
            opened->ReadBlock(block, 0, variable, level, statistics).GetStatus());
        }
      }
    }
    return Status::Ok();
  };
  ASSERT_TRUE(readAll().IsOk()) << readAll().GetMessage();
  std::mt19937 random(9);
  for (const auto& file : disk.Copy())
  {
    for (int turn = 0; turn < 20; ++turn)
    {
      // The end of a record is padding.
      const std::size_t size = file.first.find("blocks") == std::string::npos
        ? file.second.size()
        : std::min<std::size_t>(file.second.size(), 20000);
      disk.GetFile(file.first)[random() % size] ^= 0x10;
      const Status status = readAll();
      EXPECT_TRUE(status.IsOk() || status.GetCode() == StatusCode::Corrupt ||
        status.GetCode() == StatusCode::Unsupported)
        << status.GetMessage();
      if (file.first.find(".tree") != std::string::npos)
      {
        EXPECT_FALSE(status.IsOk()) << file.first;
      }
      disk.GetFile(file.first) = file.second;
    }
  }
}
