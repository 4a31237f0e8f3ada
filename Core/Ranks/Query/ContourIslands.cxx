// SPDX-License-Identifier: BSD-3-Clause
#include "Ranks/Query/ContourIslands.h"

#include "Coding/EdgeIndex/BlockIslands.h"
#include "Coding/EdgeIndex/PreviewBlocks.h"
#include "Surface/Contour/SurfaceExtractor.h"

#include <algorithm>
#include <memory>
#include <utility>
#include <vector>

namespace isosurface
{

namespace
{

/// The islands of a surface that is encoded, or of its preview.
struct ChosenPoints
{
  std::shared_ptr<const std::vector<std::int64_t>> Ids; ///< of the points that are kept
  bool LacksIslands = false;
};

Status ChoosePoints(Communicator& ranks, const IslandRequest& islands,
  const EdgeIndexHeader& header, int blockSize, BlockSource& source, int threads,
  const Progress& progress, ChosenPoints& points)
{
  const ContourRequest request = MakeContourRequest(header);
  Surface surface;
  const auto extract = [&]() -> Status
  {
    ISOSURFACE_ASSIGN_OR_RETURN(
      surface, ExtractSurface(header.Geometry, source, request, threads, progress));
    return Status::Ok();
  };
  const auto makeGrids = [&]
  {
    IslandGrids grids;
    grids.Bounds = TriangleBounds::Of(header.Geometry, nullptr);
    grids.Shared.emplace_back(header.Geometry, request);
    if (ranks.GetSize() > 1)
    {
      grids.Shared.back().AddFacesOfBlocks(blockSize);
    }
    return grids;
  };
  ChosenIslands chosen;
  ISOSURFACE_RETURN_IF_ERROR(ChooseIslands(
    ranks, Attempt(NoMemoryForIslands, extract), islands, makeGrids, threads, surface, chosen));
  points.LacksIslands = chosen.KeptIslands < chosen.Islands;
  const auto keep = [&]
  {
    std::vector<std::int64_t> ids(surface.GlobalIds.begin(), surface.GlobalIds.end());
    surface = Surface();
    std::sort(ids.begin(), ids.end());
    points.Ids = std::make_shared<const std::vector<std::int64_t>>(std::move(ids));
    return Status::Ok();
  };
  return AttemptOnAll(ranks, NoMemoryForIslands, keep);
}

} // namespace

Status LeaveOutIslands(Communicator& ranks, const ContourBlocks& blocks, int threads,
  const Progress& progress, EdgeIndexHeader& header)
{
  if (!blocks.Islands)
  {
    return Status::Ok();
  }
  IslandRequest islands = *blocks.Islands;
  islands.Level = blocks.Level;
  ChosenPoints exact;
  PreviewBlocks scalars(*blocks.Source, 0);
  ISOSURFACE_RETURN_IF_ERROR(ChoosePoints(ranks, islands, header, blocks.BlockSize, scalars,
    threads, MakePartOfProgress(progress, 0, 0.9), exact));
  ChosenPoints coarse;
  if (header.PreviewLevel > 0)
  {
    islands.Level += header.PreviewLevel;
    PreviewBlocks source(*blocks.Source, header.PreviewLevel);
    ISOSURFACE_RETURN_IF_ERROR(
      ChoosePoints(ranks, islands, header.MakePreview(), blocks.BlockSize >> header.PreviewLevel,
        source, threads, MakePartOfProgress(progress, 0.9, 1), coarse));
  }
  header.LacksIslands = exact.LacksIslands || coarse.LacksIslands;
  if (header.LacksIslands)
  {
    header.KeptIds = exact.Ids;
    header.KeptIdsOfPreview = coarse.Ids;
    header.Settings.Mode =
      header.ClosedSides.IsEmpty() ? header.Settings.Mode : EdgeIndexMode::Lossless;
  }
  return Status::Ok();
}

} // namespace isosurface
