// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_Tissues_h
#define isosurface_Tissues_h

#include <array>
#include <cstring>

namespace isosurface
{

/// What is usually looked for in a CT, and how it is shown.
struct Tissue
{
  const char* Name;
  double Isovalue; ///< in Hounsfield units: air is -1000, water 0
  std::array<double, 3> Color;
  double Opacity; ///< beside other surfaces
};

/// From the outside to the inside. Documentation/reference/choosing-isovalues.md tells where the isovalues
/// are from.
constexpr std::array<Tissue, 4> Tissues = { { { "Skin", -300, { 0.93, 0.76, 0.65 }, 0.35 },
  { "Muscle", 50, { 0.72, 0.33, 0.29 }, 0.6 }, { "Bone", 300, { 0.95, 0.91, 0.80 }, 1 },
  { "Metal", 2500, { 0.70, 0.74, 0.80 }, 1 } } };

/// The tissue of a CT that is shown before any is chosen.
constexpr const Tissue& Bone = Tissues[2];

/// Whether isovalues of this unit are those of Tissues.
inline bool AreTissuesIn(const char* unit)
{
  return unit && std::strcmp(unit, "HU") == 0;
}

} // namespace isosurface

#endif
