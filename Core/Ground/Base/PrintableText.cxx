// SPDX-License-Identifier: BSD-3-Clause
#include "Ground/Base/PrintableText.h"

#include <array>
#include <cstddef>
#include <cstdio>

namespace isosurface
{

std::string MakePrintable(const std::string& text)
{
  constexpr const char* digits = "0123456789abcdef";
  std::string printable;
  for (std::size_t at = 0; at < text.size(); ++at)
  {
    auto byte = static_cast<unsigned char>(text[at]);
    const auto next = static_cast<unsigned char>(at + 1 < text.size() ? text[at + 1] : 0);
    const bool isWide = byte == 0xc2 && next >= 0x80 && next < 0xa0;
    if (!isWide && (byte == '\n' || (byte >= 0x20 && byte != 0x7f)))
    {
      printable += text[at];
      continue;
    }
    byte = isWide ? next : byte;
    at += isWide ? 1 : 0;
    printable += { '\\', 'x', digits[byte >> 4], digits[byte & 15] };
  }
  return printable;
}

std::string DescribeBytes(double bytes)
{
  const std::array<const char*, 6> units = { "B", "kB", "MB", "GB", "TB", "PB" };
  std::size_t unit = 0;
  while (bytes >= 1000 && unit + 1 < units.size())
  {
    bytes /= 1000;
    ++unit;
  }
  std::array<char, 32> text{};
  std::snprintf(
    text.data(), text.size(), bytes < 10 && unit > 0 ? "%.1f %s" : "%.0f %s", bytes, units[unit]);
  return text.data();
}

} // namespace isosurface
