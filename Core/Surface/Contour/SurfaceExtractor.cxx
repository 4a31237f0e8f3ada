// SPDX-License-Identifier: BSD-3-Clause
#include "Surface/Contour/SurfaceExtractor.h"

#include "Ground/Base/FirstFailure.h"
#include "Ground/Base/ParallelFor.h"
#include "Ground/Base/ParallelQueue.h"
#include "Ground/Base/WithinMemory.h"
#include "Surface/Contour/BrickLattice.h"
#include "Surface/Contour/BrickScan.h"
#include "Surface/Contour/PointRestriction.h"
#include "Surface/Contour/SurfaceAssembler.h"

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstring>
#include <mutex>
#include <utility>
#include <vector>

namespace isosurface
{
namespace
{

/// Some blocks of a source, as a source of their own. The source must outlive this object.
class ChosenBlocks : public BlockSource
{
public:
  ChosenBlocks(BlockSource& source, std::vector<std::size_t> blocks)
    : Source(source)
    , Blocks(std::move(blocks))
  {
  }
  std::size_t GetNumberOfBlocks() const override { return this->Blocks.size(); }
  Index3 GetLatticeCoordinates(std::size_t block) const override
  {
    return this->Source.GetLatticeCoordinates(this->Blocks[block]);
  }
  VertexBox GetVertices(std::size_t block) const override
  {
    return this->Source.GetVertices(this->Blocks[block]);
  }
  ValueType GetValueType() const override { return this->Source.GetValueType(); }
  Result<BlockSamples> Acquire(std::size_t block) override
  {
    return this->Source.Acquire(this->Blocks[block]);
  }

private:
  BlockSource& Source;
  std::vector<std::size_t> Blocks; ///< numbers in the source
};

/**
 * The first phase of an extraction whose blocks become known only during it. Each block is scanned
 * as if it had no neighbours. When all are known, points that a neighbour owns are dropped, so the
 * result is that of BrickScan::Run for the same blocks, in the order of their numbers in the
 * source.
 *
 * Cost beside that of BrickScan: points on the faces of blocks that meet are made more than once.
 */
class QueuedScan
{
public:
  QueuedScan(const GridGeometry& geometry, BlockSource& source, const ContourRequest& request,
    BrickScan& scan)
    : Geometry(geometry)
    , Source(source)
    , Request(request)
    , Scan(scan)
  {
  }

  /// Scans all blocks of the queue into the scan; returns their lattice. Errors: those of the
  /// queue, of BrickLattice::Cut and of BrickScan::Run.
  Result<BrickLattice> Run(BlockQueue& queue, int threads, const Progress& progress)
  {
    ISOSURFACE_RETURN_IF_ERROR(this->ScanAll(queue, threads, progress));
    std::sort(this->Scanned.begin(), this->Scanned.end(),
      [](const ScannedBlock& a, const ScannedBlock& b) { return a.Block < b.Block; });
    std::vector<std::size_t> blocks;
    blocks.reserve(this->Scanned.size());
    for (const ScannedBlock& scanned : this->Scanned)
    {
      blocks.push_back(scanned.Block);
    }
    ISOSURFACE_ASSIGN_OR_RETURN(auto lattice,
      BrickLattice::Cut(this->Geometry.GetDimensions(),
        ChosenBlocks(this->Source, std::move(blocks)), this->Request.ClosedSides));
    this->Join(lattice);
    this->DropWhatOthersOwn(lattice, threads);
    return lattice;
  }

private:
  /// A block with its results, which count its bricks alone.
  struct ScannedBlock
  {
    std::size_t Block;
    BrickScan::Surfaces Results;
  };

  Status ScanBlock(std::size_t block, int thread)
  {
    ISOSURFACE_ASSIGN_OR_RETURN(const auto lattice,
      BrickLattice::Cut(this->Geometry.GetDimensions(), ChosenBlocks(this->Source, { block }),
        this->Request.ClosedSides));
    ScannedBlock scanned{ block, {} };
    this->Scan.Allocate(lattice, scanned.Results);
    ISOSURFACE_RETURN_IF_ERROR(this->Scan.ScanBlock(lattice, 0, block, scanned.Results, thread));
    const std::lock_guard<std::mutex> lock(this->Mutex);
    this->Scanned.push_back(std::move(scanned));
    return Status::Ok();
  }

  Status ScanAll(BlockQueue& queue, int threads, const Progress& progress)
  {
    FirstFailure failure;
    const auto take = [&]() -> std::vector<std::size_t>
    {
      auto blocks = failure.IsFound() ? std::vector<std::size_t>() : queue.Take();
      if (!blocks.IsOk())
      {
        failure.Keep(blocks.GetStatus());
        return {};
      }
      return std::move(*blocks);
    };
    const auto scan = [&](std::size_t block, int thread)
    { failure.Run([&] { return this->ScanBlock(block, thread); }); };
    const bool finished = ParallelQueue(take, queue.GetExpectedBlocks(), threads, scan, progress);
    ISOSURFACE_RETURN_IF_ERROR(failure.Get());
    return finished ? Status::Ok() : Status(StatusCode::Aborted, "The extraction was aborted.");
  }

  /// Puts the results of all blocks in their order.
  void Join(const BrickLattice& lattice)
  {
    BrickScan::Surfaces& all = this->Scan.GetAllSurfaces();
    this->Scan.Allocate(lattice, all);
    const std::size_t bricks = lattice.GetBricks().size();
    const std::size_t isovalues = this->Request.Isovalues.size();
    for (std::size_t block = 0; block < this->Scanned.size(); ++block)
    {
      const BrickScan::Surfaces& parts = this->Scanned[block].Results;
      const std::size_t first = lattice.GetFirstBrick(block);
      const std::size_t count = parts.Ownerships.size();
      std::copy_n(parts.Ownerships.begin(), count, all.Ownerships.begin() + first);
      for (std::size_t isovalue = 0; isovalue < isovalues; ++isovalue)
      {
        std::copy_n(parts.OfBricks.begin() + isovalue * count, count,
          all.OfBricks.begin() + isovalue * bricks + first);
      }
    }
    this->Scanned.clear();
  }

  void DropWhatOthersOwn(const BrickLattice& lattice, int threads)
  {
    BrickScan::Surfaces& all = this->Scan.GetAllSurfaces();
    const std::size_t bricks = lattice.GetBricks().size();
    std::vector<std::vector<std::uint32_t>> dropped(static_cast<std::size_t>(std::max(1, threads)));
    ParallelFor(bricks, threads,
      [&](std::size_t number, int thread)
      {
        const Brick& brick = lattice.GetBricks()[number];
        const BrickSamples position = MakeBrickSamples(this->Geometry, brick.Vertices);
        const BrickOwnership before = all.Ownerships[number];
        const BrickOwnership after =
          lattice.FindNeighborhood(number).ComputeOwnership(position.Size);
        if (std::memcmp(&before, &after, sizeof(before)) == 0)
        {
          return;
        }
        all.Ownerships[number] = after;
        for (std::size_t part = number; part < all.OfBricks.size(); part += bricks)
        {
          if (all.OfBricks[part].Inside)
          {
            RestrictPoints(brick.Vertices, before, after, this->Request.Attributes,
              all.OfBricks[part], dropped[static_cast<std::size_t>(thread)]);
          }
        }
      });
  }

  const GridGeometry& Geometry;
  BlockSource& Source;
  const ContourRequest& Request;
  BrickScan& Scan;
  std::mutex Mutex; ///< guards the blocks
  std::vector<ScannedBlock> Scanned;
};

// The first phase usually takes half of the time.
constexpr double ScanEnd = 0.5;

Status CheckRequest(const GridGeometry& geometry, const ContourRequest& request)
{
  for (const AttributeLayout& attribute : request.Attributes)
  {
    if (attribute.NumberOfComponents < 1)
    {
      return { StatusCode::InvalidArgument, "An attribute to interpolate has no components." };
    }
  }
  for (const std::int64_t size : geometry.GetDimensions())
  {
    if (size < 1)
    {
      return { StatusCode::InvalidArgument, "The grid has no vertices." };
    }
  }
  if (request.Lines)
  {
    return request.Lines->Check(geometry.GetDimensions());
  }
  return Status::Ok();
}

/// Scans all blocks of a source, or those of a queue.
Result<BrickLattice> ScanBlocks(const GridGeometry& geometry, BlockSource& source,
  const ContourRequest& request, BlockQueue* queue, int threads, const Progress& progress,
  BrickScan& scan)
{
  if (queue)
  {
    return QueuedScan(geometry, source, request, scan).Run(*queue, threads, progress);
  }
  ISOSURFACE_ASSIGN_OR_RETURN(
    auto lattice, BrickLattice::Cut(geometry.GetDimensions(), source, request.ClosedSides));
  ISOSURFACE_RETURN_IF_ERROR(scan.Run(lattice, progress));
  return lattice;
}

/// Turns the corners of all cells the other way round.
template <typename Index>
void TurnCells(Buffer<Index>& corners, const Buffer<Index>& offsets, std::size_t cells)
{
  for (std::size_t cell = 0; cell < cells; ++cell)
  {
    const bool areTriangles = offsets.IsEmpty();
    const auto begin = areTriangles ? 3 * cell : static_cast<std::size_t>(offsets[cell]);
    const auto end = areTriangles ? begin + 3 : static_cast<std::size_t>(offsets[cell + 1]);
    std::reverse(corners.GetData() + begin + 1, corners.GetData() + end);
  }
}

Result<Surface> ExtractWithinMemory(const GridGeometry& geometry, BlockSource& source,
  const ContourRequest& request, BlockQueue* queue, int threads, const Progress& progress)
{
  const auto start = std::chrono::steady_clock::now();
  Surface surface;
  if (source.GetNumberOfBlocks() != 0)
  {
    ISOSURFACE_RETURN_IF_ERROR(CheckRequest(geometry, request));
  }
  BrickScan scan(geometry, source, request, threads);
  ISOSURFACE_ASSIGN_OR_RETURN(const auto lattice,
    ScanBlocks(
      geometry, source, request, queue, threads, MakePartOfProgress(progress, 0.0, ScanEnd), scan));
  surface.NumberOfBlocks = lattice.GetNumberOfBlocks();
  surface.AcquireSeconds = scan.GetAcquireSeconds();

  SurfaceAssembler assembler(geometry, lattice, scan, request);
  if (!assembler.Run(threads, MakePartOfProgress(progress, ScanEnd, 1.0), surface))
  {
    return Status(StatusCode::Aborted, "The extraction was aborted.");
  }
  if (request.ClosedSides.AreBeyondInside && surface.Connectivity.Is64Bit)
  {
    TurnCells(surface.Connectivity.Values64, surface.Offsets.Values64, surface.NumberOfCells);
  }
  else if (request.ClosedSides.AreBeyondInside)
  {
    TurnCells(surface.Connectivity.Values32, surface.Offsets.Values32, surface.NumberOfCells);
  }
  surface.TotalSeconds =
    std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return surface;
}

/// That there is not enough memory is an error like others.
Result<Surface> Extract(const GridGeometry& geometry, BlockSource& source,
  const ContourRequest& request, BlockQueue* queue, int threads, const Progress& progress)
{
  return RunWithinMemory("", "There is not enough memory for the isosurface.",
    [&] { return ExtractWithinMemory(geometry, source, request, queue, threads, progress); });
}

} // namespace

bool HasDoublePoints(const GridGeometry& geometry, const ContourRequest& request)
{
  return request.Precision == PointPrecision::Double ||
    (request.Precision == PointPrecision::Default && NeedsDoublePoints(geometry, request.Lines));
}

GridGeometry GetNumberedGrid(const GridGeometry& geometry, const ContourRequest& request)
{
  GridGeometry grid = geometry;
  for (std::size_t side = 0; side < 6 && !request.ClosedSides.IsEmpty(); ++side)
  {
    grid.Extent[side] += side % 2 == 0 ? -1 : 1;
  }
  return grid;
}

std::int64_t CountGlobalIds(const GridGeometry& geometry, const ContourRequest& request)
{
  return (request.DropDegenerateTriangles ? 4 : 3) *
    GetNumberedGrid(geometry, request).GetNumberOfVertices() *
    static_cast<std::int64_t>(request.Isovalues.size());
}

Result<Surface> ExtractSurface(const GridGeometry& geometry, BlockSource& source,
  const ContourRequest& request, int threads, const Progress& progress)
{
  return Extract(geometry, source, request, nullptr, threads, progress);
}

Result<Surface> ExtractQueuedSurface(const GridGeometry& geometry, BlockSource& source,
  const ContourRequest& request, BlockQueue& queue, int threads, const Progress& progress)
{
  // Also in the second phase others may need this rank's help.
  const auto advance = [&](double fraction)
  {
    queue.LetOthersIn();
    return !progress || progress(fraction);
  };
  return Extract(geometry, source, request, &queue, threads, advance);
}

} // namespace isosurface
