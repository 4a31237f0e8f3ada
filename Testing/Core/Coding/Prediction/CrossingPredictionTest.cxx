// SPDX-License-Identifier: BSD-3-Clause
// The oracle computes crossings from the values at the ends of edges.
#include "Coding/Prediction/CrossingCycles.h"
#include "Coding/Prediction/CurvedFit.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <memory>
#include <random>
#include <vector>

using namespace isosurface;

namespace
{

constexpr int Side = 20; ///< vertices of a block on each axis
using Field = std::function<double(int x, int y, int z)>;

/// What a decoder knows before an edge of slice z, in a block whose isovalue is 0.
class KnownCrossings
{
public:
  KnownCrossings(const Field& field, int z)
    : Values(field)
    , Z(z)
    , Planes(std::make_unique<std::array<std::array<CrossingPlane, 3>, 3>>())
  {
    for (int slice = 0; slice < 3; ++slice)
    {
      for (int y = -2; y < Side + 2; ++y)
      {
        for (int x = -2; x < Side + 2; ++x)
        {
          if (field(x, y, z - 1 + slice) >= 0)
          {
            this->Signs[static_cast<std::size_t>(slice)].At(y).Set(x);
          }
        }
      }
    }
  }

  bool IsCrossed(int axis, int x, int y, int z) const
  {
    const std::array<int, 3> to = Step(axis, x, y, z);
    return to[0] < Side && to[1] < Side && (z <= this->Z || axis != 2) &&
      (this->Values(x, y, z) >= 0) != (this->Values(to[0], to[1], to[2]) >= 0);
  }
  double FindCrossing(int axis, int x, int y, int z) const
  {
    const std::array<int, 3> to = Step(axis, x, y, z);
    const double from = this->Values(x, y, z);
    return from / (from - this->Values(to[0], to[1], to[2]));
  }

  CrossingPlanes GetPlanesBefore(int axis, int x, int y)
  {
    for (int plane = 0; plane < 3; ++plane)
    {
      const int z = plane == 2 ? this->Z + 1 : this->Z - plane;
      for (int a = 0; a < 3; ++a)
      {
        CrossingPlane& known =
          (*this->Planes)[static_cast<std::size_t>(plane)][static_cast<std::size_t>(a)];
        known.Positions.fill(CrossingFit::None);
        known.Crossed.fill(SignRow());
        for (int j = 0; j < Side; ++j)
        {
          for (int i = 0; i < Side; ++i)
          {
            if (!this->IsCrossed(a, i, j, z))
            {
              continue;
            }
            const bool before = plane == 1 ||
              (plane == 0 && std::array<int, 3>{ j, a, i } < std::array<int, 3>{ y, axis, x });
            known.Crossed[static_cast<std::size_t>(j + 2)].Set(i);
            known.Positions[static_cast<std::size_t>(GetPlace(i, j))] = before
              ? static_cast<std::int16_t>(this->FindCrossing(a, i, j, z) * CrossingFit::Unit)
              : CrossingFit::Later;
          }
        }
      }
    }
    return { &(*this->Planes)[0], &(*this->Planes)[1], &(*this->Planes)[2] };
  }
  std::array<const SignSlice*, 3> GetSlices() const
  {
    return { &this->Signs[0], &this->Signs[1], &this->Signs[2] };
  }
  static std::ptrdiff_t GetPlace(int x, int y)
  {
    return (y + 2) * CrossingFit::RowStride + x + CrossingFit::RowMargin;
  }

  /// Calls functor(axis, x, y) for the crossed edges of the slice that lie 3 vertices inside.
  template <typename Functor>
  void VisitInner(const Functor& functor)
  {
    for (int y = 3; y < Side - 3; ++y)
    {
      for (int axis = 0; axis < 3; ++axis)
      {
        for (int x = 3; x < Side - 3; ++x)
        {
          if (this->IsCrossed(axis, x, y, this->Z))
          {
            functor(axis, x, y);
          }
        }
      }
    }
  }

private:
  static std::array<int, 3> Step(int axis, int x, int y, int z)
  {
    std::array<int, 3> to{ x, y, z };
    ++to[static_cast<std::size_t>(axis)];
    return to;
  }

  Field Values;
  int Z;
  std::array<SignSlice, 3> Signs{};
  std::unique_ptr<std::array<std::array<CrossingPlane, 3>, 3>> Planes;
};

} // namespace

TEST(CrossingPrediction, QuadraticFitFollowsASphereAndLinearFitAPlane)
{
  const Field sphere = [](int x, int y, int z)
  { return 64.3 - (x - 10.2) * (x - 10.2) - (y - 9.7) * (y - 9.7) - (z - 9.9) * (z - 9.9); };
  const Field plane = [](int x, int y, int z) { return 0.9 * x + 0.5 * y - 0.4 * z - 11.3; };
  const auto measure = [](const Field& field, double& linear, double& quadratic)
  {
    int number = 0;
    linear = 0;
    quadratic = 0;
    for (int z = 3; z < Side - 3; ++z)
    {
      KnownCrossings known(field, z);
      known.VisitInner(
        [&](int axis, int x, int y)
        {
          const CurvedFit::Result result =
            CurvedFit::Get().Predict(axis, x, y, KnownCrossings::GetPlace(x, y),
              field(x, y, z) >= 0, known.GetSlices(), known.GetPlanesBefore(axis, x, y));
          const double exact = known.FindCrossing(axis, x, y, z) * CrossingFit::FineUnit;
          linear += std::abs(result.Linear - exact) / CrossingFit::FineUnit;
          quadratic += std::abs(result.Quadratic - exact) / CrossingFit::FineUnit;
          ++number;
        });
    }
    ASSERT_GT(number, 100);
    linear /= number;
    quadratic /= number;
  };
  double linear = 0;
  double quadratic = 0;
  measure(plane, linear, quadratic);
  EXPECT_LT(linear, 0.05);
  EXPECT_LT(quadratic, 0.05);
  measure(sphere, linear, quadratic);
  EXPECT_LT(quadratic, 0.8 * linear);
}

TEST(CrossingPrediction, CyclesGiveCrossingsOfNoiseExactly)
{
  std::mt19937 random(3);
  std::vector<double> samples(Side * Side * 4);
  for (double& sample : samples)
  {
    sample = static_cast<double>(random() % 2001) - 1000.5;
  }
  const Field noise = [&](int x, int y, int z)
  {
    const auto bound = [](int n) { return std::clamp(n, 0, Side - 1); };
    return samples[static_cast<std::size_t>(
      (std::clamp(z, 0, 3) * Side + bound(y)) * Side + bound(x))];
  };
  KnownCrossings known(noise, 2);
  int number[3] = {};
  known.VisitInner(
    [&](int axis, int x, int y)
    {
      const CrossingCycles::Result result = CrossingCycles::Get().Predict(
        axis, x, y, KnownCrossings::GetPlace(x, y), known.GetPlanesBefore(axis, x, y));
      if (result.Weight != 0)
      {
        // Where the weight is large, positions in units of 2^-10 are exact enough.
        const double error =
          std::abs(result.Position / 65536.0 - known.FindCrossing(axis, x, y, 2));
        EXPECT_LT(error, result.Weight > 20000 ? 0.01 : 0.2) << axis << " " << x << " " << y;
        ++number[axis];
      }
    });
  EXPECT_GT(number[0], 10);
  EXPECT_GT(number[1], 10);
  EXPECT_EQ(number[2], 0);
}
