// SPDX-License-Identifier: BSD-3-Clause
/**
 * Learns what the edge-index models know before their first block, and writes
 * Core/Coding/TrainedModels/priors.txt. The blocks of all surfaces take turns, so that no surface is
 * learnt last. Needed only after a change of a model, which changes the format.
 */
#include "TableFile.h"
#include "TrainingSurface.h"

#include "Coding/BlockCoding/BlockCoding.h"
#include "Coding/EdgeIndex/SampledBlock.h"

#include <CLI/CLI.hpp>

#include <algorithm>
#include <cstdint>
#include <string>
#include <vector>

using namespace isosurface;

namespace
{

/// Codes a block, so that the model learns it. error: the maximum one, in voxels; 0 for lossless.
void LearnBlock(const TrainingSurface& surface, std::int64_t block, double error, BlockModel& model)
{
  EdgeIndexHeader header = surface.Header;
  header.Settings.Profile = model.Profile;
  header.Settings.Mode = EdgeIndexMode::Bounded;
  header.Settings.MaximumError = error == 0 ? 0.1 : error;
  SampleView view = surface.View;
  view.Box = surface.Grid.GetVertices(block);
  SampledBlock samples(view, header.Isovalues[0], header.GetIntervals());
  if (!samples.IsCrossed())
  {
    return;
  }
  const ValueDomain domain(header.Type, header.Isovalues[0], samples.ChooseLosslessScale());
  samples.SetDomain(&domain);
  BlockContent content;
  content.Size = samples.GetSize();
  content.Domain = error == 0 ? &domain : nullptr;
  content.Intervals = samples.GetIntervals();
  content.HasMissing = samples.HasMissingCrossings();
  std::vector<std::uint8_t> bytes;
  RangeEncoder encoder(bytes);
  CodeBlock(encoder, model, content, samples);
}

/// A probability in the units of the tables; see MakeAdaptiveBit.
int Stretch(const AdaptiveBit& bit)
{
  const int stretched = Tables.Stretch[bit.State >> 20];
  return std::clamp((stretched + (stretched < 0 ? -8 : 8)) / 16, -127, 127);
}

/// errors: the maximum ones to code each block at; 0 for lossless.
void Learn(const std::vector<TrainingSurface>& surfaces, const std::vector<double>& errors,
  BlockModel& model)
{
  std::int64_t maximum = 0;
  for (const TrainingSurface& surface : surfaces)
  {
    maximum = std::max(maximum, surface.Grid.GetNumberOfBlocks());
  }
  // Blocks in a scattered order; the blocks of each surface are spread evenly over all steps.
  constexpr std::int64_t stride = 7919;
  for (std::int64_t step = 0; step < 2 * maximum; ++step)
  {
    for (const TrainingSurface& surface : surfaces)
    {
      const std::int64_t blocks = surface.Grid.GetNumberOfBlocks();
      const std::int64_t place = step * blocks / (2 * maximum);
      if (place == (step + 1) * blocks / (2 * maximum))
      {
        continue;
      }
      for (const double error : errors)
      {
        LearnBlock(surface, place * stride % blocks, error, model);
      }
    }
  }
}

template <typename Bits>
std::vector<int> StretchAll(const Bits& bits)
{
  std::vector<int> numbers;
  std::transform(bits.begin(), bits.end(), std::back_inserter(numbers), Stretch);
  return numbers;
}

std::vector<int> ListLevels(const ResidualModel& model)
{
  std::vector<int> numbers;
  for (const SymbolTree& tree : model.ByLevel)
  {
    const std::vector<int> nodes = StretchAll(tree.Nodes);
    numbers.insert(numbers.end(), nodes.begin(), nodes.end());
  }
  return numbers;
}

template <typename Mixers>
std::vector<int> ListWeights(const Mixers& mixers)
{
  std::vector<int> numbers;
  for (const LogisticMixer& mixer : mixers)
  {
    numbers.insert(numbers.end(), mixer.Weights.begin(), mixer.Weights.end());
  }
  return numbers;
}

std::vector<int> ListShares(const ResidualModel& model)
{
  std::vector<int> numbers;
  for (const AdaptiveSymbol& symbol : model.Symbols)
  {
    numbers.insert(numbers.end(), symbol.Cumulative.begin(), symbol.Cumulative.end());
  }
  return numbers;
}

bool WritePriors(const std::string& path, const BlockModel& mixed, const BlockModel& preview)
{
  TableFile file(path, "TrainEdgeIndexPriors");
  file.Add("NearSignPriors", "int8", StretchAll(mixed.Signs.Near));
  file.Add("QuietSignPriors", "int8", StretchAll(mixed.Signs.Quiet));
  file.Add("SignMixers", "int16", ListWeights(mixed.Signs.Mixers));
  file.Add("ValueLevels", "int8", ListLevels(mixed.Values.Residuals));
  file.Add("ValueMixers", "int16", ListWeights(mixed.Values.Residuals.Mixers));
  file.Add("CrossingLevels", "int8", ListLevels(mixed.Crossings.Residuals));
  file.Add("CrossingSymbols", "uint16", ListShares(preview.Crossings.Residuals));
  file.Add("CrossingMixers", "int16", ListWeights(mixed.Crossings.Residuals.Mixers));
  std::vector<std::int32_t> weights(mixed.Values.Weights.size());
  for (std::size_t n = 0; n < weights.size(); ++n)
  {
    weights[ValueModel::InputOrder[n]] = mixed.Values.Weights[n];
  }
  file.Add("ValueWeights", "int32", weights);
  return file.IsGood();
}

} // namespace

int main(int argc, char** argv)
{
  std::string output;
  std::vector<std::string> words;
  CLI::App application("Learns the priors of the edge-index code");
  application.add_option("output", output, "the data file to write")->required();
  AddSurfaceOption(application, words);
  CLI11_PARSE(application, argc, argv);

  std::vector<TrainingSurface> surfaces;
  if (!ReadSurfaces(words, surfaces))
  {
    return 1;
  }
  BlockModel mixed(EdgeIndexProfile::Small);
  BlockModel preview(EdgeIndexProfile::Preview);
  Learn(surfaces, { 0.0, 0.09, 0.02 }, mixed);
  Learn(surfaces, { 0.09, 0.02 }, preview);
  return WritePriors(output, mixed, preview) ? 0 : 1;
}
