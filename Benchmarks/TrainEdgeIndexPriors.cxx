// SPDX-License-Identifier: BSD-3-Clause
/**
 * Learns what the edge-index models know before their first block, and writes
 * Core/EdgeIndex/EdgeIndexPriors.cxx. Blocks of all surfaces take turns, so that none is learnt
 * last. Needed after a change of a model only; then the format's version goes up.
 */
#include "BenchmarkVolume.h"

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

struct TrainingSurface
{
  std::vector<char> Bytes;
  SampleView View;
  BlockGrid Grid;
  EdgeIndexHeader Header;
};

void SetGeometry(TrainingSurface& surface, const Index3& size, ValueType type, double isovalue)
{
  surface.View.Type = type;
  surface.View.First = surface.Bytes.data();
  surface.View.Stride = { 1, static_cast<std::ptrdiff_t>(size[0]),
    static_cast<std::ptrdiff_t>(size[0] * size[1]) };
  surface.View.Box.High = size;
  surface.View.Available = surface.View.Box;
  surface.Grid = BlockGrid(size, 64);
  surface.Header.Geometry.Extent = { 0, size[0] - 1, 0, size[1] - 1, 0, size[2] - 1 };
  surface.Header.Type = type;
  surface.Header.Isovalues = { isovalue };
}

/// `words`: file of raw samples, its dimensions, type and isovalue.
bool ReadSurface(const std::string* words, TrainingSurface& surface)
{
  const Index3 size{ std::atoll(words[1].c_str()), std::atoll(words[2].c_str()),
    std::atoll(words[3].c_str()) };
  const auto type = FindValueType(words[4]);
  std::ifstream stream(words[0], std::ios::binary);
  if (!type || !stream || size[0] < 2 || size[1] < 2 || size[2] < 2)
  {
    return false;
  }
  surface.Bytes.resize(static_cast<std::size_t>(size[0] * size[1] * size[2]) * GetValueSize(*type));
  stream.read(surface.Bytes.data(), static_cast<std::streamsize>(surface.Bytes.size()));
  SetGeometry(surface, size, *type, std::atof(words[5].c_str()));
  return static_cast<bool>(stream);
}

TrainingSurface MakeGenerated(int side, double isovalue)
{
  const std::vector<std::uint16_t> volume = MakeBenchmarkVolume(side, 2);
  TrainingSurface surface;
  const char* first = reinterpret_cast<const char*>(volume.data());
  surface.Bytes.assign(first, first + 2 * volume.size());
  SetGeometry(surface, { side, side, side }, ValueType::UInt16, isovalue);
  return surface;
}

void Learn(std::vector<TrainingSurface>& surfaces, EdgeIndexProfile profile, BlockModel& model)
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
      for (const double error : { 0.0, 0.09, 0.02 })
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
      }
    }
  }
}

} // namespace

int main(int argc, char** argv)
{
  std::string output;
  std::vector<std::string> words;
  CLI::App application("Learns the priors of the edge-index code");
  application.add_option("output", output, "the source file to write")->required();
  application.add_option("--surface", words, "raw samples, three dimensions, type, isovalue")
    ->type_size(6)
    ->expected(-1)
    ->required();
  CLI11_PARSE(application, argc, argv);

  std::vector<TrainingSurface> surfaces(words.size() / 6);
  for (std::size_t n = 0; n < surfaces.size(); ++n)
  {
    if (!ReadSurface(&words[6 * n], surfaces[n]))
    {
      std::fprintf(stderr, "%s: cannot be read\n", words[6 * n].c_str());
      return 1;
    }
  }
  surfaces.push_back(MakeGenerated(192, 34000.5));
  surfaces.push_back(MakeGenerated(160, 40000.5));
  BlockModel mixed(BlockScheme::Mixed);
  BlockModel fast(BlockScheme::Fast);
  Learn(surfaces, EdgeIndexProfile::Default, mixed);
  Learn(surfaces, EdgeIndexProfile::Fast, fast);
  std::ofstream file(output);
  file << WritePriors(mixed, fast);
  return file ? 0 : 1;
}
