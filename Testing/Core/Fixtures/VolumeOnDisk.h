// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_Testing_VolumeOnDisk_h
#define isosurface_Testing_VolumeOnDisk_h

#include "Fixtures/MemoryDisk.h"
#include "Fixtures/SampleVolume.h"
#include "Fixtures/ThreadCommunicator.h"
#include "Storage/Store/BlockedVolume.h"
#include "Storage/Writing/BlockedVolumeWriter.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <random>
#include <string>
#include <vector>

namespace isosurface
{

inline const std::string VolumePath = "/data/volume.bvol";

inline GridGeometry MakeGeometry(const Index3& size)
{
  GridGeometry geometry;
  geometry.Extent = { -3, size[0] - 4, 0, size[1] - 1, 10, size[2] + 9 };
  geometry.Origin = { 0.1, -1e-7, 12345.678901234567 };
  geometry.Spacing = { 1.0 / 3.0, 0.7, 2 };
  return geometry;
}

/// How the volume lies on the ranks: the box of each.
using Layout = std::function<VertexBox(int rank, int ranks, const Index3& size)>;

inline VertexBox WholeOnAll(int, int, const Index3& size)
{
  return { { 0, 0, 0 }, size };
}
/// Slabs that share no vertices; empty where there are more ranks than slices.
inline VertexBox SlabOfEach(int rank, int ranks, const Index3& size)
{
  return { { 0, 0, size[2] * rank / ranks }, { size[0], size[1], size[2] * (rank + 1) / ranks } };
}
/// Columns along x that overlap by two vertices.
inline VertexBox OverlappingColumns(int rank, int ranks, const Index3& size)
{
  return { { std::max<std::int64_t>(0, size[0] * rank / ranks - 1), 0, 0 },
    { std::min(size[0], size[0] * (rank + 1) / ranks + 1), size[1], size[2] } };
}
/// Rank 0 has nothing, the last one everything.
inline VertexBox WholeOnLast(int rank, int ranks, const Index3& size)
{
  return rank == ranks - 1 ? VertexBox{ { 0, 0, 0 }, size } : VertexBox{};
}

/// A copy of a part of a volume, as a rank of its own would have it.
template <typename T>
struct PieceOfVolume
{
  PieceOfVolume(const SampleVolume<T>& volume, const VertexBox& box)
    : Copy(box.GetSize(),
        [&](auto i, auto j, auto k)
        { return volume.At(box.Low[0] + i, box.Low[1] + j, box.Low[2] + k); })
    , View(Copy.GetView())
  {
    this->View.Available = box;
    this->View.Box = box;
  }
  SampleVolume<T> Copy;
  SampleView View;
};

/// Writes a volume of one array "density" as `ranks` ranks, each with its piece; returns what
/// each rank got.
template <typename T>
std::vector<Result<WriteStatistics>> WriteVolume(FileSystem& disk, const SampleVolume<T>& volume,
  const BlockedVolumeSettings& settings, int ranks = 1, const Layout& layout = SlabOfEach,
  const Progress& progress = {})
{
  std::vector<Result<WriteStatistics>> results(
    static_cast<std::size_t>(ranks), Status(StatusCode::Aborted, "not run"));
  ThreadCommunicator::Run(ranks,
    [&](Communicator& communicator)
    {
      const int rank = communicator.GetRank();
      const VertexBox box = layout(rank, ranks, volume.GetDimensions());
      const PieceOfVolume<T> part(volume, box);
      VolumePiece piece;
      piece.Box = box;
      piece.Arrays = { part.View };
      BlockedVolumeWriter writer(communicator, disk);
      results[static_cast<std::size_t>(rank)] =
        writer.Write(VolumePath, MakeGeometry(volume.GetDimensions()),
          { { "density", ValueTypeOf<T>::Value } }, piece, settings, progress);
    });
  return results;
}

template <typename T>
void WriteVolumeOk(FileSystem& disk, const SampleVolume<T>& volume,
  const BlockedVolumeSettings& settings, int ranks = 1, const Layout& layout = SlabOfEach)
{
  for (const auto& result : WriteVolume(disk, volume, settings, ranks, layout))
  {
    ASSERT_TRUE(result.IsOk()) << result.GetStatus().GetMessage();
  }
}

inline BlockedVolumeSettings MakeSettings(
  int blockSize, std::uint32_t stores, DistributionMethod method = DistributionMethod::Greedy)
{
  BlockedVolumeSettings settings;
  settings.BlockSize = blockSize;
  settings.NumberOfStores = stores;
  settings.Distribution = method;
  settings.RandomSeed = 7;
  settings.Threads = 2;
  return settings;
}

/// Opens the volume with a cache of its own.
inline std::shared_ptr<BlockedVolume> OpenVolume(FileSystem& disk,
  std::uint64_t cacheBytes = std::uint64_t{ 1 } << 28, VolumeOpener opener = nullptr)
{
  return Require(
    BlockedVolume::Open(VolumePath, disk, std::make_shared<BlockCache>(cacheBytes), opener));
}

/// Writes a volume and opens it, as above.
template <typename T>
std::shared_ptr<BlockedVolume> WriteAndOpen(FileSystem& disk, const SampleVolume<T>& volume,
  const BlockedVolumeSettings& settings, int ranks = 1, const Layout& layout = SlabOfEach)
{
  WriteVolumeOk(disk, volume, settings, ranks, layout);
  return OpenVolume(disk);
}

/// Expects each block of a variable, at a level, to have the samples of the subsampled volume,
/// ghost layers included, bit by bit. Returns the bytes of the blocks.
template <typename T>
std::uint64_t ExpectReadsBack(BlockedVolume& opened, const SampleVolume<T>& volume, int level,
  QueryStatistics& statistics, std::size_t variable = 0, std::size_t step = 0)
{
  const StoredLevel stored = opened.FindLevel(level);
  const auto blocks = Require(opened.ListBlocks(step, statistics, level));
  EXPECT_EQ(static_cast<std::int64_t>(blocks.size()), stored.Grid->GetNumberOfBlocks());
  std::uint64_t bytes = 0;
  for (const BlockReference& reference : blocks)
  {
    const auto block = Require(opened.ReadBlock(reference, step, variable, level, statistics));
    const SampleView& view = block->View;
    EXPECT_EQ(view.Box, stored.Grid->GetVertices(reference.Block, stored.Level));
    EXPECT_EQ(view.Available, stored.Grid->GetGhostedVertices(reference.Block, stored.Level));
    bytes += block->Bytes.GetSize();
    SCOPED_TRACE("block " + std::to_string(reference.Block) + ", level " + std::to_string(level));
    ExpectSamples(view, view.Available, volume, level);
  }
  return bytes;
}

/// The numbers of blocks, ascending.
inline std::vector<std::int64_t> SortBlocks(const std::vector<BlockReference>& references)
{
  std::vector<std::int64_t> blocks;
  for (const BlockReference& reference : references)
  {
    blocks.push_back(reference.Block);
  }
  std::sort(blocks.begin(), blocks.end());
  return blocks;
}

/// Smooth values with noise and an empty corner.
template <typename T>
SampleVolume<T> MakeVolume(const Index3& size, unsigned seed = 1)
{
  std::mt19937 random(seed);
  return SampleVolume<T>(size,
    [&](auto i, auto j, auto k)
    {
      const std::int64_t distance = i * i + j * j + k * k;
      return i < 20 && j < 20 && k < 20
        ? T(3)
        : static_cast<T>(distance / 40 % 100 + static_cast<std::int64_t>(random() % 5));
    });
}

} // namespace isosurface

#endif
