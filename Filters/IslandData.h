// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_IslandData_h
#define isosurface_IslandData_h

#include "Ranks/Islands/IslandChoice.h"

#include <string>
#include <vector>

class vtkPolyData;

namespace isosurface
{

/// Adds what was found to the output's field data (see vtkStabbingContour::SetMinimumIslandSize),
/// and the ids of the cells, if there are any, whose memory the output takes.
void AddIslands(ChosenIslands& islands, bool ids, double seconds, vtkPolyData* output);

/// For people: "3 of 12,408 islands, 98.2 % of the triangles", of several isovalues one after another. Null:
/// islands were not looked for.
std::string SummariseIslands(const ChosenIslands* islands, const std::vector<double>& isovalues);

} // namespace isosurface

#endif
