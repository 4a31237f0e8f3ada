// SPDX-License-Identifier: BSD-3-Clause
#include "Ranks/Compositing/CompositePlan.h"

#include <numeric>

namespace isosurface
{
namespace
{

// The rows of a strip are not fewer: the overhead of a strip would exceed the cost of its pixels.
constexpr int MinimumStripRows = 8;
// Strips a rank: with more of them, their different contents are spread more evenly.
constexpr int StripsPerRank = 4;
// The cost of copying a merged pixel to the tile, relative to that of merging a pixel.
constexpr double CopyCost = 0.5;

struct CoveredPixels
{
  PixelRectangle Pixels;
  int Rank;
};

void SortUnique(std::vector<int>& values)
{
  std::sort(values.begin(), values.end());
  values.erase(std::unique(values.begin(), values.end()), values.end());
}

// Appends the cells of rows [bottom, top), between which no viewport begins or ends.
void AppendBand(const std::vector<CoveredPixels>& coverage, std::size_t tile, int bottom, int top,
  std::vector<CompositeCell>& cells)
{
  std::vector<CoveredPixels> band;
  std::vector<int> columns;
  for (const CoveredPixels& covered : coverage)
  {
    if (covered.Pixels.Y <= bottom && covered.Pixels.GetTop() >= top)
    {
      band.push_back(covered);
      columns.push_back(covered.Pixels.X);
      columns.push_back(covered.Pixels.GetRight());
    }
  }
  SortUnique(columns);
  for (std::size_t column = 0; column + 1 < columns.size(); ++column)
  {
    CompositeCell cell;
    cell.Tile = tile;
    cell.Pixels = PixelRectangle::FromEdges(columns[column], bottom, columns[column + 1], top);
    for (const CoveredPixels& covered : band)
    {
      if (covered.Pixels.Contains(cell.Pixels.X, bottom))
      {
        cell.Ranks.push_back(covered.Rank);
      }
    }
    if (!cell.Ranks.empty())
    {
      cells.push_back(std::move(cell));
    }
  }
}

// Joins the cells of the last band, from index `band` on, with the cells right below them that have
// the same columns and ranks. Those, from index `below` on, are left empty.
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
  std::vector<CoveredPixels> coverage;
  std::vector<int> rows;
  for (std::size_t rank = 0; rank < viewports.size(); ++rank)
  {
    const PixelRectangle pixels = viewports[rank].GetPixels(tilePixels);
    if (!pixels.IsEmpty())
    {
      coverage.push_back({ pixels, static_cast<int>(rank) });
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
    AppendBand(coverage, tile, rows[row], rows[row + 1], cells);
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

void AppendStrips(const CompositeCell& cell, double maximumCost, std::vector<CompositeCell>& strips)
{
  const int wanted = static_cast<int>(std::min(1e6, GetMergeCost(cell) / maximumCost)) + 1;
  const int possible = std::max(1, cell.Pixels.Height / (MinimumStripRows * cell.Divisor));
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

// Cuts the cells of several ranks into strips of at most `maximumCost`, each of which goes to the
// rank of the cell that has the least to do so far. `loads` are the ranks' costs before.
std::vector<CompositeCell> AssignOwners(
  std::vector<CompositeCell> cells, double maximumCost, std::vector<double> loads)
{
  std::vector<CompositeCell> strips;
  for (CompositeCell& cell : cells)
  {
    if (cell.Ranks.size() == 1)
    {
      strips.push_back(std::move(cell));
      continue;
    }
    const std::size_t first = strips.size();
    AppendStrips(cell, maximumCost, strips);
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
        CopyCost * static_cast<double>(cell.GetBlocks().GetArea());
      cells.push_back(std::move(cell));
    }
  }
  const double maximumCost = total / static_cast<double>(StripsPerRank * viewports.size());
  return AssignOwners(std::move(cells), maximumCost, std::move(loads));
}

} // namespace isosurface
