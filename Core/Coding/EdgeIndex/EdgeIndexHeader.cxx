// SPDX-License-Identifier: BSD-3-Clause
#include "Coding/EdgeIndex/EdgeIndexHeader.h"

#include <algorithm>
#include <cmath>

namespace isosurface
{
namespace
{

// So that GlobalIds (3 * vertex + axis, for every isovalue) fit 63 bits.
constexpr double MaximumGlobalIds = 9.0e18;

Status MakeInvalid(const char* reason)
{
  return { StatusCode::InvalidArgument, reason };
}

Status CheckGrid(const EdgeIndexHeader& header)
{
  double vertices = 1;
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    constexpr std::int64_t maximum = std::int64_t(1) << 40;
    const std::int64_t low = header.Geometry.Extent[2 * axis];
    const std::int64_t high = header.Geometry.Extent[2 * axis + 1];
    if (low < -maximum || high > maximum || high < low)
    {
      return MakeInvalid("The grid has no vertices or too many.");
    }
    vertices *= static_cast<double>(high - low + (header.ClosedSides.IsEmpty() ? 1 : 3));
  }
  const int idsOfVertex = header.ClosedSides.IsEmpty() ? 3 : 4;
  if (idsOfVertex * vertices *
      static_cast<double>(std::max<std::size_t>(1, header.Isovalues.size())) >
    MaximumGlobalIds)
  {
    return MakeInvalid("The grid has too many vertices for 64-bit ids of its edges.");
  }
  if (const char* fault = header.Geometry.FindFault())
  {
    return { StatusCode::InvalidArgument, std::string("The grid ") + fault + "." };
  }
  return Status::Ok();
}

Status CheckAttributes(const EdgeIndexHeader& header)
{
  if (header.Attributes.size() > MaximumAttributes)
  {
    return MakeInvalid("There are too many attributes.");
  }
  if (!header.ClosedSides.IsEmpty() && !header.Attributes.empty())
  {
    return MakeInvalid("Points of a closed surface have no attributes.");
  }
  int components = 0;
  int normals = 0;
  for (const EdgeIndexAttribute& attribute : header.Attributes)
  {
    components += attribute.NumberOfComponents;
    normals += attribute.IsNormals ? 1 : 0;
    if (attribute.Type != ValueType::Float32 && attribute.Type != ValueType::Float64)
    {
      return MakeInvalid("The type of an attribute must be float32 or float64.");
    }
    if (attribute.NumberOfComponents < 1 || attribute.NumberOfComponents > MaximumTupleSize)
    {
      return MakeInvalid("An attribute must have 1 to 64 components.");
    }
    if (attribute.Name.size() > MaximumTextSize)
    {
      return MakeInvalid("The name of an attribute is too long.");
    }
    if (!(attribute.MaximumError >= 0) || !std::isfinite(attribute.MaximumError))
    {
      return MakeInvalid("The maximum error of an attribute must be finite and not negative.");
    }
    if (attribute.IsNormals &&
      (attribute.Type != ValueType::Float32 || attribute.NumberOfComponents != 3))
    {
      return MakeInvalid("Normals must be three float32.");
    }
  }
  if (components > MaximumComponents || normals > 1)
  {
    return MakeInvalid("The attributes have more than 256 components together, or normals twice.");
  }
  return Status::Ok();
}

Status CheckPreview(const EdgeIndexHeader& header)
{
  if (header.PreviewLevel < 0 || header.PreviewLevel > MaximumPreviewLevel)
  {
    return MakeInvalid("The level of the preview must be 0 to 6.");
  }
  if (header.PreviewLevel > 0 &&
    (!(header.PreviewMaximumError > 0 && header.PreviewMaximumError <= 0.5) ||
      header.MakePreview().GetIntervals().GetCount() == 0))
  {
    return MakeInvalid("The maximum error of the preview must lie above 0 and not above 0.5 of its "
                       "grid's edges, and must not be finer than float coordinates.");
  }
  return Status::Ok();
}

Status CheckSettings(const EdgeIndexHeader& header)
{
  const EdgeIndexSettings& settings = header.Settings;
  if (header.LacksIslands && !header.ClosedSides.IsEmpty() &&
    settings.Mode != EdgeIndexMode::Lossless)
  {
    return MakeInvalid("A closed surface without some of its islands must be lossless.");
  }
  if (settings.Mode == EdgeIndexMode::Bounded || settings.Mode == EdgeIndexMode::Smallest)
  {
    if (!(settings.MaximumError > 0 && settings.MaximumError <= 0.5))
    {
      return MakeInvalid("The maximum error must lie above 0 and not above 0.5 of an edge.");
    }
    if (header.GetIntervals().GetCount() == 0)
    {
      return MakeInvalid("The maximum error is finer than float coordinates on this grid; lossless "
                         "mode keeps them exactly.");
    }
  }
  if (settings.Mode == EdgeIndexMode::Quantized)
  {
    if (settings.QuantizationBits < 2 || settings.QuantizationBits > 24)
    {
      return MakeInvalid("Values can be quantized to 2 to 24 bits.");
    }
    if (!std::isfinite(settings.QuantizationMinimum) ||
      !std::isfinite(settings.QuantizationMaximum) ||
      !std::isfinite(settings.QuantizationMaximum - settings.QuantizationMinimum) ||
      !(settings.QuantizationMinimum < settings.QuantizationMaximum))
    {
      return MakeInvalid("The range to quantize is empty or not finite.");
    }
  }
  return Status::Ok();
}

} // namespace

Status EdgeIndexHeader::Check() const
{
  if (this->Isovalues.size() > MaximumIsovalues)
  {
    return MakeInvalid("There are too many isovalues.");
  }
  if (this->Array.size() > MaximumTextSize || this->Source.size() > MaximumTextSize)
  {
    return MakeInvalid("The name of the array or of the source is too long.");
  }
  ISOSURFACE_RETURN_IF_ERROR(CheckGrid(*this));
  ISOSURFACE_RETURN_IF_ERROR(CheckAttributes(*this));
  ISOSURFACE_RETURN_IF_ERROR(CheckPreview(*this));
  return CheckSettings(*this);
}

void EdgeIndexHeader::TakeLosslessIfBoundIsTooFine()
{
  const double error = this->Settings.MaximumError;
  if (this->Settings.Mode == EdgeIndexMode::Smallest && error > 0 && error <= 0.5 &&
    this->GetIntervals().GetCount() == 0)
  {
    this->Settings.Mode = EdgeIndexMode::Lossless;
  }
}

CrossingIntervals EdgeIndexHeader::GetIntervals() const
{
  // A structured coordinate is rounded to float, and its parameter may be as well.
  double maximum = 1;
  for (const std::int64_t bound : this->Geometry.Extent)
  {
    maximum = std::max(maximum, std::abs(static_cast<double>(bound)) + 1);
  }
  int exponent = 0;
  std::frexp(maximum, &exponent);
  const double rounding = std::ldexp(1.0, exponent - 25) + std::ldexp(1.0, -20);
  const double spare = this->Settings.MaximumError - rounding;
  // Float parameters do not distinguish more intervals well. Lossless streams may have any error.
  if (!(spare > 0) || 0.5 / spare > 1048576.0 || this->Settings.MaximumError > 0.5)
  {
    return {};
  }
  return CrossingIntervals::MakeEqual(static_cast<std::uint32_t>(std::ceil(0.5 / spare)));
}

EdgeIndexHeader EdgeIndexHeader::MakePreview() const
{
  EdgeIndexHeader header = *this;
  header.Geometry = this->Geometry.Coarsen(this->PreviewLevel);
  header.Settings.Mode = EdgeIndexMode::Bounded;
  header.Settings.Profile = EdgeIndexProfile::Preview;
  header.Settings.MaximumError = this->PreviewMaximumError;
  header.PreviewLevel = 0;
  header.ClosedSides = {};
  header.KeptIds = this->KeptIdsOfPreview;
  header.Attributes.clear();
  return header;
}

ValueType EdgeIndexHeader::GetDecodedType() const
{
  return this->Settings.Mode == EdgeIndexMode::Quantized ? ValueType::Float32 : this->Type;
}

} // namespace isosurface
