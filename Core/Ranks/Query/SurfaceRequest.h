// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_SurfaceRequest_h
#define isosurface_SurfaceRequest_h

#include "Ground/Base/Communicator.h"
#include "Ground/Volume/Region.h"
#include "Ranks/Islands/IslandChoice.h"
#include "Ranks/Query/LevelChoice.h"
#include "Ranks/Sharing/QueryPlan.h"
#include "Surface/Contour/Surface.h"

#include <array>
#include <cstddef>
#include <optional>
#include <vector>

namespace isosurface
{

/// Which isosurfaces, where, and what they may cost. Attributes are those of Arrays.
struct SurfaceRequest : ContourRequest
{
  Region Where; ///< only blocks that meet it
  /// The box that Where is, x0 x1 y0 y1 z0 z1, if it is one: of a volume at an address, a surface has its cells alone.
  std::optional<std::array<double, 6>> Bounds;
  std::optional<IslandRequest> Islands; ///< nothing: all
  std::vector<std::size_t> Arrays;      ///< of a volume, to interpolate
  ExtractionBudget Budget;
  int Threads = 1;
  Communicator* Ranks = nullptr; ///< that share the surface; null: this process alone has it

  SurfaceRequest() { this->NormalsRoundedOnce = true; }

  /// Closes the surface around what is inside or, with `isBelow`, around what is outside. Caps meet in triangles
  /// without area, which are dropped.
  void Close(bool isBelow)
  {
    this->ClosedSides = GridSides::All();
    this->ClosedSides.AreBeyondInside = isBelow;
    this->DropDegenerateTriangles = true;
  }

  SurfaceQuery MakeQuery(std::size_t timeStep, std::size_t variable) const
  {
    return { { timeStep, variable, this->Isovalues, { this->ClosedSides, this->Where } },
      this->Ranks ? this->Ranks->GetRank() : 0, this->Ranks ? this->Ranks->GetSize() : 1,
      this->Arrays };
  }
};

} // namespace isosurface

#endif
