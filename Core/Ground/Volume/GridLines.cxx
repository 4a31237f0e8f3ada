// SPDX-License-Identifier: BSD-3-Clause
#include "Ground/Volume/GridLines.h"

#include "Ground/Volume/GridUnion.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numeric>
#include <string>

namespace isosurface
{
namespace
{

// A piece as a message: the extent, then the coordinates of each axis.
void AppendPiece(const LinedGrid& piece, Message& message)
{
  const auto append = [&message](const void* values, std::size_t bytes)
  {
    const auto* from = static_cast<const std::uint8_t*>(values);
    message.insert(message.end(), from, from + bytes);
  };
  append(piece.Grid.Extent.data(), sizeof(piece.Grid.Extent));
  for (const std::vector<double>& axis : piece.Lines.Coordinates)
  {
    append(axis.data(), axis.size() * sizeof(double));
  }
}

std::vector<LinedGrid> ReadPieces(const Message& message)
{
  std::vector<LinedGrid> pieces;
  for (std::size_t at = 0; at < message.size();)
  {
    LinedGrid& piece = pieces.emplace_back();
    std::memcpy(piece.Grid.Extent.data(), &message[at], sizeof(piece.Grid.Extent));
    at += sizeof(piece.Grid.Extent);
    const Index3 dimensions = piece.Grid.GetDimensions();
    for (std::size_t axis = 0; axis < 3; ++axis)
    {
      std::vector<double>& lines = piece.Lines.Coordinates[axis];
      lines.resize(static_cast<std::size_t>(dimensions[axis]));
      std::memcpy(lines.data(), &message[at], lines.size() * sizeof(double));
      at += lines.size() * sizeof(double);
    }
  }
  return pieces;
}

// Whether two pieces have vertices in common, all at the same places.
bool DoMeet(const LinedGrid& a, const LinedGrid& b)
{
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    const std::int64_t lowA = a.Grid.Extent[2 * axis];
    const std::int64_t lowB = b.Grid.Extent[2 * axis];
    const std::int64_t low = std::max(lowA, lowB);
    const std::int64_t high = std::min(a.Grid.Extent[2 * axis + 1], b.Grid.Extent[2 * axis + 1]);
    const auto first = a.Lines.Coordinates[axis].begin() + (low - lowA);
    if (low > high ||
      !std::equal(
        first, first + (high - low + 1), b.Lines.Coordinates[axis].begin() + (low - lowB)))
    {
      return false;
    }
  }
  return true;
}

void Unite(const LinedGrid& piece, LinedGrid& whole)
{
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    std::int64_t& low = whole.Grid.Extent[2 * axis];
    std::int64_t& high = whole.Grid.Extent[2 * axis + 1];
    const std::int64_t pieceLow = piece.Grid.Extent[2 * axis];
    const std::int64_t pieceHigh = piece.Grid.Extent[2 * axis + 1];
    const std::vector<double>& from = piece.Lines.Coordinates[axis];
    std::vector<double>& to = whole.Lines.Coordinates[axis];
    if (pieceLow < low)
    {
      to.insert(to.begin(), from.begin(), from.begin() + (low - pieceLow));
      low = pieceLow;
    }
    if (pieceHigh > high)
    {
      to.insert(to.end(), from.end() - (pieceHigh - high), from.end());
      high = pieceHigh;
    }
  }
}

/// For each piece the number of the first piece of its grid: pieces that meet are of one grid.
std::vector<std::size_t> FindOwners(const std::vector<LinedGrid>& pieces)
{
  std::vector<std::size_t> owners(pieces.size());
  std::iota(owners.begin(), owners.end(), std::size_t{ 0 });
  for (std::size_t piece = 1; piece < pieces.size(); ++piece)
  {
    for (std::size_t other = 0; other < piece; ++other)
    {
      if (owners[other] != owners[piece] && DoMeet(pieces[piece], pieces[other]))
      {
        const std::size_t from = std::max(owners[piece], owners[other]);
        const std::size_t to = std::min(owners[piece], owners[other]);
        std::replace(owners.begin(), owners.end(), from, to);
      }
    }
  }
  return owners;
}

/// The grid of all pieces that have the owner `first`.
LinedGrid UnitePieces(
  const std::vector<LinedGrid>& pieces, const std::vector<std::size_t>& owners, std::size_t first)
{
  LinedGrid whole = pieces[first];
  // A piece extends what it meets; others follow in a later round.
  for (std::size_t round = 0; round < pieces.size(); ++round)
  {
    const auto before = whole.Grid.Extent;
    for (std::size_t piece = first; piece < pieces.size(); ++piece)
    {
      if (owners[piece] == first && DoMeet(pieces[piece], whole))
      {
        Unite(pieces[piece], whole);
      }
    }
    if (whole.Grid.Extent == before)
    {
      break;
    }
  }
  return whole;
}

} // namespace

Status GridLines::Check(const Index3& dimensions) const
{
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    const std::vector<double>& lines = this->Coordinates[axis];
    const std::string name(1, "xyz"[axis]);
    if (lines.size() != static_cast<std::size_t>(dimensions[axis]))
    {
      return { StatusCode::InvalidArgument,
        "the rectilinear grid has " + std::to_string(lines.size()) + " coordinates on axis " +
          name + " for " + std::to_string(dimensions[axis]) + " vertices" };
    }
    for (std::size_t n = 0; n < lines.size(); ++n)
    {
      if (!std::isfinite(lines[n]))
      {
        return { StatusCode::InvalidArgument,
          "the rectilinear grid has a coordinate on axis " + name + " that is not finite" };
      }
      if (n > 0 && !(lines[n - 1] < lines[n]))
      {
        return { StatusCode::InvalidArgument,
          "the coordinates of the rectilinear grid do not ascend on axis " + name };
      }
    }
  }
  return Status::Ok();
}

GridLines GridLines::Coarsen(int level) const
{
  GridLines coarse;
  const std::size_t step = std::size_t{ 1 } << level;
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    for (std::size_t n = 0; n < this->Coordinates[axis].size(); n += step)
    {
      coarse.Coordinates[axis].push_back(this->Coordinates[axis][n]);
    }
  }
  return coarse;
}

GridLines GridLines::Cut(const VertexBox& box) const
{
  GridLines part;
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    const auto first = this->Coordinates[axis].begin();
    part.Coordinates[axis].assign(first + box.Low[axis], first + box.High[axis]);
  }
  return part;
}

double GridLines::At(std::size_t axis, std::int64_t vertex) const
{
  const std::vector<double>& lines = this->Coordinates[axis];
  const auto last = static_cast<std::int64_t>(lines.size()) - 1;
  return lines[static_cast<std::size_t>(std::min(std::max<std::int64_t>(0, vertex), last))];
}

GridGeometry GridLines::MakeFrame(const GridGeometry& grid, const VertexBox& box) const
{
  GridGeometry frame = grid;
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    const double low = this->At(axis, box.Low[axis]);
    const double high = this->At(axis, box.High[axis] - 1);
    const std::int64_t cells = std::max<std::int64_t>(1, box.High[axis] - 1 - box.Low[axis]);
    frame.Spacing[axis] = high > low ? (high - low) / static_cast<double>(cells) : 1.0;
    frame.Origin[axis] =
      low - frame.Spacing[axis] * static_cast<double>(grid.Extent[2 * axis] + box.Low[axis]);
  }
  return frame;
}

Message PackLinedGrids(const std::vector<LinedGrid>& pieces)
{
  Message packed;
  for (const LinedGrid& piece : pieces)
  {
    AppendPiece(piece, packed);
  }
  return packed;
}

std::vector<LinedGrid> UniteLinedGrids(
  const std::vector<Message>& packed, std::size_t own, std::vector<std::size_t>& numbers)
{
  std::vector<LinedGrid> all;
  std::size_t firstOfOwn = 0;
  std::size_t piecesOfOwn = 0;
  for (std::size_t rank = 0; rank < packed.size(); ++rank)
  {
    const std::vector<LinedGrid> read = ReadPieces(packed[rank]);
    firstOfOwn = rank == own ? all.size() : firstOfOwn;
    piecesOfOwn = rank == own ? read.size() : piecesOfOwn;
    all.insert(all.end(), read.begin(), read.end());
  }
  const std::vector<std::size_t> owners = FindOwners(all);
  std::vector<LinedGrid> united;
  std::vector<std::size_t> places(all.size());
  for (std::size_t first = 0; first < all.size(); ++first)
  {
    if (owners[first] != first)
    {
      continue;
    }
    places[first] = united.size();
    united.push_back(UnitePieces(all, owners, first));
  }
  numbers.clear();
  for (std::size_t piece = 0; piece < piecesOfOwn; ++piece)
  {
    numbers.push_back(places[owners[firstOfOwn + piece]]);
  }
  return united;
}

} // namespace isosurface
