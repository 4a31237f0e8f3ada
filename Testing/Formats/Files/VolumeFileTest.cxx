// SPDX-License-Identifier: BSD-3-Clause
// The door of the library: one call opens a volume, whatever it is stored in, and the same questions have
// the same answers.
#include "Fixtures/CodedVolumes.h"
#include "Fixtures/Require.h"
#include "Fixtures/SampleFiles.h"
#include "Fixtures/ScratchFolder.h"
#include "Fixtures/TriangleSet.h"
#include "Fixtures/VolumeOnDisk.h"
#include "Formats/Files/SurfaceFile.h"
#include "Formats/Files/SurfaceQueries.h"
#include "Formats/Indexing/SourceIndex.h"
#include "Ground/Base/Communicator.h"

#include <atomic>
#include <fstream>

using namespace isosurface;

namespace
{

constexpr double Isovalue = 120;

void WriteLocal(const std::string& path, const Bytes& bytes)
{
  std::ofstream(path, std::ios::binary)
    .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
}

TriangleSet MakeTriangleSet(const Surface& surface)
{
  TriangleSet set;
  for (std::size_t triangle = 0; triangle < surface.NumberOfTriangles; ++triangle)
  {
    std::array<Place, 3> corners;
    for (std::size_t n = 0; n < 3; ++n)
    {
      const auto point = static_cast<std::size_t>(surface.Connectivity[3 * triangle + n]);
      std::copy_n(&surface.Points[3 * point], 3, corners[n].begin());
    }
    AddTriangle(set, corners);
  }
  std::sort(set.begin(), set.end());
  return set;
}

} // namespace

TEST(VolumeFile, FileItsIndexAndItsCopyGiveTheSameSamplesCostAndSurface)
{
  const ScratchFolder folder;
  const auto volume = MakeWaves<std::uint8_t>({ 40, 33, 36 }, 0.2);
  const std::string name = folder / "waves.mhd";
  WriteLocal(folder / "waves.raw", MakeBytes(volume));
  WriteLocal(name,
    MakeBytes(std::string("ObjectType = Image\nNDims = 3\nDimSize = 40 33 36\n"
                          "ElementType = MET_UCHAR\nElementDataFile = waves.raw\n")));
  const TriangleSet expected = MakeTriangleSet(ContourPlainly(volume, { Isovalue }));
  const auto check = [&](const std::string& path, int levels)
  {
    SCOPED_TRACE(path);
    const auto file = Require(VolumeFile::Open(path));
    EXPECT_EQ(file->GetNumberOfLevels() > 1, levels > 1);
    SampleRequest sample;
    sample.Components = { 0 };
    sample.Box = { { 7, 8, 9 }, { 8, 9, 10 } };
    std::uint8_t value = 0;
    EXPECT_TRUE(file->Read(sample, &value, {}).IsOk());
    EXPECT_EQ(value, volume.At({ 7, 8, 9 }));
    SurfaceRequest request;
    request.Isovalues = { Isovalue };
    EXPECT_EQ(Require(EstimateTriangles(*file, {}, request)), static_cast<double>(expected.size()));
    std::string warning;
    const Surface surface = Require(ExtractSurface(*file, {}, request, {}, warning));
    EXPECT_EQ(DropDegenerate(MakeTriangleSet(surface)), DropDegenerate(expected));
    EXPECT_EQ(warning, "");
  };
  check(name, 1);
  SerialCommunicator alone;
  const SourceIndex index = SourceIndex::Find(GetLocalFileSystem(), name, "", "", "");
  Require(WriteSourceIndex(alone, GetLocalFileSystem(), index, std::uint64_t{ 64 } << 20));
  check(name, 2);
  check(index.Path, 2);
}

TEST(VolumeFile, AnIslandOfSeveralRanksIsOne)
{
  const ScratchFolder folder;
  // A ball in many blocks, and a smaller one.
  const SampleVolume<std::uint8_t> volume({ 60, 50, 40 },
    [](auto i, auto j, auto k)
    {
      const auto large = (i - 25) * (i - 25) + (j - 25) * (j - 25) + (k - 20) * (k - 20);
      const auto small = (i - 52) * (i - 52) + (j - 8) * (j - 8) + (k - 8) * (k - 8);
      return static_cast<std::uint8_t>(large < 300 || small < 30 ? 200 : 0);
    });
  SerialCommunicator alone;
  const PieceOfVolume<std::uint8_t> whole(volume, { { 0, 0, 0 }, volume.GetDimensions() });
  VolumePiece piece;
  piece.Box = { { 0, 0, 0 }, volume.GetDimensions() };
  piece.Arrays = { whole.View };
  Require(BlockedVolumeWriter(alone).Write(folder / "balls.bvol", volume.Geometry,
    { { "density", ValueType::UInt8, 1 } }, piece, MakeSettings(16, 1)));
  const auto count = [&](int size)
  {
    std::atomic<std::size_t> triangles{ 0 };
    ThreadCommunicator::Run(size,
      [&](Communicator& ranks)
      {
        const auto file = Require(VolumeFile::Open(folder / "balls.bvol"));
        SurfaceRequest request;
        request.Isovalues = { 100 };
        request.Ranks = &ranks;
        request.Islands.emplace().MaximumIslands = 1;
        std::string warning;
        triangles += Require(ExtractSurface(*file, {}, request, {}, warning)).NumberOfTriangles;
      });
    return triangles.load();
  };
  EXPECT_GT(count(1), 1000U);
  EXPECT_EQ(count(3), count(1));
}

TEST(VolumeFile, WhatIsNoVolumeIsRefusedByName)
{
  const ScratchFolder folder;
  ExpectError(VolumeFile::Open(folder / "none.mhd").GetStatus(), StatusCode::NotFound,
    "none.mhd: there is no such file or folder");
  WriteLocal(folder / "surface.eix", MakeBytes(std::string("EIXcode\n")));
  ASSERT_TRUE(SurfaceFile::CanRead(folder / "surface.eix"));
  ExpectError(VolumeFile::Open(folder / "surface.eix").GetStatus(), StatusCode::InvalidArgument,
    "surface.eix: is a surface, not a volume");
  WriteLocal(folder / "text.txt", MakeBytes(std::string("no volume")));
  ExpectError(
    VolumeFile::Open(folder / "text.txt").GetStatus(), StatusCode::Unsupported, "text.txt: ");
}
