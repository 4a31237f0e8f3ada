// SPDX-License-Identifier: BSD-3-Clause
// Files of all format versions stay readable with the same meaning, and the bytes that an encoder
// writes do not depend on compiler, flags or machine. The files must not change together with the
// code.
#include "Fixtures/CodedVolumes.h"

#include "Fixtures/MemoryDisk.h"

#include "Coding/EdgeIndex/EdgeIndexFile.h"
#include "Fixtures/EdgeIndexFileWriter.h"

#include <gtest/gtest.h>

#include <fstream>
#include <string>
#include <vector>

using namespace isosurface;

namespace
{

const std::string GoldenPath = "/data/surface.eix";
const std::vector<double> Isovalues = { 150.5, 400 };

/// In whole numbers (and quarters, for floats), so that it is the same everywhere.
template <typename T>
SampleVolume<T> MakeGoldenVolume()
{
  SampleVolume<T> volume({ 37, 21, 18 },
    [](auto i, auto j, auto k)
    {
      const std::int64_t value = (i - 17) * (i - 17) + 2 * (j - 9) * (j - 9) +
        3 * (k - 8) * (k - 8) + 3 * ((7 * i + 11 * j * k + 13 * k) % 9);
      return static_cast<T>(value) +
        (std::is_floating_point_v<T> ? static_cast<T>(i % 4) / T(4) : T(0));
    });
  volume.Geometry.Extent = { -3, 33, 5, 25, 0, 17 };
  volume.Geometry.Origin = { 10, -20, 0.5 };
  volume.Geometry.Spacing = { 0.5, 1, 2 };
  return volume;
}

template <typename T>
EdgeIndexHeader MakeGoldenHeader(EdgeIndexMode mode, EdgeIndexProfile profile)
{
  EdgeIndexHeader header = MakeHeader(MakeGoldenVolume<T>(), Isovalues, mode, profile);
  header.Array = "density";
  header.Source = "golden";
  header.Time = 0.25;
  header.PreviewLevel = 1;
  header.Settings.MaximumError = 0.03125;
  header.Settings.QuantizationMinimum = 0;
  header.Settings.QuantizationMaximum = 1024;
  header.RoundsFaces = false; // as in version 1
  return header;
}

std::vector<std::uint8_t> ReadGolden(const std::string& name)
{
  std::ifstream stream(ISOSURFACE_TEST_DATA "/" + name, std::ios::binary);
  return { std::istreambuf_iterator<char>(stream), {} };
}

/// Whether a golden file is the surface.
template <typename T>
void CheckDecoded(const std::vector<std::uint8_t>& golden, EdgeIndexMode mode, bool normals)
{
  const SampleVolume<T> volume = MakeGoldenVolume<T>();
  TestBlockSource<T> source(volume, 16);
  MemoryDisk disk;
  const auto file = disk.CreateForWriting(GoldenPath);
  ASSERT_TRUE(file.IsOk() && (*file)->Append(golden.data(), golden.size()).IsOk());
  const auto opened = Require(EdgeIndexFile::Open(disk, GoldenPath));
  EXPECT_TRUE(opened->Verify(1).IsOk());
  EXPECT_EQ(opened->GetHeader().RoundsFaces, golden[8] > 1); // the version
  EXPECT_EQ(opened->GetHeader().Array, "density");
  EXPECT_EQ(opened->GetHeader().Source, "golden");
  EXPECT_EQ(opened->GetHeader().Time, 0.25);
  ContourRequest request = MakeRequest(Isovalues);
  request.Normals = normals;
  const auto expected = ExtractSurface(volume.Geometry, source, request, 1);
  const auto read = Require(opened->Read({}, request, 1));
  ExpectSameTopology(*expected, read);
  if (mode == EdgeIndexMode::Lossless)
  {
    EXPECT_TRUE(HaveEqualBytes(expected->Points, read.Points));
  }
  for (std::size_t n = 0; n < expected->Points.GetSize() && mode == EdgeIndexMode::Bounded; ++n)
  {
    // Coordinates of z have two to the voxel.
    ASSERT_NEAR(expected->Points[n], read.Points[n], n % 3 == 2 ? 0.0626 : 0.0313);
  }
  ASSERT_EQ(expected->Normals.GetSize(), read.Normals.GetSize());
  for (std::size_t n = 0; n < expected->Normals.GetSize(); ++n)
  {
    ASSERT_NEAR(expected->Normals[n], read.Normals[n], 0.0078125);
  }
  request.Normals = false; // the preview has none
  EdgeIndexSelection preview;
  preview.Preview = true;
  const auto coarse = Require(opened->Read(preview, request, 1));
  EXPECT_GT(coarse.NumberOfTriangles, 0u);
}

/// Reads a golden file, and what the encoder makes now; both must be equal, and be the surface.
template <typename T>
void CheckGolden(const std::string& name, EdgeIndexMode mode, EdgeIndexProfile profile,
  bool normals = false, bool roundsFaces = false, LengthUnit unit = LengthUnit::Unknown)
{
  const std::vector<std::uint8_t> golden = ReadGolden("edge-index/" + name);
  const SampleVolume<T> volume = MakeGoldenVolume<T>();
  TestBlockSource<T> source(volume, 16);
  MemoryDisk disk;
  EdgeIndexHeader header = MakeGoldenHeader<T>(mode, profile);
  header.RoundsFaces = roundsFaces;
  header.Geometry.Unit = unit;
  if (normals)
  {
    header.Attributes = { { "Normals", ValueType::Float32, 3, 0.0078125, true } };
  }
  ASSERT_TRUE(WriteEdgeIndexFile(disk, GoldenPath, header, source, 1).IsOk());
  const MemoryDisk::Bytes encoded = disk.GetFile(GoldenPath);
  if (encoded != golden)
  {
    const std::string written = ::testing::TempDir() + name;
    std::ofstream actual(written, std::ios::binary);
    actual.write(
      reinterpret_cast<const char*>(encoded.data()), static_cast<std::streamsize>(encoded.size()));
    ADD_FAILURE() << name << " is not what is encoded now: " << written;
  }
  CheckDecoded<T>(golden, mode, normals);
}

} // namespace

TEST(EdgeIndexFilesOfRelease1, LosslessSurfaces)
{
  CheckGolden<std::int16_t>("lossless-int16.eix", EdgeIndexMode::Lossless, EdgeIndexProfile::Small);
  CheckGolden<float>("lossless-float32.eix", EdgeIndexMode::Lossless, EdgeIndexProfile::Small);
}

TEST(EdgeIndexFilesOfRelease1, BoundedByCrossings)
{
  CheckGolden<std::uint16_t>("bounded.eix", EdgeIndexMode::Bounded, EdgeIndexProfile::Small);
  CheckGolden<double>("bounded-working.eix", EdgeIndexMode::Bounded, EdgeIndexProfile::Working);
}

TEST(EdgeIndexFilesOfRelease1, QuantizedValues)
{
  CheckGolden<std::int32_t>("quantized.eix", EdgeIndexMode::Quantized, EdgeIndexProfile::Small);
}

TEST(EdgeIndexFilesOfRelease1, SmallestOfBothModes)
{
  CheckGolden<double>("smallest.eix", EdgeIndexMode::Smallest, EdgeIndexProfile::Small);
}

TEST(EdgeIndexFilesOfVersion2, SmallestWithRoundedFaces)
{
  CheckGolden<double>(
    "smallest-2.eix", EdgeIndexMode::Smallest, EdgeIndexProfile::Small, false, true);
}

TEST(EdgeIndexFilesOfRelease1, PointAttributes)
{
  CheckGolden<std::uint16_t>("normals.eix", EdgeIndexMode::Lossless, EdgeIndexProfile::Small, true);
}

TEST(EdgeIndexFilesOfVersion2, TellTheUnitOfLength)
{
  CheckGolden<std::int16_t>("unit.eix", EdgeIndexMode::Lossless, EdgeIndexProfile::Small, false,
    true, LengthUnit::Micrometer);
}

TEST(EdgeIndexFilesOfRelease1, ProfilesThatOnlyItHasAreRefusedByName)
{
  for (const auto& [name, profile] :
    { std::pair("bounded-fast.eix", "fast"), std::pair("compact-bounded.eix", "compact") })
  {
    const std::vector<std::uint8_t> golden = ReadGolden(std::string("edge-index-refused/") + name);
    MemoryDisk disk;
    const auto file = disk.CreateForWriting(GoldenPath);
    ASSERT_TRUE(file.IsOk() && (*file)->Append(golden.data(), golden.size()).IsOk());
    ExpectError(EdgeIndexFile::Open(disk, GoldenPath).GetStatus(), StatusCode::Unsupported,
      GoldenPath + ": The edge-index stream has the profile " + profile +
        ", which only ScalableIsosurface 1.0 reads and writes.");
  }
}
