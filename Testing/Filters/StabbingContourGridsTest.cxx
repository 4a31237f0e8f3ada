// SPDX-License-Identifier: BSD-3-Clause
#include "TestImages.h"

#include "vtkCellArray.h"
#include "vtkCellArrayIterator.h"
#include "vtkContourFilter.h"
#include "vtkDataSetAttributes.h"
#include "vtkImageData.h"
#include "vtkMath.h"
#include "vtkMatrix3x3.h"
#include "vtkNew.h"
#include "vtkPolyData.h"

#include <cmath>
#include <string>

using namespace isosurface;

namespace
{

const int Lengths[] = { 2, 3, 31, 32, 33, 34, 64, 65, 66 };

Extent MakeExtent(int x, int y, int z)
{
  return { 0, x - 1, 0, y - 1, 0, z - 1 };
}

// Smooth, with some noise, so that no block looks like its neighbour.
Field MakeRoughWaves()
{
  return [waves = MakeWaves(100.0), noise = MakeNoise(20, 7)](int i, int j, int k) mutable
  { return waves(i, j, k) + noise(i, j, k); };
}

std::string ToString(const Extent& extent)
{
  std::string text = "extent";
  for (const int bound : extent)
  {
    text += " " + std::to_string(bound);
  }
  return text;
}

void ExpectEqual(const Extent& extent)
{
  const auto image = MakeImage(extent, VTK_FLOAT, MakeRoughWaves());
  const EdgeSurface expected = ContourByFlyingEdges(image, 8.0);
  EXPECT_TRUE(AreEqual(ContourToEdges(image, 8.0), expected)) << ToString(extent);
}

struct Frame
{
  const char* Name;
  std::array<double, 3> Origin;
  std::array<double, 3> Spacing;
  std::array<double, 9> Direction;
};

constexpr std::array<double, 9> Identity{ 1, 0, 0, 0, 1, 0, 0, 0, 1 };

// About the axis (1, 2, 3), by one radian.
std::array<double, 9> MakeRotation()
{
  const double length = std::sqrt(14.0);
  const double a[3] = { 1 / length, 2 / length, 3 / length };
  const double s = std::sin(1.0);
  const double c = std::cos(1.0);
  const double d = 1 - c;
  return { c + a[0] * a[0] * d, a[0] * a[1] * d - a[2] * s, a[0] * a[2] * d + a[1] * s,
    a[1] * a[0] * d + a[2] * s, c + a[1] * a[1] * d, a[1] * a[2] * d - a[0] * s,
    a[2] * a[0] * d - a[1] * s, a[2] * a[1] * d + a[0] * s, c + a[2] * a[2] * d };
}

std::array<double, 9> MirrorFirstAxis(std::array<double, 9> direction)
{
  for (int row = 0; row < 3; ++row)
  {
    direction[3 * row] = -direction[3 * row];
  }
  return direction;
}

void ExpectEqualInFrame(const Frame& frame)
{
  for (const Extent& extent : { Extent{ 0, 20, 0, 18, 0, 35 }, Extent{ -20, 14, 7, 25, 1000, 1010 },
         Extent{ -40, -21, -5, 30, -3, 3 } })
  {
    const auto image = MakeImage(extent, VTK_SHORT, MakeRoughWaves());
    image->SetOrigin(const_cast<double*>(frame.Origin.data()));
    image->SetSpacing(const_cast<double*>(frame.Spacing.data()));
    vtkNew<vtkMatrix3x3> direction;
    direction->DeepCopy(frame.Direction.data());
    image->SetDirectionMatrix(direction);
    EdgeSurface expected = ContourByFlyingEdges(image, 8.5);
    EdgeSurface surface = ContourToEdges(image, 8.5);
    if (direction->Determinant() < 0)
    {
      // Sums that are 0 stay positive when all terms change their signs.
      expected.DropSignsOfZeros();
      surface.DropSignsOfZeros();
    }
    EXPECT_FALSE(expected.Triangles.empty());
    EXPECT_TRUE(AreEqual(surface, expected)) << frame.Name << ", " << ToString(extent);
  }
}

// What a surface encloses, by the order of corners.
double ComputeVolume(vtkPolyData* surface)
{
  double sixfold = 0;
  const auto cells = vtk::TakeSmartPointer(surface->GetPolys()->NewIterator());
  for (cells->GoToFirstCell(); !cells->IsDoneWithTraversal(); cells->GoToNextCell())
  {
    vtkIdType size = 0;
    const vtkIdType* points = nullptr;
    cells->GetCurrentCell(size, points);
    double corners[3][3];
    for (int corner = 0; corner < 3; ++corner)
    {
      surface->GetPoint(points[corner], corners[corner]);
    }
    sixfold += vtkMath::Determinant3x3(corners[0], corners[1], corners[2]);
  }
  return sixfold / 6;
}

} // namespace

TEST(StabbingContourGrids, AnyLengthOfAnyAxisEqualsFlyingEdges)
{
  for (const int length : Lengths)
  {
    for (const int y : { 2, 3, 34 })
    {
      for (const int z : { 2, 3, 35 })
      {
        ExpectEqual(MakeExtent(length, y, z));
        ExpectEqual(MakeExtent(y, length, z));
        ExpectEqual(MakeExtent(z, y, length));
      }
    }
  }
}

TEST(StabbingContourGrids, SeveralBlocksOnAllAxesEqualFlyingEdges)
{
  ExpectEqual(MakeExtent(32, 32, 32));
  ExpectEqual(MakeExtent(33, 33, 33));
  ExpectEqual(MakeExtent(34, 65, 33));
  ExpectEqual(MakeExtent(66, 64, 65));
  ExpectEqual(MakeExtent(97, 31, 66));
}

TEST(StabbingContourGrids, GridOneVertexThickHasNoSurface)
{
  for (const int length : { 1, 2, 33, 66 })
  {
    for (const Extent& extent : { MakeExtent(1, length, 5), MakeExtent(5, 1, length),
           MakeExtent(length, 5, 1), MakeExtent(1, 1, length) })
    {
      const auto output = Contour(MakeImage(extent, VTK_FLOAT, MakeRoughWaves()), { 8.0 });
      EXPECT_EQ(output->GetNumberOfPoints(), 0) << ToString(extent);
      EXPECT_EQ(output->GetNumberOfCells(), 0) << ToString(extent);
    }
  }
}

TEST(StabbingContourGrids, ImageWithoutVerticesHasNoSurface)
{
  vtkNew<vtkImageData> image;
  EXPECT_EQ(Contour(image, { 8.0 })->GetNumberOfCells(), 0);
}

TEST(StabbingContourGrids, ExtentsThatDoNotBeginAtZeroEqualFlyingEdges)
{
  ExpectEqual({ -40, 20, -7, 9, -33, -1 });
  ExpectEqual({ 5, 70, 100, 120, 31, 64 });
}

TEST(StabbingContourGrids, OriginAndSpacingEqualFlyingEdges)
{
  ExpectEqualInFrame({ "unit", { 0, 0, 0 }, { 1, 1, 1 }, Identity });
  ExpectEqualInFrame({ "moved", { 12.3, -0.7, 1e4 }, { 1, 1, 1 }, Identity });
  ExpectEqualInFrame({ "scaled", { 0, 0, 0 }, { 0.957, 0.957, 1.5 }, Identity });
  ExpectEqualInFrame({ "backwards", { 5, 6, 7 }, { -1, 2, -0.5 }, Identity });
  ExpectEqualInFrame({ "moved and scaled", { -91.1, 3.7, 0.001 }, { 0.3, 7.1, 1e-3 }, Identity });
}

TEST(StabbingContourGrids, ObliqueDirectionsEqualFlyingEdges)
{
  ExpectEqualInFrame({ "rotated", { 0, 0, 0 }, { 1, 1, 1 }, MakeRotation() });
  ExpectEqualInFrame({ "all", { 12.3, -0.7, 55 }, { 0.9, 1.7, 0.31 }, MakeRotation() });
}

TEST(StabbingContourGrids, LeftHandedDirectionsEqualFlyingEdgesWithCornersTurned)
{
  ExpectEqualInFrame({ "mirrored", { 0, 0, 0 }, { 1, 1, 1 }, MirrorFirstAxis(Identity) });
  ExpectEqualInFrame({ "rotated and mirrored", { 12.3, -0.7, 55 }, { 0.9, 1.7, 0.31 },
    MirrorFirstAxis(MakeRotation()) });
}

TEST(StabbingContourGrids, EnclosedVolumesArePositiveAsThoseOfContour)
{
  const auto image = MakeImage({ 0, 16, 0, 16, 0, 16 }, VTK_FLOAT,
    [](int i, int j, int k) { return 6.3 - std::hypot(i - 8.0, j - 8.0, k - 8.0); });
  for (const auto& direction : { Identity, MirrorFirstAxis(Identity), MakeRotation(),
         MirrorFirstAxis(MakeRotation()), std::array<double, 9>{ 0, 1, 0, 1, 0, 0, 0, 0, 1 } })
  {
    image->SetDirectionMatrix(const_cast<double*>(direction.data()));
    vtkNew<vtkContourFilter> stock;
    stock->SetInputData(image);
    stock->SetValue(0, 0.0);
    stock->Update();
    const double expected = ComputeVolume(stock->GetOutput());
    EXPECT_GT(expected, 900);
    EXPECT_NEAR(ComputeVolume(Contour(image, { 0.0 })), expected, 0.1);
  }
}
