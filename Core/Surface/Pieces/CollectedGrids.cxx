// SPDX-License-Identifier: BSD-3-Clause
#include "Surface/Pieces/CollectedGrids.h"

#include "Ground/Base/Coding.h"
#include "Ground/Volume/GridUnion.h"
#include "Surface/Pieces/PieceFields.h"

#include <algorithm>
#include <utility>

namespace isosurface
{
namespace
{

constexpr const char* NotPrepared = "the images of the input cannot be prepared";

/// Whether a rank has images, and their grids: the regular ones, then those with lines.
Message DescribeImages(const MemoryImages& mine)
{
  std::vector<GridGeometry> grids;
  std::vector<LinedGrid> lined;
  for (const MemoryImage& image : mine.Images)
  {
    if (image.Lines)
    {
      lined.push_back({ image.Grid, *image.Lines });
    }
    else
    {
      grids.push_back(image.Grid);
    }
  }
  const Message regular = PackGrids(grids);
  const Message others = PackLinedGrids(lined);
  Message message;
  AppendVarint(message, mine.AreThere ? 1 : 0);
  AppendVarint(message, regular.size());
  message.insert(message.end(), regular.begin(), regular.end());
  message.insert(message.end(), others.begin(), others.end());
  return message;
}

/// A piece for each image of this rank, in the grids of all. `told`: DescribeImages of all ranks.
Status UniteImages(const std::vector<MemoryImage>& images, const std::vector<Message>& told,
  std::size_t rank, MemoryGrids& united)
{
  bool areThere = false;
  std::vector<Message> regular;
  std::vector<Message> lined;
  for (const Message& message : told)
  {
    ByteReader reader(message);
    areThere = reader.ReadVarint() > 0 || areThere;
    const auto size = static_cast<std::ptrdiff_t>(reader.ReadVarint());
    const auto begin = message.end() - static_cast<std::ptrdiff_t>(reader.GetRemaining());
    regular.emplace_back(begin, begin + size);
    lined.emplace_back(begin + size, message.end());
  }
  united.Grids = UniteGrids(regular);
  const std::size_t first = united.Grids.size();
  united.Lines.resize(first);
  std::vector<std::size_t> numbers;
  for (LinedGrid& grid : UniteLinedGrids(lined, rank, numbers))
  {
    united.Grids.push_back(grid.Grid);
    united.Lines.emplace_back(std::move(grid.Lines));
  }
  if (areThere && united.Grids.empty())
  {
    return { StatusCode::NotFound, "the input has no such point array" };
  }
  std::size_t next = 0;
  for (const MemoryImage& image : images)
  {
    const std::size_t grid =
      image.Lines ? first + numbers[next++] : FindGrid(united.Grids, image.Grid);
    ISOSURFACE_ASSIGN_OR_RETURN(auto piece, image.MakePiece(united.Grids[grid]));
    piece.Grid = grid;
    united.Pieces.push_back(std::move(piece));
  }
  return Status::Ok();
}

std::vector<FieldPiece> DescribeUnited(
  const std::vector<MemoryImage>& images, const MemoryGrids& united)
{
  std::vector<FieldPiece> described;
  for (std::size_t number = 0; number < images.size(); ++number)
  {
    const MemoryPiece& piece = united.Pieces[number];
    VertexBox whole;
    for (std::size_t axis = 0; axis < 3; ++axis)
    {
      const auto& extent = images[number].Grid.Extent;
      const std::int64_t begin = united.Grids[piece.Grid].Extent[2 * axis];
      whole.Low[axis] = extent[2 * axis] - begin;
      whole.High[axis] = extent[2 * axis + 1] - begin + 1;
    }
    described.push_back({ piece.Grid, piece.Components, images[number].Block, whole,
      images[number].IsDeclared, !piece.Hidden.IsEmpty() });
  }
  return described;
}

/// The samples of a box of a piece, in a grid that begins at a vertex of theirs.
MemoryPiece MovePiece(MemoryPiece piece, const VertexBox& box, const Index3& first)
{
  const Index3 offset = { -first[0], -first[1], -first[2] };
  for (SampleView& view : piece.Components)
  {
    view.Available = view.Available.Translate(offset);
    view.Box = box.Translate(offset);
  }
  piece.Hidden.Box = piece.Hidden.Box.Translate(offset);
  return piece;
}

/// Gives each field a grid of its own.
CollectedGrids SortByFields(const MemoryGrids& united, const PieceFields& fields)
{
  CollectedGrids sorted;
  for (const GridField& field : fields.Fields)
  {
    sorted.Paths.push_back(field.Block);
  }
  std::sort(sorted.Paths.begin(), sorted.Paths.end());
  sorted.Paths.erase(std::unique(sorted.Paths.begin(), sorted.Paths.end()), sorted.Paths.end());
  for (const GridField& field : fields.Fields)
  {
    GridGeometry grid = united.Grids[field.Grid];
    for (std::size_t axis = 0; axis < 3; ++axis)
    {
      const std::int64_t first = grid.Extent[2 * axis];
      grid.Extent[2 * axis] = first + field.Box.Low[axis];
      grid.Extent[2 * axis + 1] = first + field.Box.High[axis] - 1;
    }
    sorted.Grids.push_back(grid);
    const std::optional<GridLines>& lines = united.Lines[field.Grid];
    sorted.Lines.push_back(lines ? std::make_optional(lines->Cut(field.Box)) : std::nullopt);
    sorted.Blocks.push_back(static_cast<std::size_t>(
      std::lower_bound(sorted.Paths.begin(), sorted.Paths.end(), field.Block) -
      sorted.Paths.begin()));
  }
  for (std::size_t number = 0; number < united.Pieces.size(); ++number)
  {
    for (const VertexBox& box : fields.Boxes[number])
    {
      const std::size_t field = fields.Numbers[number];
      sorted.Pieces.push_back(MovePiece(united.Pieces[number], box, fields.Fields[field].Box.Low));
      sorted.Pieces.back().Grid = field;
      sorted.Images.push_back(number);
    }
  }
  return sorted;
}

} // namespace

Result<CollectedGrids> CollectedGrids::Collect(
  Communicator& ranks, const std::function<Result<MemoryImages>()>& describe, int threads)
{
  MemoryImages mine;
  const auto tell = [&](Message& message) -> Status
  {
    ISOSURFACE_ASSIGN_OR_RETURN(mine, describe());
    message = DescribeImages(mine);
    return Status::Ok();
  };
  ISOSURFACE_ASSIGN_OR_RETURN(const auto told, GatherFromAll(ranks, NotPrepared, tell));
  MemoryGrids united;
  const auto unite = [&]() -> Result<std::vector<FieldPiece>>
  {
    ISOSURFACE_RETURN_IF_ERROR(
      UniteImages(mine.Images, told, static_cast<std::size_t>(ranks.GetRank()), united));
    return DescribeUnited(mine.Images, united);
  };
  ISOSURFACE_ASSIGN_OR_RETURN(const auto fields, PieceFields::Find(ranks, unite, threads));
  return Attempt(NotPrepared, [&] { return Result<CollectedGrids>(SortByFields(united, fields)); });
}

} // namespace isosurface
