// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_PrintableText_h
#define isosurface_PrintableText_h

#include <string>

namespace isosurface
{

/// The text with its control characters (of ASCII, and U+0080 to U+009F in UTF-8) as escapes such as
/// "\x1b", so that a terminal obeys no text of a file. Lines stay lines.
std::string MakePrintable(const std::string& text);

} // namespace isosurface

#endif
