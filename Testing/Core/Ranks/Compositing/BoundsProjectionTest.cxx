// SPDX-License-Identifier: BSD-3-Clause
#include "Ranks/Compositing/BoundsProjection.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

using namespace isosurface;

namespace
{

using Bounds = std::array<double, 6>;
using Matrix = std::array<double, 16>;

constexpr PixelRectangle Display{ 0, 0, 401, 303 };

Matrix Multiply(const Matrix& a, const Matrix& b)
{
  Matrix product{};
  for (std::size_t row = 0; row < 4; ++row)
  {
    for (std::size_t column = 0; column < 4; ++column)
    {
      for (std::size_t k = 0; k < 4; ++k)
      {
        product[4 * row + column] += a[4 * row + k] * b[4 * k + column];
      }
    }
  }
  return product;
}

/// Looks along -z from (0, 0, distance), turned by an angle about the y axis.
Matrix MakeView(double angle, double distance)
{
  const double c = std::cos(angle);
  const double s = std::sin(angle);
  return { c, 0, s, 0, 0, 1, 0, 0, -s, 0, c, -distance, 0, 0, 0, 1 };
}

/// As OpenGL's, with 60 degrees from top to bottom.
Matrix MakePerspective(double nearPlane, double farPlane)
{
  const double f = std::sqrt(3.0);
  const double aspect = 401.0 / 303.0;
  return { f / aspect, 0, 0, 0, 0, f, 0, 0, 0, 0, (farPlane + nearPlane) / (nearPlane - farPlane),
    2 * farPlane * nearPlane / (nearPlane - farPlane), 0, 0, -1, 0 };
}

Matrix MakeOrthographic(double halfHeight, double nearPlane, double farPlane)
{
  const double aspect = 401.0 / 303.0;
  return { 1 / (halfHeight * aspect), 0, 0, 0, 0, 1 / halfHeight, 0, 0, 0, 0,
    2 / (nearPlane - farPlane), (farPlane + nearPlane) / (nearPlane - farPlane), 0, 0, 0, 1 };
}

/// The smallest rectangle of pixels of many points of the box in front of the near plane, not cut at
/// the display's edges.
struct SampledBounds
{
  double Left = HUGE_VAL;
  double Right = -HUGE_VAL;
  double Bottom = HUGE_VAL;
  double Top = -HUGE_VAL;
};

SampledBounds SampleBox(const Bounds& bounds, const Matrix& worldToClip, int steps)
{
  SampledBounds sampled;
  for (int k = 0; k <= steps; ++k)
  {
    for (int j = 0; j <= steps; ++j)
    {
      for (int i = 0; i <= steps; ++i)
      {
        const std::array<double, 4> point = { bounds[0] + (bounds[1] - bounds[0]) * i / steps,
          bounds[2] + (bounds[3] - bounds[2]) * j / steps,
          bounds[4] + (bounds[5] - bounds[4]) * k / steps, 1 };
        std::array<double, 4> clip{};
        for (std::size_t row = 0; row < 4; ++row)
        {
          for (std::size_t column = 0; column < 4; ++column)
          {
            clip[row] += worldToClip[4 * row + column] * point[column];
          }
        }
        if (clip[2] >= -clip[3])
        {
          const double x = (clip[0] / clip[3] + 1) / 2 * Display.Width;
          const double y = (clip[1] / clip[3] + 1) / 2 * Display.Height;
          sampled.Left = std::min(sampled.Left, x);
          sampled.Right = std::max(sampled.Right, x);
          sampled.Bottom = std::min(sampled.Bottom, y);
          sampled.Top = std::max(sampled.Top, y);
        }
      }
    }
  }
  return sampled;
}

/// The rectangle contains all samples, and is larger by at most `slack` pixels.
void ExpectFits(const PixelRectangle& pixels, const SampledBounds& sampled, double slack)
{
  const auto cut = [](double value, int length) { return std::clamp(value, 0.0, double(length)); };
  const double left = cut(sampled.Left, Display.Width);
  const double right = cut(sampled.Right, Display.Width);
  const double bottom = cut(sampled.Bottom, Display.Height);
  const double top = cut(sampled.Top, Display.Height);
  if (left >= right || bottom >= top)
  {
    EXPECT_LE(pixels.Width == 0 ? 0 : std::min(pixels.Width, pixels.Height), 1 + slack);
    return;
  }
  EXPECT_LE(pixels.X, left);
  EXPECT_GE(pixels.GetRight(), right);
  EXPECT_LE(pixels.Y, bottom);
  EXPECT_GE(pixels.GetTop(), top);
  EXPECT_GE(pixels.X + 1 + slack, left);
  EXPECT_LE(pixels.GetRight() - 1 - slack, right);
  EXPECT_GE(pixels.Y + 1 + slack, bottom);
  EXPECT_LE(pixels.GetTop() - 1 - slack, top);
}

} // namespace

TEST(BoundsProjection, InFrontOfTheCameraItIsTheSmallestRectangleOfAllPoints)
{
  std::mt19937 random(5);
  std::uniform_real_distribution<double> place(-2, 2);
  std::uniform_real_distribution<double> length(0, 1.5);
  for (int trial = 0; trial < 200; ++trial)
  {
    Bounds bounds;
    for (std::size_t axis = 0; axis < 3; ++axis)
    {
      bounds[2 * axis] = place(random);
      bounds[2 * axis + 1] = bounds[2 * axis] + length(random);
    }
    const Matrix view = MakeView(trial, 9);
    for (const Matrix& projection : { MakePerspective(1, 30), MakeOrthographic(2.5, 1, 30) })
    {
      const Matrix matrix = Multiply(projection, view);
      // Corners are among the samples, and the smallest rectangle is that of the corners.
      ExpectFits(ProjectBounds(bounds, matrix, Display).Pixels, SampleBox(bounds, matrix, 2), 0);
    }
  }
}

TEST(BoundsProjection, OfABoxThatReachesBehindTheCameraItIsWhatTheNearPlaneLeaves)
{
  std::mt19937 random(6);
  std::uniform_real_distribution<double> place(-2, 1);
  std::uniform_real_distribution<double> length(0.5, 2.5);
  for (int trial = 0; trial < 60; ++trial)
  {
    Bounds bounds;
    for (std::size_t axis = 0; axis < 3; ++axis)
    {
      bounds[2 * axis] = place(random);
      bounds[2 * axis + 1] = bounds[2 * axis] + length(random);
    }
    // The camera is at most 1 from the center: inside many of the boxes, or in front of them.
    const Matrix matrix = Multiply(MakePerspective(0.5, 30), MakeView(trial, trial % 3 - 1.0));
    const PixelRectangle pixels = ProjectBounds(bounds, matrix, Display).Pixels;
    const SampledBounds sampled = SampleBox(bounds, matrix, 40);
    if (sampled.Left > sampled.Right)
    {
      continue; // a corner of the box may still be in front of the plane, between two samples
    }
    // Samples are a fortieth of the box apart, so they come near the corners of what is left.
    ExpectFits(pixels, sampled, 60);
  }
}

TEST(BoundsProjection, BehindTheCameraBesideTheDisplayAndEmptyAreNowhere)
{
  const Matrix matrix = Multiply(MakePerspective(1, 30), MakeView(0, 5));
  EXPECT_TRUE(ProjectBounds({ -1, 1, -1, 1, 6, 8 }, matrix, Display).Pixels.IsEmpty());
  EXPECT_TRUE(ProjectBounds({ 50, 51, -1, 1, -1, 1 }, matrix, Display).Pixels.IsEmpty());
  EXPECT_TRUE(ProjectBounds({ -1, 1, 50, 51, -1, 1 }, matrix, Display).Pixels.IsEmpty());
  EXPECT_TRUE(ProjectBounds({ -1, 1, -1, 1, -90, -80 }, matrix, Display).Pixels.IsEmpty());
  EXPECT_TRUE(ProjectBounds({ 1, -1, 1, -1, 1, -1 }, matrix, Display).Pixels.IsEmpty());
}

TEST(BoundsProjection, WithTheCameraInsideItIsAllOfTheDisplay)
{
  const Matrix matrix = Multiply(MakePerspective(0.01, 30), MakeView(0.3, 0));
  EXPECT_EQ(ProjectBounds({ -5, 5, -5, 5, -5, 5 }, matrix, Display).Pixels, Display);
}

TEST(BoundsProjection, WhatIsNotFiniteCoversAllOfTheDisplay)
{
  const Matrix matrix = Multiply(MakePerspective(1, 30), MakeView(0, 5));
  const double infinite = std::numeric_limits<double>::infinity();
  EXPECT_EQ(ProjectBounds({ -infinite, 1, 0, 1, 0, 1 }, matrix, Display).Pixels, Display);
  Matrix broken = matrix;
  broken[5] = std::nan("");
  EXPECT_EQ(ProjectBounds({ 0, 1, 0, 1, 0, 1 }, broken, Display).Pixels, Display);
}

TEST(BoundsProjection, TheMarginWidensInsideTheDisplayThatMayBeginAnywhere)
{
  const Matrix matrix = MakeOrthographic(1, 1, 30);
  const PixelRectangle away{ 1000, 2000, 401, 303 };
  const PixelRectangle plain = ProjectBounds({ -0.1, 0.1, -0.1, 0.1, -5, -4 }, matrix, away).Pixels;
  const PixelRectangle wide =
    ProjectBounds({ -0.1, 0.1, -0.1, 0.1, -5, -4 }, matrix, away, 3).Pixels;
  EXPECT_EQ(wide,
    PixelRectangle::FromEdges(plain.X - 3, plain.Y - 3, plain.GetRight() + 3, plain.GetTop() + 3));
  EXPECT_EQ(ProjectBounds({ -9, 9, -9, 9, -5, -4 }, matrix, away, 3).Pixels, away);
}

TEST(BoundsProjection, DepthsAreThoseOfTheNearestAndFarthestPoint)
{
  const ProjectedBounds projected =
    ProjectBounds({ -0.1, 0.1, -0.1, 0.1, -20, -4 }, MakeOrthographic(1, 2, 30), Display);
  EXPECT_NEAR(projected.NearDepth, -1 + 2 * (4.0 - 2) / 28, 1e-12);
  EXPECT_NEAR(projected.FarDepth, -1 + 2 * (20.0 - 2) / 28, 1e-12);
}
