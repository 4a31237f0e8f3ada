// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_RankGroup_h
#define isosurface_RankGroup_h

#include "EdgeSurface.h"

#include <cstdint>
#include <string>
#include <vector>

class vtkMultiProcessController;

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

/// Collective: all ranks' texts, on all ranks.
std::vector<std::string> GatherTexts(const std::string& mine);

} // namespace isosurface

#endif
