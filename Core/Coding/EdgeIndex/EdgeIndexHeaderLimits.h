// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_EdgeIndexHeaderLimits_h
#define isosurface_EdgeIndexHeaderLimits_h

#include <cstddef>

// Maxima of the format.
namespace isosurface
{

constexpr std::size_t MaximumIsovalues = 65536;
constexpr std::size_t MaximumAttributes = 256;
constexpr std::size_t MaximumTextSize = 65535;
constexpr int MaximumPreviewLevel = 6;
constexpr int MaximumTupleSize = 64;
constexpr int MaximumComponents = 256; ///< of all attributes together

} // namespace isosurface

#endif
