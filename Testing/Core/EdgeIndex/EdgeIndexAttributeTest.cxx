// SPDX-License-Identifier: BSD-3-Clause
#include "CodedVolumes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <vector>

using namespace isosurface;

namespace
{

constexpr int TupleSize = 3;

/// Blocks with two more arrays: the labels of vertices (int16), and three floats each.
class AttributedSource : public TestBlockSource<std::uint8_t>
{
public:
  AttributedSource(const TestVolume<std::uint8_t>& volume, int blockSize, bool odd)
    : TestBlockSource<std::uint8_t>(volume, blockSize)
    , Dimensions(volume.GetDimensions())
  {
    const auto vertices = static_cast<std::size_t>(volume.Geometry.GetNumberOfVertices());
    this->Labels.resize(vertices);
    this->Vectors.resize(TupleSize * vertices);
    for (std::size_t n = 0; n < vertices; ++n)
    {
      this->Labels[n] = static_cast<std::int16_t>(n * 7 % 2000 / 10 - 50);
      for (std::size_t c = 0; c < std::size_t{ TupleSize }; ++c)
      {
        this->Vectors[TupleSize * n + c] = static_cast<float>(n % 50 * (c + 1)) * 0.37F - 3;
      }
    }
    if (odd)
    {
      for (std::size_t n = 0; n < this->Vectors.size(); n += 37)
      {
        this->Vectors[n] = n % 4 == 0 ? std::numeric_limits<float>::quiet_NaN()
          : n % 4 == 1                ? std::numeric_limits<float>::infinity()
                                      : 3e38F;
      }
    }
  }

  Result<BlockSamples> Acquire(std::size_t block) override
  {
    Result<BlockSamples> samples = TestBlockSource<std::uint8_t>::Acquire(block);
    AttributeView view;
    view.Samples.Available.High = this->Dimensions;
    view.Samples.Box = samples->Scalars.Box;
    view.Samples.Type = ValueType::Int16;
    view.Samples.First = this->Labels.data();
    const auto width = static_cast<std::ptrdiff_t>(this->Dimensions[0]);
    const auto area = static_cast<std::ptrdiff_t>(this->Dimensions[0] * this->Dimensions[1]);
    view.Samples.Stride = { 1, width, area };
    samples->Attributes.push_back(view);
    view.Samples.Type = ValueType::Float32;
    view.Samples.First = this->Vectors.data();
    view.Samples.Stride = { TupleSize, TupleSize * width, TupleSize * area };
    view.NumberOfComponents = TupleSize;
    samples->Attributes.push_back(view);
    return samples;
  }

private:
  Index3 Dimensions;
  std::vector<std::int16_t> Labels;
  std::vector<float> Vectors;
};

EdgeIndexHeader MakeAttributedHeader(const TestVolume<std::uint8_t>& volume,
  const std::vector<double>& isovalues, EdgeIndexMode mode, EdgeIndexProfile profile, double error)
{
  EdgeIndexHeader header = MakeHeader(volume, isovalues, mode, profile);
  header.Attributes.resize(3);
  header.Attributes[0].Name = "labels";
  header.Attributes[0].Type = ValueType::Int16;
  header.Attributes[1].Name = "Normals";
  header.Attributes[1].NumberOfComponents = 3;
  header.Attributes[1].IsNormals = true;
  header.Attributes[2].Name = "vectors";
  header.Attributes[2].NumberOfComponents = TupleSize;
  header.Attributes[2].MaximumError = error;
  return header;
}

ContourRequest MakeAttributedRequest(const std::vector<double>& isovalues)
{
  ContourRequest request = MakeRequest(isovalues);
  request.Normals = true;
  request.Attributes = { { ValueType::Int16, 1 }, { ValueType::Float32, TupleSize } };
  return request;
}

} // namespace

TEST(EdgeIndexAttributes, ComeBackBitByBitInEveryMode)
{
  const auto volume = MakeWaves<std::uint8_t>({ 50, 35, 20 }, 0.3);
  const std::vector<double> isovalues = { 120.5, 90, 255 };
  AttributedSource source(volume, 16, true);
  const ContourRequest request = MakeAttributedRequest(isovalues);
  const auto expected = ExtractSurface(volume.Geometry, source, request, 1);
  ASSERT_TRUE(expected.IsOk()) << expected.GetStatus().GetMessage();
  for (const EdgeIndexMode mode :
    { EdgeIndexMode::Lossless, EdgeIndexMode::Bounded, EdgeIndexMode::Quantized })
  {
    for (const EdgeIndexProfile profile : { EdgeIndexProfile::Default, EdgeIndexProfile::Fast })
    {
      const auto bytes =
        EncodeSurface(MakeAttributedHeader(volume, isovalues, mode, profile, 0), source, 2);
      ASSERT_TRUE(bytes.IsOk()) << bytes.GetStatus().GetMessage();
      const auto decoded = DecodeSurface(bytes->data(), bytes->size(), request, 2);
      ASSERT_TRUE(decoded.IsOk()) << decoded.GetStatus().GetMessage();
      ExpectSameTopology(*expected, *decoded);
      EXPECT_TRUE(HaveEqualBytes(expected->Normals, decoded->Normals));
      ASSERT_EQ(decoded->Attributes.size(), 2u);
      for (std::size_t n = 0; n < 2; ++n)
      {
        EXPECT_TRUE(HaveEqualBytes(expected->Attributes[n].Bytes, decoded->Attributes[n].Bytes));
      }
    }
  }
}

TEST(EdgeIndexAttributes, BoundedOnesStayWithinTheirErrorAndOddOnesAreKept)
{
  const auto volume = MakeWaves<std::uint8_t>({ 40, 35, 20 }, 0.3);
  const ContourRequest request = MakeAttributedRequest({ 120.5 });
  for (const bool odd : { false, true })
  {
    AttributedSource source(volume, 16, odd);
    const auto expected = ExtractSurface(volume.Geometry, source, request, 1);
    std::size_t last = std::numeric_limits<std::size_t>::max();
    for (const double error : { 1e-30, 0.0001, 0.01, 1.0 })
    {
      const auto bytes = EncodeSurface(MakeAttributedHeader(volume, { 120.5 },
                                         EdgeIndexMode::Lossless, EdgeIndexProfile::Fast, error),
        source, 1);
      ASSERT_TRUE(bytes.IsOk()) << bytes.GetStatus().GetMessage();
      const auto decoded = DecodeSurface(bytes->data(), bytes->size(), request, 1);
      ASSERT_TRUE(decoded.IsOk()) << decoded.GetStatus().GetMessage();
      const auto& exact = expected->Attributes[1].Bytes;
      const auto& close = decoded->Attributes[1].Bytes;
      ASSERT_EQ(exact.GetSize(), close.GetSize());
      for (std::size_t n = 0; n < exact.GetSize(); n += sizeof(float))
      {
        float a = 0;
        float b = 0;
        std::memcpy(&a, &exact[n], sizeof(a));
        std::memcpy(&b, &close[n], sizeof(b));
        if (!std::isfinite(a) || std::abs(a) > 1e37F)
        {
          ASSERT_EQ(std::memcmp(&a, &b, sizeof(a)), 0);
        }
        else
        {
          ASSERT_LE(std::abs(static_cast<double>(a) - static_cast<double>(b)), error);
        }
      }
      EXPECT_LT(bytes->size(), last);
      last = bytes->size();
    }
  }
}

TEST(EdgeIndexAttributes, NormalsAreGivenIfAskedFor)
{
  const auto volume = MakeWaves<std::uint8_t>({ 20, 20, 20 }, 0.3);
  AttributedSource source(volume, 16, false);
  const auto bytes = EncodeSurface(
    MakeAttributedHeader(volume, { 120.5 }, EdgeIndexMode::Lossless, EdgeIndexProfile::Fast, 0),
    source, 1);
  ASSERT_TRUE(bytes.IsOk());
  const auto decoded = DecodeSurface(bytes->data(), bytes->size(), MakeRequest({ 120.5 }), 1);
  ASSERT_TRUE(decoded.IsOk());
  EXPECT_TRUE(decoded->Normals.IsEmpty());
  EXPECT_EQ(decoded->Attributes.size(), 2u);
}

TEST(EdgeIndexAttributes, ThoseThatDoNotFitTheHeaderAreRefused)
{
  const auto volume = MakeWaves<std::uint8_t>({ 20, 20, 20 }, 0.3);
  TestBlockSource<std::uint8_t> without(volume, 16);
  EdgeIndexHeader header =
    MakeAttributedHeader(volume, { 120.5 }, EdgeIndexMode::Lossless, EdgeIndexProfile::Fast, 0);
  EXPECT_EQ(EncodeSurface(header, without, 1).GetStatus().GetCode(), StatusCode::InvalidArgument);
  header.Attributes[0].MaximumError = 1; // of integers
  EXPECT_EQ(header.Check().GetCode(), StatusCode::InvalidArgument);
  header.Attributes[0].MaximumError = 0;
  header.Attributes[2].NumberOfComponents = 65;
  EXPECT_EQ(header.Check().GetCode(), StatusCode::InvalidArgument);
  header.Attributes[2].NumberOfComponents = 64;
  EXPECT_TRUE(header.Check().IsOk());
  header.Attributes.resize(7, header.Attributes[2]);
  EXPECT_EQ(header.Check().GetCode(), StatusCode::InvalidArgument);
}
