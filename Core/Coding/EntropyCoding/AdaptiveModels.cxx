// SPDX-License-Identifier: BSD-3-Clause
#include "Coding/EntropyCoding/AdaptiveModels.h"

namespace isosurface
{
namespace
{

// 32768 / (1 + exp(-x)) at x = -8, -7.75, ... 8, rounded. Constants, since the exponential functions
// of two libraries may differ in the last bit. Documentation/formats/edge-index.md has them, too.
constexpr std::array<std::int32_t, 65> LogisticCurve = { 11, 14, 18, 23, 30, 38, 49, 63, 81, 104,
  133, 171, 219, 281, 360, 461, 589, 753, 961, 1223, 1554, 1969, 2486, 3124, 3906, 4851, 5978, 7297,
  8813, 10513, 12371, 14347, 16384, 18421, 20397, 22255, 23955, 25471, 26790, 27917, 28862, 29644,
  30282, 30799, 31214, 31545, 31807, 32015, 32179, 32307, 32408, 32487, 32549, 32597, 32635, 32664,
  32687, 32705, 32719, 32730, 32738, 32745, 32750, 32754, 32757 };

} // namespace

ModelTables::ModelTables()
{
  for (int n = 0; n < 4096; ++n)
  {
    const auto step = static_cast<std::size_t>(n / 64);
    const int part = n % 64;
    const int value = LogisticCurve[step] * (64 - part) + LogisticCurve[step + 1] * part;
    this->Squash[static_cast<std::size_t>(n)] = static_cast<std::uint16_t>(value / 32);
  }
  // The minimum x whose probability is not below the middle of the interval.
  int x = -2047;
  for (int n = 0; n < 4096; ++n)
  {
    while (x < 2047 && this->Squash[static_cast<std::size_t>(x + 2048)] < 16 * n + 8)
    {
      ++x;
    }
    this->Stretch[static_cast<std::size_t>(n)] = static_cast<std::int16_t>(x);
  }
  for (int n = 0; n < 1024; ++n)
  {
    this->Rates[static_cast<std::size_t>(n)] = static_cast<std::uint16_t>(655360 / (10 * n + 16));
  }
  constexpr int minimum = 8;
  constexpr int rest = (1 << FrequencyBits) - minimum * NumberOfSymbols;
  for (int symbol = 0; symbol < NumberOfSymbols; ++symbol)
  {
    for (int n = 0; n < NumberOfSymbols; ++n)
    {
      this->Targets[static_cast<std::size_t>(symbol)][static_cast<std::size_t>(n)] =
        static_cast<std::int16_t>(minimum * n + (n > symbol ? rest : 0));
    }
  }
}

const ModelTables Tables;

std::uint32_t Squash(int x)
{
  return Tables.Squash[static_cast<std::size_t>(std::clamp(x, -2047, 2047) + 2048)];
}

} // namespace isosurface
