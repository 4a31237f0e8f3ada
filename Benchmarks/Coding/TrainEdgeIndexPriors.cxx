// SPDX-License-Identifier: BSD-3-Clause
/**
 * Learns what the edge-index models know before their first block, and writes
 * Core/Coding/TrainedModels/priors.txt, or with --crossings curved-crossings.txt. The blocks of all
 * surfaces take turns, so that no surface is learnt last. Needed only after a change of a model,
 * which changes the format.
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

/// Copies the probabilities by level to every side, as at the start of a block.
void ForgetSides(ResidualModel& model)
{
  constexpr std::uint32_t count = 2;
  std::vector<SymbolTree> priors;
  for (std::size_t level = 0; level < model.ByLevel.size(); level += 2)
  {
    SymbolTree& prior = priors.emplace_back();
    std::transform(model.ByLevel[level].Nodes.begin(), model.ByLevel[level].Nodes.end(),
      prior.Nodes.begin(),
      [](const AdaptiveBit& node)
      { return MakeAdaptiveBit(static_cast<std::int8_t>(Stretch(node)), count); });
  }
  model.BySide = SideTrees(std::move(priors));
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
        if (model.Profile == EdgeIndexProfile::Compact)
        {
          ForgetSides(model.Crossings.Residuals);
        }
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

void AddMagnitudes(
  TableFile& file, const std::string& kind, const ResidualModel& mixed, const ResidualModel& fast)
{
  file.Add(kind + "Levels", "int8", ListLevels(mixed));
  file.Add(kind + "Symbols", "uint16", ListShares(fast));
  file.Add(kind + "Mixers", "int16", ListWeights(mixed.Mixers));
}

bool WritePriors(const std::string& path, const std::string& program, const BlockModel& mixed,
  const BlockModel& fast)
{
  TableFile file(path, program);
  file.Add("NearSignPriors", "int8", StretchAll(mixed.Signs.Near));
  file.Add("QuietSignPriors", "int8", StretchAll(mixed.Signs.Quiet));
  file.Add("SignMixers", "int16", ListWeights(mixed.Signs.Mixers));
  AddMagnitudes(file, "Value", mixed.Values.Residuals, fast.Values.Residuals);
  AddMagnitudes(file, "Crossing", mixed.Crossings.Residuals, fast.Crossings.Residuals);
  std::vector<std::int32_t> weights(mixed.Values.Weights.size());
  for (std::size_t n = 0; n < weights.size(); ++n)
  {
    weights[ValueModel::InputOrder[n]] = mixed.Values.Weights[n];
  }
  file.Add("ValueWeights", "int32", weights);
  return file.IsGood();
}

bool WriteCurvedCrossings(
  const std::string& path, const std::string& program, const ResidualModel& compact)
{
  TableFile file(path, program);
  file.Add("CurvedCrossingLevels", "int8", ListLevels(compact));
  file.Add("CurvedCrossingMixers", "int16", ListWeights(compact.Mixers));
  return file.IsGood();
}

} // namespace

int main(int argc, char** argv)
{
  std::string output;
  std::vector<std::string> words;
  bool crossings = false;
  CLI::App application("Learns the priors of the edge-index code");
  application.add_option("output", output, "the data file to write")->required();
  application.add_flag("--crossings", crossings, "of the crossings of the profile compact");
  AddSurfaceOption(application, words);
  CLI11_PARSE(application, argc, argv);

  std::vector<TrainingSurface> surfaces;
  if (!ReadSurfaces(words, surfaces))
  {
    return 1;
  }
  const std::string program = "TrainEdgeIndexPriors";
  if (crossings)
  {
    BlockModel compact(EdgeIndexProfile::Compact);
    Learn(surfaces, { 0.09, 0.011, 0.06, 0.02, 0.075, 0.006 }, compact);
    return WriteCurvedCrossings(output, program + " --crossings", compact.Crossings.Residuals) ? 0
                                                                                               : 1;
  }
  BlockModel mixed(EdgeIndexProfile::Default);
  BlockModel fast(EdgeIndexProfile::Fast);
  Learn(surfaces, { 0.0, 0.09, 0.02 }, mixed);
  Learn(surfaces, { 0.0, 0.09, 0.02 }, fast);
  return WritePriors(output, program, mixed, fast) ? 0 : 1;
}
