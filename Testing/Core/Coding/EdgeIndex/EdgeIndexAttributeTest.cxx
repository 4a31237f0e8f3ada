// SPDX-License-Identifier: BSD-3-Clause
#include "Fixtures/AttributedSource.h"
#include "Fixtures/CodedVolumes.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>
#include <set>
#include <vector>

using namespace isosurface;

namespace
{

ContourRequest MakeAttributedRequest(const std::vector<double>& isovalues)
{
  ContourRequest request = MakeRequest(isovalues);
  request.Normals = true;
  request.Attributes = { { ValueType::Int16, 1 },
    { ValueType::Float32, AttributedSource::VectorSize }, { ValueType::Float64, 1 } };
  return request;
}

} // namespace

TEST(EdgeIndexAttributes, AreBitwiseEqualInEveryMode)
{
  const auto volume = MakeWaves<std::uint8_t>({ 50, 35, 20 }, 0.3);
  const std::vector<double> isovalues = { 120.5, 90, 255 };
  AttributedSource source(volume, 16, true);
  const ContourRequest request = MakeAttributedRequest(isovalues);
  const auto expected = Require(ExtractSurface(volume.Geometry, source, request, 1));
  for (const EdgeIndexMode mode :
    { EdgeIndexMode::Lossless, EdgeIndexMode::Bounded, EdgeIndexMode::Quantized })
  {
    for (const EdgeIndexProfile profile : { EdgeIndexProfile::Small, EdgeIndexProfile::Working })
    {
      const Surface decoded = EncodeAndDecode(
        MakeAttributedHeader(volume, isovalues, mode, profile, 0), source, request, 2);
      ExpectSameTopology(expected, decoded);
      EXPECT_TRUE(HaveEqualBytes(expected.Normals, decoded.Normals));
      ASSERT_EQ(decoded.Attributes.size(), 3u);
      for (std::size_t n = 0; n < 3; ++n)
      {
        EXPECT_EQ(expected.Attributes[n].Layout.Type, decoded.Attributes[n].Layout.Type);
        EXPECT_TRUE(HaveEqualBytes(expected.Attributes[n].Bytes, decoded.Attributes[n].Bytes));
      }
    }
  }
}

TEST(EdgeIndexAttributes, BoundedOnesStayWithinTheirErrorAndExceptionsAreKept)
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
      const auto bytes =
        Require(EncodeSurface(MakeAttributedHeader(volume, { 120.5 }, EdgeIndexMode::Lossless,
                                EdgeIndexProfile::Working, error),
          source, 1));
      const auto decoded = Require(DecodeSurface(bytes.data(), bytes.size(), request, 1));
      const auto& exact = expected->Attributes[1].Bytes;
      const auto& close = decoded.Attributes[1].Bytes;
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
      const auto* exactDoubles =
        reinterpret_cast<const double*>(expected->Attributes[2].Bytes.GetData());
      const auto* closeDoubles =
        reinterpret_cast<const double*>(decoded.Attributes[2].Bytes.GetData());
      for (std::size_t n = 0; n < expected->NumberOfPoints; ++n)
      {
        ASSERT_LE(std::abs(exactDoubles[n] - closeDoubles[n]), error);
      }
      EXPECT_LT(bytes.size(), last);
      last = bytes.size();
    }
  }
}

TEST(EdgeIndexAttributes, NormalsAreDecodedOnlyIfRequested)
{
  const auto volume = MakeWaves<std::uint8_t>({ 20, 20, 20 }, 0.3);
  AttributedSource source(volume, 16, false);
  const auto bytes = Require(EncodeSurface(
    MakeAttributedHeader(volume, { 120.5 }, EdgeIndexMode::Lossless, EdgeIndexProfile::Working, 0),
    source, 1));
  const auto decoded =
    Require(DecodeSurface(bytes.data(), bytes.size(), MakeRequest({ 120.5 }), 1));
  EXPECT_TRUE(decoded.Normals.IsEmpty());
  EXPECT_EQ(decoded.Attributes.size(), 3u);
}

TEST(EdgeIndexAttributes, PointsMergedAtAVertexHaveTheTuplesOfTheirEdges)
{
  // Values that are whole numbers, contoured at one: many points lie at vertices.
  const auto volume = MakeWaves<std::uint8_t>({ 30, 20, 20 }, 0.3);
  AttributedSource source(volume, 16, false);
  ContourRequest request = MakeAttributedRequest({ 120 });
  const auto all = Require(ExtractSurface(volume.Geometry, source, request, 1));
  request.DropDegenerateTriangles = true;
  const auto expected = Require(ExtractSurface(volume.Geometry, source, request, 1));
  ASSERT_LT(expected.NumberOfPoints, all.NumberOfPoints);
  const auto bytes = Require(EncodeSurface(
    MakeAttributedHeader(volume, { 120 }, EdgeIndexMode::Lossless, EdgeIndexProfile::Working, 0),
    source, 1));
  const auto decoded = Require(DecodeSurface(bytes.data(), bytes.size(), request, 2));
  ExpectSamePoints(expected, decoded);
  // Each tuple is one that the whole surface has at that place.
  const auto get = [](const Surface& surface, std::size_t point)
  {
    float value = 0;
    std::memcpy(&value,
      &surface.Attributes[1].Bytes[AttributedSource::VectorSize * sizeof(float) * point],
      sizeof(value));
    return value;
  };
  std::map<std::array<float, 3>, std::set<float>> valuesAt;
  for (std::size_t n = 0; n < all.NumberOfPoints; ++n)
  {
    const float* point = &all.Points[3 * n];
    valuesAt[{ point[0], point[1], point[2] }].insert(get(all, n));
  }
  for (std::size_t n = 0; n < decoded.NumberOfPoints; ++n)
  {
    const float* point = &decoded.Points[3 * n];
    EXPECT_EQ((valuesAt[{ point[0], point[1], point[2] }].count(get(decoded, n))), 1u);
  }
}

TEST(EdgeIndexAttributes, AreRefusedOnClosedSidesOfTheGrid)
{
  const auto volume = MakeWaves<std::uint8_t>({ 20, 20, 20 }, 0.3);
  AttributedSource source(volume, 16, false);
  const auto bytes = Require(EncodeSurface(
    MakeAttributedHeader(volume, { 120.5 }, EdgeIndexMode::Lossless, EdgeIndexProfile::Working, 0),
    source, 1));
  ContourRequest request = MakeRequest({ 120.5 });
  request.ClosedSides = GridSides::All();
  EXPECT_EQ(DecodeSurface(bytes.data(), bytes.size(), request, 1).GetStatus().GetCode(),
    StatusCode::InvalidArgument);
}

TEST(EdgeIndexAttributes, ArraysThatDoNotMatchTheHeaderAreRefused)
{
  const auto volume = MakeWaves<std::uint8_t>({ 20, 20, 20 }, 0.3);
  TestBlockSource<std::uint8_t> without(volume, 16);
  EdgeIndexHeader header =
    MakeAttributedHeader(volume, { 120.5 }, EdgeIndexMode::Lossless, EdgeIndexProfile::Working, 0);
  EXPECT_EQ(EncodeSurface(header, without, 1).GetStatus().GetCode(), StatusCode::InvalidArgument);
  header.Attributes[0].Type = ValueType::Int16; // of samples, not of points
  EXPECT_EQ(header.Check().GetCode(), StatusCode::InvalidArgument);
  header.Attributes[0].Type = ValueType::Float64; // int16 samples give float32
  AttributedSource source(volume, 16, false);
  EXPECT_EQ(EncodeSurface(header, source, 1).GetStatus().GetCode(), StatusCode::InvalidArgument);
  header.Attributes[0].Type = ValueType::Float32;
  EXPECT_TRUE(EncodeSurface(header, source, 1).IsOk());
  header.Attributes[2].NumberOfComponents = 65;
  EXPECT_EQ(header.Check().GetCode(), StatusCode::InvalidArgument);
  header.Attributes[2].NumberOfComponents = 64;
  EXPECT_TRUE(header.Check().IsOk());
  header.Attributes.resize(8, header.Attributes[2]);
  EXPECT_EQ(header.Check().GetCode(), StatusCode::InvalidArgument);
}
