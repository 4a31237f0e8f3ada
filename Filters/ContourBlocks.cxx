// SPDX-License-Identifier: BSD-3-Clause
#include "ContourBlocks.h"

#include "ContourExecution.h"
#include "ErrorReport.h"

#include "vtkAlgorithm.h"

#include "Ground/Volume/ChosenScalars.h"
#include "Ranks/Query/LevelChoice.h"
#include "Ranks/Query/MemoryContour.h"
#include "Ranks/Sharing/StoreRecovery.h"
#include "Storage/Store/BlockedVolume.h"
#include "Storage/Store/StoredBlockSource.h"
#include "Surface/Contour/BlockRanges.h"
#include "Surface/Pieces/PieceBlockSource.h"

#include <algorithm>
#include <utility>

namespace isosurface
{

namespace
{

constexpr const char* NotCollected = "the blocks of the isosurface cannot be collected";

// What the blocks of images refer to.
struct KeptSamples
{
  MemoryQuery Query;
  std::vector<ChosenScalars> Scalars;
};

// What a consumer of blocks could not tell from the samples.
Status CheckVisible(const std::vector<MemoryPiece>& pieces)
{
  const bool hides = std::any_of(
    pieces.begin(), pieces.end(), [](const MemoryPiece& piece) { return !piece.Hidden.IsEmpty(); });
  return hides ? Status(StatusCode::InvalidArgument,
                   "the input hides cells or points (vtkGhostType), which edge-index records "
                   "cannot tell: save or draw the surface of Isosurface itself")
               : Status::Ok();
}

Status MakeLinesError(const std::string& what)
{
  return { StatusCode::InvalidArgument,
    what +
      ", whose coordinates edge-index records cannot tell: save or draw the surface of Stabbing "
      "Contour itself" };
}

Status CheckGrids(const MemoryGrids& samples)
{
  const std::vector<GridGeometry>& grids = samples.Grids;
  if (std::any_of(samples.Lines.begin(), samples.Lines.end(),
        [](const std::optional<GridLines>& lines) { return lines.has_value(); }))
  {
    return MakeLinesError("the input has rectilinear grids");
  }
  if (grids.size() > 1)
  {
    return { StatusCode::InvalidArgument,
      "the images of the input are of several grids, or have other samples where they meet, so "
      "each "
      "has an isosurface of its own; extract one of them (Extract Block)" };
  }
  return grids.empty() ? Status(StatusCode::InvalidArgument, "the input has no samples")
                       : Status::Ok();
}

// An error of PieceBlockSource, with what a user can do about it.
Status Explain(const Status& error)
{
  return error.GetCode() == StatusCode::InvalidArgument
    ? Status(error.GetCode(),
        error.GetMessage() +
          "; Isosurface must be straight behind the reader of a blocked volume, or have "
          "images that meet")
    : error;
}

} // namespace

Status CollectContourBlocks(vtkStabbingContour* contour, int piece, int pieces,
  const std::optional<double>& time, ContourBlocks& blocks)
{
  return ContourExecution::Of(*contour).CollectBlocks(piece, pieces, time, blocks);
}

Status RunWithContourBlocks(
  vtkAlgorithm* reader, Communicator& ranks, const std::function<Status(ContourBlocks&)>& step)
{
  ContourBlocks blocks;
  std::string warning;
  const Status status = RunWithReplicas(
    ranks, [&] { return blocks.Volume.get(); }, warning,
    [&]
    {
      blocks = ContourBlocks();
      return step(blocks);
    });
  ReportWarning(reader, ranks, status, warning);
  return status;
}

Status CollectVolumeBlocks(const std::shared_ptr<BlockedVolume>& volume, const SurfaceQuery& query,
  int level, ContourBlocks& blocks)
{
  if (volume->GetLines(level))
  {
    return MakeLinesError(volume->GetPath() + " has a rectilinear grid");
  }
  QueryStatistics statistics;
  ISOSURFACE_ASSIGN_OR_RETURN(auto plan, PlanQuery(*volume, query, level, statistics));
  std::vector<BlockReference>& active = plan.Blocks;
  std::sort(active.begin(), active.end(),
    [](const BlockReference& a, const BlockReference& b) { return a.Block < b.Block; });
  blocks.Numbers.clear();
  for (const BlockReference& block : active)
  {
    blocks.Numbers.push_back(block.Block);
  }
  auto source = std::make_unique<StoredBlockSource>(
    *volume, query.TimeStep, query.Variable, level, std::move(active));
  source->SetAttributes(query.Attributes);
  blocks.Source = std::move(source);
  blocks.Owner = volume;
  blocks.HasSamples = true;
  blocks.Level = level;
  const StoredLevel stored = volume->FindLevel(level);
  blocks.BlockSize = stored.Grid->GetBlockSize() >> stored.Level;
  blocks.Grid = volume->GetHeader().Grid.Coarsen(level);
  const TimeStepDescription& step = volume->GetHeader().TimeSteps[query.TimeStep];
  blocks.Time = step.Time;
  blocks.FiniteRange = step.Ranges[query.Variable];
  const std::string& path = volume->GetPath();
  blocks.Origin = path.substr(path.rfind('/') + 1);
  if (level > 0)
  {
    blocks.Origin += ", level " + std::to_string(level);
  }
  return Status::Ok();
}

Status CollectImageBlocks(Communicator& ranks, MemoryQuery query, ContourBlocks& blocks)
{
  auto kept = std::make_shared<KeptSamples>();
  kept->Query = std::move(query);
  const MemoryGrids& samples = kept->Query.Samples;
  const int threads = kept->Query.Threads;
  PieceBlockSelection selection;
  std::vector<GridPiece> pieces;
  const auto find = [&]() -> Status
  {
    ISOSURFACE_RETURN_IF_ERROR(CheckVisible(samples.Pieces));
    ISOSURFACE_RETURN_IF_ERROR(CheckGrids(samples));
    selection.Isovalues = blocks.Isovalues;
    selection.Region = kept->Query.Region;
    selection.ClosedSides = blocks.ClosedSides;
    kept->Scalars.reserve(samples.Pieces.size());
    for (const MemoryPiece& piece : samples.Pieces)
    {
      kept->Scalars.emplace_back(piece.Components, kept->Query.Component, threads);
      pieces.push_back({ kept->Scalars.back().GetView(piece.Components), piece.Attributes });
    }
    return Status::Ok();
  };
  ISOSURFACE_RETURN_IF_ERROR(AttemptOnAll(ranks, NotCollected, find));
  // Larger blocks have fewer shared faces; but a region takes blocks whole, those of the filter.
  selection.BlockSize = selection.Region.IsEverything() ? 64 : BlockRanges::BlockSize;
  selection.WithLayer = blocks.Normals;
  blocks.Grid = samples.Grids.front();
  auto source = PieceBlockSource::Make(ranks, blocks.Grid, std::move(pieces), selection, threads);
  if (!source.IsOk())
  {
    return Explain(source.GetStatus());
  }
  const auto tell = [&]
  {
    blocks.Numbers = (*source)->GetNumbers();
    blocks.FiniteRange = (*source)->GetFiniteRange();
    blocks.Source = std::move(*source);
    blocks.HasSamples = !kept->Scalars.empty();
    blocks.BlockSize = selection.BlockSize;
    blocks.Origin = "image data";
    blocks.Owner = std::move(kept);
    return Status::Ok();
  };
  return AttemptOnAll(ranks, NotCollected, tell);
}

} // namespace isosurface
