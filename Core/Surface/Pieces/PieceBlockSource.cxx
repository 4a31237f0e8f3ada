// SPDX-License-Identifier: BSD-3-Clause
#include "Surface/Pieces/PieceBlockSource.h"

#include "Ground/Base/ParallelFor.h"
#include "Ground/Volume/SampleCopy.h"
#include "Ground/Volume/SampleRange.h"

#include <algorithm>
#include <utility>

namespace isosurface
{
namespace
{

constexpr const char* NotShared = "the blocks that ranks share cannot be collected";

/// Where samples lie of an isovalue's threshold.
constexpr int Below = 1;
constexpr int NotBelow = 2;

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

Result<std::unique_ptr<PieceBlockSource>> PieceBlockSource::Make(
  Communicator& ranks, PieceBlockInput input, int threads)
{
  std::vector<PieceBlockInput> inputs;
  const auto prepare = [&]
  {
    inputs.push_back(std::move(input));
    return Status::Ok();
  };
  const Status prepared = Attempt(NotShared, prepare);
  ISOSURFACE_ASSIGN_OR_RETURN(auto made, MakeAll(ranks, prepared, std::move(inputs), threads));
  ISOSURFACE_RETURN_IF_ERROR(ranks.Agree(made.front()->GetStatus()));
  return std::move(made.front());
}

Result<std::vector<std::unique_ptr<PieceBlockSource>>> PieceBlockSource::MakeAll(
  Communicator& ranks, const Status& prepared, std::vector<PieceBlockInput> inputs, int threads)
{
  const int rank = ranks.GetRank();
  std::vector<std::unique_ptr<PieceBlockSource>> sources;
  const auto describe = [&](Message& mine) -> Status
  {
    ISOSURFACE_RETURN_IF_ERROR(prepared);
    for (PieceBlockInput& input : inputs)
    {
      sources.emplace_back(
        new PieceBlockSource(input.Grid, std::move(input.Pieces), input.Selection));
      const Message pieces = sources.back()->DescribePieces();
      AppendVarint(mine, pieces.size());
      mine.insert(mine.end(), pieces.begin(), pieces.end());
    }
    return Status::Ok();
  };
  ISOSURFACE_ASSIGN_OR_RETURN(const auto described, GatherFromAll(ranks, NotShared, describe));
  std::vector<ByteReader> readers;
  const auto find = [&](Message& mine)
  {
    std::vector<ByteReader> pieces(described.begin(), described.end());
    for (std::size_t n = 0; n < sources.size(); ++n)
    {
      sources[n]->AddPieces(pieces);
      if (sources[n]->Fault.IsOk())
      {
        sources[n]->FindBlocks(rank, inputs[n].Selection, threads);
      }
      sources[n]->AppendRanges(rank, mine);
    }
    readers.reserve(described.size());
    return Status::Ok();
  };
  ISOSURFACE_ASSIGN_OR_RETURN(const auto ranges, GatherFromAll(ranks, NotShared, find));
  // From here on all ranks know the same of each source, whatever memory a rank lacks.
  for (const Message& message : ranges)
  {
    readers.emplace_back(message);
  }
  bool areShared = false;
  for (const auto& source : sources)
  {
    source->TakeRanges(readers);
    areShared = areShared || !source->Shared.empty();
  }
  if (areShared)
  {
    ShareSamples(ranks, sources);
  }
  return sources;
}

// Brings the samples of the shared active blocks to their owners. A rank without memory for that sends
// nothing, which the others find.
void PieceBlockSource::ShareSamples(
  Communicator& ranks, const std::vector<std::unique_ptr<PieceBlockSource>>& sources)
{
  const auto ranksThere = static_cast<std::size_t>(ranks.GetSize());
  std::vector<Message> outgoing(ranksThere);
  const auto pack = [&]
  {
    for (const auto& source : sources)
    {
      source->PackShared(ranks.GetRank(), outgoing);
    }
    return Status::Ok();
  };
  Status shared = Attempt(NotShared, pack);
  if (!shared.IsOk())
  {
    outgoing.assign(ranksThere, {});
  }
  const std::vector<Message> incoming = ranks.Exchange(std::move(outgoing));
  const auto place = [&]() -> Status
  {
    std::vector<ByteReader> readers(incoming.begin(), incoming.end());
    for (const auto& source : sources)
    {
      ISOSURFACE_RETURN_IF_ERROR(source->PlaceShared(ranks.GetRank(), readers));
    }
    return Status::Ok();
  };
  shared = shared.IsOk() ? Attempt(NotShared, place) : shared;
  for (const auto& source : sources)
  {
    source->Fault = source->Fault.IsOk() ? shared : source->Fault;
  }
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

// The message, all varints. With n pieces on the rank; nothing without; a 0 for pieces of different types:
//
//     +--------------------------------------------------+
//     | components of all arrays, scalars first      (c) |
//     | attributes                                   (a) |
//     | types of the components                      x c |
//     | components of each attribute                 x a |
//     | box of each piece: low x, y, z, high x, y, z x n |
//     +--------------------------------------------------+
Message PieceBlockSource::DescribePieces() const
{
  Message message;
  for (std::size_t n = 0; n < this->Pieces.size(); ++n)
  {
    Message arrays;
    const std::vector<SampleView> views = this->GetViews(n);
    AppendVarint(arrays, views.size());
    AppendVarint(arrays, this->Pieces[n].Attributes.size());
    for (const SampleView& view : views)
    {
      AppendVarint(arrays, static_cast<std::uint64_t>(view.Type));
    }
    for (const AttributeView& attribute : this->Pieces[n].Attributes)
    {
      AppendVarint(arrays, attribute.Components.size());
    }
    if (!message.empty() && arrays != message)
    {
      return Message(1, std::uint8_t{ 0 });
    }
    message = std::move(arrays);
  }
  for (const GridPiece& piece : this->Pieces)
  {
    for (const Index3& corner : { piece.Scalars.Available.Low, piece.Scalars.Available.High })
    {
      for (const std::int64_t coordinate : corner)
      {
        AppendVarint(message, static_cast<std::uint64_t>(coordinate));
      }
    }
  }
  return message;
}

void PieceBlockSource::AddPieces(std::vector<ByteReader>& readers)
{
  for (std::size_t rank = 0; rank < readers.size(); ++rank)
  {
    const auto size = static_cast<std::size_t>(readers[rank].ReadVarint());
    const ByteReader reader(readers[rank].ReadBytes(size), size);
    if (size > 0 && this->Fault.IsOk())
    {
      this->Fault = this->AddPiecesOf(static_cast<int>(rank), reader);
    }
  }
  if (this->Fault.IsOk() && this->Types.empty())
  {
    this->Fault = { StatusCode::InvalidArgument, "the input has no samples" };
  }
  if (this->Fault.IsOk())
  {
    this->Thresholds = FindThresholdKeys(this->Types.front(), this->Isovalues);
  }
}

Status PieceBlockSource::AddPiecesOf(int rank, ByteReader reader)
{
  std::vector<ValueType> types(static_cast<std::size_t>(reader.ReadVarint()));
  if (types.empty())
  {
    return { StatusCode::InvalidArgument,
      "the arrays are not of the same types in all images of the input" };
  }
  std::vector<int> sizes(static_cast<std::size_t>(reader.ReadVarint()));
  for (ValueType& type : types)
  {
    type = static_cast<ValueType>(reader.ReadVarint());
  }
  for (int& size : sizes)
  {
    size = reader.ReadVarint<int>();
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
    VertexBox& box = this->Boxes.emplace_back();
    for (Index3* corner : { &box.Low, &box.High })
    {
      for (std::int64_t& coordinate : *corner)
      {
        coordinate = static_cast<std::int64_t>(reader.ReadVarint());
      }
    }
  }
  return Status::Ok();
}

bool PieceBlockSource::IsAtClosedSide(std::int64_t number) const
{
  return this->ClosedSides.Touch(this->Grid.GetVertices(number), this->Grid.GetDimensions());
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
      block.Sides.resize(this->Thresholds.size());
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
    const KeyRange& range = ranges[n].All;
    if (this->IsAtClosedSide(whole[n].first) ||
      std::any_of(this->Thresholds.begin(), this->Thresholds.end(),
        [&range](ValueKey threshold) { return range.Straddles(threshold); }))
    {
      this->Numbers.push_back(whole[n].first);
      this->Places.push_back({ false, whole[n].second });
    }
  }
}

// The keys of the finite range of this rank's samples; then, of each shared block that this rank has samples of,
// how many blocks further it is, from 1 on, and its Sides; then 0.
void PieceBlockSource::AppendRanges(int rank, Message& message)
{
  Message blocks;
  std::size_t next = 0;
  for (std::size_t n = 0; n < this->Shared.size(); ++n)
  {
    SampleRange range;
    for (const Supply& supply : this->Shared[n].Supplies)
    {
      const PieceOwner& piece = this->AllPieces[supply.Piece];
      const VertexBox own = supply.Box.Intersect(this->Grid.GetVertices(this->Shared[n].Number));
      if (piece.Rank == rank && !own.IsEmpty())
      {
        range.Add(FindSampleRange(this->Pieces[piece.Number].Scalars, own));
      }
    }
    if (range.All.IsEmpty())
    {
      continue;
    }
    this->Finite.Add(range.Finite);
    AppendVarint(blocks, n + 1 - std::exchange(next, n + 1));
    for (const ValueKey threshold : this->Thresholds)
    {
      blocks.push_back(static_cast<std::uint8_t>((range.All.Minimum < threshold ? Below : 0) |
        (threshold <= range.All.Maximum ? NotBelow : 0)));
    }
  }
  AppendLittleEndian(message, this->Finite.Minimum);
  AppendLittleEndian(message, this->Finite.Maximum);
  message.insert(message.end(), blocks.begin(), blocks.end());
  AppendVarint(message, 0);
}

void PieceBlockSource::TakeRanges(std::vector<ByteReader>& readers)
{
  for (ByteReader& reader : readers)
  {
    const auto minimum = reader.Read<ValueKey>();
    this->Finite.Add({ minimum, reader.Read<ValueKey>() });
    auto block = this->Shared.begin();
    while (const auto further = static_cast<std::ptrdiff_t>(reader.ReadVarint()))
    {
      block += further;
      for (std::uint8_t& sides : (block - 1)->Sides)
      {
        sides = static_cast<std::uint8_t>(sides | reader.Read<std::uint8_t>());
      }
    }
  }
  const auto isUnwanted = [this](const SharedBlock& block)
  {
    return !this->IsAtClosedSide(block.Number) &&
      std::find(block.Sides.begin(), block.Sides.end(), Below | NotBelow) == block.Sides.end();
  };
  this->Shared.erase(
    std::remove_if(this->Shared.begin(), this->Shared.end(), isUnwanted), this->Shared.end());
  if (std::any_of(this->Shared.begin(), this->Shared.end(),
        [](const SharedBlock& block) { return block.HasGap; }))
  {
    this->Fault = { StatusCode::InvalidArgument,
      "the images of the input leave gaps in their grid where the isosurface passes" };
    this->Shared.clear();
  }
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
Status PieceBlockSource::PlaceShared(int rank, std::vector<ByteReader>& readers)
{
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
        if (!bytes)
        {
          return { StatusCode::RemoteFailure, "another rank has no memory to send its samples" };
        }
        CopyBox(MakeSampleView(this->Types[n], supply.Box, bytes), supply.Box, block.Samples,
          block.Arrays[n].GetData());
      }
    }
    const auto place = std::lower_bound(this->Numbers.begin(), this->Numbers.end(), block.Number);
    this->Places.insert(this->Places.begin() + (place - this->Numbers.begin()), { true, index });
    this->Numbers.insert(place, block.Number);
  }
  return Status::Ok();
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
