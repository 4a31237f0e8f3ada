// SPDX-License-Identifier: BSD-3-Clause
#include "ContourBlocks.h"

#include "ChosenScalars.h"
#include "ImagePieces.h"

#include "Contour/BlockRanges.h"
#include "Query/PieceBlockSource.h"
#include "Query/StoredBlockSource.h"
#include "Store/BlockedVolume.h"

#include <algorithm>
#include <utility>

namespace isosurface
{

Status CollectVolumeBlocks(const std::shared_ptr<BlockedVolume>& volume,
  const VolumeBlocksQuery& query, ContourBlocks& blocks)
{
  QueryStatistics statistics;
  auto active = volume->FindActiveBlocks(query.TimeStep, query.Variable, blocks.Isovalues,
    query.Rank, query.Ranks, statistics, query.Level, { {}, query.Region });
  if (!active.IsOk())
  {
    return active.GetStatus();
  }
  std::sort(active->begin(), active->end(),
    [](const BlockReference& a, const BlockReference& b) { return a.Block < b.Block; });
  for (const BlockReference& block : *active)
  {
    blocks.Numbers.push_back(block.Block);
  }
  auto source = std::make_unique<StoredBlockSource>(
    *volume, query.TimeStep, query.Variable, query.Level, std::move(*active));
  source->SetAttributes(query.Attributes);
  blocks.Source = std::move(source);
  blocks.Owner = volume;
  blocks.HasSamples = true;
  blocks.Level = query.Level;
  const StoredLevel stored = volume->FindLevel(query.Level);
  blocks.BlockSize = stored.Grid->GetBlockSize() >> stored.Level;
  blocks.Grid = volume->GetHeader().Grid.Coarsen(query.Level);
  const TimeStepDescription& step = volume->GetHeader().TimeSteps[query.TimeStep];
  blocks.Time = step.Time;
  blocks.FiniteRange = step.Ranges[query.Variable];
  const std::string& path = volume->GetPath();
  blocks.Origin = path.substr(path.rfind('/') + 1);
  if (query.Level > 0)
  {
    blocks.Origin += ", level " + std::to_string(query.Level);
  }
  return Status::Ok();
}

Status CollectImageBlocks(Communicator& ranks, const Status& status,
  std::shared_ptr<ImagePieces> pieces, std::vector<ChosenScalars> scalars,
  std::vector<PieceAttributes> attributes, const Region& region, int threads, ContourBlocks& blocks)
{
  ISOSURFACE_RETURN_IF_ERROR(ranks.Agree(status));
  if (pieces->Grids.size() > 1)
  {
    return { StatusCode::InvalidArgument,
      "the images of the input are of several grids, each with an isosurface of its own; extract "
      "one of them (Extract Block)" };
  }
  if (pieces->Grids.empty())
  {
    return { StatusCode::InvalidArgument, "the input has no samples" };
  }
  struct Kept
  {
    std::shared_ptr<ImagePieces> Pieces;
    std::vector<ChosenScalars> Scalars;
    std::vector<PieceAttributes> Attributes;
  };
  auto kept =
    std::make_shared<Kept>(Kept{ std::move(pieces), std::move(scalars), std::move(attributes) });
  std::vector<GridPiece> parts;
  for (std::size_t n = 0; n < kept->Pieces->Pieces.size(); ++n)
  {
    parts.push_back(
      { kept->Scalars[n].GetView(kept->Pieces->Pieces[n].Samples), kept->Attributes[n].Views });
  }
  PieceBlockSelection selection;
  selection.Isovalues = blocks.Isovalues;
  selection.Region = region;
  // Larger blocks have fewer shared faces; but a region takes blocks whole, those of the filter.
  selection.BlockSize = region.IsEverything() ? 64 : BlockRanges::BlockSize;
  selection.WithLayer = blocks.Normals;
  blocks.Grid = kept->Pieces->Grids.front();
  auto source = PieceBlockSource::Make(ranks, blocks.Grid, std::move(parts), selection, threads);
  if (!source.IsOk())
  {
    const Status& failure = source.GetStatus();
    return failure.GetCode() == StatusCode::InvalidArgument
      ? Status(failure.GetCode(),
          failure.GetMessage() +
            "; Stabbing Contour must be straight behind the reader of a blocked volume, or have "
            "images that meet")
      : failure;
  }
  blocks.Numbers = (*source)->GetNumbers();
  blocks.FiniteRange = (*source)->GetFiniteRange();
  blocks.Source = std::move(*source);
  blocks.Owner = kept;
  blocks.HasSamples = !kept->Scalars.empty();
  blocks.BlockSize = selection.BlockSize;
  blocks.Origin = "image data";
  return Status::Ok();
}

} // namespace isosurface
