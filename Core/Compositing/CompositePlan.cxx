// SPDX-License-Identifier: BSD-3-Clause
#include "Compositing/CompositePlan.h"

#include <numeric>

namespace isosurface
{
namespace
{

// Rows of the thinnest strip: below that a message's cost is that of its pieces, not of its pixels.
constexpr int LeastStripRows = 8;
// Strips a rank: the more, the more evenly their different contents are spread.
constexpr int StripsPerRank = 4;
// What it costs to put a received pixel into its place, as against merging a pixel into another.
constexpr double PlacingCost = 0.5;

struct CoveredPart
{
  PixelRectangle Pixels;
  int Rank;
};

void SortUnique(std::vector<int>& values)
{
  std::sort(values.begin(), values.end());
  values.erase(std::unique(values.begin(), values.end()), values.end());
}

// The cells of rows [bottom, top), which no edge of a part lies between.
void AppendBand(const std::vector<CoveredPart>& parts, std::size_t tile, int bottom, int top,
  std::vector<CompositeCell>& cells)
{
  std::vector<CoveredPart> band;
  std::vector<int> columns;
  for (const CoveredPart& part : parts)
  {
    if (part.Pixels.Y <= bottom && part.Pixels.GetTop() >= top)
    {
      band.push_back(part);
      columns.push_back(part.Pixels.X);
      columns.push_back(part.Pixels.GetRight());
    }
  }
  SortUnique(columns);
  for (std::size_t column = 0; column + 1 < columns.size(); ++column)
  {
    CompositeCell cell;
    cell.Tile = tile;
    cell.Pixels = PixelRectangle::FromEdges(columns[column], bottom, columns[column + 1], top);
    for (const CoveredPart& part : band)
    {
      if (part.Pixels.Contains(cell.Pixels.X, bottom))
      {
        cell.Ranks.push_back(part.Rank);
      }
    }
    if (!cell.Ranks.empty())
    {
      cells.push_back(std::move(cell));
    }
  }
}

// Joins cells of the last band, which begins at index `band`, to those right below them that have
// the same columns and ranks; these are left empty.
void JoinUpwards(std::vector<CompositeCell>& cells, std::size_t below, std::size_t band)
{
  const auto begin = cells.begin() + static_cast<std::ptrdiff_t>(below);
  const auto end = cells.begin() + static_cast<std::ptrdiff_t>(band);
  for (auto cell = end; cell != cells.end(); ++cell)
  {
    const auto same = std::find_if(begin, end,
      [&cell](const CompositeCell& other)
      {
        return other.Pixels.X == cell->Pixels.X && other.Pixels.Width == cell->Pixels.Width &&
          other.Pixels.GetTop() == cell->Pixels.Y && other.Ranks == cell->Ranks;
      });
    if (same != end)
    {
      cell->Pixels = PixelRectangle::FromEdges(
        cell->Pixels.X, same->Pixels.Y, cell->Pixels.GetRight(), cell->Pixels.GetTop());
      same->Pixels.Height = 0;
    }
  }
}

std::vector<CompositeCell> CutTile(
  const std::vector<Viewport>& viewports, const PixelRectangle& tilePixels, std::size_t tile)
{
  std::vector<CoveredPart> parts;
  std::vector<int> rows;
  for (std::size_t rank = 0; rank < viewports.size(); ++rank)
  {
    const PixelRectangle pixels = viewports[rank].GetPixels(tilePixels);
    if (!pixels.IsEmpty())
    {
      parts.push_back({ pixels, static_cast<int>(rank) });
      rows.push_back(pixels.Y);
      rows.push_back(pixels.GetTop());
    }
  }
  SortUnique(rows);
  std::vector<CompositeCell> cells;
  std::size_t below = 0;
  for (std::size_t row = 0; row + 1 < rows.size(); ++row)
  {
    const std::size_t band = cells.size();
    AppendBand(parts, tile, rows[row], rows[row + 1], cells);
    JoinUpwards(cells, below, band);
    below = band;
  }
  cells.erase(std::remove_if(cells.begin(), cells.end(),
                [](const CompositeCell& cell) { return cell.Pixels.IsEmpty(); }),
    cells.end());
  return cells;
}

int FindCommonDivisor(const CompositeCell& cell, const std::vector<Viewport>& viewports)
{
  int common = 0;
  for (const int rank : cell.Ranks)
  {
    common = std::gcd(common, viewports[static_cast<std::size_t>(rank)].Divisor);
  }
  return common;
}

double GetMergeCost(const CompositeCell& cell)
{
  return static_cast<double>(cell.GetBlocks().GetArea()) * static_cast<double>(cell.Ranks.size());
}

void AppendStrips(const CompositeCell& cell, double largestCost, std::vector<CompositeCell>& strips)
{
  const int wanted = static_cast<int>(std::min(1e6, GetMergeCost(cell) / largestCost)) + 1;
  const int possible = std::max(1, cell.Pixels.Height / (LeastStripRows * cell.Divisor));
  const int count = std::min(wanted, possible);
  for (int strip = 0; strip < count; ++strip)
  {
    const auto edge = [&cell, count](int index)
    {
      return cell.Pixels.Y +
        static_cast<int>(static_cast<std::int64_t>(cell.Pixels.Height) * index / count);
    };
    strips.push_back(cell);
    strips.back().Pixels = PixelRectangle::FromEdges(
      cell.Pixels.X, edge(strip), cell.Pixels.GetRight(), edge(strip + 1));
  }
}

} // namespace

std::vector<CompositeCell> PlanCompositing(
  const std::vector<Viewport>& viewports, const std::vector<DisplayTile>& tiles)
{
  std::vector<CompositeCell> cells;
  std::vector<double> loads(viewports.size(), 0);
  double total = 0;
  for (std::size_t tile = 0; tile < tiles.size(); ++tile)
  {
    for (CompositeCell& cell : CutTile(viewports, tiles[tile].Pixels, tile))
    {
      cell.Divisor = FindCommonDivisor(cell, viewports);
      cell.Owner = cell.Ranks.front();
      total += cell.Ranks.size() > 1 ? GetMergeCost(cell) : 0;
      loads[static_cast<std::size_t>(tiles[tile].Rank)] +=
        PlacingCost * static_cast<double>(cell.GetBlocks().GetArea());
      cells.push_back(std::move(cell));
    }
  }

  std::vector<CompositeCell> strips;
  for (const CompositeCell& cell : cells)
  {
    if (cell.Ranks.size() == 1)
    {
      strips.push_back(cell);
      continue;
    }
    const std::size_t first = strips.size();
    AppendStrips(cell, total / static_cast<double>(StripsPerRank * viewports.size()), strips);
    for (std::size_t strip = first; strip < strips.size(); ++strip)
    {
      strips[strip].Owner = *std::min_element(cell.Ranks.begin(), cell.Ranks.end(),
        [&loads](int a, int b)
        { return loads[static_cast<std::size_t>(a)] < loads[static_cast<std::size_t>(b)]; });
      loads[static_cast<std::size_t>(strips[strip].Owner)] += GetMergeCost(strips[strip]);
    }
  }
  return strips;
}

} // namespace isosurface
