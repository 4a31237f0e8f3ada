// SPDX-License-Identifier: BSD-3-Clause
/**
 * Learns what the edge-index models know before their first block, and writes
 * Core/EdgeIndex/EdgeIndexPriors.cxx, or with --crossings CurvedCrossingPriors.cxx. Blocks of all
 * surfaces take turns, so that none is learnt last. Needed after a change of a model only; then the
 * format's version goes up.
 */
#include "TrainingSurface.h"

#include "EdgeIndex/BlockCoder.h"
#include "EdgeIndex/EdgeIndexEncoder.h"
#include "EdgeIndex/EdgeIndexPriors.h"

#include <CLI/CLI.hpp>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <string>
#include <vector>

using namespace isosurface;

namespace
{

/// errors: the largest ones, in voxels, to code each block at; 0 for lossless.
void Learn(std::vector<TrainingSurface>& surfaces, EdgeIndexProfile profile,
  const std::vector<double>& errors, BlockModel& model)
{
  std::int64_t most = 0;
  for (const TrainingSurface& surface : surfaces)
  {
    most = std::max(most, surface.Grid.GetNumberOfBlocks());
  }
  // Blocks in an order of no meaning, shares of all surfaces even.
  constexpr std::int64_t stride = 7919;
  for (std::int64_t step = 0; step < 2 * most; ++step)
  {
    for (TrainingSurface& surface : surfaces)
    {
      const std::int64_t blocks = surface.Grid.GetNumberOfBlocks();
      if (step * blocks / (2 * most) == (step + 1) * blocks / (2 * most))
      {
        continue;
      }
      const std::int64_t block = step * blocks / (2 * most) * stride % blocks;
      BlockSamples samples;
      samples.Scalars = surface.View;
      samples.Scalars.Box = surface.Grid.GetVertices(block);
      for (const double error : errors)
      {
        EdgeIndexHeader header = surface.Header;
        header.Settings.Profile = profile;
        header.Settings.Mode = error == 0 ? EdgeIndexMode::Lossless : EdgeIndexMode::Bounded;
        header.Settings.MaximumError = error == 0 ? 0.1 : error;
        EdgeIndexEncoder encoder(header, &model);
        std::vector<std::uint8_t> bytes;
        if (!encoder.EncodeBlock({}, samples, 0, bytes).IsOk())
        {
          std::fprintf(stderr, "a block cannot be encoded\n");
          std::exit(1);
        }
        if (profile == EdgeIndexProfile::Compact)
        {
          ForgetSides(model.Crossings.Residuals);
        }
      }
    }
  }
}

} // namespace

int main(int argc, char** argv)
{
  std::string output;
  std::vector<std::string> words;
  bool crossings = false;
  CLI::App application("Learns the priors of the edge-index code");
  application.add_option("output", output, "the source file to write")->required();
  application.add_flag("--crossings", crossings, "of the crossings of the profile compact");
  AddSurfaceOption(application, words);
  CLI11_PARSE(application, argc, argv);

  std::vector<TrainingSurface> surfaces;
  if (!ReadSurfaces(words, surfaces))
  {
    return 1;
  }
  std::ofstream file(output);
  if (crossings)
  {
    BlockModel compact(BlockScheme::Compact);
    Learn(surfaces, EdgeIndexProfile::Compact, { 0.09, 0.011, 0.06, 0.02, 0.075, 0.006 }, compact);
    file << WriteCrossingPriors(compact);
    return file ? 0 : 1;
  }
  BlockModel mixed(BlockScheme::Mixed);
  BlockModel fast(BlockScheme::Fast);
  Learn(surfaces, EdgeIndexProfile::Default, { 0.0, 0.09, 0.02 }, mixed);
  Learn(surfaces, EdgeIndexProfile::Fast, { 0.0, 0.09, 0.02 }, fast);
  file << WritePriors(mixed, fast);
  return file ? 0 : 1;
}
