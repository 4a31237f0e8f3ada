// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_EdgeIndexProfile_h
#define isosurface_EdgeIndexProfile_h

#include <cstdint>

namespace isosurface
{

/// How much time is spent on coding few bits. The numbers are those of the file format.
enum class EdgeIndexProfile : std::uint8_t
{
  Default = 0, ///< probabilities mixed from several contexts
  Fast = 1,    ///< one context for each probability
  Compact = 2, ///< mixed as well; signs, values and crossings have predictions that take longer
  Working = 3  ///< nothing is learnt: planes of bytes, see BytePlanes
};

/// Whether probabilities are mixed from several contexts.
constexpr bool IsMixed(EdgeIndexProfile profile)
{
  return profile == EdgeIndexProfile::Default || profile == EdgeIndexProfile::Compact;
}

} // namespace isosurface

#endif
