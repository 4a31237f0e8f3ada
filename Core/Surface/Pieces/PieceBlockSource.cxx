// SPDX-License-Identifier: BSD-3-Clause
#include "Surface/Pieces/PieceBlockSource.h"

#include "Ground/Base/Coding.h"
#include "Ground/Base/ParallelFor.h"
#include "Ground/Volume/SampleCopy.h"

#include <algorithm>

namespace isosurface
{
namespace
{

constexpr const char* NotShared = "the blocks that ranks share cannot be collected";

} // namespace

PieceBlockSource::PieceBlockSource(
  const GridGeometry& geometry, std::vector<GridPiece> pieces, const PieceBlockSelection& selection)
  : Geometry(geometry)
  , Grid(geometry.GetDimensions(), selection.BlockSize)
  , WithLayer(selection.WithLayer)
  , ClosedSides(selection.ClosedSides)
  , Isovalues(selection.Isovalues)
  , Pieces(std::move(pieces))
{
}

Result<std::unique_ptr<PieceBlockSource>> PieceBlockSource::Make(Communicator& ranks,
  const GridGeometry& grid, std::vector<GridPiece> pieces, const PieceBlockSelection& selection,
  int threads)
{
  std::unique_ptr<PieceBlockSource> source;
  Message mine;
  const auto describe = [&]
  {
    source.reset(new PieceBlockSource(grid, std::move(pieces), selection));
    return source->DescribePieces(mine);
  };
  ISOSURFACE_RETURN_IF_ERROR(AttemptOnAll(ranks, NotShared, describe));
  const std::vector<Message> all = ranks.AllGather(mine);
  CommonRanges ranges;
  const auto find = [&]() -> Status
  {
    ISOSURFACE_RETURN_IF_ERROR(source->AddPieces(all));
    source->FindBlocks(ranks.GetRank(), selection, threads);
    source->FindSharedRanges(ranks.GetRank(), ranges);
    return Status::Ok();
  };
  ISOSURFACE_RETURN_IF_ERROR(AttemptOnAll(ranks, NotShared, find));
  ranges.Join(ranks);
  ISOSURFACE_RETURN_IF_ERROR(source->CollectShared(ranks));
  return source;
}

std::vector<SampleView> PieceBlockSource::GetViews(std::size_t piece) const
{
  std::vector<SampleView> views = { this->Pieces[piece].Scalars };
  for (const AttributeView& attribute : this->Pieces[piece].Attributes)
  {
    views.insert(views.end(), attribute.Components.begin(), attribute.Components.end());
  }
  return views;
}

// The message, all int64. With n pieces on the rank, 0 without:
//
//     +--------------------------------------------------+
//     | components of all arrays, scalars first      (c) |
//     | attributes                                   (a) |
//     | types of the components                      x c |
//     | components of each attribute                 x a |
//     | box of each piece: low x, y, z, high x, y, z x n |
//     +--------------------------------------------------+
Status PieceBlockSource::DescribePieces(Message& message) const
{
  for (std::size_t n = 0; n < this->Pieces.size(); ++n)
  {
    Message arrays;
    const std::vector<SampleView> views = this->GetViews(n);
    AppendLittleEndian(arrays, static_cast<std::int64_t>(views.size()));
    AppendLittleEndian(arrays, static_cast<std::int64_t>(this->Pieces[n].Attributes.size()));
    for (const SampleView& view : views)
    {
      AppendLittleEndian(arrays, static_cast<std::int64_t>(view.Type));
    }
    for (const AttributeView& attribute : this->Pieces[n].Attributes)
    {
      AppendLittleEndian(arrays, static_cast<std::int64_t>(attribute.Components.size()));
    }
    if (!message.empty() && arrays != message)
    {
      return { StatusCode::InvalidArgument,
        "the arrays are not of the same types in all images of the input" };
    }
    message = std::move(arrays);
  }
  for (const GridPiece& piece : this->Pieces)
  {
    AppendBox(message, piece.Scalars.Available);
  }
  return Status::Ok();
}

Status PieceBlockSource::AddPieces(const std::vector<Message>& messages)
{
  for (std::size_t rank = 0; rank < messages.size(); ++rank)
  {
    if (!messages[rank].empty())
    {
      ISOSURFACE_RETURN_IF_ERROR(this->AddPiecesOf(static_cast<int>(rank), messages[rank]));
    }
  }
  if (this->Types.empty())
  {
    return { StatusCode::InvalidArgument, "the input has no samples" };
  }
  this->Thresholds = FindThresholdKeys(this->Types.front(), this->Isovalues);
  return Status::Ok();
}

Status PieceBlockSource::AddPiecesOf(int rank, const Message& message)
{
  ByteReader reader(message.data(), message.size());
  const auto components = reader.Read<std::int64_t>();
  const auto attributes = reader.Read<std::int64_t>();
  std::vector<ValueType> types;
  std::vector<int> sizes;
  for (std::int64_t n = 0; n < components; ++n)
  {
    types.push_back(static_cast<ValueType>(reader.Read<std::int64_t>()));
  }
  for (std::int64_t n = 0; n < attributes; ++n)
  {
    sizes.push_back(static_cast<int>(reader.Read<std::int64_t>()));
  }
  if (!this->Types.empty() && (types != this->Types || sizes != this->AttributeSizes))
  {
    return { StatusCode::InvalidArgument,
      "the arrays are not of the same types in the images of all ranks" };
  }
  this->Types = std::move(types);
  this->AttributeSizes = std::move(sizes);
  for (std::size_t number = 0; reader.GetRemaining() > 0; ++number)
  {
    this->AllPieces.push_back({ rank, number });
    this->Boxes.push_back(ReadBox(reader));
  }
  return Status::Ok();
}

bool PieceBlockSource::IsWanted(std::int64_t number, const KeyRange& range) const
{
  return this->ClosedSides.Touch(this->Grid.GetVertices(number), this->Grid.GetDimensions()) ||
    std::any_of(this->Thresholds.begin(), this->Thresholds.end(),
      [&range](ValueKey threshold) { return range.Straddles(threshold); });
}

// Sorts the blocks of the region into those within a piece, of which the own active ones are kept, and
// shared ones.
void PieceBlockSource::FindBlocks(int rank, const PieceBlockSelection& selection, int threads)
{
  const GridLines* lines = selection.Lines;
  std::vector<std::pair<std::int64_t, std::size_t>> whole; // own blocks and their pieces
  for (std::int64_t number = 0; number < this->Grid.GetNumberOfBlocks(); ++number)
  {
    const VertexBox vertices = this->Grid.GetVertices(number);
    if (!selection.Region.Intersects(
          lines ? lines->MakeFrame(this->Geometry, vertices) : this->Geometry, vertices))
    {
      continue;
    }
    const VertexBox samples =
      this->WithLayer ? vertices.AddLayer(this->Grid.GetDimensions()) : vertices;
    const auto find = [this](const auto& isWanted)
    {
      return static_cast<std::size_t>(
        std::find_if(this->Boxes.begin(), this->Boxes.end(), isWanted) - this->Boxes.begin());
    };
    const std::size_t owner = find([&](const VertexBox& box) { return box.Contains(samples); });
    if (owner < this->Boxes.size())
    {
      if (this->AllPieces[owner].Rank == rank)
      {
        whole.emplace_back(number, this->AllPieces[owner].Number);
      }
      continue;
    }
    const std::size_t first =
      find([&](const VertexBox& box) { return !box.Intersect(vertices).IsEmpty(); });
    if (first < this->Boxes.size())
    {
      SharedBlock& block = this->Shared.emplace_back();
      block.Number = number;
      block.Owner = this->AllPieces[first].Rank;
      block.Samples = samples;
      std::vector<VertexBox> missing = { samples };
      block.Supplies = FindSupplies(this->Boxes, missing);
      block.HasGap = !missing.empty();
    }
  }
  std::vector<SampleRange> ranges(whole.size());
  static_cast<void>(ParallelFor(whole.size(), threads,
    [&](std::size_t n, int)
    {
      ranges[n] = FindSampleRange(
        this->Pieces[whole[n].second].Scalars, this->Grid.GetVertices(whole[n].first));
    }));
  for (std::size_t n = 0; n < whole.size(); ++n)
  {
    this->Finite.Add(ranges[n].Finite);
    if (this->IsWanted(whole[n].first, ranges[n].All))
    {
      this->Numbers.push_back(whole[n].first);
      this->Places.push_back({ false, whole[n].second });
    }
  }
}

// Adds the ranges of the shared blocks' samples that this rank has, and that of all its samples.
void PieceBlockSource::FindSharedRanges(int rank, CommonRanges& common)
{
  common.Add(this->Finite);
  for (SharedBlock& block : this->Shared)
  {
    for (const Supply& supply : block.Supplies)
    {
      const PieceOwner& piece = this->AllPieces[supply.Piece];
      const VertexBox own = supply.Box.Intersect(this->Grid.GetVertices(block.Number));
      if (piece.Rank == rank && !own.IsEmpty())
      {
        block.Range.Add(FindSampleRange(this->Pieces[piece.Number].Scalars, own));
      }
    }
    common.Add(block.Range.All);
    common.Add(block.Range.Finite);
  }
}

// Once the ranges are those of all ranks.
void PieceBlockSource::DropInactive()
{
  for (const SharedBlock& block : this->Shared)
  {
    this->Finite.Add(block.Range.Finite);
  }
  this->Shared.erase(
    std::remove_if(this->Shared.begin(), this->Shared.end(),
      [this](const SharedBlock& block) { return !this->IsWanted(block.Number, block.Range.All); }),
    this->Shared.end());
}

// Brings the samples of the shared active blocks to their owners.
Status PieceBlockSource::CollectShared(Communicator& ranks)
{
  this->DropInactive();
  const auto hasGap = [](const SharedBlock& block) { return block.HasGap; };
  if (std::any_of(this->Shared.begin(), this->Shared.end(), hasGap))
  {
    return { StatusCode::InvalidArgument,
      "the images of the input leave gaps in their grid where the isosurface passes" };
  }
  std::vector<Message> outgoing;
  const auto pack = [&]
  {
    outgoing.resize(static_cast<std::size_t>(ranks.GetSize()));
    this->PackShared(ranks.GetRank(), outgoing);
    return Status::Ok();
  };
  ISOSURFACE_RETURN_IF_ERROR(AttemptOnAll(ranks, NotShared, pack));
  const std::vector<Message> incoming = ranks.Exchange(std::move(outgoing));
  const auto place = [&]
  {
    this->PlaceShared(ranks.GetRank(), incoming);
    return Status::Ok();
  };
  return AttemptOnAll(ranks, NotShared, place);
}

// Packs the samples for each rank, and makes room for those that this rank will get.
void PieceBlockSource::PackShared(int rank, std::vector<Message>& outgoing)
{
  for (SharedBlock& block : this->Shared)
  {
    Message& message = outgoing[static_cast<std::size_t>(block.Owner)];
    for (const Supply& supply : block.Supplies)
    {
      const PieceOwner& piece = this->AllPieces[supply.Piece];
      for (const SampleView& view :
        piece.Rank == rank ? this->GetViews(piece.Number) : std::vector<SampleView>())
      {
        const std::size_t begin = message.size();
        message.resize(begin +
          static_cast<std::size_t>(supply.Box.GetNumberOfVertices()) * GetValueSize(view.Type));
        CopyBox(view, supply.Box, supply.Box, message.data() + begin);
      }
    }
    for (std::size_t n = 0; block.Owner == rank && n < this->Types.size(); ++n)
    {
      block.Arrays.emplace_back(static_cast<std::size_t>(block.Samples.GetNumberOfVertices()) *
        GetValueSize(this->Types[n]));
    }
  }
}

// Adds the shared blocks of this rank to its own, with the samples that all ranks sent.
void PieceBlockSource::PlaceShared(int rank, const std::vector<Message>& incoming)
{
  std::vector<ByteReader> readers(incoming.begin(), incoming.end());
  for (std::size_t index = 0; index < this->Shared.size(); ++index)
  {
    SharedBlock& block = this->Shared[index];
    if (block.Owner != rank)
    {
      continue;
    }
    for (const Supply& supply : block.Supplies)
    {
      ByteReader& reader = readers[static_cast<std::size_t>(this->AllPieces[supply.Piece].Rank)];
      const auto count = static_cast<std::size_t>(supply.Box.GetNumberOfVertices());
      for (std::size_t n = 0; n < this->Types.size(); ++n)
      {
        const std::uint8_t* bytes = reader.ReadBytes(count * GetValueSize(this->Types[n]));
        CopyBox(MakeSampleView(this->Types[n], supply.Box, bytes), supply.Box, block.Samples,
          block.Arrays[n].GetData());
      }
    }
    const auto place = std::lower_bound(this->Numbers.begin(), this->Numbers.end(), block.Number);
    this->Places.insert(this->Places.begin() + (place - this->Numbers.begin()), { true, index });
    this->Numbers.insert(place, block.Number);
  }
}

Result<BlockSamples> PieceBlockSource::Acquire(std::size_t block)
{
  const Place& place = this->Places[block];
  BlockSamples samples;
  std::vector<SampleView> views;
  if (!place.IsShared)
  {
    views = this->GetViews(place.Index);
  }
  else
  {
    const SharedBlock& shared = this->Shared[place.Index];
    for (std::size_t n = 0; n < this->Types.size(); ++n)
    {
      views.push_back(MakeSampleView(this->Types[n], shared.Samples, shared.Arrays[n].GetData()));
    }
  }
  for (SampleView& view : views)
  {
    view.Box = this->GetVertices(block);
  }
  samples.Scalars = views.front();
  auto next = views.begin() + 1;
  for (const int components : this->AttributeSizes)
  {
    samples.Attributes.emplace_back().Components.assign(next, next + components);
    next += components;
  }
  return samples;
}

} // namespace isosurface
