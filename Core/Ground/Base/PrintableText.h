// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_PrintableText_h
#define isosurface_PrintableText_h

#include <cstdint>
#include <string>

namespace isosurface
{

/// The text with its control characters (of ASCII, and U+0080 to U+009F in UTF-8) as escapes such as
/// "\x1b", so that a terminal obeys no text of a file. Lines stay lines.
std::string MakePrintable(const std::string& text);

/// "31 B", "4.7 MB", "12 GB": bytes in decimal units.
std::string DescribeBytes(double bytes);
inline std::string DescribeBytes(std::uint64_t bytes)
{
  return DescribeBytes(static_cast<double>(bytes));
}

} // namespace isosurface

#endif
