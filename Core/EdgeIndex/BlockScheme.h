// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_BlockScheme_h
#define isosurface_BlockScheme_h

namespace isosurface
{

/// How blocks are coded; follows from the profile and the version of the format.
enum class BlockScheme
{
  Fast,   ///< one context each
  Mixed,  ///< probabilities mixed of several contexts: the profile Default
  Fitted, ///< Mixed, but values are predicted by a fit: Compact of version 2, which is only read
  Compact ///< Compact of version 3
};

/// Whether probabilities are mixed of several contexts.
constexpr bool IsMixed(BlockScheme scheme)
{
  return scheme != BlockScheme::Fast;
}

/// Whether values are predicted by a fit to those around (HeightFit).
constexpr bool IsFitted(BlockScheme scheme)
{
  return scheme == BlockScheme::Fitted || scheme == BlockScheme::Compact;
}

/// Whether crossings are predicted by curved surfaces, and their intervals have a width.
constexpr bool IsCurved(BlockScheme scheme)
{
  return scheme == BlockScheme::Compact;
}

} // namespace isosurface

#endif
