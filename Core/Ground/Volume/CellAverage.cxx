// SPDX-License-Identifier: BSD-3-Clause
#include "Ground/Volume/CellAverage.h"

#include "Ground/Base/ParallelFor.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <type_traits>

namespace isosurface
{
namespace
{

// The cells around a vertex in the order of vtkStructuredData::GetPointCells: sums are rounded.
constexpr int Steps[8][3] = { { -1, 0, 0 }, { -1, -1, 0 }, { -1, -1, -1 }, { -1, 0, -1 },
  { 0, 0, 0 }, { 0, -1, 0 }, { 0, -1, -1 }, { 0, 0, -1 } };

// As vtkMath::RoundDoubleToIntegralIfNecessary.
template <typename T>
T Round(double value)
{
  if constexpr (std::is_same_v<T, double>)
  {
    return value;
  }
  else
  {
    if (std::isnan(value))
    {
      return std::is_integral_v<T> ? T(0) : static_cast<T>(value);
    }
    value = std::min(std::max(value, static_cast<double>(std::numeric_limits<T>::lowest())),
      static_cast<double>(std::numeric_limits<T>::max()));
    if constexpr (std::is_floating_point_v<T>)
    {
      return static_cast<T>(value);
    }
    else
    {
      const double rounded = value >= 0.0 ? value + 0.5 : value - 0.5;
      // The limits of 64 bits are no doubles: what is rounded to them stays within the type.
      return rounded >= static_cast<double>(std::numeric_limits<T>::max())
        ? std::numeric_limits<T>::max()
        : static_cast<T>(rounded);
    }
  }
}

template <typename T>
class Averages
{
public:
  Averages(const CellTuples& cells, const Blanking& hidden)
    : Cells(cells)
    , Hidden(hidden)
  {
    const Index3 size = cells.Box.GetSize();
    for (std::size_t axis = 0; axis < 3; ++axis)
    {
      this->Size[axis] = std::max<std::int64_t>(1, size[axis] - 1);
    }
  }

  void WriteTuple(const Index3& vertex, T* tuple) const
  {
    const T* around[8];
    const int count = this->FindCells(vertex, around);
    const double weight = count > 0 ? 1.0 / count : 0.0;
    for (int component = 0; component < this->Cells.NumberOfComponents; ++component)
    {
      double sum = 0;
      for (int n = 0; n < count; ++n)
      {
        sum += weight * static_cast<double>(around[n][component]);
      }
      tuple[component] = Round<T>(sum);
    }
  }

private:
  int FindCells(const Index3& vertex, const T* around[8]) const
  {
    int count = 0;
    for (const auto& step : Steps)
    {
      Index3 cell{};
      bool isCell = true;
      for (std::size_t axis = 0; axis < 3; ++axis)
      {
        cell[axis] = vertex[axis] - this->Cells.Box.Low[axis] + step[axis];
        isCell = isCell && cell[axis] >= 0 && cell[axis] < this->Size[axis];
      }
      const auto number =
        static_cast<std::ptrdiff_t>(cell[0] + this->Size[0] * (cell[1] + this->Size[1] * cell[2]));
      if (isCell && (this->Hidden.IsEmpty() || !this->IsHidden(cell, number)))
      {
        around[count++] =
          static_cast<const T*>(this->Cells.First) + number * this->Cells.NumberOfComponents;
      }
    }
    return count;
  }

  bool IsHidden(const Index3& cell, std::ptrdiff_t number) const
  {
    if (this->Hidden.Cells && (this->Hidden.Cells[number] & this->Hidden.HidesCell) != 0)
    {
      return true;
    }
    for (std::int64_t n = 0; this->Hidden.Vertices && n < 8; ++n)
    {
      const std::int64_t steps[3] = { n % 2, n / 2 % 2, n / 4 };
      Index3 corner = this->Cells.Box.Low;
      for (std::size_t axis = 0; axis < 3; ++axis)
      {
        // An axis with one vertex has no second corner.
        corner[axis] =
          std::min(corner[axis] + cell[axis] + steps[axis], this->Cells.Box.High[axis] - 1);
      }
      if ((*this->Hidden.AtVertex(corner) & this->Hidden.HidesVertex) != 0)
      {
        return true;
      }
    }
    return false;
  }

  const CellTuples& Cells;
  const Blanking& Hidden;
  Index3 Size{}; ///< cells
};

} // namespace

void AverageCells(const CellTuples& cells, const Blanking& hidden, const VertexBox& vertices,
  int threads, void* tuples)
{
  const Index3 size = vertices.GetSize();
  DispatchValueType(cells.Type,
    [&](auto zero)
    {
      using T = decltype(zero);
      const Averages<T> averages(cells, hidden);
      const std::ptrdiff_t row = static_cast<std::ptrdiff_t>(size[0]) * cells.NumberOfComponents;
      ParallelFor(static_cast<std::size_t>(size[1] * size[2]), threads,
        [&](std::size_t number, int)
        {
          const auto n = static_cast<std::int64_t>(number);
          T* tuple = static_cast<T*>(tuples) + static_cast<std::ptrdiff_t>(number) * row;
          for (std::int64_t i = 0; i < size[0]; ++i, tuple += cells.NumberOfComponents)
          {
            averages.WriteTuple(
              { vertices.Low[0] + i, vertices.Low[1] + n % size[1], vertices.Low[2] + n / size[1] },
              tuple);
          }
        });
    });
}

} // namespace isosurface
