// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_TiffUnits_h
#define isosurface_TiffUnits_h

#include <array>
#include <string>

namespace isosurface
{

/// The unit of length that OME or ImageJ names; empty for pixels.
std::string NormalizeUnit(const std::string& unit);

/// Brings lengths on three axes to the unit of the first one. False if they have several, and one of
/// them is no known unit of length; then they stay.
bool UniteLengths(std::array<double, 3>& lengths, const std::array<std::string, 3>& units);

} // namespace isosurface

#endif
