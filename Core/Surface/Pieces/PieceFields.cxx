// SPDX-License-Identifier: BSD-3-Clause
#include "Surface/Pieces/PieceFields.h"

#include "Ground/Base/Checksum.h"
#include "Ground/Base/Coding.h"
#include "Ground/Base/ParallelFor.h"
#include "Ground/Volume/PieceOwnership.h"
#include "Ground/Volume/SampleCopy.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>
#include <numeric>
#include <optional>
#include <tuple>
#include <utility>

namespace isosurface
{
namespace
{

constexpr const char* NotSorted = "the images of the input cannot be compared";

/// What all ranks know of a piece.
struct KnownPiece
{
  std::size_t Rank = 0;
  std::size_t Number = 0; ///< of that rank's
  std::int64_t Grid = 0;
  std::int64_t Type = 0;
  std::int64_t Components = 0;
  bool IsDeclared = false;
  bool Hides = false;
  VertexBox Own;
  VertexBox Place; ///< Own, or if that is empty, all samples
  VertexBox Whole;
  std::vector<std::int64_t> Block;
};

Message DescribeFieldPieces(const std::vector<FieldPiece>& pieces)
{
  Message message;
  const auto append = [&message](auto number)
  { AppendLittleEndian(message, static_cast<std::int64_t>(number)); };
  for (const FieldPiece& piece : pieces)
  {
    const SampleView& first = piece.Components.front();
    append(piece.Grid);
    append(first.Type);
    append(piece.Components.size());
    append(piece.IsDeclared ? 1 : 0);
    append(piece.Hides ? 1 : 0);
    AppendBox(message, first.Box);
    AppendBox(message, first.Box.IsEmpty() ? first.Available : first.Box);
    AppendBox(message, piece.Whole);
    append(piece.Block.size());
    for (const std::int64_t child : piece.Block)
    {
      append(child);
    }
  }
  return message;
}

/// In an order that the distribution of blocks over ranks does not change.
std::vector<KnownPiece> ReadFieldPieces(const std::vector<Message>& messages)
{
  std::vector<KnownPiece> all;
  for (std::size_t rank = 0; rank < messages.size(); ++rank)
  {
    ByteReader reader(messages[rank]);
    for (std::size_t number = 0; reader.GetRemaining() > 0; ++number)
    {
      KnownPiece& piece = all.emplace_back();
      piece.Rank = rank;
      piece.Number = number;
      piece.Grid = reader.Read<std::int64_t>();
      piece.Type = reader.Read<std::int64_t>();
      piece.Components = reader.Read<std::int64_t>();
      piece.IsDeclared = reader.Read<std::int64_t>() != 0;
      piece.Hides = reader.Read<std::int64_t>() != 0;
      piece.Own = ReadBox(reader);
      piece.Place = ReadBox(reader);
      piece.Whole = ReadBox(reader);
      piece.Block.resize(static_cast<std::size_t>(reader.Read<std::int64_t>()));
      reader.ReadAll(piece.Block);
    }
  }
  const auto key = [](const KnownPiece& piece)
  { return std::tie(piece.Grid, piece.Block, piece.Place.Low, piece.Place.High); };
  std::stable_sort(all.begin(), all.end(),
    [&key](const KnownPiece& a, const KnownPiece& b) { return key(a) < key(b); });
  return all;
}

/// The cells between the vertices of a box, by their low corners; of a flat box the vertices.
VertexBox FindCells(VertexBox box)
{
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    box.High[axis] = std::max(box.High[axis] - 1, box.Low[axis] + 1);
  }
  return box;
}

/// Whether two pieces, which have these vertices in common, have a cell in common.
bool ShareCells(const KnownPiece& a, const KnownPiece& b, const VertexBox& common)
{
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    if (common.GetSize()[axis] < 2 && (a.Place.GetSize()[axis] > 1 || b.Place.GetSize()[axis] > 1))
    {
      return false;
    }
  }
  return true;
}

enum class Relation : std::uint8_t
{
  Apart, ///< nothing speaks for one field, nothing against it
  Parts, ///< of one field
  Others ///< of different fields
};

/// Two pieces whose samples have to be compared.
struct Comparison
{
  std::size_t First = 0;
  std::size_t Second = 0;
  VertexBox Common;
};

/// The relations of all pieces of one grid with each other.
class Relations
{
public:
  explicit Relations(const std::vector<KnownPiece>& pieces)
    : Pieces(pieces)
    , Table(pieces.size() * pieces.size(), Relation::Apart)
  {
  }

  Relation Get(std::size_t a, std::size_t b) const
  {
    return this->Table[a * this->Pieces.size() + b];
  }
  void Set(std::size_t a, std::size_t b, Relation relation)
  {
    this->Table[a * this->Pieces.size() + b] = relation;
    this->Table[b * this->Pieces.size() + a] = relation;
  }

  /// Finds those that need no samples, and what is to be compared for the others.
  std::vector<Comparison> FindByPlace();

private:
  const std::vector<KnownPiece>& Pieces;
  std::vector<Relation> Table;
};

std::vector<Comparison> Relations::FindByPlace()
{
  std::vector<Comparison> comparisons;
  for (std::size_t first = 0; first < this->Pieces.size(); ++first)
  {
    const KnownPiece& a = this->Pieces[first];
    for (std::size_t second = first + 1;
         second < this->Pieces.size() && this->Pieces[second].Grid == a.Grid; ++second)
    {
      const KnownPiece& b = this->Pieces[second];
      const VertexBox common = a.Place.Intersect(b.Place);
      const bool isSameType = a.Type == b.Type && a.Components == b.Components;
      const bool isDeclared =
        a.IsDeclared && b.IsDeclared && a.Whole == b.Whole && a.Block == b.Block;
      if (isDeclared && isSameType && (common.IsEmpty() || !ShareCells(a, b, common)))
      {
        this->Set(first, second, Relation::Parts);
      }
      else if (!common.IsEmpty() && !isSameType)
      {
        this->Set(first, second, Relation::Others);
      }
      else if (!common.IsEmpty())
      {
        comparisons.push_back({ first, second, common });
      }
    }
  }
  return comparisons;
}

//------------------------------------------------------------------------------
// Samples

/// Gives values that compare as equal, and all NaN, one representation.
template <typename T>
void MakeCanonical(std::vector<std::uint8_t>& row)
{
  for (std::size_t at = 0; at < row.size(); at += sizeof(T))
  {
    T value;
    std::memcpy(&value, &row[at], sizeof(T));
    value = std::isnan(value) ? std::numeric_limits<T>::quiet_NaN() : value == 0 ? T{} : value;
    std::memcpy(&row[at], &value, sizeof(T));
  }
}

void CopyRow(
  const SampleView& view, const Index3& first, std::int64_t count, std::vector<std::uint8_t>& row)
{
  const std::size_t size = GetValueSize(view.Type);
  row.resize(static_cast<std::size_t>(count) * size);
  CopySamples(row.data(), 1, view.AtBytes(first), view.Stride[0], count, size);
  if (view.Type == ValueType::Float32)
  {
    MakeCanonical<float>(row);
  }
  else if (view.Type == ValueType::Float64)
  {
    MakeCanonical<double>(row);
  }
}

std::uint64_t SumSamples(const FieldPiece& piece, const VertexBox& box)
{
  std::uint64_t sum = 0;
  std::vector<std::uint8_t> row;
  for (const SampleView& view : piece.Components)
  {
    VisitRows(box,
      [&](const Index3& first, std::int64_t count)
      {
        CopyRow(view, first, count, row);
        sum = ComputeChecksum(row.data(), row.size(), sum);
      });
  }
  return sum;
}

bool HaveEqualSamples(const FieldPiece& a, const FieldPiece& b, const VertexBox& box)
{
  std::vector<std::uint8_t> rows[2];
  for (std::size_t n = 0; n < a.Components.size(); ++n)
  {
    const SampleView& ofA = a.Components[n];
    const SampleView& ofB = b.Components[n];
    for (std::int64_t k = box.Low[2]; k < box.High[2]; ++k)
    {
      for (std::int64_t j = box.Low[1]; j < box.High[1]; ++j)
      {
        const Index3 first = { box.Low[0], j, k };
        if (ofA.AtBytes(first) == ofB.AtBytes(first) && ofA.Stride == ofB.Stride)
        {
          continue; // an array that both have
        }
        CopyRow(ofA, first, box.GetSize()[0], rows[0]);
        CopyRow(ofB, first, box.GetSize()[0], rows[1]);
        if (rows[0] != rows[1])
        {
          return false;
        }
      }
    }
  }
  return true;
}

/// What this rank knows of the samples: of each comparison that has a piece of it, in this order, a
/// checksum of its samples; where it has both pieces, whether they are equal.
std::vector<std::uint64_t> CompareSamples(const std::vector<KnownPiece>& all,
  const std::vector<Comparison>& comparisons, std::size_t rank,
  const std::vector<FieldPiece>& pieces, int threads)
{
  using PieceBox = std::pair<std::size_t, std::pair<Index3, Index3>>; // a piece, and a box of it
  std::map<PieceBox, std::uint64_t> sums; // many pieces may have the same box in common with one
  std::vector<std::size_t> own;
  const auto isMine = [&](std::size_t piece) { return all[piece].Rank == rank; };
  const auto makeBox = [&](const Comparison& comparison)
  {
    const std::size_t mine = isMine(comparison.First) ? comparison.First : comparison.Second;
    return PieceBox{ all[mine].Number, { comparison.Common.Low, comparison.Common.High } };
  };
  std::vector<std::pair<const PieceBox, std::uint64_t>*> toSum;
  for (std::size_t n = 0; n < comparisons.size(); ++n)
  {
    const bool isFirst = isMine(comparisons[n].First);
    if (isFirst != isMine(comparisons[n].Second))
    {
      const auto added = sums.emplace(makeBox(comparisons[n]), 0);
      if (added.second)
      {
        toSum.push_back(&*added.first);
      }
    }
    if (isFirst || isMine(comparisons[n].Second))
    {
      own.push_back(n);
    }
  }
  static_cast<void>(ParallelFor(toSum.size(), threads,
    [&](std::size_t n, int)
    {
      const auto& [number, box] = toSum[n]->first;
      toSum[n]->second = SumSamples(pieces[number], { box.first, box.second });
    }));
  std::vector<std::uint64_t> found(own.size());
  static_cast<void>(ParallelFor(own.size(), threads,
    [&](std::size_t n, int)
    {
      const Comparison& comparison = comparisons[own[n]];
      const KnownPiece& a = all[comparison.First];
      const KnownPiece& b = all[comparison.Second];
      found[n] = a.Rank == b.Rank
        ? (HaveEqualSamples(pieces[a.Number], pieces[b.Number], comparison.Common) ? 1U : 0U)
        : sums.at(makeBox(comparison));
    }));
  return found;
}

/// `messages`: of each rank, CompareSamples.
void TakeComparisons(const std::vector<KnownPiece>& all, const std::vector<Comparison>& comparisons,
  const std::vector<Message>& messages, Relations& relations)
{
  std::vector<ByteReader> readers(messages.begin(), messages.end());
  for (const Comparison& comparison : comparisons)
  {
    const std::size_t first = all[comparison.First].Rank;
    const std::size_t second = all[comparison.Second].Rank;
    const auto ofFirst = readers[first].Read<std::uint64_t>();
    const bool isEqual =
      first == second ? ofFirst == 1 : ofFirst == readers[second].Read<std::uint64_t>();
    relations.Set(
      comparison.First, comparison.Second, isEqual ? Relation::Parts : Relation::Others);
  }
}

//------------------------------------------------------------------------------
// Fields

/// Sorts pieces into groups, each of which becomes a field.
class Grouping
{
public:
  Grouping(const std::vector<KnownPiece>& pieces, Relations& relations)
    : Pieces(pieces)
    , Known(relations)
    , Owners(pieces.size())
    , Members(pieces.size())
  {
    std::iota(this->Owners.begin(), this->Owners.end(), std::size_t{ 0 });
    for (std::size_t piece = 0; piece < pieces.size(); ++piece)
    {
      this->Members[piece] = { piece };
    }
  }

  void Group();
  /// The first piece of each piece's group.
  const std::vector<std::size_t>& GetOwners() const { return this->Owners; }

private:
  /// Joins the groups of two pieces, unless some of their pieces are of different fields.
  void Join(std::size_t a, std::size_t b);
  /// Has blocks that are copies of others, or of parts of them, be fields of their own.
  void SeparateCopies();
  VertexBox FindBounds(std::size_t owner) const;
  bool IsFilled(std::size_t owner, const VertexBox& bounds) const;
  /// How many steps into the input two pieces have in common.
  std::size_t CountCommonSteps(std::size_t a, std::size_t b) const;

  const std::vector<KnownPiece>& Pieces;
  Relations& Known;
  std::vector<std::size_t> Owners;
  std::vector<std::vector<std::size_t>> Members; ///< of the owners
};

std::size_t Grouping::CountCommonSteps(std::size_t a, std::size_t b) const
{
  const std::vector<std::int64_t>& ofA = this->Pieces[a].Block;
  const std::vector<std::int64_t>& ofB = this->Pieces[b].Block;
  const auto end = std::mismatch(ofA.begin(), ofA.end(), ofB.begin(), ofB.end());
  return static_cast<std::size_t>(end.first - ofA.begin());
}

void Grouping::Join(std::size_t a, std::size_t b)
{
  const std::size_t to = std::min(this->Owners[a], this->Owners[b]);
  const std::size_t from = std::max(this->Owners[a], this->Owners[b]);
  if (to == from)
  {
    return;
  }
  for (const std::size_t one : this->Members[to])
  {
    for (const std::size_t other : this->Members[from])
    {
      if (this->Known.Get(one, other) == Relation::Others)
      {
        return;
      }
    }
  }
  for (const std::size_t moved : this->Members[from])
  {
    this->Owners[moved] = to;
    this->Members[to].push_back(moved);
  }
  this->Members[from].clear();
}

VertexBox Grouping::FindBounds(std::size_t owner) const
{
  VertexBox bounds = this->Pieces[owner].Place;
  for (const std::size_t piece : this->Members[owner])
  {
    bounds.Extend(this->Pieces[piece].Place);
  }
  return bounds;
}

bool Grouping::IsFilled(std::size_t owner, const VertexBox& bounds) const
{
  std::vector<VertexBox> empty = { FindCells(bounds) };
  for (const std::size_t piece : this->Members[owner])
  {
    empty = SubtractBox(empty, FindCells(this->Pieces[piece].Place));
  }
  return empty.empty();
}

void Grouping::SeparateCopies()
{
  for (std::size_t whole = 0; whole < this->Pieces.size(); ++whole)
  {
    if (this->Owners[whole] != whole)
    {
      continue;
    }
    const VertexBox bounds = this->FindBounds(whole);
    const bool isFilled = this->IsFilled(whole, bounds);
    for (std::size_t part = 0; isFilled && part < this->Pieces.size(); ++part)
    {
      const KnownPiece& other = this->Pieces[part];
      if (this->Owners[part] != part || other.Grid != this->Pieces[whole].Grid ||
        other.Block == this->Pieces[whole].Block || !bounds.Contains(this->FindBounds(part)))
      {
        continue;
      }
      for (const std::size_t a : this->Members[whole])
      {
        for (const std::size_t b : this->Members[part])
        {
          this->Known.Set(a, b, Relation::Others);
        }
      }
    }
  }
}

void Grouping::Group()
{
  std::vector<std::tuple<std::size_t, std::size_t, std::size_t>> ofBlocks; // far ones last
  for (std::size_t a = 0; a < this->Pieces.size(); ++a)
  {
    for (std::size_t b = a + 1; b < this->Pieces.size(); ++b)
    {
      if (this->Known.Get(a, b) != Relation::Parts)
      {
        continue;
      }
      if (this->Pieces[a].Block == this->Pieces[b].Block)
      {
        this->Join(a, b);
      }
      else
      {
        ofBlocks.emplace_back(
          std::numeric_limits<std::size_t>::max() - this->CountCommonSteps(a, b), a, b);
      }
    }
  }
  this->SeparateCopies();
  std::sort(ofBlocks.begin(), ofBlocks.end());
  for (const auto& [distance, a, b] : ofBlocks)
  {
    if (this->Known.Get(a, b) == Relation::Parts)
    {
      this->Join(a, b);
    }
  }
}

/// What a piece contours that no piece before it in its field does.
std::vector<VertexBox> FindOwnBoxes(
  const std::vector<KnownPiece>& all, const std::vector<std::size_t>& owners, std::size_t piece)
{
  std::vector<VertexBox> boxes = { all[piece].Own };
  if (all[piece].Own.IsEmpty())
  {
    return boxes;
  }
  boxes.front() = FindCells(all[piece].Own);
  const Index3 size = all[piece].Own.GetSize();
  for (std::size_t before = owners[piece]; before < piece; ++before)
  {
    const bool isVisible = !all[before].Hides && !all[piece].Hides;
    if (owners[before] == owners[piece] && isVisible && !all[before].Own.IsEmpty())
    {
      boxes = SubtractBox(boxes, FindCells(all[before].Own));
    }
  }
  for (VertexBox& box : boxes)
  {
    for (std::size_t axis = 0; axis < 3; ++axis)
    {
      box.High[axis] += size[axis] > 1 ? 1 : 0;
    }
  }
  // A piece that contours nothing still has samples for the normals of others.
  return boxes.empty() ? std::vector<VertexBox>(1) : boxes;
}

PieceFields MakeFields(const std::vector<KnownPiece>& all, const std::vector<std::size_t>& owners,
  std::size_t rank, std::size_t numberOfPieces)
{
  PieceFields fields;
  fields.Numbers.resize(numberOfPieces);
  fields.Boxes.resize(numberOfPieces);
  std::vector<std::size_t> numbers(all.size());
  for (std::size_t piece = 0; piece < all.size(); ++piece)
  {
    const KnownPiece& known = all[piece];
    if (owners[piece] == piece)
    {
      numbers[piece] = fields.Fields.size();
      fields.Fields.push_back({ static_cast<std::size_t>(known.Grid), known.Whole, known.Block });
    }
    numbers[piece] = numbers[owners[piece]];
    fields.Fields[numbers[piece]].Box.Extend(known.Whole);
    if (known.Rank == rank)
    {
      fields.Numbers[known.Number] = numbers[piece];
      fields.Boxes[known.Number] = FindOwnBoxes(all, owners, piece);
    }
  }
  return fields;
}

} // namespace

Result<PieceFields> PieceFields::Find(Communicator& ranks,
  const std::function<Result<std::vector<FieldPiece>>()>& describe, int threads)
{
  const auto rank = static_cast<std::size_t>(ranks.GetRank());
  std::vector<FieldPiece> pieces;
  const auto tell = [&](Message& mine) -> Status
  {
    ISOSURFACE_ASSIGN_OR_RETURN(pieces, describe());
    mine = DescribeFieldPieces(pieces);
    return Status::Ok();
  };
  ISOSURFACE_ASSIGN_OR_RETURN(const auto descriptions, GatherFromAll(ranks, NotSorted, tell));
  std::vector<KnownPiece> all;
  std::vector<Comparison> comparisons;
  std::optional<Relations> relations;
  const auto compare = [&](Message& mine)
  {
    all = ReadFieldPieces(descriptions);
    comparisons = relations.emplace(all).FindByPlace();
    for (const std::uint64_t found : CompareSamples(all, comparisons, rank, pieces, threads))
    {
      AppendLittleEndian(mine, found);
    }
    return Status::Ok();
  };
  ISOSURFACE_ASSIGN_OR_RETURN(const auto found, GatherFromAll(ranks, NotSorted, compare));
  PieceFields fields;
  const auto group = [&]
  {
    TakeComparisons(all, comparisons, found, *relations);
    Grouping grouping(all, *relations);
    grouping.Group();
    fields = MakeFields(all, grouping.GetOwners(), rank, pieces.size());
    return Status::Ok();
  };
  ISOSURFACE_RETURN_IF_ERROR(Attempt(NotSorted, group));
  return fields;
}

} // namespace isosurface
