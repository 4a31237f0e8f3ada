// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_Refinement_h
#define isosurface_Refinement_h

#include <array>

namespace isosurface
{

/// The number of parts in which ranks agree on shares.
constexpr double Millionths = 1e6;

/// How far the surface that follows a coarse one is.
enum class RefinementStage
{
  None = 0,     ///< the surface is final, or nothing was extracted since the last change
  Working = 1,  ///< it is being extracted
  Ready = 2,    ///< all ranks have it: Refine costs next to nothing
  TooLarge = 3, ///< it is not extracted, since it would not fit into memory
  Growing = 4   ///< that of a sample; it becomes exact where its file is indexed meanwhile
};

/// Of a progressive surface or slice; equal on all ranks.
struct Refinement
{
  RefinementStage Stage = RefinementStage::None;
  int ShownLevel = 0;
  int NextLevel = 0;    ///< that is being extracted
  int FinalLevel = 0;   ///< the level without which the surface is not final
  int FittingLevel = 0; ///< the finest level that fits into memory
  double Share = 0;     ///< of the next level that is extracted, 0 to 1
  double Triangles = 0; ///< of the next level, estimated, of all ranks
  double Bytes = 0;     ///< of memory that these need on a rank
  double FreeBytes = 0; ///< of memory that the rank with the minimum has; 0: unknown

  /// As a window takes it.
  std::array<double, 9> List() const
  {
    return { static_cast<double>(this->Stage), static_cast<double>(this->ShownLevel),
      static_cast<double>(this->NextLevel), static_cast<double>(this->FinalLevel),
      static_cast<double>(this->FittingLevel), this->Share, this->Triangles, this->Bytes,
      this->FreeBytes };
  }
};

} // namespace isosurface

#endif
