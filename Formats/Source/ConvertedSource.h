// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_ConvertedSource_h
#define isosurface_ConvertedSource_h

#include "Ground/Volume/BoxSource.h"
#include "Ground/Volume/PageBuffer.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>

namespace isosurface
{

/// What a stored number stands for: Slope * number + Intercept.
struct SampleScale
{
  double Slope = 1;
  double Intercept = 0;

  bool IsIdentity() const { return this->Slope == 1 && this->Intercept == 0; }
};

/// The type of scaled samples: float32 if the numbers have at most 16 bits or are float32, otherwise
/// float64.
ValueType FindScaledType(ValueType stored);

/// Scales samples of type `stored` without gaps to `type`, in double precision. Values beyond an
/// integer type are cut to its ends.
void ScaleSamples(ValueType stored, const void* from, std::size_t count, SampleScale scale,
  ValueType type, void* to);

/// The value of an IEEE float of 16 bits.
float WidenHalf(std::uint16_t bits);

/// The samples of another source of one component, converted. Scaling is done in double precision.
class ConvertedSource : public BoxSource
{
public:
  /// Scales samples of type `stored` to `type`.
  ConvertedSource(
    std::unique_ptr<BoxSource> source, ValueType stored, SampleScale scale, ValueType type);
  /// Widens floats of 16 bits, which the source has as uint16, to float32.
  explicit ConvertedSource(std::unique_ptr<BoxSource> halves);

  const VertexBox& GetBox() const override { return this->Source->GetBox(); }
  std::uint64_t GetReadBytes(const VertexBox& box) const override;
  std::uint64_t GetHeldBytes() const override { return this->Source->GetHeldBytes(); }
  std::int64_t GetRowsAtOnce() const override { return this->Source->GetRowsAtOnce(); }
  std::optional<Index3> GetChunk() const override { return this->Source->GetChunk(); }
  bool HasCheapRows() const override { return this->Source->HasCheapRows(); }
  bool DecodesInParallel() const override { return this->Source->DecodesInParallel(); }
  void Prefetch(const VertexBox& box) const override { this->Source->Prefetch(box); }
  bool CanReadAhead() const override { return this->Source->CanReadAhead(); }
  Result<BoxSamples> Read(const VertexBox& box) override;

private:
  std::unique_ptr<BoxSource> Source;
  ValueType Stored;
  SampleScale Scale;
  ValueType Type;
  bool IsHalf = false;
  std::shared_ptr<PageBufferPool> Pool;
};

} // namespace isosurface

#endif
