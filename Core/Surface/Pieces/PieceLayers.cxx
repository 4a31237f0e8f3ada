// SPDX-License-Identifier: BSD-3-Clause
#include "Surface/Pieces/PieceLayers.h"

#include "Ground/Base/Coding.h"
#include "Ground/Volume/PieceOwnership.h"
#include "Surface/Contour/CellVisibility.h"

#include <algorithm>
#include <cstring>
#include <memory>
#include <utility>

namespace isosurface
{
namespace
{

// What all ranks know of a piece.
struct PlacedPiece
{
  std::int64_t Grid = 0;
  std::int64_t Type = 0;
  VertexBox Needed; ///< with the layer
  VertexBox Available;
};

// A part of a piece's layer, and who has it.
struct Supply
{
  VertexBox Box;
  int Rank = 0;
  std::size_t Piece = 0; ///< of that rank
};

// By rank, then by number. A message has for each piece: grid and type as int64, both boxes.
std::vector<std::vector<PlacedPiece>> GatherPieces(
  Communicator& ranks, const std::vector<LayeredPiece>& pieces)
{
  Message mine;
  for (const LayeredPiece& piece : pieces)
  {
    const VertexBox& box = piece.Scalars.Box;
    AppendLittleEndian(mine, static_cast<std::int64_t>(piece.Grid));
    AppendLittleEndian(mine, static_cast<std::int64_t>(piece.Scalars.Type));
    AppendBox(mine, box.IsEmpty() ? box : box.AddLayer(piece.Dimensions));
    AppendBox(mine, piece.Scalars.Available);
  }
  std::vector<std::vector<PlacedPiece>> all;
  for (const Message& message : ranks.AllGather(mine))
  {
    std::vector<PlacedPiece>& placed = all.emplace_back();
    ByteReader reader(message);
    while (reader.GetRemaining() > 0)
    {
      PlacedPiece& piece = placed.emplace_back();
      piece.Grid = reader.Read<std::int64_t>();
      piece.Type = reader.Read<std::int64_t>();
      piece.Needed = ReadBox(reader);
      piece.Available = ReadBox(reader);
    }
  }
  return all;
}

// The parts of the layer that a piece needs, each from the first piece that has it.
std::vector<Supply> FindSupplies(
  const std::vector<std::vector<PlacedPiece>>& all, const PlacedPiece& piece)
{
  std::vector<Supply> supplies;
  if (piece.Needed.IsEmpty())
  {
    return supplies;
  }
  std::vector<VertexBox> missing = SubtractBox(piece.Needed, piece.Available);
  for (std::size_t rank = 0; rank < all.size() && !missing.empty(); ++rank)
  {
    for (std::size_t n = 0; n < all[rank].size() && !missing.empty(); ++n)
    {
      const PlacedPiece& other = all[rank][n];
      if (other.Grid != piece.Grid || other.Type != piece.Type)
      {
        continue;
      }
      for (const VertexBox& rest : missing)
      {
        const VertexBox part = rest.Intersect(other.Available);
        if (!part.IsEmpty())
        {
          supplies.push_back({ part, static_cast<int>(rank), n });
        }
      }
      missing = SubtractBox(missing, other.Available);
    }
  }
  return supplies;
}

// Appends the samples of a box, then a byte for each that says whether it is known.
void AppendPart(const LayeredPiece& piece, const VertexBox& box, Message& message)
{
  BlockSamples samples;
  samples.Scalars = piece.Scalars;
  samples.Hidden = &piece.Hidden;
  const CellVisibility visibility(samples, false);
  const std::size_t valueSize = GetValueSize(piece.Scalars.Type);
  const std::size_t first = message.size();
  const auto count = static_cast<std::size_t>(box.GetNumberOfVertices());
  message.resize(first + count * (valueSize + 1));
  std::uint8_t* to = &message[first];
  std::uint8_t* known = to + count * valueSize;
  DispatchValueType(piece.Scalars.Type,
    [&](auto zero)
    {
      VisitVertices(box,
        [&](const Index3& vertex)
        {
          std::memcpy(to, piece.Scalars.At<decltype(zero)>(vertex), valueSize);
          to += valueSize;
          *known++ = visibility.IsKnown(vertex) ? 1 : 0;
        });
    });
}

// A part for the samples of a supply, before they arrive.
PieceLayers::Part MakeRoom(const LayeredPiece& piece, const Supply& supply)
{
  const auto count = static_cast<std::size_t>(supply.Box.GetNumberOfVertices());
  PieceLayers::Part part;
  part.Rank = supply.Rank;
  part.Box = supply.Box;
  part.Samples = Buffer<std::uint8_t>(count * GetValueSize(piece.Scalars.Type));
  part.Known.resize(count);
  return part;
}

} // namespace

Result<PieceLayers> PieceLayers::Collect(
  Communicator& ranks, const std::vector<LayeredPiece>& pieces)
{
  const std::vector<std::vector<PlacedPiece>> all = GatherPieces(ranks, pieces);
  std::vector<Message> outgoing(all.size());
  bool isAnyNeeded = false; // the same on all ranks
  PieceLayers layers;
  layers.Parts.resize(pieces.size());
  // Packs what other pieces need of this rank's, and makes room for what its own ones need.
  const auto pack = [&]
  {
    for (std::size_t rank = 0; rank < all.size(); ++rank)
    {
      for (std::size_t number = 0; number < all[rank].size(); ++number)
      {
        const std::vector<Supply> supplies = FindSupplies(all, all[rank][number]);
        isAnyNeeded = isAnyNeeded || !supplies.empty();
        for (const Supply& supply : supplies)
        {
          if (supply.Rank == ranks.GetRank())
          {
            AppendPart(pieces[supply.Piece], supply.Box, outgoing[rank]);
          }
          if (rank == static_cast<std::size_t>(ranks.GetRank()))
          {
            layers.Parts[number].push_back(MakeRoom(pieces[number], supply));
          }
        }
      }
    }
    return Status::Ok();
  };
  ISOSURFACE_RETURN_IF_ERROR(
    ranks.Agree(Attempt("the layers around the pieces of images cannot be collected", pack)));
  if (isAnyNeeded)
  {
    layers.Place(ranks.Exchange(std::move(outgoing)));
  }
  return layers;
}

void PieceLayers::Place(const std::vector<Message>& incoming)
{
  std::vector<std::size_t> used(incoming.size(), 0);
  for (std::vector<Part>& parts : this->Parts)
  {
    for (Part& part : parts)
    {
      const auto rank = static_cast<std::size_t>(part.Rank);
      const std::uint8_t* from = &incoming[rank][used[rank]];
      const std::size_t bytes = part.Samples.GetSize();
      std::memcpy(part.Samples.GetData(), from, bytes);
      std::memcpy(part.Known.data(), from + bytes, part.Known.size());
      used[rank] += bytes + part.Known.size();
    }
  }
}

//------------------------------------------------------------------------------
// Blocks

/// A block's samples with the layer around it, and what is not known of them.
struct LayeredBlockSource::Copy
{
  VertexBox Box;
  std::size_t ValueSize = 0;
  Buffer<std::uint8_t> Samples;
  std::vector<std::uint8_t> HiddenVertices;
  std::vector<std::uint8_t> HiddenCells;
  Blanking Hidden;
};

LayeredBlockSource::LayeredBlockSource(
  BlockSource& inner, const LayeredPiece& piece, const std::vector<PieceLayers::Part>& layer)
  : Inner(inner)
  , Piece(piece)
  , Layer(layer)
{
}

VertexBox LayeredBlockSource::GetKnownSamples() const
{
  return this->Piece.Scalars.Box.AddLayer(this->Piece.Dimensions);
}

Result<BlockSamples> LayeredBlockSource::Acquire(std::size_t block)
{
  auto samples = this->Inner.Acquire(block);
  ISOSURFACE_RETURN_IF_ERROR(samples.GetStatus());
  SampleView& scalars = samples->Scalars;
  const auto copy = std::make_shared<Copy>();
  copy->Box = scalars.Box.AddLayer(this->Piece.Dimensions).Intersect(this->GetKnownSamples());
  if (scalars.Available.Contains(copy->Box))
  {
    return samples;
  }
  const auto count = static_cast<std::size_t>(copy->Box.GetNumberOfVertices());
  copy->ValueSize = GetValueSize(scalars.Type);
  copy->Samples = Buffer<std::uint8_t>(count * copy->ValueSize);
  std::memset(copy->Samples.GetData(), 0, count * copy->ValueSize);
  copy->HiddenVertices.assign(count, 1);
  this->CopyPiece(scalars, *copy);
  this->CopyParts(*copy);
  this->CopyHiddenCells(*copy);
  const Index3 size = copy->Box.GetSize();
  scalars.First = copy->Samples.GetData();
  scalars.Stride = { 1, static_cast<std::ptrdiff_t>(size[0]),
    static_cast<std::ptrdiff_t>(size[0] * size[1]) };
  scalars.Available = copy->Box;
  copy->Hidden.Box = copy->Box;
  copy->Hidden.HidesCell = 1;
  copy->Hidden.HidesVertex = 1;
  const auto& flags = copy->HiddenVertices;
  if (std::find(flags.begin(), flags.end(), 1) != flags.end())
  {
    copy->Hidden.Vertices = flags.data();
  }
  samples->Hidden = &copy->Hidden;
  // Attributes are still those of the inner source.
  samples->Owner = std::make_shared<std::pair<std::shared_ptr<const void>, std::shared_ptr<Copy>>>(
    samples->Owner, copy);
  return samples;
}

void LayeredBlockSource::CopyPiece(const SampleView& scalars, Copy& copy) const
{
  const Blanking& hidden = this->Piece.Hidden;
  DispatchValueType(scalars.Type,
    [&](auto zero)
    {
      VisitVertices(copy.Box.Intersect(scalars.Available),
        [&](const Index3& vertex)
        {
          const std::size_t to = copy.Box.FindIndex(vertex);
          std::memcpy(copy.Samples.GetData() + to * copy.ValueSize,
            scalars.At<decltype(zero)>(vertex), copy.ValueSize);
          const bool isHidden =
            hidden.Vertices && (*hidden.AtVertex(vertex) & hidden.HidesVertex) != 0;
          copy.HiddenVertices[to] = isHidden ? 1 : 0;
        });
    });
}

void LayeredBlockSource::CopyParts(Copy& copy) const
{
  for (const PieceLayers::Part& part : this->Layer)
  {
    VisitVertices(copy.Box.Intersect(part.Box),
      [&](const Index3& vertex)
      {
        const std::size_t to = copy.Box.FindIndex(vertex);
        const std::size_t from = part.Box.FindIndex(vertex);
        std::memcpy(copy.Samples.GetData() + to * copy.ValueSize,
          part.Samples.GetData() + from * copy.ValueSize, copy.ValueSize);
        copy.HiddenVertices[to] = part.Known[from] != 0 ? 0 : 1;
      });
  }
}

void LayeredBlockSource::CopyHiddenCells(Copy& copy) const
{
  const Blanking& hidden = this->Piece.Hidden;
  if (!hidden.Cells)
  {
    return;
  }
  VertexBox cells = copy.Box;
  for (std::int64_t& high : cells.High)
  {
    --high;
  }
  copy.HiddenCells.assign(static_cast<std::size_t>(cells.GetNumberOfVertices()), 0);
  VisitVertices(cells,
    [&](const Index3& cell)
    {
      if (hidden.HasCell(cell) && (*hidden.AtCell(cell) & hidden.HidesCell) != 0)
      {
        copy.HiddenCells[cells.FindIndex(cell)] = 1;
      }
    });
  copy.Hidden.Cells = copy.HiddenCells.data();
}

} // namespace isosurface
