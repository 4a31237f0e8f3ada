// SPDX-License-Identifier: BSD-3-Clause
#include "Compositing/ViewportCompositor.h"

#include <algorithm>
#include <chrono>

namespace isosurface
{
namespace
{

/// Adds the seconds of its life to a sum.
class SecondsMeter
{
public:
  explicit SecondsMeter(double& sum)
    : Sum(sum)
  {
  }
  ~SecondsMeter()
  {
    this->Sum +=
      std::chrono::duration<double>(std::chrono::steady_clock::now() - this->Begin).count();
  }
  SecondsMeter(const SecondsMeter&) = delete;
  SecondsMeter& operator=(const SecondsMeter&) = delete;

private:
  double& Sum;
  std::chrono::steady_clock::time_point Begin = std::chrono::steady_clock::now();
};

bool Takes(const CompositeCell& cell, int rank)
{
  return std::binary_search(cell.Ranks.begin(), cell.Ranks.end(), rank);
}

// The samples of a rank that a cell shows.
PixelRectangle GetPiece(const CompositeCell& cell, const Viewport& viewport)
{
  return CoverWithBlocks(cell.Pixels, viewport.Divisor).Intersect(viewport.Blocks);
}

// The cells of the target raster that a run of blocks covers, each as `factor` x `factor` cells.
PixelRectangle EnlargeRun(const PixelRun& run, int factor, const PixelRectangle& target)
{
  return PixelRectangle{ run.X * factor, run.Y * factor, run.Length * factor, factor }.Intersect(
    target);
}

/// A raster that samples are merged into, or put.
struct TargetRaster
{
  std::uint32_t* Colors;
  float* Depths; ///< null where only colors count
  PixelRectangle Raster;
  PixelRectangle Part; ///< nothing outside of it is touched

  std::size_t GetIndex(int x, int y) const
  {
    return static_cast<std::size_t>(y - this->Raster.Y) *
      static_cast<std::size_t>(this->Raster.Width) +
      static_cast<std::size_t>(x - this->Raster.X);
  }
};

// Calls use(target index, run's sample index) for each cell of the target under a run of samples,
// each of which stands for factor x factor cells.
template <typename Function>
void ForEachCellOfRun(
  const PixelRun& run, int factor, const TargetRaster& target, const Function& use)
{
  const PixelRectangle covered = EnlargeRun(run, factor, target.Part);
  for (int y = covered.Y; y < covered.GetTop(); ++y)
  {
    std::size_t index = target.GetIndex(covered.X, y);
    if (factor == 1)
    {
      const std::size_t first = static_cast<std::size_t>(covered.X - run.X);
      for (std::size_t x = 0; x < static_cast<std::size_t>(covered.Width); ++x)
      {
        use(index + x, first + x);
      }
      continue;
    }
    for (int x = covered.X; x < covered.GetRight(); ++x, ++index)
    {
      use(index, static_cast<std::size_t>(x / factor - run.X));
    }
  }
}

// Of a cell's sample and a new one the nearer is kept, of equal ones the new one.
void MergeRun(const PixelRun& run, const std::uint32_t* colors, const float* depths, int factor,
  const TargetRaster& target)
{
  ForEachCellOfRun(run, factor, target,
    [&](std::size_t cell, std::size_t sample)
    {
      const float depth = depths[sample];
      const bool isNearer = depth <= target.Depths[cell] && depth < 1.0F;
      target.Depths[cell] = isNearer ? depth : target.Depths[cell];
      target.Colors[cell] = isNearer ? colors[sample] : target.Colors[cell];
    });
}

// The runs' depths are null if none were sent; all samples are active.
void PutRun(const PixelRun& run, const std::uint32_t* colors, const float* depths, int factor,
  const TargetRaster& target)
{
  ForEachCellOfRun(run, factor, target,
    [&](std::size_t cell, std::size_t sample) { target.Colors[cell] = colors[sample]; });
  if (target.Depths && depths)
  {
    ForEachCellOfRun(run, factor, target,
      [&](std::size_t cell, std::size_t sample) { target.Depths[cell] = depths[sample]; });
  }
}

// Calls use(run, its colors, its depths) for the active samples of a part of a picture.
template <typename Function>
void ForEachActiveRun(const ImageView& picture, const PixelRectangle& part, const Function& use)
{
  for (int y = part.Y; y < part.GetTop(); ++y)
  {
    const std::size_t first = picture.GetIndex(part.X, y);
    const std::uint32_t* colors = picture.Colors + first;
    const float* depths = picture.Depths + first;
    for (int begin = FindActive(depths, 0, part.Width); begin < part.Width;)
    {
      const int end = FindInactive(depths, begin, part.Width);
      use(PixelRun{ part.X + begin, y, end - begin, 0 }, colors + begin, depths + begin);
      begin = FindActive(depths, end, part.Width);
    }
  }
}

// Every rank shows one tile at most, every tile is shown by some rank, and what a rank draws or
// fills is there.
Status CheckArguments(const Communicator& communicator, const std::vector<Viewport>& viewports,
  const std::vector<DisplayTile>& tiles, const ImageView& mine, const TileImage& tile)
{
  const int me = communicator.GetRank();
  if (viewports.size() != static_cast<std::size_t>(communicator.GetSize()))
  {
    return { StatusCode::InvalidArgument, "Viewports are not those of all ranks." };
  }
  for (const Viewport& viewport : viewports)
  {
    if (viewport.Divisor < 1 || viewport.Divisor > LargestDivisor || viewport.Blocks.X < 0 ||
      viewport.Blocks.Y < 0)
    {
      return { StatusCode::InvalidArgument, "A viewport begins outside of the display." };
    }
  }
  std::vector<bool> shows(viewports.size(), false);
  for (const DisplayTile& shown : tiles)
  {
    const auto rank = static_cast<std::size_t>(shown.Rank);
    if (rank >= shows.size() || shows[rank])
    {
      return { StatusCode::InvalidArgument, "A tile has no rank of its own that shows it." };
    }
    shows[rank] = true;
  }
  const PixelRectangle& blocks = viewports[static_cast<std::size_t>(me)].Blocks;
  if (!blocks.IsEmpty() && (!(mine.Raster == blocks) || !mine.Colors || !mine.Depths))
  {
    return { StatusCode::InvalidArgument, "A rank's picture is not that of its viewport." };
  }
  if (shows[static_cast<std::size_t>(me)] && !tile.Colors)
  {
    return { StatusCode::InvalidArgument,
      "A rank that shows a tile has no place for its picture." };
  }
  return Status::Ok();
}

} // namespace

std::vector<Message> ViewportCompositor::EncodePieces(
  int me, const std::vector<Viewport>& viewports, const ImageView& mine)
{
  const SecondsMeter meter(this->Cost.EncodeSeconds);
  std::vector<Message> messages(viewports.size());
  for (const CompositeCell& cell : this->Cells)
  {
    if (cell.Owner != me && Takes(cell, me))
    {
      AppendActivePixels(mine, GetPiece(cell, viewports[static_cast<std::size_t>(me)]),
        PixelContent::ColorsAndDepths, messages[static_cast<std::size_t>(cell.Owner)]);
    }
  }
  return messages;
}

Status ViewportCompositor::MergeOwnedCells(int me, const std::vector<Viewport>& viewports,
  const ImageView& mine, const std::vector<Message>& pieces)
{
  const SecondsMeter meter(this->Cost.MergeSeconds);
  std::vector<std::size_t> offsets(pieces.size(), 0);
  this->Owned.resize(std::max(this->Owned.size(), this->Cells.size()));
  for (std::size_t index = 0; index < this->Cells.size(); ++index)
  {
    const CompositeCell& cell = this->Cells[index];
    if (cell.Owner != me || cell.Ranks.size() == 1)
    {
      continue;
    }
    OwnedImage& owned = this->Owned[index];
    const PixelRectangle raster = cell.GetBlocks();
    owned.Colors.assign(static_cast<std::size_t>(raster.GetArea()), 0);
    owned.Depths.assign(static_cast<std::size_t>(raster.GetArea()), 1.0F);
    owned.View = { owned.Colors.data(), owned.Depths.data(), raster };
    const TargetRaster target{ owned.Colors.data(), owned.Depths.data(), raster, raster };
    for (const int rank : cell.Ranks)
    {
      const auto from = static_cast<std::size_t>(rank);
      const PixelRectangle piece = GetPiece(cell, viewports[from]);
      const int factor = viewports[from].Divisor / cell.Divisor;
      this->Cost.PixelsMerged += static_cast<std::uint64_t>(piece.GetArea());
      if (rank == me)
      {
        ForEachActiveRun(mine, piece,
          [&](const PixelRun& run, const std::uint32_t* colors, const float* depths)
          { MergeRun(run, colors, depths, factor, target); });
        continue;
      }
      ISOSURFACE_RETURN_IF_ERROR(ReadActivePixels(
        pieces[from], piece, PixelContent::ColorsAndDepths, offsets[from], this->Received));
      for (const PixelRun& run : this->Received.Runs)
      {
        MergeRun(run, this->Received.Colors.data() + run.First,
          this->Received.Depths.data() + run.First, factor, target);
      }
    }
  }
  return Status::Ok();
}

const ImageView& ViewportCompositor::GetMergedImage(std::size_t cell, const ImageView& mine) const
{
  return this->Cells[cell].Ranks.size() == 1 ? mine : this->Owned[cell].View;
}

std::vector<Message> ViewportCompositor::EncodeMergedCells(int me, const ImageView& mine)
{
  const SecondsMeter meter(this->Cost.EncodeSeconds);
  std::vector<Message> messages(this->NumberOfRanks);
  for (std::size_t index = 0; index < this->Cells.size(); ++index)
  {
    const CompositeCell& cell = this->Cells[index];
    const int shownBy = this->Tiles[cell.Tile].Rank;
    if (cell.Owner == me && shownBy != me)
    {
      AppendActivePixels(this->GetMergedImage(index, mine), cell.GetBlocks(), this->Delivered,
        messages[static_cast<std::size_t>(shownBy)]);
    }
  }
  return messages;
}

Status ViewportCompositor::FillTile(
  int me, const ImageView& mine, const std::vector<Message>& merged, const TileImage& tile)
{
  const SecondsMeter meter(this->Cost.DeliverSeconds);
  const auto shown = std::find_if(this->Tiles.begin(), this->Tiles.end(),
    [me](const DisplayTile& candidate) { return candidate.Rank == me; });
  if (shown == this->Tiles.end())
  {
    return Status::Ok();
  }
  const PixelRectangle& raster = shown->Pixels;
  std::fill_n(tile.Colors, raster.GetArea(), 0);
  if (tile.Depths)
  {
    std::fill_n(tile.Depths, raster.GetArea(), 1.0F);
  }
  std::vector<std::size_t> offsets(merged.size(), 0);
  for (std::size_t index = 0; index < this->Cells.size(); ++index)
  {
    const CompositeCell& cell = this->Cells[index];
    if (this->Tiles[cell.Tile].Rank != me)
    {
      continue;
    }
    const TargetRaster target{ tile.Colors, tile.Depths, raster, cell.Pixels };
    if (cell.Owner == me)
    {
      ForEachActiveRun(this->GetMergedImage(index, mine), cell.GetBlocks(),
        [&](const PixelRun& run, const std::uint32_t* colors, const float* depths)
        { PutRun(run, colors, depths, cell.Divisor, target); });
      continue;
    }
    const auto from = static_cast<std::size_t>(cell.Owner);
    ISOSURFACE_RETURN_IF_ERROR(ReadActivePixels(
      merged[from], cell.GetBlocks(), this->Delivered, offsets[from], this->Received));
    for (const PixelRun& run : this->Received.Runs)
    {
      PutRun(run, this->Received.Colors.data() + run.First,
        this->Received.Depths.empty() ? nullptr : this->Received.Depths.data() + run.First,
        cell.Divisor, target);
    }
  }
  return Status::Ok();
}

std::vector<Message> ViewportCompositor::Send(
  Communicator& communicator, std::vector<Message> outgoing)
{
  for (std::size_t rank = 0; rank < outgoing.size(); ++rank)
  {
    this->Cost.BytesSent += outgoing[rank].size();
  }
  const SecondsMeter meter(this->Cost.ExchangeSeconds);
  return communicator.Exchange(std::move(outgoing));
}

Status ViewportCompositor::Composite(Communicator& communicator,
  const std::vector<Viewport>& viewports, const std::vector<DisplayTile>& tiles,
  const ImageView& mine, const TileImage& tile, bool wantsDepths)
{
  const int me = communicator.GetRank();
  this->Cost = {};
  ISOSURFACE_RETURN_IF_ERROR(
    communicator.Agree(CheckArguments(communicator, viewports, tiles, mine, tile)));
  this->NumberOfRanks = viewports.size();
  this->Tiles = tiles;
  this->Cells = PlanCompositing(viewports, tiles);
  this->Delivered = wantsDepths ? PixelContent::ColorsAndDepths : PixelContent::Colors;

  const std::vector<Message> pieces =
    this->Send(communicator, this->EncodePieces(me, viewports, mine));
  ISOSURFACE_RETURN_IF_ERROR(
    communicator.Agree(this->MergeOwnedCells(me, viewports, mine, pieces)));
  const std::vector<Message> merged = this->Send(communicator, this->EncodeMergedCells(me, mine));
  return communicator.Agree(this->FillTile(me, mine, merged, tile));
}

} // namespace isosurface
