// SPDX-License-Identifier: BSD-3-Clause
#include "EdgeIndex/BlockCoder.h"
#include "EdgeIndex/EdgeIndexPriors.h"

#include <algorithm>
#include <sstream>

namespace isosurface
{
namespace
{

// How much a prior counts against what comes: as so many updates.
constexpr std::uint32_t NearCount = 10;
constexpr std::uint32_t LevelCount = 8;
constexpr std::uint32_t SideCount = 2;

AdaptiveBit MakeBit(std::int8_t stretched, std::uint32_t count)
{
  AdaptiveBit bit;
  bit.State = Squash(stretched * 16) << 16 | count;
  return bit;
}

int StretchBit(const AdaptiveBit& bit)
{
  const int stretched = Tables.Stretch[bit.State >> 20];
  return std::clamp((stretched + (stretched < 0 ? -8 : 8)) / 16, -127, 127);
}

void ApplyMixedPriors(ResidualModel& model, const std::array<std::int8_t, 512>& byLevel,
  const std::array<std::int16_t, 512>& mixers)
{
  const auto apply = [&byLevel](SymbolTree& tree, std::size_t level, std::uint32_t count)
  {
    for (std::size_t node = 0; node < std::size_t{ NumberOfSymbols }; ++node)
    {
      tree.Nodes[node] = MakeBit(byLevel[level * NumberOfSymbols + node], count);
    }
  };
  for (std::size_t level = 0; level < model.ByLevel.size(); ++level)
  {
    apply(model.ByLevel[level], level, LevelCount);
  }
  for (std::vector<SymbolTree>& table : model.BySide)
  {
    for (std::size_t n = 0; n < table.size(); ++n)
    {
      apply(table[n], 2 * (n / ResidualModel::NumberOfSides), SideCount);
    }
  }
  for (std::size_t n = 0; n < model.Mixers.size(); ++n)
  {
    std::copy_n(mixers.begin() + static_cast<std::ptrdiff_t>(n * LogisticMixer::Size),
      LogisticMixer::Size, model.Mixers[n].Weights.begin());
  }
}

template <typename Values>
void WriteValues(std::ostringstream& text, const Values& values)
{
  text << "{ {";
  std::size_t column = 100;
  for (const int value : values)
  {
    const std::string number = std::to_string(value) + ",";
    if (column + number.size() > 99)
    {
      text << "\n";
      column = 0;
    }
    text << number;
    column += number.size();
  }
  text << "\n} },\n";
}

void WriteLevels(std::ostringstream& text, const ResidualModel& mixed)
{
  std::vector<int> values;
  for (const SymbolTree& tree : mixed.ByLevel)
  {
    for (const AdaptiveBit& bit : tree.Nodes)
    {
      values.push_back(StretchBit(bit));
    }
  }
  WriteValues(text, values);
}

void WriteMixers(std::ostringstream& text, const ResidualModel& mixed)
{
  std::vector<int> values;
  for (const LogisticMixer& mixer : mixed.Mixers)
  {
    values.insert(values.end(), mixer.Weights.begin(), mixer.Weights.end());
  }
  WriteValues(text, values);
}

// The begin of a source file, up to the name of a constant.
void WriteBegin(std::ostringstream& text, const char* type, const char* name)
{
  text << "// SPDX-License-Identifier: BSD-3-Clause\n"
          "// Written by TrainEdgeIndexPriors; see Documentation/dev/edge-index.md.\n"
          "#include \"EdgeIndex/EdgeIndexPriors.h\"\n\n"
          "namespace isosurface\n{\n\n"
          "// clang-format off\n"
          "const "
       << type << " " << name << " = {\n";
}

constexpr char End[] = "};\n// clang-format on\n\n} // namespace isosurface\n";

void WriteResiduals(std::ostringstream& text, const ResidualModel& mixed, const ResidualModel& fast)
{
  text << "{\n";
  WriteLevels(text, mixed);
  std::vector<int> values;
  for (const AdaptiveSymbol& symbol : fast.Symbols)
  {
    values.insert(values.end(), symbol.Cumulative.begin(), symbol.Cumulative.end());
  }
  WriteValues(text, values);
  WriteMixers(text, mixed);
  text << "},\n";
}

} // namespace

void ApplyPriors(SignModel& model)
{
  for (std::size_t n = 0; n < model.Near.size(); ++n)
  {
    model.Near[n] = MakeBit(Priors.Near[n], NearCount);
  }
  for (std::size_t n = 0; n < model.Quiet.size(); ++n)
  {
    model.Quiet[n] = MakeBit(Priors.Quiet[n], NearCount);
  }
  for (std::size_t n = 0; n < model.Mixers.size(); ++n)
  {
    std::copy_n(Priors.SignMixers.begin() + static_cast<std::ptrdiff_t>(n * LogisticMixer::Size),
      LogisticMixer::Size, model.Mixers[n].Weights.begin());
  }
}

void ApplyPriors(NetworkSignModel& model)
{
  for (std::size_t n = 0; n < model.Quiet.size(); ++n)
  {
    model.Quiet[n] = MakeBit(Priors.Quiet[n], NearCount);
  }
}

void ApplyPriors(ResidualModel& model, const ResidualPriors& priors)
{
  constexpr std::size_t nodes = NumberOfSymbols;
  for (std::size_t n = 0; n < model.Symbols.size(); ++n)
  {
    for (std::size_t symbol = 0; symbol < nodes; ++symbol)
    {
      model.Symbols[n].Cumulative[symbol] =
        static_cast<std::int16_t>(priors.Symbols[n * nodes + symbol]);
    }
  }
  if (!model.ByLevel.empty())
  {
    ApplyMixedPriors(model, priors.ByLevel, priors.Mixers);
  }
}

void ApplyPriors(ResidualModel& model, const MixedResidualPriors& priors)
{
  ApplyMixedPriors(model, priors.ByLevel, priors.Mixers);
}

void ForgetSides(ResidualModel& model)
{
  for (std::vector<SymbolTree>& table : model.BySide)
  {
    for (std::size_t n = 0; n < table.size(); ++n)
    {
      const SymbolTree& level = model.ByLevel[2 * (n / ResidualModel::NumberOfSides)];
      for (std::size_t node = 0; node < std::size_t{ NumberOfSymbols }; ++node)
      {
        table[n].Nodes[node] =
          MakeBit(static_cast<std::int8_t>(StretchBit(level.Nodes[node])), SideCount);
      }
    }
  }
}

void ApplyPriors(ValueModel& model)
{
  for (std::size_t n = 0; n < model.Weights.size(); ++n)
  {
    model.Weights[n] = Priors.Weights[ValueModel::InputOrder[n]];
  }
}

std::string WritePriors(const BlockModel& mixed, const BlockModel& fast)
{
  std::ostringstream text;
  WriteBegin(text, "EdgeIndexPriors", "Priors");
  std::vector<int> values;
  for (const AdaptiveBit& bit : mixed.Signs.Near)
  {
    values.push_back(StretchBit(bit));
  }
  WriteValues(text, values);
  values.clear();
  for (const AdaptiveBit& bit : mixed.Signs.Quiet)
  {
    values.push_back(StretchBit(bit));
  }
  WriteValues(text, values);
  values.clear();
  for (const LogisticMixer& mixer : mixed.Signs.Mixers)
  {
    values.insert(values.end(), mixer.Weights.begin(), mixer.Weights.end());
  }
  WriteValues(text, values);
  WriteResiduals(text, mixed.Values.Residuals, fast.Values.Residuals);
  WriteResiduals(text, mixed.Crossings.Residuals, fast.Crossings.Residuals);
  std::array<std::int32_t, ValueModel::NumberOfTaps> weights{};
  for (std::size_t n = 0; n < weights.size(); ++n)
  {
    weights[ValueModel::InputOrder[n]] = mixed.Values.Weights[n];
  }
  WriteValues(text, weights);
  text << End;
  return text.str();
}

std::string WriteCrossingPriors(const BlockModel& compact)
{
  std::ostringstream text;
  WriteBegin(text, "MixedResidualPriors", "CurvedCrossingPriors");
  WriteLevels(text, compact.Crossings.Residuals);
  WriteMixers(text, compact.Crossings.Residuals);
  text << End;
  return text.str();
}

} // namespace isosurface
