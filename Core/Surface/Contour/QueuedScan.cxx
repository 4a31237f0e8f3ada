// SPDX-License-Identifier: BSD-3-Clause
#include "Surface/Contour/QueuedScan.h"

#include "Ground/Base/FirstFailure.h"
#include "Ground/Base/ParallelFor.h"
#include "Ground/Base/ParallelQueue.h"
#include "Surface/Contour/ChosenBlocks.h"
#include "Surface/Contour/PointRestriction.h"

#include <algorithm>
#include <cstdint>
#include <cstring>

namespace isosurface
{

Result<BrickLattice> QueuedScan::Run(BlockQueue& queue, int threads, const Progress& progress)
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
    BrickLattice::Cut(this->Geometry.GetDimensions(), ChosenBlocks(this->Source, std::move(blocks)),
      this->Request.ClosedSides));
  this->Join(lattice);
  this->DropWhatOthersOwn(lattice, threads);
  return lattice;
}

Status QueuedScan::ScanAll(BlockQueue& queue, int threads, const Progress& progress)
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

Status QueuedScan::ScanBlock(std::size_t block, int thread)
{
  ISOSURFACE_ASSIGN_OR_RETURN(const auto lattice,
    BrickLattice::Cut(this->Geometry.GetDimensions(), ChosenBlocks(this->Source, { block }),
      this->Request.ClosedSides));
  ScannedBlock scanned{ block, {} };
  this->Scan.Allocate(lattice, scanned.Parts);
  ISOSURFACE_RETURN_IF_ERROR(this->Scan.ScanBlock(lattice, 0, block, scanned.Parts, thread));
  const std::lock_guard<std::mutex> lock(this->Mutex);
  this->Scanned.push_back(std::move(scanned));
  return Status::Ok();
}

void QueuedScan::Join(const BrickLattice& lattice)
{
  BrickScan::Parts& all = this->Scan.GetAllParts();
  this->Scan.Allocate(lattice, all);
  const std::size_t bricks = lattice.GetBricks().size();
  const std::size_t isovalues = this->Request.Isovalues.size();
  for (std::size_t block = 0; block < this->Scanned.size(); ++block)
  {
    const BrickScan::Parts& parts = this->Scanned[block].Parts;
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

void QueuedScan::DropWhatOthersOwn(const BrickLattice& lattice, int threads)
{
  BrickScan::Parts& all = this->Scan.GetAllParts();
  const std::size_t bricks = lattice.GetBricks().size();
  std::vector<std::vector<std::uint32_t>> dropped(static_cast<std::size_t>(std::max(1, threads)));
  ParallelFor(bricks, threads,
    [&](std::size_t number, int thread)
    {
      const Brick& brick = lattice.GetBricks()[number];
      const BrickSamples position = MakeBrickSamples(this->Geometry, brick.Vertices);
      const BrickOwnership before = all.Ownerships[number];
      const BrickOwnership after = lattice.FindNeighborhood(number).ComputeOwnership(position.Size);
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

} // namespace isosurface
