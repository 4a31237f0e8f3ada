// SPDX-License-Identifier: BSD-3-Clause
#include "ContourBlocks.h"

#include "ChosenScalars.h"
#include "ContourExecution.h"
#include "ErrorReport.h"
#include "ImagePieces.h"

#include "vtkAlgorithm.h"

#include "Ground/Volume/ArrayVariables.h"
#include "Ranks/Query/LevelChoice.h"
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

// The images of a rank, and what is contoured and interpolated of them.
struct KeptPieces
{
  ImagePieces Pieces;
  std::vector<ChosenScalars> Scalars;
  std::vector<PieceAttributes> Attributes;

  Status FindArrays(const ImageContour::Settings& settings);
  std::vector<GridPiece> GetGridPieces() const;
};

Status KeptPieces::FindArrays(const ImageContour::Settings& settings)
{
  for (const ImagePiece& piece : this->Pieces.Pieces)
  {
    ISOSURFACE_ASSIGN_OR_RETURN(auto attributes,
      FindAttributes(piece, settings.Arrays, *settings.Averages, settings.Threads));
    this->Attributes.push_back(std::move(attributes));
    const auto components = static_cast<int>(piece.Samples.Components.size());
    this->Scalars.emplace_back(
      piece.Samples, *FindChosenComponent(components, settings.Component), settings.Threads);
  }
  return Status::Ok();
}

std::vector<GridPiece> KeptPieces::GetGridPieces() const
{
  std::vector<GridPiece> pieces;
  for (std::size_t n = 0; n < this->Pieces.Pieces.size(); ++n)
  {
    pieces.push_back(
      { this->Scalars[n].GetView(this->Pieces.Pieces[n].Samples), this->Attributes[n].Views });
  }
  return pieces;
}

// What a consumer of blocks could not tell from the samples.
Status CheckVisible(const std::vector<ImagePiece>& pieces)
{
  const bool hides = std::any_of(pieces.begin(), pieces.end(),
    [](const ImagePiece& piece) { return !piece.Samples.Hidden.IsEmpty(); });
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

Status CheckGrids(const ImagePieces& pieces)
{
  const std::vector<GridGeometry>& grids = pieces.Grids;
  if (std::any_of(pieces.Lines.begin(), pieces.Lines.end(),
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

Status CollectImageBlocks(Communicator& ranks, ImagePieces pieces,
  const ImageContour::Settings& settings, ContourBlocks& blocks)
{
  auto kept = std::make_shared<KeptPieces>();
  kept->Pieces = std::move(pieces);
  PieceBlockSelection selection;
  std::vector<GridPiece> gridPieces;
  const auto find = [&]() -> Status
  {
    ISOSURFACE_RETURN_IF_ERROR(kept->FindArrays(settings));
    ISOSURFACE_RETURN_IF_ERROR(CheckVisible(kept->Pieces.Pieces));
    ISOSURFACE_RETURN_IF_ERROR(CheckGrids(kept->Pieces));
    selection.Isovalues = blocks.Isovalues;
    selection.Region = settings.Region;
    selection.ClosedSides = blocks.ClosedSides;
    gridPieces = kept->GetGridPieces();
    return Status::Ok();
  };
  ISOSURFACE_RETURN_IF_ERROR(AttemptOnAll(ranks, NotCollected, find));
  // Larger blocks have fewer shared faces; but a region takes blocks whole, those of the filter.
  selection.BlockSize = settings.Region.IsEverything() ? 64 : BlockRanges::BlockSize;
  selection.WithLayer = blocks.Normals;
  blocks.Grid = kept->Pieces.Grids.front();
  auto source =
    PieceBlockSource::Make(ranks, blocks.Grid, std::move(gridPieces), selection, settings.Threads);
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
    if (blocks.HasSamples)
    {
      blocks.Arrays = kept->Attributes.back().Arrays;
    }
    blocks.BlockSize = selection.BlockSize;
    blocks.Origin = "image data";
    blocks.Owner = std::move(kept);
    return Status::Ok();
  };
  return AttemptOnAll(ranks, NotCollected, tell);
}

} // namespace isosurface
