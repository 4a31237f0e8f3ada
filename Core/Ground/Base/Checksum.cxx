// SPDX-License-Identifier: BSD-3-Clause
#include "Ground/Base/Checksum.h"

#include <xxhash.h>

#include <array>

namespace isosurface
{
namespace
{

constexpr std::uint8_t NoDigit = 16;

/// The value of each character as a digit. Digits of a checksum are random, so branches would cost
/// more.
constexpr std::array<std::uint8_t, 256> MakeDigitValues()
{
  std::array<std::uint8_t, 256> values{};
  for (std::uint8_t& value : values)
  {
    value = NoDigit;
  }
  for (std::uint8_t value = 0; value < 16; ++value)
  {
    values[static_cast<std::size_t>(value < 10 ? '0' + value : 'a' + value - 10)] = value;
  }
  return values;
}

} // namespace

std::uint64_t ComputeChecksum(const void* bytes, std::size_t size, std::uint64_t seed)
{
  return XXH3_64bits_withSeed(bytes, size, seed);
}

std::string FormatChecksum(std::uint64_t checksum)
{
  std::string text(16, '0');
  for (std::size_t digit = 16; digit-- > 0; checksum >>= 4)
  {
    text[digit] = "0123456789abcdef"[checksum & 15];
  }
  return text;
}

bool ParseChecksum(const char* digits, std::uint64_t& checksum)
{
  static constexpr std::array<std::uint8_t, 256> values = MakeDigitValues();
  std::uint64_t parsed = 0;
  std::uint8_t found = 0;
  for (int digit = 0; digit < 16; ++digit)
  {
    const std::uint8_t value = values[static_cast<std::uint8_t>(digits[digit])];
    found |= value;
    parsed = parsed << 4 | (value & 15);
  }
  checksum = parsed;
  return found < NoDigit;
}

} // namespace isosurface
