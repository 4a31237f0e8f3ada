// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_AttributeCoder_h
#define isosurface_AttributeCoder_h

#include "Coding/BlockCoding/ResidualCoder.h"
#include "Coding/Prediction/SignRows.h"
#include "Ground/Volume/ValueType.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

namespace isosurface
{

/**
 * Maps values of a point array (float32 or float64) to the integers that are coded.
 *
 * - Without error: the bits in the order of the values, see ValueDomain.
 * - With a maximum error: the nearest multiple of a step slightly below twice the error. Values that
 *   are not finite, or so large that a rounded multiple exceeds the error, have no code.
 */
class AttributeDomain
{
public:
  /// maximumError: 0 to keep every bit.
  AttributeDomain(ValueType type, double maximumError);

  std::size_t GetValueSize() const { return this->ValueSize; }

  /// Whether a value (of any alignment) has a code.
  bool HasCode(const std::uint8_t* value) const;
  std::int64_t ToCode(const std::uint8_t* value) const;
  void ToValue(std::int64_t code, std::uint8_t* value) const;

  /// A code modulo 2^32 for float32, modulo 2^64 for others.
  std::int64_t Wrap(std::uint64_t code) const
  {
    return this->IsNarrow ? static_cast<std::int32_t>(static_cast<std::uint32_t>(code))
                          : static_cast<std::int64_t>(code);
  }

private:
  double Load(const std::uint8_t* value) const;
  double Restore(std::int64_t code) const;

  ValueType Type;
  std::size_t ValueSize;
  bool IsNarrow;
  double MaximumError;
  double Step; ///< 0 if every bit is kept
};

/// The edges near an edge from whose tuples its tuple is predicted, with their weights.
class AttributeNeighbors
{
public:
  /// The edges along one axis that begin in one row, at x - 2 to x + 2.
  struct Row
  {
    std::size_t Plane = 0; ///< 0: this slice; 1: the one before
    std::size_t Axis = 0;
    int Y = 0;              ///< relative to the edge
    std::uint32_t Near = 0; ///< bits of the edges that are near enough
    std::array<std::int32_t, 5> Weights{};
  };

  /// The table for all blocks, made by the first call.
  static const AttributeNeighbors& Get();

  const std::vector<Row>& GetRows(int axis) const
  {
    return this->Rows[static_cast<std::size_t>(axis)];
  }

private:
  AttributeNeighbors();

  std::array<std::vector<Row>, 3> Rows;
};

/// The tuples of a point array at the edges of a block: First[axis] is that of the edge along the
/// axis at the first vertex, then x fastest, without gaps. Only those of crossed edges are accessed.
struct AttributeEdges
{
  std::array<std::uint8_t*, 3> First{};
};

/// A point array that is coded with a block.
struct CodedAttribute
{
  ValueType Type = ValueType::Float32; ///< or Float64
  int NumberOfComponents = 1;
  double MaximumError = 0; ///< 0 keeps every bit
  AttributeEdges Edges;    ///< tuples that are given, or to be set
  bool HasExceptions =
    false; ///< when encoding: some values have no code (AttributeDomain::HasCode)
};

/**
 * Codes the tuples of a point array at the crossed edges of a block, slice after slice, each in the
 * order of CrossingCoder. A component is predicted by the mean of the components decoded nearby,
 * weighted by distance; the difference is coded in one context.
 */
template <typename Coder>
class AttributeCoder
{
public:
  /// Also codes whether the attribute has exceptions. size: of the block, in vertices.
  AttributeCoder(Coder& coder, const CodedAttribute& attribute, const std::array<int, 3>& size)
    : Output(coder)
    , Domain(attribute.Type, attribute.MaximumError)
    , Edges(attribute.Edges)
    , HasExceptions(coder.CodeUniform(attribute.HasExceptions ? 1 : 0, 1) != 0)
    , Size(size)
    , Components(static_cast<std::size_t>(attribute.NumberOfComponents))
  {
    for (std::unique_ptr<Component>& component : this->Components)
    {
      component = std::make_unique<Component>();
    }
  }

  /// Codes the tuples at edges that begin in slice z. above: the next slice, null for the last one.
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
    ResidualModel Residuals;
    AdaptiveBit Exception;
    std::array<std::unique_ptr<Plane>, 2> Codes{ std::make_unique<Plane>(),
      std::make_unique<Plane>() };
    /// The level of the magnitude that was coded last at each place of a slice.
    std::array<std::array<std::uint16_t, PlaneSize>, 3> Levels{};
    std::int64_t Last = 0; ///< the code that was coded last; predicts where no neighbour is known
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
    if (this->HasExceptions && this->CodeException(component, value))
    {
      code = predicted;
      return;
    }
    std::uint16_t* level = component.Levels[direction].data() + at;
    ResidualContext context;
    context.Level = FindExpectedLevel(level, RowStride);
    context.Sides[0] = static_cast<std::uint32_t>(direction);
    std::uint64_t magnitude = 0;
    if constexpr (Coder::Encodes)
    {
      code = this->Domain.ToCode(value);
      magnitude = MakeMagnitude(this->Domain.Wrap(
        static_cast<std::uint64_t>(code) - static_cast<std::uint64_t>(predicted)));
    }
    magnitude =
      ResidualCoder<Coder, false>(this->Output, component.Residuals).Code(magnitude, context);
    if constexpr (!Coder::Encodes)
    {
      code = this->Domain.Wrap(static_cast<std::uint64_t>(predicted) + MakeDifference(magnitude));
      this->Domain.ToValue(code, value);
    }
    *level = static_cast<std::uint16_t>(MeasureMagnitude(magnitude));
    component.Last = code;
  }

  // Codes whether a value has no code; if so, its bytes, too.
  bool CodeException(Component& component, std::uint8_t* value)
  {
    bool isException = false;
    if constexpr (Coder::Encodes)
    {
      isException = !this->Domain.HasCode(value);
    }
    isException = CodeAdaptive(this->Output, component.Exception, isException, 255);
    if (isException)
    {
      this->CodeBytes(value);
    }
    return isException;
  }

  std::int64_t Predict(const Component& component, int axis, int x, int y, std::ptrdiff_t at) const
  {
    std::int64_t base = component.Last;
    std::int64_t sum = 0;
    std::int64_t weights = 0;
    for (const AttributeNeighbors::Row& row : this->Neighbors.GetRows(axis))
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
        constexpr std::int64_t maximum = std::int64_t{ 1 } << 44;
        const auto difference = static_cast<std::int64_t>(
          static_cast<std::uint64_t>(codes[place]) - static_cast<std::uint64_t>(base));
        const std::int64_t weight = row.Weights[static_cast<std::size_t>(place)];
        sum += weight * std::clamp(difference, -maximum, maximum);
        weights += weight;
      }
    }
    return weights == 0 ? base
                        : this->Domain.Wrap(static_cast<std::uint64_t>(base) +
                            static_cast<std::uint64_t>(sum / weights));
  }

  void CodeBytes(std::uint8_t* value)
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
  const AttributeNeighbors& Neighbors = AttributeNeighbors::Get();
  bool HasExceptions;
  std::array<int, 3> Size;
  std::vector<std::unique_ptr<Component>> Components;
  /// The edges with tuples in this slice and the one before: [slice][axis][y + 2].
  std::array<std::array<std::array<SignRow, MaximumCodedVertices + 4>, 3>, 2> Known;
};

} // namespace isosurface

#endif
