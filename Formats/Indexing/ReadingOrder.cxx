// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/Indexing/ReadingOrder.h"

#include <algorithm>
#include <cstddef>
#include <optional>

namespace isosurface
{
namespace
{

/// The first slices are at most so many times as far apart as the last ones.
constexpr std::int64_t CoarsestSlices = 8;
/// What is read of a stream at once; it takes a small part of a second.
constexpr std::uint64_t StreamBytes = std::uint64_t{ 1 } << 24;

std::int64_t DivideUp(std::int64_t number, std::int64_t by)
{
  return (number + by - 1) / by;
}

/// Powers of two, so that a lattice of the whole source has at most `vertices`, about as many on each
/// axis.
Index3 ChooseStep(const Index3& size, std::int64_t vertices)
{
  Index3 step{ 1, 1, 1 };
  Index3 count = size;
  while (count[0] * count[1] * count[2] > vertices)
  {
    const auto longest =
      static_cast<std::size_t>(std::max_element(count.begin(), count.end()) - count.begin());
    step[longest] *= 2;
    count[longest] = DivideUp(size[longest], step[longest]);
  }
  return step;
}

/// Slices from the first to the last, far apart first and then in between; or, where each read waits for a server,
/// rows of them.
class SliceOrder : public ReadingOrder
{
public:
  SliceOrder(const VertexBox& box, const Index3& step, bool isByRows, bool isFar)
    : ReadingOrder(step)
    , Box(box)
    , ByRows(isByRows)
    , ReadsRows(isByRows && isFar)
    , Slices(DivideUp(box.High[2], step[2]))
    , Rows(this->ReadsRows ? DivideUp(box.High[1], step[1]) : 1)
    , Apart(ChooseApart(this->Slices))
    , RowsApart(ChooseApart(this->Rows))
  {
  }

  std::vector<VertexBox> FindNext() override
  {
    std::vector<VertexBox> boxes;
    if (this->HasBegun && this->Apart == 1 && this->RowsApart == 1)
    {
      return boxes;
    }
    const std::int64_t before = this->Apart;
    const std::int64_t rowsBefore = this->RowsApart;
    this->Apart = this->HasBegun ? std::max<std::int64_t>(1, before / 2) : before;
    this->RowsApart = this->HasBegun ? std::max<std::int64_t>(1, rowsBefore / 2) : rowsBefore;
    for (std::int64_t slice = 0; slice < this->Slices; slice += this->Apart)
    {
      for (std::int64_t row = 0; row < this->Rows; row += this->RowsApart)
      {
        if (!this->HasBegun || slice % before != 0 || row % rowsBefore != 0)
        {
          VertexBox box = this->Box;
          box.Low[2] = slice * this->Step[2];
          box.High[2] = box.Low[2] + 1;
          box.Low[1] = this->ReadsRows ? row * this->Step[1] : box.Low[1];
          box.High[1] = this->ReadsRows ? box.Low[1] + 1 : box.High[1];
          boxes.push_back(box);
        }
      }
    }
    this->HasBegun = true;
    return boxes;
  }

  Lattice GetLattice() const override
  {
    return { this->Box,
      { this->Step[0], this->Step[1] * this->RowsApart, this->Step[2] * this->Apart } };
  }
  bool IsByRows() const override { return this->ByRows; }

private:
  static std::int64_t ChooseApart(std::int64_t count)
  {
    std::int64_t apart = 1;
    while (apart < CoarsestSlices && count > 2 * apart)
    {
      apart *= 2;
    }
    return apart;
  }

  const VertexBox Box;
  const bool ByRows;
  const bool ReadsRows; ///< each a box of its own
  const std::int64_t Slices;
  const std::int64_t Rows;
  std::int64_t Apart; ///< in slices of the last lattice
  std::int64_t RowsApart;
  bool HasBegun = false;
};

/// A box of whole chunks, which grows from the middle.
class ChunkOrder : public ReadingOrder
{
public:
  /// While the box is an eighth of the source, the lattice has half of the step.
  ChunkOrder(const VertexBox& box, const Index3& chunk, const Index3& step, std::int64_t atOnce)
    : ReadingOrder({ std::max<std::int64_t>(1, step[0] / 2), std::max<std::int64_t>(1, step[1] / 2),
        std::max<std::int64_t>(1, step[2] / 2) })
    , Box(box)
    , Chunk(chunk)
    , WholeStep(step)
    , AtOnce(atOnce)
  {
    for (std::size_t axis = 0; axis < 3; ++axis)
    {
      this->Chunks.High[axis] = DivideUp(box.High[axis], chunk[axis]);
      this->Read.Low[axis] = this->Read.High[axis] = this->Chunks.High[axis] / 2;
    }
  }

  std::vector<VertexBox> FindNext() override
  {
    const VertexBox before = this->Read;
    const std::int64_t known = before.GetNumberOfVertices();
    const std::int64_t wanted = std::min(known + this->AtOnce, this->Chunks.GetNumberOfVertices());
    while (this->Read.GetNumberOfVertices() < wanted)
    {
      this->Grow();
    }
    std::vector<VertexBox> boxes;
    VisitVertices(this->Read,
      [&](const Index3& chunk)
      {
        const VertexBox one{ chunk, { chunk[0] + 1, chunk[1] + 1, chunk[2] + 1 } };
        if (before.IsEmpty() || !before.Contains(one))
        {
          boxes.push_back(this->GetVertices(one));
        }
      });
    return boxes;
  }

  Lattice GetLattice() const override
  {
    const VertexBox vertices = this->GetVertices(this->Read);
    const bool isSmall = vertices.GetNumberOfVertices() <= this->Box.GetNumberOfVertices() / 8;
    return { vertices, isSmall ? this->Step : this->WholeStep };
  }
  const Index3& GetWholeStep() const override { return this->WholeStep; }

private:
  VertexBox GetVertices(const VertexBox& chunks) const
  {
    VertexBox box;
    for (std::size_t axis = 0; axis < 3; ++axis)
    {
      box.Low[axis] = chunks.Low[axis] * this->Chunk[axis];
      box.High[axis] = std::min(chunks.High[axis] * this->Chunk[axis], this->Box.High[axis]);
    }
    return box;
  }

  /// By a layer of chunks on both sides of the axis on which the box is shortest. The first box is
  /// the chunk in the middle.
  void Grow()
  {
    if (this->Read.IsEmpty())
    {
      this->Read.High = { this->Read.Low[0] + 1, this->Read.Low[1] + 1, this->Read.Low[2] + 1 };
      return;
    }
    std::optional<std::size_t> shortest;
    for (std::size_t axis = 0; axis < 3; ++axis)
    {
      const Index3 size = this->GetVertices(this->Read).GetSize();
      if (this->Read.GetSize()[axis] < this->Chunks.High[axis] &&
        (!shortest || size[axis] < size[*shortest]))
      {
        shortest = axis;
      }
    }
    if (shortest)
    {
      std::int64_t& low = this->Read.Low[*shortest];
      std::int64_t& high = this->Read.High[*shortest];
      low = std::max<std::int64_t>(0, low - 1);
      high = std::min(this->Chunks.High[*shortest], high + 1);
    }
  }

  const VertexBox Box;
  const Index3 Chunk;
  const Index3 WholeStep;
  const std::int64_t AtOnce;
  VertexBox Chunks; ///< all, by number
  VertexBox Read;   ///< those of the boxes so far
};

/// Slices from the first one on, of a stream, of which nothing can be skipped.
class StreamOrder : public ReadingOrder
{
public:
  /// Reads so many slices at once.
  StreamOrder(const VertexBox& box, const Index3& step, std::int64_t slices)
    : ReadingOrder(step)
    , Box(box)
    , Slices(slices)
  {
  }

  std::vector<VertexBox> FindNext() override
  {
    VertexBox slab = this->Box;
    slab.Low[2] = this->End;
    this->End = slab.High[2] = std::min(slab.Low[2] + this->Slices, this->Box.High[2]);
    return slab.IsEmpty() ? std::vector<VertexBox>() : std::vector<VertexBox>{ slab };
  }

  Lattice GetLattice() const override
  {
    VertexBox box = this->Box;
    box.High[2] = this->End;
    return { box, this->Step };
  }
  const char* GetPart() const override { return "first"; }

private:
  const VertexBox Box;
  const std::int64_t Slices;
  std::int64_t End = 0; ///< of the slices so far
};

} // namespace

VertexBox Lattice::GetNumbers() const
{
  VertexBox numbers;
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    numbers.Low[axis] = DivideUp(this->Box.Low[axis], this->Step[axis]);
    numbers.High[axis] = DivideUp(this->Box.High[axis], this->Step[axis]);
  }
  return numbers;
}

std::unique_ptr<ReadingOrder> ReadingOrder::Choose(
  const BoxSource& source, std::int64_t vertices, std::int64_t atOnce)
{
  const VertexBox& box = source.GetBox();
  const Index3 step = ChooseStep(box.High, vertices);
  const auto chunk = source.GetChunk();
  if (source.HasCheapRows() || (chunk && (*chunk)[2] * 2 <= step[2]))
  {
    return std::make_unique<SliceOrder>(box, step, source.HasCheapRows(), atOnce > 1);
  }
  if (chunk)
  {
    return std::make_unique<ChunkOrder>(box, *chunk, step, atOnce);
  }
  VertexBox slice = box;
  slice.High[2] = std::min<std::int64_t>(1, box.High[2]);
  const auto slices =
    static_cast<std::int64_t>(StreamBytes / std::max<std::uint64_t>(1, source.GetReadBytes(slice)));
  return std::make_unique<StreamOrder>(box, step, std::max<std::int64_t>(1, slices));
}

} // namespace isosurface
