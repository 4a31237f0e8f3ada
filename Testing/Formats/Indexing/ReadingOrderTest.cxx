// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/Indexing/ReadingOrder.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

using namespace isosurface;

namespace
{

/// A source of which only the description matters.
class DescribedSource : public BoxSource
{
public:
  DescribedSource(const Index3& size, std::optional<Index3> chunk, bool hasCheapRows)
    : Box{ { 0, 0, 0 }, size }
    , Chunk(chunk)
    , CheapRows(hasCheapRows)
  {
  }
  const VertexBox& GetBox() const override { return this->Box; }
  std::uint64_t GetReadBytes(const VertexBox& box) const override
  {
    return static_cast<std::uint64_t>(box.GetNumberOfVertices()) * 4096;
  }
  std::optional<Index3> GetChunk() const override { return this->Chunk; }
  bool HasCheapRows() const override { return this->CheapRows; }
  Result<BoxSamples> Read(const VertexBox&) override { return BoxSamples{}; }

private:
  VertexBox Box;
  std::optional<Index3> Chunk;
  bool CheapRows;
};

const Index3 DescribedSize = { 40, 33, 50 };
constexpr std::int64_t MostVertices = 1200;

struct Source
{
  const char* Name;
  DescribedSource Described;
};

std::vector<Source> MakeSources()
{
  return {
    { "rows", { DescribedSize, Index3{ 40, 32, 32 }, true } },
    { "slices", { DescribedSize, Index3{ 40, 33, 1 }, false } },
    { "chunks", { DescribedSize, Index3{ 7, 16, 9 }, false } },
    { "one chunk", { DescribedSize, DescribedSize, false } },
    { "a stream", { DescribedSize, std::nullopt, false } },
  };
}

std::set<Index3> FindVertices(const Lattice& lattice)
{
  std::set<Index3> vertices;
  VisitVertices(lattice.GetNumbers(),
    [&](const Index3& number)
    {
      vertices.insert(
        { number[0] * lattice.Step[0], number[1] * lattice.Step[1], number[2] * lattice.Step[2] });
    });
  return vertices;
}

} // namespace

TEST(ReadingOrder, EachLatticeIsReadAndLargerThanTheOneBefore)
{
  for (const Source& source : MakeSources())
  {
    SCOPED_TRACE(source.Name);
    const auto order = ReadingOrder::Choose(source.Described, MostVertices);
    std::set<Index3> read;
    std::size_t last = 0;
    for (auto boxes = order->FindNext(); !boxes.empty(); boxes = order->FindNext())
    {
      for (const VertexBox& box : boxes)
      {
        for (const Index3& vertex : FindVertices({ box, order->GetStep() }))
        {
          EXPECT_TRUE(read.insert(vertex).second) << "read twice";
        }
      }
      const std::set<Index3> shown = FindVertices(order->GetLattice());
      EXPECT_TRUE(std::includes(read.begin(), read.end(), shown.begin(), shown.end()));
      EXPECT_LE(shown.size(), static_cast<std::size_t>(MostVertices));
      EXPECT_GT(shown.size(), 0u);
      last = shown.size();
    }
    const Lattice lattice = order->GetLattice();
    EXPECT_TRUE(lattice.Box == source.Described.GetBox()) << "not all of the source";
    EXPECT_GE(last, static_cast<std::size_t>(MostVertices) / 4);
  }
}

TEST(ReadingOrder, SlicesCanEndEarlyAndShowTheWholeVolume)
{
  for (const std::size_t kind : { 0, 1 })
  {
    const Source source = MakeSources()[kind];
    SCOPED_TRACE(source.Name);
    const auto order = ReadingOrder::Choose(source.Described, MostVertices);
    const std::size_t first = order->FindNext().size();
    const Lattice lattice = order->GetLattice();
    EXPECT_TRUE(lattice.Box == source.Described.GetBox());
    EXPECT_GE(first, 2u);
    EXPECT_LT(first, 10u);
    EXPECT_EQ(order->FindNext().size() + first, 2 * first - first % 2);
  }
}

TEST(ReadingOrder, AStreamIsReadFromTheFrontASlabAtATime)
{
  const Source source = MakeSources()[4];
  const auto order = ReadingOrder::Choose(source.Described, MostVertices);
  std::int64_t slices = 0;
  int parts = 0;
  for (auto boxes = order->FindNext(); !boxes.empty(); boxes = order->FindNext())
  {
    ASSERT_EQ(boxes.size(), 1u) << "two would be read at the same time";
    EXPECT_TRUE((boxes[0] ==
      VertexBox{ { 0, 0, slices }, { DescribedSize[0], DescribedSize[1], boxes[0].High[2] } }));
    slices = boxes[0].High[2];
    ++parts;
  }
  EXPECT_EQ(slices, DescribedSize[2]);
  EXPECT_GT(parts, 10);
}

TEST(ReadingOrder, ChunksAreWholeAndGrowFromTheMiddle)
{
  const Source source = MakeSources()[2];
  const auto order = ReadingOrder::Choose(source.Described, MostVertices);
  const std::vector<VertexBox> first = order->FindNext();
  ASSERT_EQ(first.size(), 1u);
  EXPECT_TRUE((first[0] == VertexBox{ { 21, 16, 27 }, { 28, 32, 36 } }));
  VertexBox before = order->GetLattice().Box;
  for (auto boxes = order->FindNext(); !boxes.empty(); boxes = order->FindNext())
  {
    EXPECT_TRUE(order->GetLattice().Box.Contains(before));
    before = order->GetLattice().Box;
  }
}
