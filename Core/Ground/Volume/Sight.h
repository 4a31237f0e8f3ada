// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_Sight_h
#define isosurface_Sight_h

#include <array>

namespace isosurface
{

/// What a view shows of the world: a line of sight, and what is around it.
struct Sight
{
  std::array<double, 3> Eye{};
  std::array<double, 3> Direction{ 0, 0, -1 }; ///< of length 1
  double Radius = 0;                           ///< that is seen at the eye
  double Widening = 0;                         ///< of the radius with each unit of the distance

  double FindRadius(double distance) const { return this->Radius + this->Widening * distance; }
  bool operator==(const Sight& other) const
  {
    return this->Eye == other.Eye && this->Direction == other.Direction &&
      this->Radius == other.Radius && this->Widening == other.Widening;
  }
};

} // namespace isosurface

#endif
