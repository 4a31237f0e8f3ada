// SPDX-License-Identifier: BSD-3-Clause
/**
 * Learns the network that predicts signs in the profile compact (SignNetwork), and writes
 * Core/Coding/TrainedModels/sign-network.txt. Needed only after a change of its inputs, which changes the
 * format.
 *
 * Stochastic gradient descent in batches: D. P. Kingma and J. Ba, "Adam: a method for stochastic
 * optimization", ICLR 2015. The rate decays with a cosine.
 */
#include "TableFile.h"
#include "TrainingSurface.h"

#include "Coding/BlockCoding/SignNeighborhood.h"
#include "Coding/EdgeIndex/SampledBlock.h"

#include <CLI/CLI.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <random>
#include <string>
#include <vector>

using namespace isosurface;

namespace
{

constexpr std::size_t Inputs = SignNetworkWeights::NumberOfInputs;
constexpr std::size_t Width = SignNetworkWeights::Width;
constexpr std::size_t Depth = SignNetworkWeights::Depth;
constexpr float Maximum = 8; // of hidden values and of the stretched probability

/// The inputs of a vertex, and whether its sign differs from that of the vertex to its left.
struct Sample
{
  SignNetworkInputs Seen;
  SignNetworkRow Row;
  bool IsOther;
};

/// Stands in for a range coder, but codes nothing.
struct NoCoder
{
  static constexpr bool Encodes = true;
  bool CodeBit(bool bit, std::uint32_t) { return bit; }
  std::uint32_t CodeUniform(std::uint32_t number, int) { return number; }
};

struct SampleModel
{
  QuietSigns Quiet;
  std::vector<Sample> Samples;
};

class SampledSigns
{
public:
  using Model = SampleModel;

  explicit SampledSigns(SampleModel& model)
    : Known(model)
  {
  }
  void BeginRow(const SignRowPlace& place) { this->Around.BeginRow(place); }
  bool CodeVertex(
    NoCoder&, bool bit, std::uint32_t own, const SignRow& row, const SignRowsAround& rows, int x)
  {
    const bool left = own >> 1 != 0;
    this->Known.Samples.push_back(
      { this->Around.Find(left, row, rows, x), this->Around.GetRow(), bit != left });
    return bit;
  }

private:
  SampleModel& Known;
  SignNeighborhood Around;
};

/// A random choice of vertices of a surface, at most `limit`.
std::vector<Sample> TakeSamples(
  const TrainingSurface& surface, std::size_t limit, std::mt19937& random)
{
  SampleModel model;
  for (std::int64_t block = 0; block < surface.Grid.GetNumberOfBlocks(); ++block)
  {
    SampleView view = surface.View;
    view.Box = surface.Grid.GetVertices(block);
    SampledBlock sampled(view, surface.Header.Isovalues[0], CrossingIntervals::MakeEqual(1));
    if (!sampled.IsCrossed())
    {
      continue;
    }
    NoCoder coder;
    const std::array<int, 3> size = sampled.GetSize();
    SignCoder<NoCoder, SampledSigns> signs(coder, model, size[0], size[1]);
    for (int z = 0; z < size[2]; ++z)
    {
      signs.CodeSlice(sampled.GetSigns(z), z > 0 ? &sampled.GetSigns(z - 1) : nullptr,
        z > 1 ? &sampled.GetSigns(z - 2) : nullptr);
    }
  }
  std::shuffle(model.Samples.begin(), model.Samples.end(), random);
  model.Samples.resize(std::min(limit, model.Samples.size()));
  return model.Samples;
}

/// SignNetworkWeights before rounding.
struct Network
{
  std::array<std::array<float, Width>, Inputs + 1> First;
  std::array<std::array<float, Depth>, Width + 1> Second; ///< transposed; last: added
  std::array<float, Depth + 1> Third;                     ///< last: added
};
constexpr std::size_t NumberOfWeights = sizeof(Network) / sizeof(float);

Network MakeNetwork(std::mt19937& random)
{
  std::normal_distribution<float> normal;
  Network network;
  const auto fill = [&](auto& rows, float spread)
  {
    for (auto& row : rows)
    {
      std::generate(row.begin(), row.end(), [&] { return spread * normal(random); });
    }
    rows.back().fill(0.1F);
  };
  fill(network.First, 0.15F);
  fill(network.Second, std::sqrt(1.5F / Width));
  std::generate(network.Third.begin(), network.Third.end(), [&] { return 0.3F * normal(random); });
  return network;
}

/// The numbers of the inputs that are ones, including the one that always is.
std::vector<std::size_t> ListOnes(const Sample& sample)
{
  std::vector<std::size_t> ones;
  std::size_t input = 0;
  const auto add = [&](bool bit)
  {
    if (bit)
    {
      ones.push_back(input);
    }
    ++input;
  };
  for (std::size_t n = 0; n < sample.Seen.Patterns.size(); ++n)
  {
    for (int bit = 0; bit < SignNetworkInputs::Bits[n]; ++bit)
    {
      add((sample.Seen.Patterns[n] >> bit & 1) != 0);
    }
  }
  for (const bool bit : sample.Row)
  {
    add(bit);
  }
  add(true);
  return ones;
}

/// The values of a network for one sample.
struct Activation
{
  std::array<float, Width> First{}; ///< clamped
  std::array<float, Depth> Second;  ///< before clamping
  float Probability = 0;            ///< that the sign is another one
};

Activation Evaluate(const Network& network, const std::vector<std::size_t>& ones)
{
  Activation result;
  for (const std::size_t one : ones)
  {
    for (std::size_t i = 0; i < Width; ++i)
    {
      result.First[i] += network.First[one][i];
    }
  }
  result.Second = network.Second[Width];
  for (std::size_t i = 0; i < Width; ++i)
  {
    result.First[i] = std::clamp(result.First[i], 0.0F, Maximum);
    for (std::size_t j = 0; j < Depth; ++j)
    {
      result.Second[j] += result.First[i] * network.Second[i][j];
    }
  }
  float stretched = network.Third[Depth];
  for (std::size_t j = 0; j < Depth; ++j)
  {
    stretched += std::clamp(result.Second[j], 0.0F, Maximum) * network.Third[j];
  }
  result.Probability = 1 / (1 + std::exp(-std::clamp(stretched, -Maximum, Maximum)));
  return result;
}

/// Adds the gradient of a sample's cost to `gradient`; returns the cost in bits.
float AddGradient(const Network& network, const Sample& sample, Network& gradient)
{
  const std::vector<std::size_t> ones = ListOnes(sample);
  const Activation values = Evaluate(network, ones);
  const float error = values.Probability - (sample.IsOther ? 1.0F : 0.0F);
  gradient.Third[Depth] += error;
  std::array<float, Depth> deep;
  for (std::size_t j = 0; j < Depth; ++j)
  {
    const float second = values.Second[j];
    gradient.Third[j] += error * std::clamp(second, 0.0F, Maximum);
    deep[j] = second > 0 && second < Maximum ? error * network.Third[j] : 0;
    gradient.Second[Width][j] += deep[j];
  }
  std::array<float, Width> wide{};
  for (std::size_t i = 0; i < Width; ++i)
  {
    const float first = values.First[i];
    if (first <= 0)
    {
      continue;
    }
    float sum = 0;
    for (std::size_t j = 0; j < Depth; ++j)
    {
      sum += deep[j] * network.Second[i][j];
      gradient.Second[i][j] += first * deep[j];
    }
    wide[i] = first < Maximum ? sum : 0;
  }
  for (const std::size_t one : ones)
  {
    for (std::size_t i = 0; i < Width; ++i)
    {
      gradient.First[one][i] += wide[i];
    }
  }
  return -std::log2(sample.IsOther ? values.Probability : 1 - values.Probability);
}

Network Learn(std::vector<Sample>& samples, double epochs, double rate, std::mt19937& random)
{
  constexpr std::size_t batch = 128;
  constexpr double fading = 0.9;
  constexpr double squareFading = 0.999;
  Network network = MakeNetwork(random);
  std::vector<float> mean(NumberOfWeights);
  std::vector<float> meanSquare(NumberOfWeights);
  const auto steps = static_cast<std::int64_t>(
    epochs * static_cast<double>(samples.size()) / static_cast<double>(batch));
  double power = 1;
  double squarePower = 1;
  double bits = 0;
  std::size_t next = samples.size();
  for (std::int64_t step = 0; step < steps; ++step)
  {
    if (next + batch > samples.size())
    {
      std::shuffle(samples.begin(), samples.end(), random);
      next = 0;
    }
    Network gradient{};
    for (std::size_t n = 0; n < batch; ++n)
    {
      bits += static_cast<double>(AddGradient(network, samples[next++], gradient));
    }
    power *= fading;
    squarePower *= squareFading;
    const double pi = 3.14159265358979;
    const double part = static_cast<double>(step) / static_cast<double>(steps);
    const double warm = std::min(1.0, static_cast<double>(step) / 200);
    const auto now = static_cast<float>(
      rate * warm * (0.5 + 0.5 * std::cos(pi * part)) * std::sqrt(1 - squarePower) / (1 - power));
    auto* weights = reinterpret_cast<float*>(&network);
    const auto* slopes = reinterpret_cast<const float*>(&gradient);
    for (std::size_t n = 0; n < NumberOfWeights; ++n)
    {
      const float slope = slopes[n] / static_cast<float>(batch);
      mean[n] += static_cast<float>(1 - fading) * (slope - mean[n]);
      meanSquare[n] += static_cast<float>(1 - squareFading) * (slope * slope - meanSquare[n]);
      weights[n] -= now * mean[n] / (std::sqrt(meanSquare[n]) + 1e-8F);
    }
    const std::int64_t tenth = std::max<std::int64_t>(1, steps / 10);
    if ((step + 1) % tenth == 0)
    {
      std::printf("%3.0f %%: %.5f bits a vertex\n", 100 * part,
        bits / static_cast<double>(tenth * static_cast<std::int64_t>(batch)));
      bits = 0;
    }
  }
  return network;
}

/// Writes the weights in the units of SignNetwork.
bool Write(const Network& network, const std::string& path)
{
  constexpr float hiddenUnit = 256;
  constexpr float unit = 1024;
  constexpr long half = 512; // sums are rounded down
  std::vector<long> first;
  for (const auto& weights : network.First)
  {
    for (const float weight : weights)
    {
      first.push_back(std::lround(weight * hiddenUnit));
    }
  }
  std::vector<long> second;
  std::vector<long> added;
  std::vector<long> third;
  for (std::size_t j = 0; j < Depth; ++j)
  {
    for (std::size_t i = 0; i < Width; ++i)
    {
      second.push_back(std::lround(network.Second[i][j] * unit));
    }
    added.push_back(std::lround(network.Second[Width][j] * unit * hiddenUnit) + half);
    third.push_back(std::lround(network.Third[j] * unit));
  }
  const std::vector<long> thirdAdded = { std::lround(network.Third[Depth] * unit * hiddenUnit) +
    half };
  TableFile file(path, "TrainSignNetwork");
  file.Add("SignNetworkFirst", "int16", first);
  file.Add("SignNetworkSecond", "int16", second);
  file.Add("SignNetworkSecondAdded", "int32", added);
  file.Add("SignNetworkThird", "int16", third);
  file.Add("SignNetworkThirdAdded", "int32", thirdAdded);
  return file.IsGood();
}

} // namespace

int main(int argc, char** argv)
{
  std::string output;
  std::vector<std::string> words;
  std::size_t limit = 250000;
  double epochs = 20;
  double rate = 0.0025;
  CLI::App application("Learns the network that predicts signs in the edge-index code");
  application.add_option("output", output, "the data file to write")->required();
  AddSurfaceOption(application, words);
  application.add_option("--most", limit, "maximum number of vertices of a surface");
  application.add_option("--epochs", epochs, "passes over all vertices");
  application.add_option("--rate", rate, "initial learning rate");
  CLI11_PARSE(application, argc, argv);

  std::vector<TrainingSurface> surfaces;
  if (!ReadSurfaces(words, surfaces))
  {
    return 1;
  }
  std::mt19937 random(7);
  std::vector<Sample> samples;
  for (const TrainingSurface& surface : surfaces)
  {
    const std::vector<Sample> taken = TakeSamples(surface, limit, random);
    samples.insert(samples.end(), taken.begin(), taken.end());
  }
  std::printf("%zu vertices\n", samples.size());
  return Write(Learn(samples, epochs, rate, random), output) ? 0 : 1;
}
