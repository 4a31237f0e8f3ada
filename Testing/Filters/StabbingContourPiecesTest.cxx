// SPDX-License-Identifier: BSD-3-Clause
#include "TestImages.h"

#include "RectilinearFixtures.h"

#include "vtkContourSpectrum.h"

#include "vtkDataArray.h"
#include "vtkExtractVOI.h"
#include "vtkFieldData.h"
#include "vtkMultiBlockDataSet.h"
#include "vtkMultiPieceDataSet.h"
#include "vtkNew.h"
#include "vtkPartitionedDataSet.h"
#include "vtkPartitionedDataSetCollection.h"
#include "vtkPointData.h"
#include "vtkRTAnalyticSource.h"
#include "vtkRectilinearGrid.h"
#include "vtkStringArray.h"
#include "vtkTable.h"

#include <algorithm>
#include <cmath>

using namespace isosurface;

namespace
{

constexpr Extent Whole{ -7, 40, 3, 37, 0, 33 };

// Noise within, 0 on the faces: whatever is inside is closed.
Field MakeClosedNoise(const Extent& extent)
{
  return [extent, noise = MakeNoise(100, 21)](int i, int j, int k) mutable
  {
    const double value = noise(i, j, k);
    const bool onFace = i == extent[0] || i == extent[1] || j == extent[2] || j == extent[3] ||
      k == extent[4] || k == extent[5];
    return onFace ? 0.0 : value;
  };
}

vtkSmartPointer<vtkImageData> MakeWhole()
{
  const auto image = MakeImage(Whole, VTK_FLOAT, MakeClosedNoise(Whole));
  image->SetOrigin(0.1, -7.7, 23.0);
  image->SetSpacing(0.3, 1.1, 2.7);
  return image;
}

// Boxes of cells that fill the extent: 3 x 2 x 2, of unequal sizes.
std::vector<Extent> CutExtent(const Extent& extent)
{
  const std::vector<int> cuts[3] = { { extent[0], extent[0] + 5, extent[0] + 38, extent[1] },
    { extent[2], extent[2] + 1, extent[3] }, { extent[4], extent[4] + 17, extent[5] } };
  std::vector<Extent> parts;
  for (std::size_t k = 0; k + 1 < cuts[2].size(); ++k)
  {
    for (std::size_t j = 0; j + 1 < cuts[1].size(); ++j)
    {
      for (std::size_t i = 0; i + 1 < cuts[0].size(); ++i)
      {
        parts.push_back(
          { cuts[0][i], cuts[0][i + 1], cuts[1][j], cuts[1][j + 1], cuts[2][k], cuts[2][k + 1] });
      }
    }
  }
  return parts;
}

// One more layer on every side that has one.
Extent Grow(Extent part, const Extent& whole)
{
  for (int axis = 0; axis < 3; ++axis)
  {
    part[2 * axis] = std::max(part[2 * axis] - 1, whole[2 * axis]);
    part[2 * axis + 1] = std::min(part[2 * axis + 1] + 1, whole[2 * axis + 1]);
  }
  return part;
}

std::vector<vtkSmartPointer<vtkImageData>> CutIntoPiecesWithGhosts(vtkImageData* image)
{
  std::vector<vtkSmartPointer<vtkImageData>> pieces;
  Extent whole;
  image->GetExtent(whole.data());
  for (const Extent& part : CutExtent(whole))
  {
    pieces.push_back(CutImage(image, Grow(part, whole), part));
  }
  return pieces;
}

vtkSmartPointer<vtkPartitionedDataSet> JoinPiecesWithGhosts(vtkImageData* image)
{
  auto pieces = vtkSmartPointer<vtkPartitionedDataSet>::New();
  for (const auto& piece : CutIntoPiecesWithGhosts(image))
  {
    pieces->SetPartition(pieces->GetNumberOfPartitions(), piece);
  }
  return pieces;
}

// The surface of the pieces of an image must be that of the image, bit for bit.
void ExpectWholeSurface(vtkDataObject* pieces, vtkImageData* whole)
{
  const auto output = Contour(pieces, { 50.5 });
  ExpectDistinctIds(output);
  EXPECT_TRUE(AreEqual(ToEdges(output), ContourToEdges(whole, 50.5)));
}

} // namespace

TEST(StabbingContourPieces, GlobalIdsAreTheGridEdgesOfThePoints)
{
  const Extent extent{ -3, 35, 5, 20, 0, 33 };
  const auto image = MakeImage(extent, VTK_FLOAT, MakeWaves());
  const auto output = Contour(image, { 0.1234 });
  vtkDataArray* ids = output->GetPointData()->GetGlobalIds();
  ASSERT_GT(output->GetNumberOfPoints(), 0);
  for (vtkIdType point = 0; point < output->GetNumberOfPoints(); ++point)
  {
    const double* position = output->GetPoint(point);
    int vertex[3];
    int axis = -1;
    for (int n = 0; n < 3; ++n)
    {
      vertex[n] = static_cast<int>(std::floor(position[n]));
      if (position[n] != vertex[n])
      {
        ASSERT_EQ(axis, -1);
        axis = n;
      }
    }
    ASSERT_NE(axis, -1);
    ASSERT_EQ(
      static_cast<vtkIdType>(ids->GetTuple1(point)), 3 * image->ComputePointId(vertex) + axis);
  }
}

TEST(StabbingContourPieces, SurfaceOfClosedInputIsAClosedManifold)
{
  for (const int type : { VTK_UNSIGNED_CHAR, VTK_FLOAT })
  {
    const auto image = MakeImage(Whole, type, MakeClosedNoise(Whole));
    for (const double isovalue : { 20.0, 50.5, 90.0 })
    {
      const EdgeSurface surface = ContourToEdges(image, isovalue);
      EXPECT_FALSE(surface.Triangles.empty());
      EXPECT_TRUE(IsClosedManifold(surface));
    }
  }
}

// The source gives any piece, with ghost levels if they are asked for.
TEST(StabbingContourPieces, AnyNumberOfUpdatePiecesGivesTheWholeSurface)
{
  vtkNew<vtkRTAnalyticSource> source;
  source->SetWholeExtent(-20, 21, -13, 27, -9, 30);
  source->Update();
  vtkNew<vtkImageData> whole;
  whole->DeepCopy(source->GetOutput());
  EdgeSurface expected = ContourByFlyingEdges(whole, 157.0);
  const auto contour = MakeContour(source, 157.0);
  const ExpectNoErrors errors(contour);
  const auto expectWhole = [&](int pieces, int ghosts)
  {
    EdgeSurface surface;
    for (int piece = 0; piece < pieces; ++piece)
    {
      contour->UpdatePiece(piece, pieces, ghosts);
      surface.Add(contour->GetOutput());
    }
    surface.MergeEqualPoints();
    EXPECT_TRUE(AreEqual(surface, expected)) << pieces << " pieces, " << ghosts << " ghosts";
  };
  for (int pieces = 1; pieces <= 7; ++pieces)
  {
    expectWhole(pieces, 0);
    expectWhole(pieces, 1);
  }
  contour->ComputeNormalsOff();
  expected.DropNormals();
  expectWhole(5, 0);
}

// A cut-out knows its extent in the whole, but nothing of the samples beyond it: normals differ
// where it ends.
TEST(StabbingContourPieces, AdjacentExtentsGiveTheWholeSurface)
{
  const auto whole = MakeWhole();
  vtkNew<vtkPartitionedDataSet> pieces;
  for (Extent part : CutExtent(Whole))
  {
    vtkNew<vtkExtractVOI> cutOut;
    cutOut->SetInputData(whole);
    cutOut->SetVOI(part.data());
    cutOut->Update();
    pieces->SetPartition(pieces->GetNumberOfPartitions(), cutOut->GetOutput());
  }
  const std::vector<double> isovalues{ 50.5, 70.0 };
  const auto output = Contour(pieces, isovalues);
  ExpectDistinctIds(output);
  const vtkIdType edges = 3 * whole->GetNumberOfPoints();
  for (int number = 0; number < 2; ++number)
  {
    EdgeSurface expected = ContourByFlyingEdges(whole, isovalues[number]);
    expected.DropNormals();
    EdgeSurface surface = ToEdges(output, number * edges, (number + 1) * edges);
    surface.DropNormals();
    EXPECT_TRUE(AreEqual(surface, expected));
    EXPECT_TRUE(IsClosedManifold(surface));
  }
}

// As vtkFlyingEdges3D makes them of the piece alone.
TEST(StabbingContourPieces, NormalsWhereExtentsEndAreOneSided)
{
  const Extent extent{ 0, 20, 0, 20, 0, 20 };
  const auto whole = MakeImage(extent, VTK_FLOAT, MakeWaves());
  const Extent low{ 0, 10, 0, 20, 0, 20 };
  vtkNew<vtkPartitionedDataSet> pieces;
  pieces->SetPartition(0, CutImage(whole, low));
  pieces->SetPartition(1, CutImage(whole, { 12, 20, 0, 20, 0, 20 }));
  const auto alone = CutImage(whole, low);
  EdgeSurface expected = ContourByFlyingEdges(alone, 0.1);
  EdgeSurface surface = ToEdges(Contour(pieces, { 0.1 }));
  std::size_t found = 0;
  for (const EdgePoint& point : surface.Points)
  {
    found += std::any_of(expected.Points.begin(), expected.Points.end(),
      [&](const EdgePoint& other)
      { return other.Position == point.Position && other.Normal == point.Normal; });
  }
  EXPECT_EQ(found, expected.Points.size());
}

TEST(StabbingContourPieces, PartitionedDataSetEqualsTheWholeImage)
{
  const auto whole = MakeWhole();
  ExpectWholeSurface(JoinPiecesWithGhosts(whole), whole);
}

TEST(StabbingContourPieces, MultiBlockDataSetEqualsTheWholeImage)
{
  const auto whole = MakeWhole();
  vtkNew<vtkMultiBlockDataSet> blocks;
  for (const auto& piece : CutIntoPiecesWithGhosts(whole))
  {
    blocks->SetBlock(blocks->GetNumberOfBlocks() + 1, piece); // every other one is empty
  }
  ExpectWholeSurface(blocks, whole);
}

// Normals, too: each image needs the samples of its neighbours, which it does not have.
TEST(StabbingContourPieces, ImagesThatMeetWithoutGhostLayersEqualTheWholeImage)
{
  const auto whole = MakeWhole();
  vtkNew<vtkMultiBlockDataSet> blocks;
  for (const Extent& part : CutExtent(Whole))
  {
    blocks->SetBlock(blocks->GetNumberOfBlocks(), CutImage(whole, part));
  }
  ExpectWholeSurface(blocks, whole);
}

// The images on one side of the seam are smaller, and one of them is not there.
TEST(StabbingContourPieces, NormalsAreOneSidedWhereNoImageMeets)
{
  const auto whole = MakeImage(
    { 0, 40, 0, 40, 0, 33 }, VTK_FLOAT, [](int i, int j, int k) { return 2.0 * i - j + 2.0 * k; });
  vtkNew<vtkMultiBlockDataSet> blocks;
  const Extent parts[] = { { 0, 20, 0, 40, 0, 33 }, { 20, 40, 0, 13, 0, 33 },
    { 20, 40, 13, 40, 0, 11 } };
  for (unsigned int n = 0; n < 3; ++n)
  {
    blocks->SetBlock(n, CutImage(whole, parts[n]));
  }
  const auto surface = Contour(blocks, { 30.25 });
  ExpectNormal(surface, { -2.0 / 3, 1.0 / 3, -2.0 / 3 });
}

TEST(StabbingContourPieces, NestedCompositesEqualTheWholeImage)
{
  const auto whole = MakeWhole();
  vtkNew<vtkMultiBlockDataSet> blocks;
  vtkNew<vtkPartitionedDataSetCollection> collection;
  for (const auto& piece : CutIntoPiecesWithGhosts(whole))
  {
    const unsigned int number = collection->GetNumberOfPartitionedDataSets();
    collection->SetPartition(number, 0, piece);
    vtkNew<vtkMultiPieceDataSet> nested;
    nested->SetPiece(1, piece);
    vtkNew<vtkMultiBlockDataSet> outer;
    outer->SetBlock(0, nested);
    blocks->SetBlock(number, outer);
  }
  ExpectWholeSurface(blocks, whole);
  ExpectWholeSurface(collection, whole);
}

// Pieces without a surface, first and last ones included.
TEST(StabbingContourPieces, PiecesWithoutSurfaceDoNotMatter)
{
  const auto whole =
    MakeImage(Whole, VTK_FLOAT, [](int i, int, int) { return i > 8 && i < 12 ? 100.0 : 0.0; });
  const auto pieces = JoinPiecesWithGhosts(whole);
  ExpectWholeSurface(pieces, whole);
  EXPECT_EQ(Contour(pieces, { 200.0 })->GetNumberOfPoints(), 0);
}

TEST(StabbingContourPieces, CompositeWithoutImagesHasNoSurface)
{
  vtkNew<vtkPartitionedDataSet> pieces;
  EXPECT_EQ(Contour(pieces, { 50.5 })->GetNumberOfPoints(), 0);
  pieces->SetPartition(3, vtkNew<vtkImageData>());
  EXPECT_EQ(Contour(pieces, { 50.5 })->GetNumberOfPoints(), 0);
}

TEST(StabbingContourPieces, SeveralIsovaluesOfACompositeEqualThoseOfTheWholeImage)
{
  const auto whole = MakeWhole();
  const auto pieces = JoinPiecesWithGhosts(whole);
  const auto output = Contour(pieces, { 80.0, 30.5 });
  ExpectDistinctIds(output);
  const vtkIdType edges = 3 * whole->GetNumberOfPoints();
  EXPECT_TRUE(AreEqual(ToEdges(output, 0, edges), ContourToEdges(whole, 80.0)));
  EXPECT_TRUE(AreEqual(ToEdges(output, edges, 2 * edges), ContourToEdges(whole, 30.5)));
}

TEST(StabbingContourPieces, ImagesOfDifferentSpacingHaveConsecutiveIds)
{
  const auto coarse = MakeImage(Whole, VTK_FLOAT, MakeClosedNoise(Whole));
  coarse->SetSpacing(2.0, 2.0, 2.0);
  const Extent extent{ 0, 20, 0, 20, 0, 40 };
  const auto fine = MakeImage(extent, VTK_SHORT, MakeClosedNoise(extent));
  vtkNew<vtkMultiBlockDataSet> blocks;
  blocks->SetBlock(0, coarse);
  blocks->SetBlock(1, fine);
  const auto output = Contour(blocks, { 50.5 });
  ExpectDistinctIds(output);
  const vtkIdType fineEdges = 3 * fine->GetNumberOfPoints();
  EXPECT_TRUE(AreEqual(ToEdges(output, 0, fineEdges), ContourToEdges(fine, 50.5)));
  EXPECT_TRUE(AreEqual(ToEdges(output, fineEdges), ContourToEdges(coarse, 50.5)));
}

//------------------------------------------------------------------------------
// Images of one grid that are not parts of one field

namespace
{

vtkSmartPointer<vtkMultiBlockDataSet> GroupNamed(
  const std::vector<std::pair<const char*, vtkDataSet*>>& members)
{
  auto group = vtkSmartPointer<vtkMultiBlockDataSet>::New();
  for (const auto& [name, member] : members)
  {
    const unsigned int number = group->GetNumberOfBlocks();
    group->SetBlock(number, member);
    group->GetMetaData(number)->Set(vtkCompositeDataSet::NAME(), name);
  }
  return group;
}

vtkSmartPointer<vtkStabbingContour> FindIslands(vtkDataObject* input, double isovalue)
{
  const auto contour = MakeContour(input, isovalue);
  contour->ComputeIslandIdsOn();
  contour->Update();
  return contour;
}

double CountIslands(vtkStabbingContour* contour)
{
  return contour->GetOutput()->GetFieldData()->GetArray("Islands")->GetTuple1(0);
}

// Waves, from a phase of one's own.
vtkSmartPointer<vtkImageData> MakeMember(int phase, const Extent& extent = Whole)
{
  return MakeImage(extent, VTK_FLOAT,
    [phase, waves = MakeWaves(100.0)](int i, int j, int k) { return waves(i + phase, j, k); });
}

// Each block's triangles, points, normals and islands are those that it has alone.
void ExpectSurfacesOfBlocks(vtkMultiBlockDataSet* group)
{
  const auto contour = FindIslands(group, 8.0);
  vtkPolyData* surface = contour->GetOutput();
  ExpectDistinctIds(surface);
  vtkDataArray* blocks = surface->GetPointData()->GetArray("BlockIds");
  auto* names =
    vtkStringArray::SafeDownCast(surface->GetFieldData()->GetAbstractArray("BlockNames"));
  ASSERT_TRUE(blocks && names);
  ASSERT_EQ(names->GetNumberOfValues(), group->GetNumberOfBlocks());
  std::int64_t firstId = 0;
  double islands = 0;
  for (unsigned int number = 0; number < group->GetNumberOfBlocks(); ++number)
  {
    auto* image = vtkDataSet::SafeDownCast(group->GetBlock(number));
    const std::int64_t nextId = firstId + 3 * image->GetNumberOfPoints();
    EXPECT_TRUE(AreEqual(ToEdges(surface, firstId, nextId), ContourToEdges(image, 8.0)))
      << "block " << number;
    firstId = nextId;
    islands += CountIslands(FindIslands(image, 8.0));
    EXPECT_EQ(
      names->GetValue(number), group->GetMetaData(number)->Get(vtkCompositeDataSet::NAME()));
  }
  EXPECT_EQ(surface->GetPointData()->GetGlobalIds()->GetRange()[1] < firstId, true);
  EXPECT_EQ(CountIslands(contour), islands);
  EXPECT_EQ(blocks->GetRange()[1], group->GetNumberOfBlocks() - 1.0);
}

} // namespace

TEST(StabbingContourMembers, OfAnEnsembleKeepTheirSurfacesIslandsAndNames)
{
  const auto first = MakeMember(0);
  const auto second = MakeMember(5);
  ExpectSurfacesOfBlocks(GroupNamed({ { "first", first }, { "second", second } }));
}

TEST(StabbingContourMembers, OnRectilinearGridsKeepTheirs)
{
  const auto first = MakeLinedGrid(MakeMember(0));
  const auto second = MakeLinedGrid(MakeMember(5));
  ExpectSurfacesOfBlocks(GroupNamed({ { "first", first }, { "second", second } }));
}

TEST(StabbingContourMembers, ThatAreTheSameImageTwiceAreTwoSurfaces)
{
  const auto image = MakeMember(0);
  vtkNew<vtkImageData> copy;
  copy->DeepCopy(image);
  ExpectSurfacesOfBlocks(GroupNamed({ { "a", image }, { "copy", copy }, { "again", image } }));
}

TEST(StabbingContourMembers, WithOtherSamplesWhereTheyMeetAreNotJoined)
{
  const auto left = MakeMember(0, { -7, 20, 3, 37, 0, 33 });
  const auto right = MakeMember(3, { 20, 40, 3, 37, 0, 33 });
  ExpectSurfacesOfBlocks(GroupNamed({ { "left", left }, { "right", right } }));
}

TEST(StabbingContourMembers, AreClosedOneByOne)
{
  const auto left = MakeMember(0, { -7, 20, 3, 37, 0, 33 });
  const auto right = MakeMember(3, { 20, 40, 3, 37, 0, 33 });
  vtkIdType expected = 0;
  vtkIdType triangles = 0;
  const auto group = GroupNamed({ { "left", left }, { "right", right } });
  for (vtkDataObject* input : { static_cast<vtkDataObject*>(left),
         static_cast<vtkDataObject*>(right), static_cast<vtkDataObject*>(group) })
  {
    const auto contour = MakeContour(input, 8.0);
    contour->CloseBoundaryOn();
    contour->Update();
    EXPECT_TRUE(IsClosed(ToEdges(contour->GetOutput())));
    triangles = contour->GetOutput()->GetNumberOfCells();
    expected += input == group.Get() ? 0 : triangles;
  }
  EXPECT_EQ(triangles, expected);
}

// Ghost cells that are not marked, as in files.
TEST(StabbingContourMembers, ThatOverlapWithEqualSamplesAreOneGridContouredOnce)
{
  const auto whole = MakeWhole();
  const auto left = CutImage(whole, { -7, 22, 3, 37, 0, 33 });
  const auto right = CutImage(whole, { 19, 40, 3, 37, 0, 33 });
  const auto group = GroupNamed({ { "left", left }, { "right", right } });
  ExpectWholeSurface(group, whole);
  EXPECT_EQ(
    Contour(group, { 50.5 })->GetNumberOfCells(), Contour(whole, { 50.5 })->GetNumberOfCells());
}

TEST(StabbingContourMembers, AreCountedOneByOneInTheSpectrum)
{
  const auto image = MakeMember(0);
  vtkNew<vtkContourSpectrum> alone;
  alone->SetInputDataObject(image);
  alone->Update();
  vtkNew<vtkContourSpectrum> both;
  both->SetInputDataObject(GroupNamed({ { "a", image }, { "b", image } }));
  both->Update();
  vtkTable* expected = alone->GetOutput();
  vtkTable* found = both->GetOutput();
  ASSERT_EQ(found->GetNumberOfRows(), expected->GetNumberOfRows());
  ASSERT_GT(found->GetNumberOfRows(), 0);
  for (vtkIdType row = 0; row < found->GetNumberOfRows(); ++row)
  {
    EXPECT_EQ(found->GetValueByName(row, "Triangles").ToDouble(),
      2 * expected->GetValueByName(row, "Triangles").ToDouble());
  }
}
