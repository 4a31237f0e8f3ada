// SPDX-License-Identifier: BSD-3-Clause
#include "Surface/Pieces/PieceBlockSource.h"

#include "Ground/Base/Coding.h"
#include "Ground/Base/ParallelFor.h"
#include "Ground/Volume/PieceOwnership.h"

#include <algorithm>
#include <cstring>
#include <new>
#include <utility>

namespace isosurface
{
namespace
{

// The message of GatherPieces, all int64. With n pieces on the rank, 0 without:
//
//     +--------------------------------------------------+
//     | components of all arrays, scalars first      (c) |
//     | attributes                                   (a) |
//     | types of the components                      x c |
//     | components of each attribute                 x a |
//     | box of each piece: low x, y, z, high x, y, z x n |
//     +--------------------------------------------------+
// Appends the samples of a box, x fastest.
void AppendSamples(const SampleView& view, const VertexBox& box, Message& message)
{
  DispatchValueType(view.Type,
    [&](auto zero)
    {
      using T = decltype(zero);
      VisitRows(box,
        [&](const Index3& first, std::int64_t size)
        {
          const std::size_t at = message.size();
          message.resize(at + static_cast<std::size_t>(size) * sizeof(T));
          const T* row = view.At<T>(first);
          for (std::int64_t i = 0; i < size; ++i)
          {
            const T value = row[i * view.Stride[0]];
            std::memcpy(
              message.data() + at + static_cast<std::size_t>(i) * sizeof(T), &value, sizeof(T));
          }
        });
    });
}

// Puts such samples into an array of all vertices of `whole`; returns how many bytes were used.
std::size_t PlaceSamples(const std::uint8_t* bytes, std::size_t valueSize, const VertexBox& box,
  const VertexBox& whole, std::uint8_t* array)
{
  std::size_t used = 0;
  VisitRows(box,
    [&](const Index3& first, std::int64_t count)
    {
      const std::size_t row = static_cast<std::size_t>(count) * valueSize;
      std::memcpy(array + whole.FindIndex(first) * valueSize, bytes + used, row);
      used += row;
    });
  return used;
}

void Extend(KeyRange& range, const KeyRange& other)
{
  range.Minimum = std::min(range.Minimum, other.Minimum);
  range.Maximum = std::max(range.Maximum, other.Maximum);
}

} // namespace

PieceBlockSource::PieceBlockSource(
  const GridGeometry& geometry, std::vector<GridPiece> pieces, const PieceBlockSelection& selection)
  : Geometry(geometry)
  , Grid(geometry.GetDimensions(), selection.BlockSize)
  , WithLayer(selection.WithLayer)
  , Isovalues(selection.Isovalues)
  , Pieces(std::move(pieces))
{
}

Result<std::unique_ptr<PieceBlockSource>> PieceBlockSource::Make(Communicator& ranks,
  const GridGeometry& grid, std::vector<GridPiece> pieces, const PieceBlockSelection& selection,
  int threads)
{
  std::unique_ptr<PieceBlockSource> source(
    new PieceBlockSource(grid, std::move(pieces), selection));
  ISOSURFACE_RETURN_IF_ERROR(source->GatherPieces(ranks));
  source->FindBlocks(ranks, selection.Region, threads);
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

Status PieceBlockSource::GatherPieces(Communicator& ranks)
{
  Message mine;
  ISOSURFACE_RETURN_IF_ERROR(ranks.Agree(this->DescribePieces(mine)));
  const std::vector<Message> all = ranks.AllGather(mine);
  for (std::size_t rank = 0; rank < all.size(); ++rank)
  {
    if (!all[rank].empty())
    {
      ISOSURFACE_RETURN_IF_ERROR(this->AddPieces(all[rank], static_cast<int>(rank)));
    }
  }
  if (this->Types.empty())
  {
    return { StatusCode::InvalidArgument, "the input has no samples" };
  }
  DispatchValueType(this->Types.front(),
    [this](auto zero)
    {
      for (const double isovalue : this->Isovalues)
      {
        if (const auto threshold = FindThreshold<decltype(zero)>(isovalue))
        {
          this->Thresholds.push_back(MakeValueKey(*threshold));
        }
      }
    });
  return Status::Ok();
}

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

Status PieceBlockSource::AddPieces(const Message& message, int rank)
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
    PlacedPiece piece;
    piece.Rank = rank;
    piece.Number = number;
    piece.Box = ReadBox(reader);
    this->AllPieces.push_back(piece);
  }
  return Status::Ok();
}

bool PieceBlockSource::IsActive(const KeyRange& range) const
{
  return std::any_of(this->Thresholds.begin(), this->Thresholds.end(),
    [&range](ValueKey threshold) { return range.Straddles(threshold); });
}

std::vector<std::pair<std::size_t, VertexBox>> PieceBlockSource::FindParts(
  const VertexBox& box, std::vector<VertexBox>& missing) const
{
  std::vector<std::pair<std::size_t, VertexBox>> parts;
  missing = { box };
  for (std::size_t n = 0; n < this->AllPieces.size() && !missing.empty(); ++n)
  {
    const VertexBox& piece = this->AllPieces[n].Box;
    if (piece.Intersect(box).IsEmpty())
    {
      continue;
    }
    for (const VertexBox& rest : missing)
    {
      const VertexBox part = rest.Intersect(piece);
      if (!part.IsEmpty())
      {
        parts.emplace_back(n, part);
      }
    }
    missing = SubtractBox(missing, piece);
  }
  return parts;
}

// Sorts the blocks of the region into those within a piece, of which the own ones are kept, and
// shared ones, and finds which are active.
void PieceBlockSource::FindBlocks(Communicator& ranks, const Region& region, int threads)
{
  std::vector<std::pair<std::int64_t, std::size_t>> whole; // own blocks and their pieces
  for (std::int64_t number = 0; number < this->Grid.GetNumberOfBlocks(); ++number)
  {
    const VertexBox vertices = this->Grid.GetVertices(number);
    if (!region.Intersects(this->Geometry, vertices))
    {
      continue;
    }
    const VertexBox samples =
      this->WithLayer ? vertices.AddLayer(this->Grid.GetDimensions()) : vertices;
    const PlacedPiece* owner = nullptr;
    const PlacedPiece* first = nullptr;
    for (const PlacedPiece& piece : this->AllPieces)
    {
      if (piece.Box.Contains(samples))
      {
        owner = &piece;
        break;
      }
      first = !first && !piece.Box.Intersect(vertices).IsEmpty() ? &piece : first;
    }
    if (owner && owner->Rank == ranks.GetRank())
    {
      whole.emplace_back(number, owner->Number);
    }
    else if (!owner && first)
    {
      SharedBlock block;
      block.Number = number;
      block.Owner = first->Rank;
      block.Samples = samples;
      this->Shared.push_back(std::move(block));
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
    Extend(this->Finite, ranges[n].Finite);
    if (this->IsActive(ranges[n].All))
    {
      this->Numbers.push_back(whole[n].first);
      this->Places.push_back({ false, whole[n].second });
    }
  }
  this->JoinRanges(ranks);
}

void PieceBlockSource::JoinRanges(Communicator& ranks)
{
  std::vector<std::uint64_t> minima = { this->Finite.Minimum };
  std::vector<std::uint64_t> maxima = { this->Finite.Maximum };
  for (SharedBlock& block : this->Shared)
  {
    std::vector<VertexBox> missing;
    for (const auto& [number, part] : this->FindParts(block.Samples, missing))
    {
      const PlacedPiece& piece = this->AllPieces[number];
      const VertexBox own = part.Intersect(this->Grid.GetVertices(block.Number));
      if (piece.Rank == ranks.GetRank() && !own.IsEmpty())
      {
        block.Range.Add(FindSampleRange(this->Pieces[piece.Number].Scalars, own));
      }
    }
    block.HasGap = !missing.empty();
    for (const KeyRange* range : { &block.Range.All, &block.Range.Finite })
    {
      minima.push_back(range->Minimum);
      maxima.push_back(range->Maximum);
    }
  }
  ranks.ReduceMinimum(minima);
  ranks.ReduceMaximum(maxima);
  this->Finite = { minima.front(), maxima.front() };
  std::size_t next = 1;
  for (SharedBlock& block : this->Shared)
  {
    for (KeyRange* range : { &block.Range.All, &block.Range.Finite })
    {
      *range = { minima[next], maxima[next] };
      ++next;
    }
    Extend(this->Finite, block.Range.Finite);
  }
  this->Shared.erase(
    std::remove_if(this->Shared.begin(), this->Shared.end(),
      [this](const SharedBlock& block) { return !this->IsActive(block.Range.All); }),
    this->Shared.end());
}

// Brings the samples of the shared active blocks to their owners.
Status PieceBlockSource::CollectShared(Communicator& ranks)
{
  const auto hasGap = [](const SharedBlock& block) { return block.HasGap; };
  if (std::any_of(this->Shared.begin(), this->Shared.end(), hasGap))
  {
    return { StatusCode::InvalidArgument,
      "the images of the input leave gaps in their grid where the isosurface passes" };
  }
  std::vector<Message> outgoing(static_cast<std::size_t>(ranks.GetSize()));
  Status status;
  try
  {
    this->PackShared(ranks.GetRank(), outgoing);
  }
  catch (const std::bad_alloc&)
  {
    status =
      Status(StatusCode::OutOfMemory, "there is not enough memory for the blocks that ranks share");
  }
  ISOSURFACE_RETURN_IF_ERROR(ranks.Agree(status));
  this->PlaceShared(ranks.GetRank(), ranks.Exchange(std::move(outgoing)));
  return Status::Ok();
}

// Packs the samples for each rank, and makes room for those that this rank will get.
void PieceBlockSource::PackShared(int rank, std::vector<Message>& outgoing)
{
  std::vector<VertexBox> missing;
  for (SharedBlock& block : this->Shared)
  {
    for (const auto& [number, part] : this->FindParts(block.Samples, missing))
    {
      const PlacedPiece& piece = this->AllPieces[number];
      for (const SampleView& view :
        piece.Rank == rank ? this->GetViews(piece.Number) : std::vector<SampleView>())
      {
        AppendSamples(view, part, outgoing[static_cast<std::size_t>(block.Owner)]);
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
  std::vector<VertexBox> missing;
  std::vector<std::size_t> used(incoming.size(), 0);
  for (std::size_t index = 0; index < this->Shared.size(); ++index)
  {
    SharedBlock& block = this->Shared[index];
    if (block.Owner != rank)
    {
      continue;
    }
    for (const auto& [number, part] : this->FindParts(block.Samples, missing))
    {
      const auto from = static_cast<std::size_t>(this->AllPieces[number].Rank);
      for (std::size_t n = 0; n < this->Types.size(); ++n)
      {
        used[from] += PlaceSamples(incoming[from].data() + used[from], GetValueSize(this->Types[n]),
          part, block.Samples, block.Arrays[n].GetData());
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
    const Index3 size = shared.Samples.GetSize();
    for (std::size_t n = 0; n < this->Types.size(); ++n)
    {
      SampleView& view = views.emplace_back();
      view.Type = this->Types[n];
      view.First = shared.Arrays[n].GetData();
      view.Stride = { 1, static_cast<std::ptrdiff_t>(size[0]),
        static_cast<std::ptrdiff_t>(size[0] * size[1]) };
      view.Available = shared.Samples;
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
