// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_RankGroup_h
#define isosurface_RankGroup_h

#include "EdgeSurface.h"

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

class vtkMultiProcessController;
class vtkPolyData;

namespace isosurface
{

/// All ranks of this program. What is collective is entered by every rank, so tests that use it
/// must not return early on some ranks: EXPECT, not ASSERT.
vtkMultiProcessController* GetRanks();
int GetRank();
int GetNumberOfRanks();

/// Collective: the sum over all ranks, on all ranks.
std::uint64_t SumOverRanks(std::uint64_t mine);

/// Collective: all ranks' surfaces put together, on rank 0; empty elsewhere. Points that several
/// ranks have are there several times.
EdgeSurface GatherSurfaces(const EdgeSurface& mine);

/// Collective: the same of a contour's outputs, or of their triangles with ids in a range. Points
/// that are equal on several ranks are there once.
EdgeSurface GatherSurface(
  vtkPolyData* mine, std::int64_t firstId = 0, std::int64_t endId = INT64_MAX);

/// Collective: rank 0 does something while no other one does anything.
void OnFirstRank(const std::function<void()>& deed);

/// Collective: all ranks' texts, on all ranks.
std::vector<std::string> GatherTexts(const std::string& mine);

} // namespace isosurface

#endif
