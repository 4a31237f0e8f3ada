// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_AttributeDomain_h
#define isosurface_AttributeDomain_h

#include "Ground/Volume/ValueType.h"

#include <cstddef>
#include <cstdint>

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

} // namespace isosurface

#endif
