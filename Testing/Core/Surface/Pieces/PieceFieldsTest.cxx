// SPDX-License-Identifier: BSD-3-Clause
// Which pieces are parts of one field, wherever they are.
#include "Surface/Pieces/PieceFields.h"

#include "Fixtures/Require.h"
#include "Fixtures/ThreadCommunicator.h"

#include "Ground/Volume/SampleCopy.h"

#include <gtest/gtest.h>

#include <functional>
#include <limits>
#include <utility>
#include <vector>

using namespace isosurface;

namespace
{

using Values = std::function<float(const Index3&)>;

float Ramp(const Index3& vertex)
{
  return static_cast<float>(vertex[0] + 10 * vertex[1] + 100 * vertex[2]);
}

struct Image
{
  Image(const VertexBox& box, std::vector<std::int64_t> block, const Values& values = Ramp)
    : Box(box)
  {
    this->Piece.Block = std::move(block);
    VisitVertices(box, [&](const Index3& vertex) { this->Samples.push_back(values(vertex)); });
  }
  FieldPiece Get() const
  {
    FieldPiece piece = this->Piece;
    piece.Components = { MakeSampleView(ValueType::Float32, this->Box, this->Samples.data()) };
    piece.Whole = this->Piece.IsDeclared ? this->Piece.Whole : this->Box;
    return piece;
  }

  VertexBox Box;
  std::vector<float> Samples;
  FieldPiece Piece;
};

/// The field of each image, as on one rank; the same is expected on 2 and 3 ranks, however the images
/// are dealt out.
std::vector<std::size_t> FindFields(const std::vector<Image>& images)
{
  std::vector<std::size_t> expected;
  for (const int size : { 1, 2, 3 })
  {
    std::vector<std::size_t> found(images.size());
    ThreadCommunicator::Run(size,
      [&](Communicator& ranks)
      {
        const auto own = static_cast<std::size_t>(ranks.GetRank());
        std::vector<FieldPiece> mine;
        std::vector<std::size_t> places;
        for (std::size_t n = 0; n < images.size(); ++n)
        {
          if ((images.size() - n) % static_cast<std::size_t>(size) == own)
          {
            places.push_back(n);
            mine.push_back(images[n].Get());
          }
        }
        const auto fields = Require(PieceFields::Find(
          ranks, [&] { return mine; }, 1));
        for (std::size_t n = 0; n < mine.size(); ++n)
        {
          found[places[n]] = fields.Numbers[n];
        }
      });
    expected = size == 1 ? found : expected;
    EXPECT_EQ(found, expected) << size << " ranks";
  }
  return expected;
}

constexpr VertexBox Left = { { 0, 0, 0 }, { 5, 4, 4 } };
constexpr VertexBox Right = { { 4, 0, 0 }, { 9, 4, 4 } };
using Numbers = std::vector<std::size_t>;

} // namespace

TEST(PieceFields, PiecesWithEqualSamplesWhereTheyMeetAreOneField)
{
  EXPECT_EQ(FindFields({ { Left, { 0 } }, { Right, { 1 } } }), (Numbers{ 0, 0 }));
  EXPECT_EQ(
    FindFields({ { Left, { 0 } }, { { { 3, 0, 0 }, { 9, 4, 4 } }, { 1 } } }), (Numbers{ 0, 0 }));
}

TEST(PieceFields, OneOtherSampleWhereTheyMeetMakesTwoFields)
{
  const auto values = [](const Index3& vertex) {
    return Ramp(vertex) + (vertex == Index3{ 4, 3, 3 } ? 1.0F : 0.0F);
  };
  EXPECT_EQ(FindFields({ { Left, { 0 } }, { Right, { 1 }, values } }), (Numbers{ 0, 1 }));
}

TEST(PieceFields, PiecesThatDoNotMeetAreFieldsOfTheirOwnUnlessTheirBlockDeclaresAWhole)
{
  const VertexBox far = { { 6, 0, 0 }, { 9, 4, 4 } };
  std::vector<Image> images = { { Left, { 0 } }, { far, { 0 } } };
  EXPECT_EQ(FindFields(images), (Numbers{ 0, 1 }));
  for (Image& image : images)
  {
    image.Piece.IsDeclared = true;
    image.Piece.Whole = { { 0, 0, 0 }, { 9, 4, 4 } };
  }
  EXPECT_EQ(FindFields(images), (Numbers{ 0, 0 }));
}

TEST(PieceFields, NotANumberAndSignsOfZeroAreEqual)
{
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const auto withFace = [](float first, float second)
  {
    return [=](const Index3& vertex) {
      return vertex[0] != 4 ? Ramp(vertex) : vertex[1] == 0 ? first : second;
    };
  };
  EXPECT_EQ(
    FindFields({ { Left, { 0 }, withFace(nan, 0.0F) }, { Right, { 1 }, withFace(-nan, -0.0F) } }),
    (Numbers{ 0, 0 }));
  EXPECT_EQ(
    FindFields({ { Left, { 0 }, withFace(nan, 0.0F) }, { Right, { 1 }, withFace(1.0F, 0.0F) } }),
    (Numbers{ 0, 1 }));
}

TEST(PieceFields, MembersInBlocksStayTogetherThoughTheirFacesAreEqual)
{
  const auto flat = [](float inside)
  {
    return [inside](const Index3& vertex)
    { return vertex[0] == 4 || vertex[0] == 0 || vertex[0] == 8 ? 0.0F : inside; };
  };
  EXPECT_EQ(FindFields({ { Left, { 0, 0 }, flat(1) }, { Right, { 0, 1 }, flat(1) },
              { Left, { 1, 0 }, flat(2) }, { Right, { 1, 1 }, flat(2) } }),
    (Numbers{ 0, 0, 1, 1 }));
}

TEST(PieceFields, CopiesAndPartsThatAreCopiesAreFieldsOfTheirOwn)
{
  EXPECT_EQ(FindFields({ { Left, { 0 } }, { Left, { 1 } } }), (Numbers{ 0, 1 }));
  EXPECT_EQ(FindFields(
              { { Left, { 0, 0 } }, { Right, { 0, 1 } }, { Left, { 1, 0 } }, { Right, { 1, 1 } } }),
    (Numbers{ 0, 0, 1, 1 }));
  EXPECT_EQ(
    FindFields({ { Left, { 0 } }, { { { 1, 1, 1 }, { 3, 3, 3 } }, { 1 } } }), (Numbers{ 0, 1 }));
}

TEST(PieceFields, OtherTypesAreOtherFields)
{
  std::vector<std::int32_t> integers(static_cast<std::size_t>(Right.GetNumberOfVertices()));
  const Image left(Left, { 0 }, [](const Index3&) { return 0.0F; });
  ThreadCommunicator::Run(1,
    [&](Communicator& ranks)
    {
      FieldPiece right;
      right.Block = { 1 };
      right.Whole = Right;
      right.Components = { MakeSampleView(ValueType::Int32, Right, integers.data()) };
      EXPECT_EQ(Require(PieceFields::Find(
                          ranks,
                          [&] {
                            return std::vector<FieldPiece>{ left.Get(), right };
                          },
                          1))
                  .Fields.size(),
        2U);
    });
}

TEST(PieceFields, EachCellOfAFieldBelongsToItsFirstPiece)
{
  const Image first(Left, { 0 });
  const Image second({ { 2, 0, 0 }, { 9, 6, 4 } }, { 1 });
  ThreadCommunicator::Run(1,
    [&](Communicator& ranks)
    {
      const auto fields = Require(PieceFields::Find(
        ranks,
        [&] {
          return std::vector<FieldPiece>{ first.Get(), second.Get() };
        },
        1));
      ASSERT_EQ(fields.Fields.size(), 1U);
      EXPECT_EQ(fields.Fields[0].Box, (VertexBox{ { 0, 0, 0 }, { 9, 6, 4 } }));
      EXPECT_EQ(fields.Boxes[0], std::vector<VertexBox>{ Left });
      std::int64_t cells = 0;
      for (const VertexBox& box : fields.Boxes[1])
      {
        const Index3 size = box.GetSize();
        cells += (size[0] - 1) * (size[1] - 1) * (size[2] - 1);
        EXPECT_TRUE(box.Low[0] >= 4 || box.Low[1] >= 3) << box.Low[0] << ' ' << box.Low[1];
      }
      EXPECT_EQ(cells, 6 * 5 * 3 - 2 * 3 * 3);
    });
}
