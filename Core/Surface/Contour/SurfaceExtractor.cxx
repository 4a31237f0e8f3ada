// SPDX-License-Identifier: BSD-3-Clause
#include "Surface/Contour/SurfaceExtractor.h"

#include "Ground/Base/WithinMemory.h"
#include "Surface/Contour/BrickLattice.h"
#include "Surface/Contour/BrickScan.h"
#include "Surface/Contour/QueuedScan.h"
#include "Surface/Contour/SurfaceAssembler.h"

#include <algorithm>
#include <chrono>
#include <utility>

namespace isosurface
{
namespace
{

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
