// SPDX-License-Identifier: BSD-3-Clause
#include "Fixtures/CodedVolumes.h"
#include "Fixtures/PlainContour.h"
#include "Ground/Volume/Vector3.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

using namespace isosurface;

namespace
{

struct Frame
{
  std::string Name;
  std::array<double, 3> Spacing;
  std::array<double, 9> Direction;
};

// All ways in which axes may be permuted and mirrored, by the direction, the spacing or both; and a turned grid.
std::vector<Frame> ListFrames()
{
  std::vector<Frame> frames;
  std::array<std::size_t, 3> axes{ 0, 1, 2 };
  do
  {
    for (unsigned mirrored = 0; mirrored < 8; ++mirrored)
    {
      // Every second permutation mirrors by the spacing what the others mirror by the direction; the last
      // does both.
      const unsigned order = static_cast<unsigned>(frames.size() / 8);
      const unsigned signs = order == 5 ? mirrored | ((mirrored * 3) & 7) << 3
        : order % 2 == 0                ? mirrored
                                        : mirrored << 3;
      Frame frame{ std::to_string(signs), { 1, 2, 0.5 }, {} };
      for (std::size_t axis = 0; axis < 3; ++axis)
      {
        frame.Direction[3 * axes[axis] + axis] = (signs >> axis & 1) != 0 ? -1 : 1;
        frame.Spacing[axis] *= (signs >> (3 + axis) & 1) != 0 ? -1 : 1;
        frame.Name += "," + std::to_string(axes[axis]);
      }
      frames.push_back(frame);
    }
  } while (std::next_permutation(axes.begin(), axes.end()));
  frames.push_back(
    { "turned and mirrored", { 0.3, 1.7, 2.1 }, { 0.6, 0.8, 0, 0.8, -0.6, 0, 0, 0, 1 } });
  return frames;
}

SampleVolume<float> MakeBall()
{
  return SampleVolume<float>({ 17, 15, 16 },
    [](auto i, auto j, auto k)
    {
      return 5 -
        std::hypot(
          static_cast<double>(i) - 8.2, static_cast<double>(j) - 7.1, static_cast<double>(k) - 7.6);
    });
}

// Of the triangles, by their corners' order; polygons are fans of triangles.
double ComputeVolume(const Surface& surface)
{
  double sixfold = 0;
  for (std::size_t cell = 0; cell < surface.NumberOfCells; ++cell)
  {
    const auto corner = [&](std::int64_t index)
    {
      const auto point = surface.Connectivity[static_cast<std::size_t>(index)];
      return surface.GetPoint(static_cast<std::size_t>(point));
    };
    for (std::int64_t n = surface.Offsets[cell] + 1; n + 1 < surface.Offsets[cell + 1]; ++n)
    {
      sixfold += Dot(corner(surface.Offsets[cell]), Cross(corner(n), corner(n + 1)));
    }
  }
  return sixfold / 6;
}

Vector3 GetNormal(const Surface& surface, std::size_t point)
{
  const float* normal = surface.Normals.GetData() + 3 * point;
  return { normal[0], normal[1], normal[2] };
}

void ExpectOutward(const Surface& surface, const std::string& name)
{
  Vector3 center{};
  for (std::size_t point = 0; point < surface.NumberOfPoints; ++point)
  {
    for (std::size_t axis = 0; axis < 3; ++axis)
    {
      center[axis] += surface.GetPoint(point)[axis] / static_cast<double>(surface.NumberOfPoints);
    }
  }
  std::size_t inward = 0;
  for (std::size_t point = 0; point < surface.NumberOfPoints; ++point)
  {
    inward +=
      Dot(GetNormal(surface, point), Subtract(surface.GetPoint(point), center)) > 0 ? 0U : 1U;
  }
  EXPECT_EQ(inward, 0U) << name;
}

ContourRequest MakeOffsetsRequest()
{
  ContourRequest request = MakePlainRequest({ 0.0 });
  request.Offsets = true;
  return request;
}

} // namespace

TEST(LeftHandedGrids, CornersAndNormalsPointToLowValuesInAnyGrid)
{
  SampleVolume<float> volume = MakeBall();
  constexpr double pi = 3.14159265358979;
  for (const Frame& frame : ListFrames())
  {
    volume.Geometry.Spacing = frame.Spacing;
    volume.Geometry.Direction = frame.Direction;
    const double cell = std::abs(frame.Spacing[0] * frame.Spacing[1] * frame.Spacing[2]);
    for (const bool polygons : { false, true })
    {
      for (const bool roundedOnce : { false, true })
      {
        ContourRequest request = MakeOffsetsRequest();
        request.Polygons = polygons;
        request.NormalsRoundedOnce = roundedOnce;
        const Surface surface = ExtractBlocks(volume, 8, request);
        EXPECT_NEAR(ComputeVolume(surface) / cell, 4 * pi / 3 * 125, 15) << frame.Name;
        ExpectOutward(surface, frame.Name);
      }
    }
  }
}

TEST(LeftHandedGrids, CapsOfClosedSurfacesPointOutwards)
{
  SampleVolume<float> volume({ 6, 5, 7 });
  std::fill(volume.Samples.begin(), volume.Samples.end(), 1.0F);
  for (const Frame& frame : ListFrames())
  {
    volume.Geometry.Spacing = frame.Spacing;
    volume.Geometry.Direction = frame.Direction;
    const double cell = std::abs(frame.Spacing[0] * frame.Spacing[1] * frame.Spacing[2]);
    for (const bool drop : { false, true })
    {
      ContourRequest request = MakeOffsetsRequest();
      request.ClosedSides = GridSides::All();
      request.DropDegenerateTriangles = drop;
      const Surface surface = ExtractBlocks(volume, 8, request);
      EXPECT_NEAR(ComputeVolume(surface) / cell, 5 * 4 * 6, 1e-3) << frame.Name;
      ExpectOutward(surface, frame.Name);
    }
  }
}

TEST(LeftHandedGrids, StreamsDecodeToTheExtractedCornersAndNormals)
{
  SampleVolume<float> volume = MakeBall();
  for (const Frame& frame : ListFrames())
  {
    volume.Geometry.Spacing = frame.Spacing;
    volume.Geometry.Direction = frame.Direction;
    ContourRequest request = MakeOffsetsRequest();
    TestBlockSource<float> source(volume, 8, 1);
    const Surface extracted = Require(ExtractSurface(volume.Geometry, source, request, 1));
    EdgeIndexHeader header =
      MakeHeader(volume, { 0.0 }, EdgeIndexMode::Lossless, EdgeIndexProfile::Working);
    EdgeIndexAttribute normals;
    normals.NumberOfComponents = 3;
    normals.IsNormals = true;
    header.Attributes = { normals };
    const Surface decoded = EncodeAndDecode(header, source, request);
    ExpectSamePoints(extracted, decoded);
    EXPECT_TRUE(HaveEqualBytes(extracted.Normals, decoded.Normals)) << frame.Name;
  }
}
