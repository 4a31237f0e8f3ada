// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_SampledBlock_h
#define isosurface_SampledBlock_h

#include "Coding/BlockCoding/BlockCoding.h"
#include "Coding/BlockCoding/Quantizer.h"
#include "Ground/Volume/BlockSource.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace isosurface
{

/// Gives the samples of a block to an encoder. Signs are computed by the brick kernel. The view, and
/// the objects that are set, must outlive it.
class SampledBlock : public BlockValues
{
public:
  SampledBlock(const SampleView& view, double isovalue, const CrossingIntervals& intervals);

  const std::array<int, 3>& GetSize() const { return this->Size; }
  const CrossingIntervals& GetIntervals() const { return this->Intervals; }
  bool IsCrossed() const { return this->Crossed; }
  /// Whether any vertex is inside.
  bool HasInside() const { return this->Inside; }
  std::uint64_t CountPoints() const;
  /// Codes are those of the quantizer, or without one those of the domain.
  void SetDomain(const ValueDomain* domain) { this->Domain = domain; }
  void SetQuantizer(const Quantizer* quantizer) { this->Quantization = quantizer; }

  /// The point arrays that are coded with the block, without HasExceptions; none unless set.
  void SetAttributes(std::vector<CodedAttribute> attributes);
  const std::vector<CodedAttribute>& GetAttributes() const { return this->Attributes; }

  SignSlice& GetSigns(int z) override { return this->Signs[static_cast<std::size_t>(z)]; }
  void FinishSigns(int) override {}
  bool FinishSlice(int) override { return true; }

  void ExchangeCodes(int y, int z, const SignRow& vertices, std::int64_t* codes) override;

  void ExchangeBins(int axis, int y, int z, const SignRow& edges, std::uint32_t* bins) override;

  /// The mean distance of values from the isovalue at relevant vertices, estimated from the first
  /// ones.
  double MeasureDistance() const;

  /// The scale of the domain of its values without error; see ValueDomain.
  int ChooseLosslessScale() const;

  bool HasMissingCrossings() const;

  /// Stores the middles of the intervals of all crossings on the block's faces. crossings[axis] is for
  /// the edge along the axis from each vertex, x fastest.
  void RoundOnFaces(const std::array<float*, 3>& crossings);

private:
  // Whether some value at a crossed edge has no code.
  bool HasExceptions(const CodedAttribute& attribute) const;

  const std::uint8_t* At(int x, int y, int z) const
  {
    return this->First + x * this->Stride[0] + y * this->Stride[1] + z * this->Stride[2];
  }

  double GetDouble(const std::uint8_t* sample) const;

  template <typename T>
  double FindTypedCrossing(const std::uint8_t* from, int axis) const;
  double FindCrossing(const std::uint8_t* from, int axis) const;

  // Calls functor(y, z, crossed edges along each axis) for rows until it returns false.
  template <typename Functor>
  void VisitCrossedRows(const Functor& functor) const;

  // Calls functor(first sample, axis) for crossed edges until it returns false.
  template <typename Functor>
  void VisitCrossings(const Functor& functor) const;

  // Computes the signs; in 32 columns from x = begin on. threshold: a number of the samples' type.
  void Classify();
  void ClassifyColumns(int begin, const void* threshold);

  const SampleView& View;
  double Isovalue;
  CrossingIntervals Intervals;
  std::array<int, 3> Size{};
  const std::uint8_t* First = nullptr;
  std::array<std::ptrdiff_t, 3> Stride{}; ///< in bytes
  const ValueDomain* Domain = nullptr;
  const Quantizer* Quantization = nullptr;
  std::array<SignSlice, MaximumCodedVertices> Signs;
  bool Crossed = false;
  bool Inside = false;
  std::vector<CodedAttribute> Attributes;
};

} // namespace isosurface

#endif
