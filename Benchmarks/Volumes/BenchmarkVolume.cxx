// SPDX-License-Identifier: BSD-3-Clause
#include "Volumes/BenchmarkVolume.h"

#include "Ground/Base/ParallelFor.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <random>

namespace isosurface
{
namespace
{

struct Wave
{
  double Vector[3]; ///< radians a sample
  double Phase;
  float Amplitude;
};

std::vector<Wave> MakeWaves(int side)
{
  constexpr int count = 16;
  constexpr double twoPi = 6.283185307179586;
  // The numbers of the engine are specified, those of the standard distributions are not.
  std::mt19937 engine(2009);
  auto uniform = [&engine] { return static_cast<double>(engine()) / 4294967296.0; };
  std::vector<Wave> waves;
  const double longest = side / 4.0;
  const double shortest = std::min(12.0, longest);
  for (int index = 0; index < count; ++index)
  {
    const double wavelength =
      longest * std::pow(shortest / longest, static_cast<double>(index) / (count - 1));
    const double z = 2 * uniform() - 1;
    const double angle = twoPi * uniform();
    const double r = std::sqrt(1 - z * z);
    const double k = twoPi / wavelength;
    waves.push_back({ { k * r * std::cos(angle), k * r * std::sin(angle), k * z },
      twoPi * uniform(), static_cast<float>(wavelength) });
  }
  return waves;
}

// A row of the sum. Each wave is a complex number that is rotated from sample to sample.
void FillRow(const std::vector<Wave>& waves, int side, int j, int k, std::vector<float>& row)
{
  std::fill(row.begin(), row.end(), 0.0F);
  for (const Wave& wave : waves)
  {
    const double start = wave.Vector[1] * j + wave.Vector[2] * k + wave.Phase;
    std::complex<double> value = std::polar(static_cast<double>(wave.Amplitude), start);
    const std::complex<double> step = std::polar(1.0, wave.Vector[0]);
    for (int i = 0; i < side; ++i)
    {
      row[static_cast<std::size_t>(i)] += static_cast<float>(value.real());
      value = { value.real() * step.real() - value.imag() * step.imag(),
        value.real() * step.imag() + value.imag() * step.real() };
    }
  }
}

} // namespace

std::vector<std::uint16_t> MakeBenchmarkVolume(int side, int threads)
{
  const std::vector<Wave> waves = MakeWaves(side);
  // Clamped at four standard deviations, which the sum rarely exceeds.
  double variance = 0;
  for (const Wave& wave : waves)
  {
    variance += 0.5 * wave.Amplitude * wave.Amplitude;
  }
  const float scale = static_cast<float>(32767.0 / (4.0 * std::sqrt(variance)));

  const auto n = static_cast<std::size_t>(side);
  std::vector<std::uint16_t> volume(n * n * n);
  ParallelFor(n, threads,
    [&](std::size_t k, int)
    {
      std::vector<float> row(n);
      for (std::size_t j = 0; j < n; ++j)
      {
        FillRow(waves, side, static_cast<int>(j), static_cast<int>(k), row);
        std::uint16_t* out = &volume[(k * n + j) * n];
        for (std::size_t i = 0; i < n; ++i)
        {
          out[i] =
            static_cast<std::uint16_t>(std::clamp(32768.0F + scale * row[i], 0.0F, 65535.0F));
        }
      }
    });
  return volume;
}

} // namespace isosurface
