// SPDX-License-Identifier: BSD-3-Clause
#include "Ranks/Query/ContourBlocks.h"

#include "Coding/EdgeIndex/BlockIslands.h"
#include "Coding/EdgeIndex/PreviewBlocks.h"
#include "Ground/Base/Coding.h"
#include "Ground/Volume/ChosenScalars.h"
#include "Ranks/Query/LevelChoice.h"
#include "Ranks/Query/MemoryContour.h"
#include "Ranks/Sharing/QueryPlan.h"
#include "Storage/Store/BlockedVolume.h"
#include "Storage/Store/StoredBlockSource.h"
#include "Surface/Contour/BlockRanges.h"
#include "Surface/Contour/SurfaceExtractor.h"
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

constexpr const char* NotDescribed = "the isosurface cannot be described to all ranks";

void AppendText(Message& message, const std::string& text)
{
  AppendVarint(message, text.size());
  message.insert(message.end(), text.begin(), text.end());
}

std::string ReadText(ByteReader& reader)
{
  const auto size = std::min<std::uint64_t>(reader.ReadVarint(), reader.GetRemaining());
  const std::uint8_t* text = reader.ReadBytes(static_cast<std::size_t>(size));
  return text ? std::string(text, text + size) : std::string();
}

Message PackArrays(const std::vector<InterpolatedArray>& arrays)
{
  Message message;
  for (const InterpolatedArray& array : arrays)
  {
    AppendText(message, array.Name);
    message.push_back(static_cast<std::uint8_t>(array.Layout.Type));
    AppendVarint(message, static_cast<std::uint64_t>(array.Layout.NumberOfComponents));
    AppendVarint(message, array.ComponentNames.size());
    for (const std::string& name : array.ComponentNames)
    {
      AppendText(message, name);
    }
  }
  return message;
}

std::vector<InterpolatedArray> ReadArrays(const Message& message)
{
  std::vector<InterpolatedArray> arrays;
  ByteReader reader(message);
  while (reader.GetRemaining() > 0)
  {
    InterpolatedArray& array = arrays.emplace_back();
    array.Name = ReadText(reader);
    array.Layout.Type = static_cast<ValueType>(reader.Read<std::uint8_t>());
    array.Layout.NumberOfComponents = reader.ReadVarint<int>();
    for (std::uint64_t left = reader.ReadVarint(); left > 0 && reader.GetRemaining() > 0; --left)
    {
      array.ComponentNames.push_back(ReadText(reader));
    }
  }
  return arrays;
}

EdgeIndexHeader DescribeBlocks(const ContourBlocks& blocks, const BlockCoding& coding)
{
  EdgeIndexHeader header;
  header.Geometry = blocks.Grid;
  header.Type = blocks.Source->GetValueType();
  header.Isovalues = blocks.Request.Isovalues;
  header.ClosedSides = blocks.Request.ClosedSides;
  header.Array = blocks.ArrayName;
  header.Source = blocks.Origin;
  header.Time = blocks.Time;
  for (const InterpolatedArray& array : blocks.Arrays)
  {
    header.Attributes.push_back({ array.Name, GetInterpolatedType(array.Layout.Type),
      array.Layout.NumberOfComponents, coding.ArrayError, false });
  }
  if (blocks.Request.Normals)
  {
    header.Attributes.push_back({ "Normals", ValueType::Float32, 3, coding.NormalError, true });
  }
  header.Settings = coding.Settings;
  const auto range = blocks.FiniteRange.GetValues(header.Type);
  header.Settings.SetQuantizationRange(range[0], range[1]);
  header.PreviewLevel = coding.PreviewLevel;
  while (header.PreviewLevel > 0 && (1 << header.PreviewLevel) > blocks.BlockSize)
  {
    --header.PreviewLevel;
  }
  header.TakeLosslessIfBoundIsTooFine();
  return header;
}

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

/**
 * If Request.Islands is set: finds the islands of the surface that the blocks of all ranks have, and of its
 * preview, and lets the header leave out those that the filter does not keep. A closed surface becomes
 * lossless then. If all are kept, the header stays as it is. Collective. Errors of any rank: what
 * ExtractSurface and ChooseIslands return. Memory: this rank's part of the whole surface; then 8 bytes for
 * each of its points that is kept.
 */
Status LeaveOutIslands(Communicator& ranks, const ContourBlocks& blocks, int threads,
  const Progress& progress, EdgeIndexHeader& header)
{
  if (!blocks.Request.Islands)
  {
    return Status::Ok();
  }
  IslandRequest islands = *blocks.Request.Islands;
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

} // namespace

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
  PieceBlockInput input;
  PieceBlockSelection& selection = input.Selection;
  const auto find = [&]() -> Status
  {
    ISOSURFACE_RETURN_IF_ERROR(CheckVisible(samples.Pieces));
    ISOSURFACE_RETURN_IF_ERROR(CheckGrids(samples));
    selection.Isovalues = blocks.Request.Isovalues;
    selection.Region = kept->Query.Region;
    selection.ClosedSides = blocks.Request.ClosedSides;
    kept->Scalars.reserve(samples.Pieces.size());
    for (const MemoryPiece& piece : samples.Pieces)
    {
      kept->Scalars.emplace_back(piece.Components, kept->Query.Component, threads);
      input.Pieces.push_back({ kept->Scalars.back().GetView(piece.Components), piece.Attributes });
    }
    return Status::Ok();
  };
  ISOSURFACE_RETURN_IF_ERROR(AttemptOnAll(ranks, NotCollected, find));
  // Larger blocks have fewer shared faces; but a region takes blocks whole, those of the filter.
  selection.BlockSize = selection.Region.IsEverything() ? 64 : BlockRanges::BlockSize;
  selection.WithLayer = blocks.Request.Normals;
  input.Grid = blocks.Grid = samples.Grids.front();
  const int blockSize = selection.BlockSize;
  auto source = PieceBlockSource::Make(ranks, std::move(input), threads);
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
    blocks.BlockSize = blockSize;
    blocks.Origin = "image data";
    blocks.Owner = std::move(kept);
    return Status::Ok();
  };
  return AttemptOnAll(ranks, NotCollected, tell);
}

Result<EdgeIndexHeader> MakeSurfaceHeader(Communicator& ranks, const ContourBlocks& blocks,
  const BlockCoding& coding, int threads, const Progress& progress)
{
  EdgeIndexHeader header;
  const auto pack = [&](Message& mine) -> Status
  {
    header = DescribeBlocks(blocks, coding);
    ISOSURFACE_RETURN_IF_ERROR(header.Check());
    if (blocks.HasSamples)
    {
      header.Append(mine);
    }
    return Status::Ok();
  };
  ISOSURFACE_ASSIGN_OR_RETURN(const auto messages, GatherFromAll(ranks, NotDescribed, pack));
  const auto take = [&]() -> Status
  {
    const auto first = std::find_if(
      messages.begin(), messages.end(), [](const Message& message) { return !message.empty(); });
    if (first != messages.end())
    {
      std::size_t used = 0;
      ISOSURFACE_ASSIGN_OR_RETURN(
        header, EdgeIndexHeader::Parse(first->data(), first->size(), used));
    }
    for (EdgeIndexAttribute& attribute : header.Attributes)
    {
      // The bytes do not say it.
      attribute.NormalsRoundedOnce = blocks.Request.NormalsRoundedOnce;
      attribute.NormalsByDirection = blocks.Request.NormalsByDirection;
    }
    return Status::Ok();
  };
  ISOSURFACE_RETURN_IF_ERROR(AttemptOnAll(ranks, NotDescribed, take));
  ISOSURFACE_RETURN_IF_ERROR(LeaveOutIslands(ranks, blocks, threads, progress, header));
  return header;
}

Result<EdgeIndexFileSummary> WriteBlocks(Communicator& ranks, const ContourBlocks& blocks,
  const BlockCoding& coding, const std::string& path, const EdgeIndexWriteJob::Settings& settings,
  const Progress& progress)
{
  constexpr double islandsEnd = 0.3;
  const double middle = blocks.Request.Islands ? islandsEnd : 0;
  ISOSURFACE_ASSIGN_OR_RETURN(const auto header,
    MakeSurfaceHeader(
      ranks, blocks, coding, settings.Threads, MakePartOfProgress(progress, 0, middle)));
  EdgeIndexWriteJob job(
    ranks, GetLocalFileSystem(), path, header, *blocks.Source, blocks.Numbers, settings);
  return job.Run(MakePartOfProgress(progress, middle, 1));
}

Result<std::vector<InterpolatedArray>> ShareArrays(Communicator& ranks, const ContourBlocks& blocks)
{
  const auto pack = [&](Message& mine)
  {
    mine = blocks.HasSamples ? PackArrays(blocks.Arrays) : Message();
    return Status::Ok();
  };
  ISOSURFACE_ASSIGN_OR_RETURN(const auto messages, GatherFromAll(ranks, NotDescribed, pack));
  std::vector<InterpolatedArray> arrays;
  const auto take = [&]
  {
    for (std::size_t rank = 0; arrays.empty() && rank < messages.size(); ++rank)
    {
      arrays = ReadArrays(messages[rank]);
    }
    return Status::Ok();
  };
  ISOSURFACE_RETURN_IF_ERROR(AttemptOnAll(ranks, NotDescribed, take));
  return arrays;
}

} // namespace isosurface
