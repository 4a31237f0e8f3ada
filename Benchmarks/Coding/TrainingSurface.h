// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_TrainingSurface_h
#define isosurface_TrainingSurface_h

#include "Coding/EdgeIndex/EdgeIndexHeader.h"
#include "Ground/Volume/BlockGrid.h"
#include "Ground/Volume/SampleView.h"

#include <CLI/CLI.hpp>

#include <string>
#include <vector>

namespace isosurface
{

/// An isosurface to learn from, in blocks of 64^3 cells.
struct TrainingSurface
{
  std::vector<char> Bytes; ///< the samples
  SampleView View;
  BlockGrid Grid;
  EdgeIndexHeader Header;
};

/// Adds the option --surface, which has six words for each surface.
void AddSurfaceOption(CLI::App& application, std::vector<std::string>& words);

/// Reads the surfaces of the option, and adds two of generated fields. Prints on standard error which
/// file cannot be read.
bool ReadSurfaces(const std::vector<std::string>& words, std::vector<TrainingSurface>& surfaces);

} // namespace isosurface

#endif
