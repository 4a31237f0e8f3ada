// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_AttributeDomain_h
#define isosurface_AttributeDomain_h

#include "EdgeIndex/EdgeIndexHeader.h"

#include <cstddef>
#include <cstdint>

namespace isosurface
{

/**
 * Values of a point array (float32 or float64) as the integers that are coded.
 *
 * - kept bit by bit: the bits in the order of the values (ValueDomain);
 * - with a bounded error: the nearest multiple of a step slightly below twice the error. Values
 * that are not finite, or so great that a rounded multiple would be too far away, have no code.
 */
class AttributeDomain
{
public:
  explicit AttributeDomain(const EdgeIndexAttribute& attribute);

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
  double Step; ///< 0 if values are kept bit by bit
};

} // namespace isosurface

#endif
