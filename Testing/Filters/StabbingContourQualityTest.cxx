// SPDX-License-Identifier: BSD-3-Clause
// Interpolated arrays, degenerate triangles, closed surfaces, regions.
#include "TestImages.h"

#include "vtkCamera.h"
#include "vtkCellArray.h"
#include "vtkCellArrayIterator.h"
#include "vtkCleanPolyData.h"
#include "vtkDataArray.h"
#include "vtkDoubleArray.h"
#include "vtkExecutive.h"
#include "vtkFieldData.h"
#include "vtkFloatArray.h"
#include "vtkFlyingEdges3D.h"
#include "vtkImageConstantPad.h"
#include "vtkMassProperties.h"
#include "vtkMath.h"
#include "vtkMatrix3x3.h"
#include "vtkNew.h"
#include "vtkPartitionedDataSet.h"
#include "vtkPlanes.h"
#include "vtkPointData.h"
#include "vtkPoints.h"
#include "vtkShortArray.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>

using namespace isosurface;

namespace
{

constexpr Extent QualityGrid{ -5, 40, 2, 37, 0, 20 };

using Place = std::array<double, 3>;
using Triangles = std::vector<std::array<Place, 3>>;

Place GetPlace(vtkPolyData* surface, vtkIdType point)
{
  Place place;
  surface->GetPoint(point, place.data());
  return place;
}

/// The triangles by the places of their corners, sorted; those of two equal corners on demand.
Triangles ListTriangles(vtkPolyData* surface, bool degenerate)
{
  Triangles list;
  const auto cells = vtk::TakeSmartPointer(surface->GetPolys()->NewIterator());
  for (cells->GoToFirstCell(); !cells->IsDoneWithTraversal(); cells->GoToNextCell())
  {
    vtkIdType size = 0;
    const vtkIdType* points = nullptr;
    cells->GetCurrentCell(size, points);
    if (size < 3)
    {
      continue; // what vtkCleanPolyData makes of degenerate ones
    }
    std::array<Place, 3> corners{ GetPlace(surface, points[0]), GetPlace(surface, points[1]),
      GetPlace(surface, points[2]) };
    std::rotate(corners.begin(), std::min_element(corners.begin(), corners.end()), corners.end());
    const std::set<Place> distinct(corners.begin(), corners.end());
    if (degenerate || distinct.size() == 3)
    {
      list.push_back(corners);
    }
  }
  std::sort(list.begin(), list.end());
  return list;
}

/// A ball around the low corner of the grid, of which an eighth lies within.
Field MakeEighthOfBall()
{
  return [](int i, int j, int k)
  { return 25.0 - std::sqrt(std::pow(i + 5, 2) + std::pow(j - 2, 2) + std::pow(1.5 * k, 2)); };
}

/// vtkFlyingEdges3D on the image with a layer around it that is outside, whose points are moved
/// back into the image. For images at the world's axes.
vtkSmartPointer<vtkPolyData> CloseByPadding(vtkImageData* image, double isovalue)
{
  int extent[6];
  image->GetExtent(extent);
  vtkNew<vtkImageConstantPad> pad;
  pad->SetInputData(image);
  pad->SetOutputWholeExtent(
    extent[0] - 1, extent[1] + 1, extent[2] - 1, extent[3] + 1, extent[4] - 1, extent[5] + 1);
  pad->SetConstant(-1e6);
  pad->Update();
  const auto surface = RunFlyingEdges(pad->GetOutput(), isovalue, false);
  double bounds[6];
  image->GetBounds(bounds);
  for (vtkIdType point = 0; point < surface->GetNumberOfPoints(); ++point)
  {
    Place place = GetPlace(surface, point);
    for (std::size_t axis = 0; axis < 3; ++axis)
    {
      place[axis] = std::min(std::max(place[axis], bounds[2 * axis]), bounds[2 * axis + 1]);
    }
    surface->GetPoints()->SetPoint(point, place.data());
  }
  return surface;
}

/// Three arrays beside the scalars: a vector of floats, doubles and shorts.
void AddArrays(vtkImageData* image)
{
  const vtkIdType count = image->GetNumberOfPoints();
  vtkNew<vtkFloatArray> vectors;
  vectors->SetName("velocity");
  vectors->SetNumberOfComponents(3);
  vectors->SetNumberOfTuples(count);
  vectors->SetComponentName(1, "upwards");
  vtkNew<vtkDoubleArray> doubles;
  doubles->SetName("pressure");
  doubles->SetNumberOfTuples(count);
  vtkNew<vtkShortArray> shorts;
  shorts->SetName("label");
  shorts->SetNumberOfTuples(count);
  for (vtkIdType n = 0; n < count; ++n)
  {
    const double x = static_cast<double>(n);
    vectors->SetTuple3(n, std::sin(x), std::cos(0.01 * x), 1e6 * std::sin(0.3 * x));
    doubles->SetValue(n, std::sin(0.37 * x));
    shorts->SetValue(n, static_cast<short>(1000 * std::sin(0.11 * x)));
  }
  image->GetPointData()->AddArray(vectors);
  image->GetPointData()->AddArray(doubles);
  image->GetPointData()->AddArray(shorts);
}

vtkSmartPointer<vtkPolyData> UpdateContour(vtkStabbingContour* contour)
{
  const ExpectNoErrors errors(contour);
  contour->Update();
  return contour->GetOutput();
}

void ExpectError(vtkStabbingContour* contour, const std::string& words)
{
  const ErrorCounter errors(contour);
  contour->Update();
  ExpectOneError(errors, { words });
  EXPECT_EQ(contour->GetOutput()->GetNumberOfPoints(), 0);
}

/// The image in boxes of 2 x 2 x 2, with or without ghosts around each.
vtkSmartPointer<vtkPartitionedDataSet> CutIntoPieces(vtkImageData* image, bool ghosts)
{
  const auto pieces = vtkSmartPointer<vtkPartitionedDataSet>::New();
  Extent whole;
  image->GetExtent(whole.data());
  for (int part = 0; part < 8; ++part)
  {
    Extent own = whole;
    for (int axis = 0; axis < 3; ++axis)
    {
      const int middle = (whole[2 * axis] + whole[2 * axis + 1]) / 2 + axis;
      own[2 * axis + ((part >> axis & 1) == 0 ? 1 : 0)] = middle;
    }
    Extent grown = own;
    for (int axis = 0; axis < 3; ++axis)
    {
      grown[2 * axis] = std::max(whole[2 * axis], own[2 * axis] - 1);
      grown[2 * axis + 1] = std::min(whole[2 * axis + 1], own[2 * axis + 1] + 1);
    }
    pieces->SetPartition(
      static_cast<unsigned int>(part), ghosts ? CutImage(image, grown, own) : CutImage(image, own));
  }
  return pieces;
}

} // namespace

TEST(StabbingContourQuality, InterpolatedArraysAreThoseOfFlyingEdges)
{
  const auto image = MakeImage(QualityGrid, VTK_FLOAT, MakeWaves());
  AddArrays(image);
  const auto contour = MakeContour(image, 0.123);
  for (const char* name : { "label", "velocity", "pressure", "density" })
  {
    contour->AddInterpolatedArray(name);
  }
  const auto surface = UpdateContour(contour);
  vtkNew<vtkFlyingEdges3D> edges;
  edges->SetInputData(image);
  edges->SetValue(0, 0.123);
  edges->InterpolateAttributesOn();
  edges->Update();
  vtkPolyData* expected = edges->GetOutput();
  std::map<Place, vtkIdType> points;
  for (vtkIdType point = 0; point < expected->GetNumberOfPoints(); ++point)
  {
    points[GetPlace(expected, point)] = point;
  }
  ASSERT_EQ(points.size(), static_cast<std::size_t>(surface->GetNumberOfPoints()));
  EXPECT_EQ(surface->GetPointData()->GetNumberOfArrays(), 6);
  EXPECT_STREQ(surface->GetPointData()->GetArray("velocity")->GetComponentName(1), "upwards");
  for (const char* name : { "label", "velocity", "pressure" })
  {
    vtkDataArray* ours = surface->GetPointData()->GetArray(name);
    vtkDataArray* theirs = expected->GetPointData()->GetArray(name);
    ASSERT_NE(ours, nullptr) << name;
    EXPECT_EQ(ours->GetDataType(), theirs->GetDataType()) << name;
    ASSERT_EQ(ours->GetNumberOfComponents(), theirs->GetNumberOfComponents()) << name;
    for (vtkIdType point = 0; point < surface->GetNumberOfPoints(); ++point)
    {
      for (int component = 0; component < ours->GetNumberOfComponents(); ++component)
      {
        const double value = theirs->GetComponent(points.at(GetPlace(surface, point)), component);
        ASSERT_NEAR(ours->GetComponent(point, component), value, 1e-6 * std::abs(value)) << name;
      }
    }
  }
}

TEST(StabbingContourQuality, ContouredArrayItselfIsTheIsovalue)
{
  const auto image = MakeImage(QualityGrid, VTK_FLOAT, MakeWaves());
  const auto contour = MakeContour(image, 0.123);
  contour->ComputeScalarsOff();
  contour->AddInterpolatedArray("density");
  vtkSmartPointer<vtkPolyData> surface = UpdateContour(contour);
  vtkDataArray* density = surface->GetPointData()->GetArray("density");
  ASSERT_NE(density, nullptr);
  EXPECT_EQ(surface->GetPointData()->GetScalars(), nullptr);
  for (vtkIdType point = 0; point < surface->GetNumberOfPoints(); ++point)
  {
    ASSERT_NEAR(density->GetTuple1(point), 0.123, 1e-6);
  }
  contour->RemoveAllInterpolatedArrays();
  EXPECT_EQ(UpdateContour(contour)->GetPointData()->GetArray("density"), nullptr);
}

TEST(StabbingContourQuality, ArraysOfPiecesAreThoseOfTheWhole)
{
  const auto image = MakeImage(QualityGrid, VTK_FLOAT, MakeWaves());
  vtkNew<vtkStabbingContour> contour;
  contour->SetValue(0, 0.123);
  contour->ComputeScalarsOff();
  contour->AddInterpolatedArray("density");
  for (const bool ghosts : { true, false })
  {
    contour->SetInputDataObject(CutIntoPieces(image, ghosts));
    const auto surface = UpdateContour(contour);
    vtkDataArray* density = surface->GetPointData()->GetArray("density");
    ASSERT_EQ(density->GetNumberOfTuples(), surface->GetNumberOfPoints());
    for (vtkIdType point = 0; point < surface->GetNumberOfPoints(); ++point)
    {
      ASSERT_NEAR(density->GetTuple1(point), 0.123, 1e-6);
    }
  }
}

TEST(StabbingContourQuality, ArraysThatCannotBeInterpolatedAreTold)
{
  const auto image = MakeImage(QualityGrid, VTK_FLOAT, MakeWaves());
  const auto contour = MakeContour(image, 0.123);
  contour->AddInterpolatedArray("temperature");
  ExpectError(contour, "\"temperature\"");

  const auto pieces = CutIntoPieces(image, true);
  for (unsigned int piece = 0; piece < 8; ++piece)
  {
    auto* part = vtkImageData::SafeDownCast(pieces->GetPartition(piece));
    vtkSmartPointer<vtkDataArray> array;
    if (piece == 5)
    {
      array = vtkSmartPointer<vtkShortArray>::New();
    }
    else
    {
      array = vtkSmartPointer<vtkDoubleArray>::New();
    }
    array->SetName("temperature");
    array->SetNumberOfTuples(part->GetNumberOfPoints());
    array->Fill(1.0);
    part->GetPointData()->AddArray(array);
  }
  contour->SetInputDataObject(pieces);
  ExpectError(contour, "types");
  vtkImageData::SafeDownCast(pieces->GetPartition(5))->GetPointData()->RemoveArray("temperature");
  pieces->Modified();
  ExpectError(contour, "\"temperature\"");
}

TEST(StabbingContourQuality, TrianglesLeftAreThoseThatAreNotDegenerateInVTK)
{
  const auto image = MakeImage(QualityGrid, VTK_SHORT, MakeNoise(6, 3));
  image->SetOrigin(0.1, 7.0, -3.0);
  image->SetSpacing(0.5, 1.25, 2.0);
  vtkNew<vtkStabbingContour> contour;
  contour->SetValue(0, 3.0);
  contour->DropDegenerateTrianglesOn();
  vtkNew<vtkCleanPolyData> clean;
  clean->SetInputData(RunFlyingEdges(image, 3.0, false));
  clean->ToleranceIsAbsoluteOn();
  clean->SetAbsoluteTolerance(0.0);
  clean->ConvertPolysToLinesOff();
  clean->Update();
  const Triangles expected = ListTriangles(clean->GetOutput(), false);
  EXPECT_LT(expected.size(), ListTriangles(RunFlyingEdges(image, 3.0, false), true).size());
  contour->SetInputData(image);
  EXPECT_EQ(ListTriangles(UpdateContour(contour), true), expected);
  for (const bool ghosts : { true, false })
  {
    contour->SetInputDataObject(CutIntoPieces(image, ghosts));
    const auto surface = UpdateContour(contour);
    EXPECT_EQ(ListTriangles(surface, true), expected);
    std::set<Place> places;
    for (vtkIdType point = 0; point < surface->GetNumberOfPoints(); ++point)
    {
      places.insert(GetPlace(surface, point));
    }
    EXPECT_EQ(places.size(), static_cast<std::size_t>(surface->GetNumberOfPoints()));
  }
}

TEST(StabbingContourQuality, ClosedSurfaceIsThatOfThePaddedImage)
{
  for (const Field& field : { MakeWaves(20.0), MakeNoise(50, 9), MakeEighthOfBall() })
  {
    const auto image = MakeImage(QualityGrid, VTK_DOUBLE, field);
    const Triangles expected = ListTriangles(CloseByPadding(image, 7.25), false);
    vtkNew<vtkStabbingContour> contour;
    contour->SetValue(0, 7.25);
    contour->CloseBoundaryOn();
    contour->SetInputData(image);
    const auto surface = UpdateContour(contour);
    EXPECT_EQ(ListTriangles(surface, false), expected);
    EXPECT_TRUE(IsClosed(ToEdges(surface)));
    std::map<double, Place> places;
    for (vtkIdType point = 0; point < surface->GetNumberOfPoints(); ++point)
    {
      places[surface->GetPointData()->GetGlobalIds()->GetTuple1(point)] = GetPlace(surface, point);
    }
    // Pieces, even those that must do without ghosts, have the same points under the same ids.
    for (const bool ghosts : { true, false })
    {
      contour->SetInputDataObject(CutIntoPieces(image, ghosts));
      const auto ofPieces = UpdateContour(contour);
      EXPECT_EQ(ListTriangles(ofPieces, true), expected);
      ASSERT_EQ(ofPieces->GetNumberOfPoints(), surface->GetNumberOfPoints());
      for (vtkIdType point = 0; point < ofPieces->GetNumberOfPoints(); ++point)
      {
        const double id = ofPieces->GetPointData()->GetGlobalIds()->GetTuple1(point);
        ASSERT_EQ(places.at(id), GetPlace(ofPieces, point));
      }
    }
  }
}

TEST(StabbingContourQuality, ClosedSurfaceWithoutDegenerateTrianglesEnclosesTheVolume)
{
  const auto image = MakeImage(QualityGrid, VTK_FLOAT, MakeEighthOfBall());
  const auto contour = MakeContour(image, 5.0);
  contour->CloseBoundaryOn();
  contour->DropDegenerateTrianglesOn();
  const auto surface = UpdateContour(contour);
  EXPECT_EQ(
    ListTriangles(surface, false).size(), static_cast<std::size_t>(surface->GetNumberOfCells()));
  EXPECT_TRUE(IsClosed(ToEdges(surface)));
  vtkNew<vtkMassProperties> mass;
  mass->SetInputData(surface);
  mass->Update();
  // An ellipsoid of half axes 20, 20 and 20 / 1.5; chords cut off a little.
  const double volume = vtkMath::Pi() / 6 * 20 * 20 * 20 / 1.5;
  EXPECT_NEAR(mass->GetVolume(), volume, 0.01 * volume);
  EXPECT_LT(mass->GetVolume(), volume);

  contour->CloseBoundaryOff();
  EXPECT_FALSE(IsClosed(ToEdges(UpdateContour(contour))));
}

TEST(StabbingContourQuality, PoresAreClosedOnTheSideBelow)
{
  // The eighth of a ball is hollow: what is below is the rest of the box.
  const auto image = MakeImage(QualityGrid, VTK_FLOAT, MakeEighthOfBall());
  const auto contour = MakeContour(image, 5.0);
  contour->CloseBoundaryOn();
  double volumes[2] = {};
  for (const int inside : { vtkStabbingContour::ABOVE, vtkStabbingContour::BELOW })
  {
    contour->SetInside(inside);
    const auto surface = UpdateContour(contour);
    EXPECT_TRUE(IsClosed(ToEdges(surface)));
    EXPECT_EQ(
      ListTriangles(surface, false).size(), static_cast<std::size_t>(surface->GetNumberOfCells()));
    contour->ComputeIslandIdsOn();
    contour->SetIslandSize(vtkStabbingContour::VOLUME);
    volumes[inside] =
      UpdateContour(contour)->GetFieldData()->GetArray("IslandVolume")->GetTuple1(0);
    contour->ComputeIslandIdsOff();
  }
  double bounds[6];
  image->GetBounds(bounds);
  const double all = (bounds[1] - bounds[0]) * (bounds[3] - bounds[2]) * (bounds[5] - bounds[4]);
  EXPECT_GT(volumes[0], 0);
  EXPECT_GT(volumes[1], 0);
  EXPECT_NEAR(volumes[0] + volumes[1], all, 1e-4 * all);
}

TEST(StabbingContourQuality, NormalsOfCapsPointOutwardsInTheWorld)
{
  const auto image = MakeImage(QualityGrid, VTK_FLOAT, [](int, int, int) { return 1.0; });
  image->SetSpacing(0.5, 1.0, 2.0);
  image->SetDirectionMatrix(0, -1, 0, 1, 0, 0, 0, 0, 1);
  const auto contour = MakeContour(image, 0.5);
  contour->CloseBoundaryOn();
  const auto surface = UpdateContour(contour);
  ASSERT_GT(surface->GetNumberOfPoints(), 0);
  double bounds[6];
  image->GetBounds(bounds);
  for (vtkIdType point = 0; point < surface->GetNumberOfPoints(); ++point)
  {
    const Place place = GetPlace(surface, point);
    double normal[3];
    surface->GetPointData()->GetNormals()->GetTuple(point, normal);
    int sides = 0;
    for (std::size_t axis = 0; axis < 3; ++axis)
    {
      if (std::abs(normal[axis]) > 0.5)
      {
        ++sides;
        EXPECT_NEAR(place[axis], bounds[2 * axis + (normal[axis] > 0 ? 1 : 0)], 1e-5);
      }
    }
    EXPECT_GE(sides, 1);
    EXPECT_NEAR(vtkMath::Norm(normal), 1.0, 1e-6);
  }
}

TEST(StabbingContourQuality, GlobalIdsOfSeveralGridsAreDistinctWithEveryOption)
{
  vtkNew<vtkPartitionedDataSet> grids;
  for (unsigned int number = 0; number < 3; ++number)
  {
    const auto image = MakeImage(QualityGrid, VTK_SHORT, MakeNoise(6, number));
    image->SetOrigin(100.0 * number, 0, 0);
    grids->SetPartition(number, image);
  }
  const auto contour = MakeContour(grids, 3.0);
  contour->SetValue(1, 4.0);
  contour->CloseBoundaryOn();
  contour->DropDegenerateTrianglesOn();
  const auto surface = UpdateContour(contour);
  ExpectDistinctIds(surface);
  EXPECT_TRUE(IsClosed(ToEdges(surface)));
}

TEST(StabbingContourQuality, RegionIsBlocksThatReachIntoABox)
{
  const auto image = MakeImage({ 0, 128, 0, 96, 0, 64 }, VTK_FLOAT, MakeWaves(100.0));
  const auto contour = MakeContour(image, 10.5);
  contour->SetRegionBounds(std::array<double, 6>{ 33.0, 63.0, 10.0, 70.0, 40.0, 400.0 }.data());
  EXPECT_EQ(
    UpdateContour(contour)->GetFieldData()->GetArray("ActiveBlocks")->GetTuple1(0), 4 * 3 * 2);
  contour->UseRegionOn();
  const auto surface = UpdateContour(contour);
  EXPECT_EQ(surface->GetFieldData()->GetArray("ActiveBlocks")->GetTuple1(0), 1 * 3 * 1);
  // By blocks, not exactly.
  const double* bounds = surface->GetBounds();
  EXPECT_NEAR(bounds[0], 32.0, 0.999);
  EXPECT_NEAR(bounds[1], 64.0, 0.999);
  EXPECT_NEAR(bounds[2], 0.0, 0.999);
  EXPECT_NEAR(bounds[4], 32.0, 0.999);
  const Triangles all = ListTriangles(RunFlyingEdges(image, 10.5, false), true);
  const Triangles part = ListTriangles(surface, true);
  EXPECT_TRUE(std::includes(all.begin(), all.end(), part.begin(), part.end()));

  contour->SetRegionBounds(std::array<double, 6>{ 1e3, 2e3, 0.0, 1.0, 0.0, 1.0 }.data());
  EXPECT_EQ(UpdateContour(contour)->GetNumberOfCells(), 0);
}

TEST(StabbingContourQuality, FrustumOfACameraLeavesOutWhatItDoesNotSee)
{
  const auto image = MakeImage({ 0, 128, 0, 96, 0, 64 }, VTK_FLOAT, MakeWaves(100.0));
  image->SetDirectionMatrix(0.6, 0, 0.8, 0, 1, 0, -0.8, 0, 0.6);
  double center[3];
  image->GetCenter(center);
  vtkNew<vtkCamera> camera;
  camera->SetFocalPoint(center);
  camera->SetPosition(center[0] + 200, center[1] + 30, center[2] - 20);
  camera->SetViewAngle(8);
  camera->SetClippingRange(1, 1000);
  double planes[24];
  camera->GetFrustumPlanes(1.0, planes);
  const auto contour = MakeContour(image, 10.5);
  const Triangles all = ListTriangles(UpdateContour(contour), true);
  contour->SetFrustumPlanes(planes);
  const Triangles seen = ListTriangles(UpdateContour(contour), true);
  EXPECT_LT(seen.size(), all.size() / 2);
  EXPECT_GT(seen.size(), 0u);
  // Every triangle with a corner in view is there.
  vtkNew<vtkPlanes> frustum;
  frustum->SetFrustumPlanes(planes);
  std::size_t inView = 0;
  for (const auto& triangle : all)
  {
    if (std::any_of(triangle.begin(), triangle.end(),
          [&](Place place) { return frustum->EvaluateFunction(place.data()) < 0; }))
    {
      ++inView;
      ASSERT_TRUE(std::binary_search(seen.begin(), seen.end(), triangle));
    }
  }
  EXPECT_GT(inView, 0u);
  const double none[24] = {};
  contour->SetFrustumPlanes(none);
  EXPECT_EQ(contour->GetFrustum(), nullptr);
  EXPECT_EQ(ListTriangles(UpdateContour(contour), true).size(), all.size());
}
