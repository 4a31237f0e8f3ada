// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_JsonDepth_h
#define isosurface_JsonDepth_h

#include <string>

namespace isosurface
{

/// Whether objects and arrays in the text of a JSON document are nested deeper than `depth`. The
/// parser's own callback could tell, too, but takes quadratic time in long arrays; and what copies,
/// formats or frees a parsed document is recursive, so this is asked first. Cost: one pass.
bool IsJsonDeeperThan(const std::string& text, int depth);

} // namespace isosurface

#endif
