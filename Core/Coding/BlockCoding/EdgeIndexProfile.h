// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_EdgeIndexProfile_h
#define isosurface_EdgeIndexProfile_h

#include <cstdint>

namespace isosurface
{

/// How much time is spent on coding few bits. The numbers are those of the file format.
enum class EdgeIndexProfile : std::uint8_t
{
  Small = 0,   ///< probabilities that learn, mixed from several contexts
  Preview = 1, ///< one context for each probability; only for the blocks of previews
  Working = 3  ///< nothing is learnt: planes of bytes, see BytePlanes
};

/// The profile of a number that a script or state may have; 1 and 2 were others in version 1.0.
constexpr EdgeIndexProfile FindNearestProfile(int number)
{
  return number <= 0 || number == 2 ? EdgeIndexProfile::Small : EdgeIndexProfile::Working;
}

} // namespace isosurface

#endif
