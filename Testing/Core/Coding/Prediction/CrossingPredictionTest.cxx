// SPDX-License-Identifier: BSD-3-Clause
// The oracle computes crossings from the values at the ends of edges.
#include "Coding/Prediction/CrossingFit.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <memory>

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

TEST(CrossingPrediction, FollowsAPlaneClosely)
{
  const Field plane = [](int x, int y, int z) { return 0.9 * x + 0.5 * y - 0.4 * z - 11.3; };
  int number = 0;
  double sum = 0;
  for (int z = 3; z < Side - 3; ++z)
  {
    KnownCrossings known(plane, z);
    known.VisitInner(
      [&](int axis, int x, int y)
      {
        const CrossingFit::Result result =
          CrossingFit::Get().Predict(axis, x, y, KnownCrossings::GetPlace(x, y),
            plane(x, y, z) >= 0, known.GetSlices(), known.GetPlanesBefore(axis, x, y));
        sum += std::abs(static_cast<double>(result.Position) / CrossingFit::FineUnit -
          known.FindCrossing(axis, x, y, z));
        ++number;
      });
  }
  ASSERT_GT(number, 100);
  EXPECT_LT(sum / number, 0.05);
}
