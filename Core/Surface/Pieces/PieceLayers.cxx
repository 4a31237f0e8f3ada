// SPDX-License-Identifier: BSD-3-Clause
#include "Surface/Pieces/PieceLayers.h"

#include "Ground/Base/Coding.h"
#include "Ground/Volume/PieceOwnership.h"
#include "Ground/Volume/SampleCopy.h"
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
struct DescribedPiece
{
  std::size_t Rank = 0;
  std::size_t Number = 0; ///< of that rank's
  std::int64_t Grid = 0;
  std::int64_t Type = 0;
  VertexBox Needed; ///< with the layer
  VertexBox Available;
};

constexpr const char* NoLayers = "the layers around the pieces of images cannot be collected";

// For each piece: grid and type as int64, both boxes.
Message DescribePieces(const std::vector<LayeredPiece>& pieces)
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
  return mine;
}

// By rank, then by number.
std::vector<DescribedPiece> ReadPieces(const std::vector<Message>& messages)
{
  std::vector<DescribedPiece> all;
  for (std::size_t rank = 0; rank < messages.size(); ++rank)
  {
    ByteReader reader(messages[rank]);
    for (std::size_t number = 0; reader.GetRemaining() > 0; ++number)
    {
      DescribedPiece& piece = all.emplace_back();
      piece.Rank = rank;
      piece.Number = number;
      piece.Grid = reader.Read<std::int64_t>();
      piece.Type = reader.Read<std::int64_t>();
      piece.Needed = ReadBox(reader);
      piece.Available = ReadBox(reader);
    }
  }
  return all;
}

// The parts of the layer that a piece needs, each from the first piece of its grid that has it.
std::vector<Supply> FindLayer(const std::vector<DescribedPiece>& all, const DescribedPiece& piece)
{
  if (piece.Needed.IsEmpty())
  {
    return {};
  }
  std::vector<VertexBox> boxes;
  boxes.reserve(all.size());
  for (const DescribedPiece& other : all)
  {
    const bool isOfGrid = other.Grid == piece.Grid && other.Type == piece.Type;
    boxes.push_back(isOfGrid ? other.Available : VertexBox());
  }
  std::vector<VertexBox> missing = SubtractBox(piece.Needed, piece.Available);
  return FindSupplies(boxes, missing);
}

// Appends the samples of a box, then a byte for each that says whether it is hidden.
void AppendPart(const LayeredPiece& piece, const VertexBox& box, Message& message)
{
  BlockSamples samples;
  samples.Scalars = piece.Scalars;
  samples.Hidden = &piece.Hidden;
  const CellVisibility visibility(samples, false);
  const std::size_t first = message.size();
  message.resize(
    first + static_cast<std::size_t>(box.GetNumberOfVertices()) * GetValueSize(piece.Scalars.Type));
  CopyBox(piece.Scalars, box, box, message.data() + first);
  VisitVertices(
    box, [&](const Index3& vertex) { message.push_back(visibility.IsKnown(vertex) ? 0 : 1); });
}

// A part for the samples of a supply, before they arrive.
PieceLayers::LayerBox MakeRoom(const LayeredPiece& piece, const Supply& supply, std::size_t rank)
{
  const auto count = static_cast<std::size_t>(supply.Box.GetNumberOfVertices());
  PieceLayers::LayerBox part;
  part.Rank = static_cast<int>(rank);
  part.Box = supply.Box;
  part.Samples = Buffer<std::uint8_t>(count * GetValueSize(piece.Scalars.Type));
  part.Hidden.resize(count);
  return part;
}

} // namespace

Result<PieceLayers> PieceLayers::Collect(
  Communicator& ranks, const Status& prepared, const std::vector<LayeredPiece>& pieces)
{
  const auto describe = [&](Message& mine) -> Status
  {
    ISOSURFACE_RETURN_IF_ERROR(prepared);
    mine = DescribePieces(pieces);
    return Status::Ok();
  };
  ISOSURFACE_ASSIGN_OR_RETURN(const auto messages, GatherFromAll(ranks, NoLayers, describe));
  const auto own = static_cast<std::size_t>(ranks.GetRank());
  std::vector<Message> outgoing(messages.size());
  PieceLayers layers;
  // Packs what other pieces need of this rank's, and makes room for what its own ones need.
  const auto pack = [&]
  {
    const std::vector<DescribedPiece> all = ReadPieces(messages);
    layers.Layers.resize(pieces.size());
    for (const DescribedPiece& piece : all)
    {
      for (const Supply& supply : FindLayer(all, piece))
      {
        const DescribedPiece& from = all[supply.Piece];
        if (from.Rank == own)
        {
          AppendPart(pieces[from.Number], supply.Box, outgoing[piece.Rank]);
        }
        if (piece.Rank == own)
        {
          layers.Layers[piece.Number].push_back(MakeRoom(pieces[piece.Number], supply, from.Rank));
        }
      }
    }
    return Status::Ok();
  };
  // A rank without memory for that sends nothing, which the others find.
  const Status packed = Attempt(NoLayers, pack);
  if (!packed.IsOk())
  {
    outgoing.assign(messages.size(), {});
  }
  const std::vector<Message> incoming = ranks.Exchange(std::move(outgoing));
  ISOSURFACE_RETURN_IF_ERROR(packed);
  ISOSURFACE_RETURN_IF_ERROR(Attempt(NoLayers, [&] { return layers.Place(incoming); }));
  return layers;
}

Status PieceLayers::Place(const std::vector<Message>& incoming)
{
  std::vector<ByteReader> readers(incoming.begin(), incoming.end());
  for (std::vector<LayerBox>& parts : this->Layers)
  {
    for (LayerBox& part : parts)
    {
      ByteReader& reader = readers[static_cast<std::size_t>(part.Rank)];
      const std::size_t size = part.Samples.GetSize();
      const std::uint8_t* bytes = reader.ReadBytes(size);
      if (!bytes)
      {
        return { StatusCode::RemoteFailure, "another rank has no memory to send its samples" };
      }
      std::memcpy(part.Samples.GetData(), bytes, size);
      reader.ReadAll(part.Hidden);
    }
  }
  return Status::Ok();
}

//------------------------------------------------------------------------------
// Blocks

/// A block's samples with the layer around it, and what is not known of them.
struct LayeredBlockSource::Copy
{
  Copy(const VertexBox& box, ValueType type)
    : Box(box)
    , Samples(static_cast<std::size_t>(box.GetNumberOfVertices()) * GetValueSize(type))
    , HiddenVertices(static_cast<std::size_t>(box.GetNumberOfVertices()), 1)
  {
    std::memset(this->Samples.GetData(), 0, this->Samples.GetSize());
  }

  void Add(const SampleView& samples)
  {
    CopyBox(samples, this->Box.Intersect(samples.Available), this->Box, this->Samples.GetData());
  }
  void AddHidden(const VertexBox& box, const std::uint8_t* hidden)
  {
    CopyBox(MakeSampleView(ValueType::UInt8, box, hidden), this->Box.Intersect(box), this->Box,
      this->HiddenVertices.data());
  }
  /// The flags of a piece that has the samples in `available`.
  void AddPiece(const Blanking& hidden, const VertexBox& available);

  VertexBox Box;
  Buffer<std::uint8_t> Samples;
  std::vector<std::uint8_t> HiddenVertices;
  std::vector<std::uint8_t> HiddenCells;
  Blanking Hidden;
};

void LayeredBlockSource::Copy::AddPiece(const Blanking& hidden, const VertexBox& available)
{
  VisitVertices(this->Box.Intersect(available),
    [&](const Index3& vertex)
    {
      const bool isHidden = hidden.Vertices && (*hidden.AtVertex(vertex) & hidden.HidesVertex) != 0;
      this->HiddenVertices[this->Box.FindIndex(vertex)] = isHidden ? 1 : 0;
    });
  if (!hidden.Cells)
  {
    return;
  }
  VertexBox cells = this->Box;
  for (std::int64_t& high : cells.High)
  {
    --high;
  }
  this->HiddenCells.assign(static_cast<std::size_t>(cells.GetNumberOfVertices()), 0);
  VisitVertices(cells,
    [&](const Index3& cell)
    {
      if (hidden.HasCell(cell) && (*hidden.AtCell(cell) & hidden.HidesCell) != 0)
      {
        this->HiddenCells[cells.FindIndex(cell)] = 1;
      }
    });
  this->Hidden.Cells = this->HiddenCells.data();
}

LayeredBlockSource::LayeredBlockSource(
  BlockSource& inner, const LayeredPiece& piece, const std::vector<PieceLayers::LayerBox>& layer)
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
  ISOSURFACE_ASSIGN_OR_RETURN(auto samples, this->Inner.Acquire(block));
  SampleView& scalars = samples.Scalars;
  const VertexBox box =
    scalars.Box.AddLayer(this->Piece.Dimensions).Intersect(this->GetKnownSamples());
  if (scalars.Available.Contains(box))
  {
    return samples;
  }
  const auto copy = std::make_shared<Copy>(box, scalars.Type);
  copy->Add(scalars);
  copy->AddPiece(this->Piece.Hidden, scalars.Available);
  for (const PieceLayers::LayerBox& part : this->Layer)
  {
    copy->Add(MakeSampleView(scalars.Type, part.Box, part.Samples.GetData()));
    copy->AddHidden(part.Box, part.Hidden.data());
  }
  const VertexBox own = scalars.Box;
  scalars = MakeSampleView(scalars.Type, box, copy->Samples.GetData());
  scalars.Box = own;
  copy->Hidden.Box = copy->Box;
  copy->Hidden.HidesCell = 1;
  copy->Hidden.HidesVertex = 1;
  const auto& flags = copy->HiddenVertices;
  if (std::find(flags.begin(), flags.end(), 1) != flags.end())
  {
    copy->Hidden.Vertices = flags.data();
  }
  samples.Hidden = &copy->Hidden;
  // Attributes are still those of the inner source.
  samples.Owner = std::make_shared<std::pair<std::shared_ptr<const void>, std::shared_ptr<Copy>>>(
    samples.Owner, copy);
  return samples;
}

} // namespace isosurface
