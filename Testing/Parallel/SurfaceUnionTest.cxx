// SPDX-License-Identifier: BSD-3-Clause
// The surface is the same one, and so are the files, for any number of ranks.
#include "ParallelVolumes.h"

#include "vtkDataArray.h"
#include "vtkMultiProcessController.h"
#include "vtkPointData.h"

#include <algorithm>
#include <filesystem>
#include <map>
#include <ostream>

using namespace isosurface;

namespace
{

enum VolumeKind
{
  BALL_UINT8, ///< at the world's axes
  BALL_INT16, ///< oblique, negative extent
  BALL_FLOAT, ///< oblique, not starting at 0
  TWO_CUBED,  ///< a single cell
  SMALL,      ///< fewer vertices than several ranks can share
  FLAT_X,     ///< one vertex thick: no surface
  FLAT_Z
};

struct VolumeCase
{
  VolumeKind Kind;
  VolumeSettings Settings;
  int Layout;

  std::string GetName() const
  {
    const char* const kinds[] = { "uint8", "int16", "float", "cell", "small", "flatX", "flatZ" };
    const char* const distributions[] = { "greedy", "random", "slab" };
    const char* const layouts[] = { "subextents", "firstRank", "overlapping", "everywhere" };
    return std::string(kinds[this->Kind]) + "_" + std::to_string(this->Settings.BlockSize) + "_" +
      std::to_string(this->Settings.NumberOfStores) + "_" +
      distributions[this->Settings.Distribution] + "_" + layouts[this->Layout];
  }
};

std::ostream& operator<<(std::ostream& stream, const VolumeCase& one)
{
  return stream << one.GetName();
}

const std::vector<double>& GetIsovalues()
{
  // Whole ones equal samples; the last one is above all of them.
  static const std::vector<double> isovalues{ 200.0, 60.5, 150.0, 1e4 };
  return isovalues;
}

vtkSmartPointer<vtkImageData> MakeVolume(VolumeKind kind)
{
  vtkSmartPointer<vtkImageData> image;
  switch (kind)
  {
    case BALL_UINT8:
      return MakeClosedVolume({ 0, 69, 0, 60, 0, 82 }, VTK_UNSIGNED_CHAR);
    case BALL_INT16:
      image = MakeClosedVolume({ -41, 28, -7, 53, -90, -8 }, VTK_SHORT);
      break;
    case BALL_FLOAT:
      image = MakeClosedVolume({ 5, 74, -30, 30, 11, 93 }, VTK_FLOAT);
      break;
    case TWO_CUBED:
      return MakeImage({ 3, 4, 0, 1, -1, 0 }, VTK_UNSIGNED_CHAR,
        [](int i, int j, int k) { return 80.0 * (i - 3) + 60.0 * j + 100.0 * (k + 1); });
    case SMALL:
      return MakeImage({ 0, 4, 0, 2, 0, 1 }, VTK_FLOAT, MakeNoise(250, 5));
    case FLAT_X:
      return MakeImage({ 7, 7, 0, 40, 0, 29 }, VTK_UNSIGNED_CHAR, MakeNoise(250, 6));
    case FLAT_Z:
    default:
      return MakeImage({ 0, 40, 0, 29, 2, 2 }, VTK_SHORT, MakeNoise(250, 7));
  }
  TurnObliquely(image);
  return image;
}

vtkImageData* GetVolume(VolumeKind kind)
{
  static std::map<VolumeKind, vtkSmartPointer<vtkImageData>> volumes;
  vtkSmartPointer<vtkImageData>& volume = volumes[kind];
  if (!volume)
  {
    volume = MakeVolume(kind);
  }
  return volume;
}

const EdgeSurface& GetExpected(VolumeKind kind, double isovalue)
{
  static std::map<std::pair<VolumeKind, double>, EdgeSurface> surfaces;
  const auto key = std::make_pair(kind, isovalue);
  auto found = surfaces.find(key);
  if (found == surfaces.end())
  {
    found = surfaces.emplace(key, ContourByFlyingEdges(GetVolume(kind), isovalue)).first;
  }
  return found->second;
}

// Every store, distribution, block size; types and layouts take turns so that each of them meets
// all of those in some case.
std::vector<VolumeCase> MakeVolumeCases()
{
  std::vector<VolumeCase> cases;
  int turn = 0;
  for (const int stores : { 1, 4, 7 })
  {
    for (const int distribution : { 0, 1, 2 })
    {
      for (const int blockSize : { 16, 32, 64 })
      {
        const auto kind = static_cast<VolumeKind>((turn + turn / 3 + turn / 9) % 3);
        cases.push_back({ kind, { blockSize, stores, distribution }, turn % 4 });
        ++turn;
      }
    }
  }
  for (const VolumeKind kind : { TWO_CUBED, SMALL, FLAT_X, FLAT_Z })
  {
    for (const int layout : { 0, 1, 2, 3 })
    {
      cases.push_back({ kind, { 16, layout + 1, layout % 3 }, layout });
    }
  }
  return cases;
}

std::string NameOfCase(const testing::TestParamInfo<VolumeCase>& info)
{
  return info.param.GetName();
}

class SurfaceUnion : public testing::TestWithParam<VolumeCase>
{
protected:
  // Leaves the files' hash for runs of more ranks, or compares with what the run of one rank left.
  void CheckFingerprint(const std::string& path)
  {
    if (GetRank() != 0)
    {
      return;
    }
    const std::string hash = std::to_string(ComputeFingerprint(path));
    const std::string left = "fingerprints/" + GetParam().GetName();
    if (GetNumberOfRanks() == 1)
    {
      std::filesystem::create_directories("fingerprints");
      WriteBytes(left, hash);
    }
    EXPECT_EQ(hash, ReadBytes(left)) << "the files differ from those that one rank writes";
  }

  // The n-th isosurface of all ranks is that of the whole volume.
  void CheckUnion(vtkPolyData* mine, int number)
  {
    const double isovalue = GetIsovalues()[static_cast<std::size_t>(number)];
    const std::int64_t ids =
      3 * static_cast<std::int64_t>(GetVolume(GetParam().Kind)->GetNumberOfPoints());
    const EdgeSurface all = GatherSurface(mine, number * ids, (number + 1) * ids);
    if (GetRank() != 0)
    {
      return;
    }
    const auto twin = std::adjacent_find(all.Points.begin(), all.Points.end(),
      [](const EdgePoint& a, const EdgePoint& b) { return a.Edge == b.Edge; });
    EXPECT_EQ(twin, all.Points.end()) << "two ranks have different points of one GlobalId";
    EXPECT_TRUE(AreEqual(all, GetExpected(GetParam().Kind, isovalue))) << "at " << isovalue;
    if (GetParam().Kind <= BALL_FLOAT)
    {
      EXPECT_EQ(all.Triangles.empty(), isovalue > 1000);
      EXPECT_TRUE(IsClosedManifold(all)) << "at " << isovalue;
    }
  }

  void CheckScalars(vtkPolyData* mine)
  {
    vtkDataArray* scalars = mine->GetPointData()->GetScalars();
    vtkDataArray* ids = mine->GetPointData()->GetGlobalIds();
    EXPECT_TRUE(scalars && ids);
    const std::int64_t each =
      3 * static_cast<std::int64_t>(GetVolume(GetParam().Kind)->GetNumberOfPoints());
    vtkIdType wrong = 0;
    for (vtkIdType point = 0; scalars && ids && point < mine->GetNumberOfPoints(); ++point)
    {
      const auto number = static_cast<std::int64_t>(ids->GetComponent(point, 0)) / each;
      wrong +=
        scalars->GetTuple1(point) == GetIsovalues().at(static_cast<std::size_t>(number)) ? 0 : 1;
    }
    EXPECT_EQ(wrong, 0);
    if (scalars && mine->GetNumberOfPoints() > 0)
    {
      EXPECT_STREQ(scalars->GetName(), "density");
    }
  }
};

TEST_P(SurfaceUnion, EqualsSurfaceOfWholeVolume)
{
  const SharedFolder folder("SurfaceUnion-" + GetParam().GetName());
  const std::string path = folder.GetPath("volume.bvol");
  WriteFromPieces(GetVolume(GetParam().Kind), GetParam().Layout, path, GetParam().Settings);
  this->CheckFingerprint(path);

  ContourPipeline pipeline(path);
  vtkPolyData* mine = pipeline.Update(GetIsovalues());
  this->CheckScalars(mine);
  for (int number = 0; number < static_cast<int>(GetIsovalues().size()); ++number)
  {
    this->CheckUnion(mine, number);
  }
}

TEST(SurfaceUnionAtLevels, EqualsSurfaceOfSubsampledVolume)
{
  const SharedVolume volume("SurfaceUnionAtLevels", GetVolume(BALL_INT16), { 16, 3 });
  ContourPipeline pipeline(volume.Path);
  for (int level = 0; level < 8; ++level)
  {
    pipeline.Contour->SetLevel(level);
    SCOPED_TRACE("level " + std::to_string(level));
    ExpectSurfaceOf(pipeline.Update({ 150 }), SubsampleImage(GetVolume(BALL_INT16), level), 150);
  }
}

INSTANTIATE_TEST_SUITE_P(Cases, SurfaceUnion, testing::ValuesIn(MakeVolumeCases()), NameOfCase);

} // namespace
