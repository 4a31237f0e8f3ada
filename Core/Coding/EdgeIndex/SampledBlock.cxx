// SPDX-License-Identifier: BSD-3-Clause
#include "Coding/EdgeIndex/SampledBlock.h"

#include "Coding/BlockCoding/NewestInstructions.h"
#include "Ground/Volume/SampleView.h"
#include "Ground/Volume/ValueKey.h"
#include "Surface/Contour/BrickKernel.h"

#include <algorithm>
#include <cmath>
#include <type_traits>
#include <utility>

namespace isosurface
{
namespace
{

/// Finds which samples of a box, of at most 64 columns, are at least the threshold, a number of
/// their type: bit i of inside[j + rows * k] is that of vertex (i, j, k) of the box.
void FindInsideRows(
  const SampleView& samples, const VertexBox& box, const void* threshold, std::uint64_t* inside)
{
  BrickSamples rows{};
  rows.First = samples.AtBytes(box.Low);
  const Index3 size = box.GetSize();
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    rows.Stride[axis] = samples.Stride[axis];
    rows.Size[axis] = static_cast<int>(size[axis]);
  }
  GetBrickKernels().ClassifyRows(samples.Type, rows, threshold, inside);
}

// Where the kernel puts a point; see BrickKernelPoints.txx.
template <typename T>
double FindParameter(double isovalue, T from, T to)
{
  double difference = 0;
  if constexpr (std::is_floating_point_v<T>)
  {
    difference = static_cast<double>(static_cast<T>(to - from));
  }
  else if constexpr (sizeof(T) == 8)
  {
    difference = to >= from
      ? static_cast<double>(static_cast<std::uint64_t>(to) - static_cast<std::uint64_t>(from))
      : -static_cast<double>(static_cast<std::uint64_t>(from) - static_cast<std::uint64_t>(to));
  }
  else
  {
    difference = static_cast<double>(to) - static_cast<double>(from);
  }
  return (isovalue - static_cast<double>(from)) / difference;
}

} // namespace

SampledBlock::SampledBlock(
  const SampleView& view, double isovalue, const CrossingIntervals& intervals)
  : View(view)
  , Isovalue(isovalue)
  , Intervals(intervals)
{
  const Index3 size = view.Box.GetSize();
  this->First = view.AtBytes(view.Box.Low);
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    this->Size[axis] = static_cast<int>(size[axis]);
    this->Stride[axis] = view.Stride[axis] * static_cast<std::ptrdiff_t>(GetValueSize(view.Type));
  }
  this->Classify();
}

template <typename T>
double SampledBlock::FindTypedCrossing(const std::uint8_t* from, int axis) const
{
  return FindParameter(this->Isovalue, *reinterpret_cast<const T*>(from),
    *reinterpret_cast<const T*>(from + this->Stride[static_cast<std::size_t>(axis)]));
}

double SampledBlock::GetDouble(const std::uint8_t* sample) const
{
  return DispatchValueType(this->View.Type,
    [sample](auto zero)
    { return static_cast<double>(*reinterpret_cast<const decltype(zero)*>(sample)); });
}

double SampledBlock::FindCrossing(const std::uint8_t* from, int axis) const
{
  return DispatchValueType(this->View.Type,
    [&](auto zero) { return this->FindTypedCrossing<decltype(zero)>(from, axis); });
}

template <typename Functor>
void SampledBlock::VisitCrossedRows(const Functor& functor) const
{
  const SignRow vertices = SignRow::MakeMask(this->Size[0]);
  const SignRow cells = SignRow::MakeMask(this->Size[0] - 1);
  for (int z = 0; z < this->Size[2]; ++z)
  {
    const SignSlice& slice = this->Signs[static_cast<std::size_t>(z)];
    for (int y = 0; y < this->Size[1]; ++y)
    {
      const SignRow& row = slice.At(y);
      SignRow edges[3] = { (row ^ row.ShiftDown()) & cells, SignRow(), SignRow() };
      if (y + 1 < this->Size[1])
      {
        edges[1] = (row ^ slice.At(y + 1)) & vertices;
      }
      if (z + 1 < this->Size[2])
      {
        edges[2] = (row ^ this->Signs[static_cast<std::size_t>(z + 1)].At(y)) & vertices;
      }
      if (!functor(y, z, edges))
      {
        return;
      }
    }
  }
}

template <typename Functor>
void SampledBlock::VisitCrossings(const Functor& functor) const
{
  this->VisitCrossedRows(
    [&](int y, int z, const SignRow(&edges)[3])
    {
      bool goesOn = true;
      for (int axis = 0; axis < 3; ++axis)
      {
        VisitBits(edges[axis], [&](int x) { goesOn = goesOn && functor(this->At(x, y, z), axis); });
      }
      return goesOn;
    });
}

std::uint64_t SampledBlock::CountPoints() const
{
  std::uint64_t points = 0;
  const auto add = [&points](int, int, const SignRow(&edges)[3])
  {
    for (const SignRow& row : edges)
    {
      points += static_cast<std::uint64_t>(
        __builtin_popcountll(row.Words[0]) + __builtin_popcountll(row.Words[1]));
    }
    return true;
  };
  CallWith(CoderInstructions::Newest, [&] { this->VisitCrossedRows(add); });
  return points;
}

void SampledBlock::SetAttributes(std::vector<CodedAttribute> attributes)
{
  this->Attributes = std::move(attributes);
  for (CodedAttribute& attribute : this->Attributes)
  {
    attribute.HasExceptions = this->HasExceptions(attribute);
  }
}

void SampledBlock::ExchangeCodes(int y, int z, const SignRow& vertices, std::int64_t* codes)
{
  const std::uint8_t* row = this->At(0, y, z);
  if (this->Quantization)
  {
    const SignRow& signs = this->Signs[static_cast<std::size_t>(z)].At(y);
    VisitBits(vertices,
      [&](int x)
      {
        codes[x] =
          this->Quantization->ToCode(this->GetDouble(row + x * this->Stride[0]), signs.Get(x));
      });
    return;
  }
  DispatchValueType(this->View.Type,
    [&](auto zero)
    {
      using T = decltype(zero);
      VisitBits(vertices,
        [&](int x) {
          codes[x] = this->Domain->ToCode(*reinterpret_cast<const T*>(row + x * this->Stride[0]));
        });
    });
}

void SampledBlock::ExchangeBins(int axis, int y, int z, const SignRow& edges, std::uint32_t* bins)
{
  const std::uint8_t* row = this->At(0, y, z);
  DispatchValueType(this->View.Type,
    [&](auto zero)
    {
      VisitBits(edges,
        [&](int x)
        {
          const std::uint8_t* from = row + x * this->Stride[0];
          bins[x] = this->Intervals.Find(this->FindTypedCrossing<decltype(zero)>(from, axis));
        });
    });
}

double SampledBlock::MeasureDistance() const
{
  double sum = 0;
  std::size_t count = 0;
  this->VisitCrossings(
    [&](const std::uint8_t* from, int axis)
    {
      for (const std::uint8_t* sample :
        { from, from + this->Stride[static_cast<std::size_t>(axis)] })
      {
        const double distance = std::abs(this->GetDouble(sample) - this->Isovalue);
        if (std::isfinite(distance))
        {
          sum += std::min(distance, 1e300);
          ++count;
        }
      }
      return count < 1500;
    });
  return count == 0 ? 0 : sum / static_cast<double>(count);
}

int SampledBlock::ChooseLosslessScale() const
{
  const int scale = ChooseScale(this->MeasureDistance());
  const bool isOffsets =
    ValueDomain(this->View.Type, this->Isovalue, 0).GetKind() == ValueDomain::Kind::Offsets;
  return isOffsets ? std::clamp(scale, -30, 10) : scale;
}

bool SampledBlock::HasMissingCrossings() const
{
  if (!IsFloatingType(this->View.Type))
  {
    return false;
  }
  bool missing = false;
  this->VisitCrossings(
    [&](const std::uint8_t* from, int axis)
    {
      missing = std::isnan(this->FindCrossing(from, axis));
      return !missing;
    });
  return missing;
}

void SampledBlock::RoundOnFaces(const std::array<float*, 3>& crossings)
{
  SignRow ends;
  ends.Set(0);
  ends.Set(this->Size[0] - 1);
  std::array<std::uint32_t, MaximumCodedVertices> bins;
  this->VisitCrossedRows(
    [&](int y, int z, const SignRow(&edges)[3])
    {
      const bool isFace[3] = { false, y == 0 || y == this->Size[1] - 1,
        z == 0 || z == this->Size[2] - 1 };
      const std::ptrdiff_t row = (std::ptrdiff_t(z) * this->Size[1] + y) * this->Size[0];
      for (int axis = 0; axis < 3; ++axis)
      {
        const bool isWhole = (axis != 1 && isFace[1]) || (axis != 2 && isFace[2]);
        const SignRow chosen = isWhole ? edges[axis] : axis != 0 ? edges[axis] & ends : SignRow();
        this->ExchangeBins(axis, y, z, chosen, bins.data());
        VisitBits(chosen,
          [&](int x) {
            crossings[static_cast<std::size_t>(axis)][row + x] = this->Intervals.GetPlace(bins[x]);
          });
      }
      return true;
    });
}

bool SampledBlock::HasExceptions(const CodedAttribute& attribute) const
{
  const AttributeDomain domain(attribute.Type, attribute.MaximumError);
  if (attribute.MaximumError == 0)
  {
    return false;
  }
  const auto components = static_cast<std::size_t>(attribute.NumberOfComponents);
  bool found = false;
  this->VisitCrossedRows(
    [&](int y, int z, const SignRow(&rows)[3])
    {
      const std::ptrdiff_t row = (std::ptrdiff_t(z) * this->Size[1] + y) * this->Size[0];
      for (std::size_t axis = 0; axis < 3; ++axis)
      {
        VisitBits(rows[axis],
          [&](int x)
          {
            const std::uint8_t* tuple = attribute.Edges.First[axis] +
              static_cast<std::size_t>(row + x) * components * domain.GetValueSize();
            for (std::size_t n = 0; n < components; ++n)
            {
              found = found || !domain.HasCode(tuple + n * domain.GetValueSize());
            }
          });
      }
      return !found;
    });
  return found;
}

void SampledBlock::Classify()
{
  DispatchValueType(this->View.Type,
    [this](auto zero)
    {
      using T = decltype(zero);
      if (const auto threshold = FindThreshold<T>(this->Isovalue))
      {
        for (int begin = 0; begin < this->Size[0]; begin += 32)
        {
          this->ClassifyColumns(begin, &*threshold);
        }
      }
    });
  const SignRow full = SignRow::MakeMask(this->Size[0]);
  SignRow any;
  SignRow all = full;
  for (int z = 0; z < this->Size[2]; ++z)
  {
    for (int y = 0; y < this->Size[1]; ++y)
    {
      any = any | this->Signs[static_cast<std::size_t>(z)].At(y);
      all = all & this->Signs[static_cast<std::size_t>(z)].At(y);
    }
  }
  this->Inside = !any.IsZero();
  this->Crossed = this->Inside && !(all ^ full).IsZero();
}

void SampledBlock::ClassifyColumns(int begin, const void* threshold)
{
  VertexBox box = this->View.Box;
  box.Low[0] += begin;
  box.High[0] = std::min(box.High[0], box.Low[0] + 32);
  std::array<std::uint64_t, MaximumCodedVertices> inside;
  for (int z = 0; z < this->Size[2]; ++z)
  {
    box.Low[2] = this->View.Box.Low[2] + z;
    box.High[2] = box.Low[2] + 1;
    FindInsideRows(this->View, box, threshold, inside.data());
    SignSlice& slice = this->Signs[static_cast<std::size_t>(z)];
    for (int y = 0; y < this->Size[1]; ++y)
    {
      const auto bit = static_cast<unsigned>(begin + SignRow::Margin);
      const std::uint64_t bits = inside[static_cast<std::size_t>(y)];
      slice.At(y).Words[bit / 64] |= bits << (bit % 64);
      if (bit % 64 > 32 && bit / 64 == 0)
      {
        slice.At(y).Words[1] |= bits >> (64 - bit % 64);
      }
    }
  }
}

} // namespace isosurface
