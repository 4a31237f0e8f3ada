// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_AttributeCoder_h
#define isosurface_AttributeCoder_h

#include "EdgeIndex/AttributeDomain.h"
#include "EdgeIndex/ResidualCoder.h"
#include "EdgeIndex/SignRows.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

namespace isosurface
{

/// The tuples of a point array at the edges of a block that begin at its vertices along x, y, z:
/// vertices x fastest, without gaps. Only crossed edges have one. Written to when decoding.
struct AttributeEdges
{
  std::array<std::uint8_t*, 3> First{};
};

/// The edges around one from which its values are predicted.
class AttributeNeighbors
{
public:
  /// Of one row of vertices, x - 2 to x + 2.
  struct Row
  {
    std::size_t Plane = 0; ///< 0 this slice, 1 the one before
    std::size_t Axis = 0;
    int Y = 0;
    std::uint32_t Near = 0; ///< bits of those that are near enough
    std::array<std::int32_t, 5> Weights{};
  };

  AttributeNeighbors();
  const std::vector<Row>& Get(int axis) const { return this->Rows[static_cast<std::size_t>(axis)]; }

private:
  std::array<std::vector<Row>, 3> Rows;
};

/**
 * Codes the values of a point array at the crossed edges of a block, slice after slice, each in the
 * order of CrossingCoder. A component is predicted as the mean of those decoded nearby, weighted by
 * their distances, and the difference is coded by one context.
 */
template <typename Coder>
class AttributeCoder
{
public:
  AttributeCoder(
    Coder& coder, const EdgeIndexAttribute& attribute, const AttributeEdges& edges, const int* size)
    : Output(coder)
    , Domain(attribute)
    , Edges(edges)
    , Size{ size[0], size[1], size[2] }
    , Components(static_cast<std::size_t>(attribute.NumberOfComponents))
  {
    for (std::unique_ptr<Component>& component : this->Components)
    {
      component = std::make_unique<Component>();
    }
  }

  /// Tells whether there are values that the domain has no code for; to be called first.
  void CodeExceptions(bool has)
  {
    this->HasExceptions = this->Output.CodeUniform(has ? 1 : 0, 1) != 0;
  }

  const AttributeDomain& GetDomain() const { return this->Domain; }

  /// Goes on to the next slice, of which all values are coded. `above` is null for the last one.
  void CodeSlice(int z, const SignSlice& slice, const SignSlice* above)
  {
    std::swap(this->Known[0], this->Known[1]);
    for (auto& rows : this->Known[0])
    {
      rows.fill(SignRow());
    }
    for (std::unique_ptr<Component>& component : this->Components)
    {
      std::swap(component->Codes[0], component->Codes[1]);
    }
    for (int y = 0; y < this->Size[1]; ++y)
    {
      for (int axis = 0; axis < 3; ++axis)
      {
        const SignRow edges = FindCrossedEdges(axis, y, slice, above, this->Size[0], this->Size[1]);
        const std::ptrdiff_t row = (std::ptrdiff_t(z) * this->Size[1] + y) * this->Size[0];
        VisitBits(edges, [&](int x) { this->CodeTuple(axis, x, y, row + x); });
      }
    }
  }

private:
  static constexpr std::ptrdiff_t RowStride = 80;
  static constexpr std::size_t PlaneSize = (MaximumCodedVertices + 4) * std::size_t(RowStride);
  using Plane = std::array<std::array<std::int64_t, PlaneSize>, 3>;

  struct Component
  {
    ResidualModel Residuals{ false, Priors.Crossings };
    AdaptiveBit Exception;
    std::array<std::unique_ptr<Plane>, 2> Codes{ std::make_unique<Plane>(),
      std::make_unique<Plane>() };
    /// The magnitude that came last at each place of a slice.
    std::array<std::array<std::uint16_t, PlaneSize>, 3> Levels{};
    std::int64_t Last = 0;
  };

  void CodeTuple(int axis, int x, int y, std::ptrdiff_t tuple)
  {
    const auto direction = static_cast<std::size_t>(axis);
    const std::size_t width = this->Domain.GetValueSize();
    std::uint8_t* value = this->Edges.First[direction] +
      static_cast<std::size_t>(tuple) * width * this->Components.size();
    for (std::unique_ptr<Component>& component : this->Components)
    {
      this->CodeComponent(*component, axis, x, y, value);
      value += width;
    }
    this->Known[0][direction][static_cast<std::size_t>(y + 2)].Set(x);
  }

  void CodeComponent(Component& component, int axis, int x, int y, std::uint8_t* value)
  {
    const auto direction = static_cast<std::size_t>(axis);
    const std::ptrdiff_t at = (y + 2) * RowStride + x + 8;
    const std::int64_t predicted = this->Predict(component, axis, x, y, at);
    std::int64_t& code = (*component.Codes[0])[direction][static_cast<std::size_t>(at)];
    if (this->HasExceptions)
    {
      bool isException = false;
      if constexpr (Coder::Encodes)
      {
        isException = !this->Domain.HasCode(value);
      }
      if (CodeAdaptive(this->Output, component.Exception, isException, 255))
      {
        this->CodeBits(value);
        code = predicted;
        return;
      }
    }
    if constexpr (Coder::Encodes)
    {
      code = this->Domain.ToCode(value);
    }
    auto& levels = component.Levels[direction];
    ResidualContext context;
    const auto level = [&levels, at](std::ptrdiff_t offset)
    { return int{ levels[static_cast<std::size_t>(at + offset)] }; };
    context.Level = (4 * (level(-1) + level(-RowStride) + level(0)) +
                      2 * (level(-RowStride - 1) + level(-RowStride + 1)) + 8) >>
      4;
    context.Sides[0] = static_cast<std::uint32_t>(direction);
    std::uint64_t magnitude = 0;
    if constexpr (Coder::Encodes)
    {
      const std::int64_t difference =
        this->Domain.Wrap(static_cast<std::uint64_t>(code) - static_cast<std::uint64_t>(predicted));
      magnitude = (static_cast<std::uint64_t>(difference) << 1) ^
        static_cast<std::uint64_t>(difference >> 63);
    }
    magnitude =
      ResidualCoder<Coder, false>(this->Output, component.Residuals).Code(magnitude, context);
    if constexpr (!Coder::Encodes)
    {
      const std::uint64_t difference = (magnitude >> 1) ^ (0 - (magnitude & 1));
      code = this->Domain.Wrap(static_cast<std::uint64_t>(predicted) + difference);
      this->Domain.ToValue(code, value);
    }
    levels[static_cast<std::size_t>(at)] = static_cast<std::uint16_t>(MeasureMagnitude(magnitude));
    component.Last = code;
  }

  std::int64_t Predict(const Component& component, int axis, int x, int y, std::ptrdiff_t at) const
  {
    std::int64_t base = component.Last;
    std::int64_t sum = 0;
    std::int64_t weights = 0;
    for (const AttributeNeighbors::Row& row : this->Neighbors.Get(axis))
    {
      std::uint32_t known =
        this->Known[row.Plane][row.Axis][static_cast<std::size_t>(y + row.Y + 2)].GetWindow(x) &
        row.Near;
      const std::int64_t* codes =
        (*component.Codes[row.Plane])[row.Axis].data() + at + row.Y * RowStride - 2;
      for (; known != 0; known &= known - 1)
      {
        const int place = __builtin_ctz(known);
        base = weights == 0 ? codes[place] : base;
        constexpr std::int64_t most = std::int64_t{ 1 } << 44;
        const auto difference = static_cast<std::int64_t>(
          static_cast<std::uint64_t>(codes[place]) - static_cast<std::uint64_t>(base));
        const std::int64_t weight = row.Weights[static_cast<std::size_t>(place)];
        sum += weight * std::clamp(difference, -most, most);
        weights += weight;
      }
    }
    return weights == 0 ? base
                        : this->Domain.Wrap(static_cast<std::uint64_t>(base) +
                            static_cast<std::uint64_t>(sum / weights));
  }

  // A value as it is.
  void CodeBits(std::uint8_t* value)
  {
    for (std::size_t n = 0; n < this->Domain.GetValueSize(); ++n)
    {
      std::uint32_t byte = 0;
      if constexpr (Coder::Encodes)
      {
        byte = value[n];
      }
      byte = this->Output.CodeUniform(byte, 8);
      if constexpr (!Coder::Encodes)
      {
        value[n] = static_cast<std::uint8_t>(byte);
      }
    }
  }

  Coder& Output;
  AttributeDomain Domain;
  AttributeEdges Edges;
  AttributeNeighbors Neighbors;
  bool HasExceptions = false;
  std::array<int, 3> Size;
  std::vector<std::unique_ptr<Component>> Components;
  /// Which edges of this slice and the one before have values: by axis, row y at y + 2.
  std::array<std::array<std::array<SignRow, MaximumCodedVertices + 4>, 3>, 2> Known;
};

} // namespace isosurface

#endif
