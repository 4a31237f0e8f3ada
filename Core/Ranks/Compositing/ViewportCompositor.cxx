// SPDX-License-Identifier: BSD-3-Clause
#include "Ranks/Compositing/ViewportCompositor.h"

#include "Ranks/Compositing/ImageScaling.h"

#include <algorithm>
#include <utility>

namespace isosurface
{
namespace
{

bool IsCoveredBy(const CompositeCell& cell, int rank)
{
  return std::binary_search(cell.Ranks.begin(), cell.Ranks.end(), rank);
}

// The samples of a rank's viewport that a cell shows.
PixelRectangle GetSamples(const CompositeCell& cell, const Viewport& viewport)
{
  return CoverWithBlocks(cell.Pixels, viewport.Divisor).Intersect(viewport.Blocks);
}

// The rectangle of the target that a run of samples covers, each factor x factor pixels.
PixelRectangle UpsampleRun(const PixelRun& run, int factor, const PixelRectangle& target)
{
  return PixelRectangle{ run.X * factor, run.Y * factor, run.Length * factor, factor }.Intersect(
    target);
}

/// A raster that samples are merged into, or copied to.
struct TargetRaster
{
  std::uint32_t* Colors;
  float* Depths; ///< null if only colors are wanted
  PixelRectangle Raster;
  PixelRectangle Written; ///< nothing outside of it is written

  std::size_t GetIndex(int x, int y) const
  {
    return static_cast<std::size_t>(y - this->Raster.Y) *
      static_cast<std::size_t>(this->Raster.Width) +
      static_cast<std::size_t>(x - this->Raster.X);
  }
};

// Calls use(pixel, sample) for each pixel of the target under a run of samples, each of which stands
// for factor x factor pixels. Both are indices: into the target, and into the run.
template <typename Function>
void ForEachPixelOfRun(
  const PixelRun& run, int factor, const TargetRaster& target, const Function& use)
{
  const PixelRectangle covered = UpsampleRun(run, factor, target.Written);
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

// Keeps the nearer one of a pixel's sample and a new one; of equally near ones the new one.
void MergeRun(const PixelRun& run, const std::uint32_t* colors, const float* depths, int factor,
  const TargetRaster& target)
{
  ForEachPixelOfRun(run, factor, target,
    [&](std::size_t pixel, std::size_t sample)
    {
      const float depth = depths[sample];
      const bool isNearer = depth <= target.Depths[pixel] && depth < 1.0F;
      target.Depths[pixel] = isNearer ? depth : target.Depths[pixel];
      target.Colors[pixel] = isNearer ? colors[sample] : target.Colors[pixel];
    });
}

// Copies active samples. `depths` is null if none were sent.
void CopyRun(const PixelRun& run, const std::uint32_t* colors, const float* depths, int factor,
  const TargetRaster& target)
{
  ForEachPixelOfRun(run, factor, target,
    [&](std::size_t pixel, std::size_t sample) { target.Colors[pixel] = colors[sample]; });
  if (target.Depths && depths)
  {
    ForEachPixelOfRun(run, factor, target,
      [&](std::size_t pixel, std::size_t sample) { target.Depths[pixel] = depths[sample]; });
  }
}

// Calls use(run, its colors, its depths) for pixels from another rank; depths are null if none were
// sent.
template <typename Function>
void ForEachReceivedRun(const ActivePixels& received, const Function& use)
{
  for (const PixelRun& run : received.Runs)
  {
    use(run, received.Colors.data() + run.First,
      received.Depths.empty() ? nullptr : received.Depths.data() + run.First);
  }
}

// Every rank shows one tile at most, every tile is shown by some rank, and this rank has the image
// that it drew and memory for the tile that it shows.
Status CheckArguments(const Communicator& communicator, const DisplayLayout& display,
  const std::vector<Viewport>& viewports, const ImageView& mine, const TileImage& tile)
{
  const int me = communicator.GetRank();
  if (viewports.size() != static_cast<std::size_t>(communicator.GetSize()))
  {
    return { StatusCode::InvalidArgument, "The number of viewports is not that of the ranks." };
  }
  for (const Viewport& viewport : viewports)
  {
    if (viewport.Divisor < 1 || viewport.Divisor > MaximumDivisor || viewport.Blocks.X < 0 ||
      viewport.Blocks.Y < 0)
    {
      return { StatusCode::InvalidArgument, "A viewport begins outside of the display." };
    }
  }
  std::vector<bool> shows(viewports.size(), false);
  for (const DisplayTile& shown : display.Tiles)
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
    return { StatusCode::InvalidArgument, "A rank's image is not that of its viewport." };
  }
  if (shows[static_cast<std::size_t>(me)] && !tile.Colors)
  {
    return { StatusCode::InvalidArgument, "A rank that shows a tile has no memory for its image." };
  }
  return Status::Ok();
}

} // namespace

std::vector<Message> ViewportCompositor::EncodeSamples(
  int me, const std::vector<Viewport>& viewports, const ImageView& mine) const
{
  std::vector<Message> messages(viewports.size());
  for (const CompositeCell& cell : this->Cells)
  {
    if (cell.Owner != me && IsCoveredBy(cell, me))
    {
      AppendActivePixels(mine, GetSamples(cell, viewports[static_cast<std::size_t>(me)]),
        PixelContent::ColorsAndDepths, messages[static_cast<std::size_t>(cell.Owner)]);
    }
  }
  return messages;
}

Status ViewportCompositor::MergeOwnedCells(int me, const std::vector<Viewport>& viewports,
  const ImageView& mine, const std::vector<Message>& samples)
{
  std::vector<std::size_t> offsets(samples.size(), 0);
  this->Owned.resize(std::max(this->Owned.size(), this->Cells.size()));
  for (std::size_t index = 0; index < this->Cells.size(); ++index)
  {
    const CompositeCell& cell = this->Cells[index];
    if (cell.Owner != me || cell.Ranks.size() == 1)
    {
      continue;
    }
    ImageBuffer& owned = this->Owned[index];
    owned.Clear(cell.GetBlocks());
    const TargetRaster target{ owned.Colors.data(), owned.Depths.data(), owned.Raster,
      owned.Raster };
    for (const int rank : cell.Ranks)
    {
      const auto from = static_cast<std::size_t>(rank);
      const PixelRectangle rectangle = GetSamples(cell, viewports[from]);
      const int factor = viewports[from].Divisor / cell.Divisor;
      const auto merge = [&](const PixelRun& run, const std::uint32_t* colors, const float* depths)
      { MergeRun(run, colors, depths, factor, target); };
      if (rank == me)
      {
        ForEachActiveRun(mine, rectangle, merge);
        continue;
      }
      ISOSURFACE_RETURN_IF_ERROR(ReadActivePixels(
        samples[from], rectangle, PixelContent::ColorsAndDepths, offsets[from], this->Received));
      ForEachReceivedRun(this->Received, merge);
    }
  }
  return Status::Ok();
}

ImageView ViewportCompositor::GetMergedImage(std::size_t cell, const ImageView& mine) const
{
  return this->Cells[cell].Ranks.size() == 1 ? mine : this->Owned[cell].GetView();
}

std::vector<Message> ViewportCompositor::EncodeMergedCells(
  int me, std::size_t ranks, const ImageView& mine) const
{
  std::vector<Message> messages(ranks);
  for (std::size_t index = 0; index < this->Cells.size(); ++index)
  {
    const CompositeCell& cell = this->Cells[index];
    const int shownBy = this->Display.Tiles[cell.Tile].Rank;
    if (cell.Owner == me && shownBy != me)
    {
      AppendActivePixels(this->GetMergedImage(index, mine), cell.GetBlocks(), this->Delivered,
        messages[static_cast<std::size_t>(shownBy)]);
    }
  }
  return messages;
}

Status ViewportCompositor::FillSamples(const DisplayTile& shown, const ImageView& mine,
  const std::vector<Message>& merged, const TileImage& samples)
{
  std::fill_n(samples.Colors, shown.Pixels.GetArea(), 0);
  if (samples.Depths)
  {
    std::fill_n(samples.Depths, shown.Pixels.GetArea(), 1.0F);
  }
  std::vector<std::size_t> offsets(merged.size(), 0);
  for (std::size_t index = 0; index < this->Cells.size(); ++index)
  {
    const CompositeCell& cell = this->Cells[index];
    if (this->Display.Tiles[cell.Tile].Rank != shown.Rank)
    {
      continue;
    }
    const TargetRaster target{ samples.Colors, samples.Depths, shown.Pixels, cell.Pixels };
    const auto copy = [&](const PixelRun& run, const std::uint32_t* colors, const float* depths)
    { CopyRun(run, colors, depths, cell.Divisor, target); };
    if (cell.Owner == shown.Rank)
    {
      ForEachActiveRun(this->GetMergedImage(index, mine), cell.GetBlocks(), copy);
      continue;
    }
    const auto from = static_cast<std::size_t>(cell.Owner);
    ISOSURFACE_RETURN_IF_ERROR(ReadActivePixels(
      merged[from], cell.GetBlocks(), this->Delivered, offsets[from], this->Received));
    ForEachReceivedRun(this->Received, copy);
  }
  return Status::Ok();
}

Status ViewportCompositor::FillTile(
  int me, const ImageView& mine, const std::vector<Message>& merged, const TileImage& tile)
{
  const DisplayTile* shown = this->Display.FindTile(me);
  if (!shown)
  {
    return Status::Ok();
  }
  if (this->Display.SamplesPerPixel == 1)
  {
    return this->FillSamples(*shown, mine, merged, tile);
  }
  ImageBuffer& fine = this->TileSamples;
  fine.Resize(shown->Pixels);
  const TileImage samples{ fine.Colors.data(), tile.Depths ? fine.Depths.data() : nullptr };
  ISOSURFACE_RETURN_IF_ERROR(this->FillSamples(*shown, mine, merged, samples));
  const PixelRectangle pixels = this->Display.CoverWithPixels(shown->Pixels);
  AverageSamples(
    samples.Colors, samples.Depths, pixels.Width, pixels.Height, tile.Colors, tile.Depths);
  return Status::Ok();
}

std::vector<Message> ViewportCompositor::Send(
  Communicator& communicator, std::vector<Message> outgoing)
{
  for (const Message& message : outgoing)
  {
    this->BytesSent += message.size();
  }
  return communicator.Exchange(std::move(outgoing));
}

Status ViewportCompositor::Composite(Communicator& communicator, const DisplayLayout& display,
  const std::vector<Viewport>& viewports, const ImageView& mine, const TileImage& tile,
  bool wantsDepths)
{
  const int me = communicator.GetRank();
  this->BytesSent = 0;
  const std::string context = "an image cannot be composited";
  std::vector<Message> encoded;
  const auto encode = [&]() -> Status
  {
    ISOSURFACE_RETURN_IF_ERROR(CheckArguments(communicator, display, viewports, mine, tile));
    this->Display = display;
    this->Cells = PlanCompositing(viewports, display.Tiles);
    this->Delivered = wantsDepths ? PixelContent::ColorsAndDepths : PixelContent::Colors;
    encoded = this->EncodeSamples(me, viewports, mine);
    return Status::Ok();
  };
  ISOSURFACE_RETURN_IF_ERROR(communicator.Agree(Attempt(context, encode)));
  const std::vector<Message> samples = this->Send(communicator, std::move(encoded));
  std::vector<Message> encodedCells;
  const auto merge = [&]() -> Status
  {
    ISOSURFACE_RETURN_IF_ERROR(this->MergeOwnedCells(me, viewports, mine, samples));
    encodedCells = this->EncodeMergedCells(me, viewports.size(), mine);
    return Status::Ok();
  };
  ISOSURFACE_RETURN_IF_ERROR(communicator.Agree(Attempt(context, merge)));
  const std::vector<Message> merged = this->Send(communicator, std::move(encodedCells));
  return communicator.Agree(
    Attempt(context, [&] { return this->FillTile(me, mine, merged, tile); }));
}

} // namespace isosurface
