// SPDX-License-Identifier: BSD-3-Clause
#include "Coding/Meshes/MeshFile.h"

#include "CompressedMesh.h"

#include "Fixtures/MemoryDisk.h"
#include "Fixtures/Require.h"

#include <gtest/gtest.h>

#include <numeric>

using namespace isosurface;

namespace
{

const char* const Endings[] = { ".stl", ".ply", ".glb" };

/// A closed grid of triangles around a torus: two a point.
struct Torus
{
  explicit Torus(std::uint32_t side)
    : Points(3 * side * side, 0.5f)
    , Ids(side * side)
  {
    std::iota(this->Ids.begin(), this->Ids.end(), 0);
    for (std::uint32_t j = 0; j < side; ++j)
    {
      for (std::uint32_t i = 0; i < side; ++i)
      {
        const std::uint32_t next = (i + 1) % side;
        const std::uint32_t above = (j + 1) % side * side;
        this->Corners.insert(this->Corners.end(),
          { j * side + i, j * side + next, above + i, above + i, j * side + next, above + next });
      }
    }
  }

  Mesh Get(bool hasNormals) const
  {
    Mesh mesh;
    mesh.Points = this->Points.data();
    mesh.Normals = hasNormals ? this->Points.data() : nullptr;
    mesh.GlobalIds = this->Ids.data();
    mesh.NumberOfPoints = this->Ids.size();
    mesh.Corners = this->Corners.data();
    mesh.NumberOfTriangles = this->Corners.size() / 3;
    return mesh;
  }

  std::vector<float> Points;
  std::vector<std::int64_t> Ids;
  std::vector<std::uint32_t> Corners;
};

MeshFile::Settings MakeSettings(const std::string& path, std::uint64_t points)
{
  MeshFile::Settings settings;
  settings.Path = path;
  settings.Partial = path;
  settings.MostMeshes = 1;
  settings.Points = points;
  settings.Triangles = 2 * points;
  return settings;
}

} // namespace

TEST(MeshFile, BytesAreThoseThatWereEstimated)
{
  const Torus torus(200);
  EdgeIndexHeader header;
  header.Isovalues = { 1 };
  for (const char* ending : Endings)
  {
    for (const bool hasNormals : { false, true })
    {
      MemoryDisk disk;
      MeshFile::Settings settings = MakeSettings(std::string("a") + ending, torus.Ids.size());
      settings.HasNormals = hasNormals;
      const auto file = Require(MeshFile::Create(disk, header, settings));
      PointNumbers numbers;
      numbers.Values.resize(torus.Ids.size());
      std::iota(numbers.Values.begin(), numbers.Values.end(), 0);
      EXPECT_TRUE(file->Append(torus.Get(hasNormals), numbers).IsOk());
      EXPECT_TRUE(file->Finish().IsOk());
      const auto written = static_cast<double>(disk.GetFile(settings.Path).size());
      EXPECT_NEAR(static_cast<double>(MeshFile::EstimateBytes(settings)) / written, 1, 0.01)
        << settings.Path << (hasNormals ? " with normals" : "");
    }
  }
}

TEST(MeshFile, IsRefusedBeforeItIsCreatedIfItsFormatHasNoRoom)
{
  const EdgeIndexHeader header;
  for (const char* ending : Endings)
  {
    MemoryDisk disk;
    const std::string path = std::string("large") + ending;
    const auto file = MeshFile::Create(disk, header, MakeSettings(path, 6'000'000'000));
    ExpectError(file.GetStatus(), StatusCode::Unsupported, path + ": would have about ");
    EXPECT_TRUE(disk.GetFiles().empty());
  }
  MeshFile::Settings settings = MakeSettings("some.glb", 160'000'000);
  EXPECT_FALSE(MeshFile::CheckLimits(settings).IsOk()) << "36 bytes a point are above 4 GiB";
  settings.Compression = &MeshoptimizerCompression;
  EXPECT_TRUE(MeshFile::CheckLimits(settings).IsOk());
  EXPECT_TRUE(MeshFile::CheckLimits(MakeSettings("some.ply", 160'000'000)).IsOk());
  EXPECT_TRUE(MeshFile::CheckLimits(MakeSettings("some.stl", 160'000'000)).IsOk());
}
