// SPDX-License-Identifier: BSD-3-Clause
#include "Store/BlockDealing.h"

#include <algorithm>
#include <tuple>

namespace isosurface
{
namespace
{

constexpr std::int64_t MaximumStep = 24; // finds good lattices; more ranks differ little
constexpr std::int64_t Radius = 3;       // of neighbours that are looked at, in blocks

// How near the nearest blocks of one rank are, and how many such neighbours there are, negated: the
// greater, the better.
std::tuple<std::int64_t, std::int64_t> Judge(std::int64_t ranks, std::int64_t y, std::int64_t z)
{
  std::int64_t nearest = 3 * (Radius + 1) * (Radius + 1);
  std::int64_t count = 0;
  for (std::int64_t k = 0; k <= Radius; ++k)
  {
    for (std::int64_t j = -Radius; j <= Radius; ++j)
    {
      for (std::int64_t i = -Radius; i <= Radius; ++i)
      {
        const std::int64_t square = i * i + j * j + k * k;
        if (square == 0 || square > nearest || (i + y * j + z * k) % ranks != 0)
        {
          continue;
        }
        count = square < nearest ? 1 : count + 1;
        nearest = square;
      }
    }
  }
  return { nearest, -count };
}

} // namespace

BlockDealing::BlockDealing(std::uint32_t ranks)
  : Ranks(ranks)
{
  std::tuple<std::int64_t, std::int64_t> best{ 0, 0 };
  const std::int64_t last = std::min(this->Ranks - 1, MaximumStep);
  for (std::int64_t y = 1; y <= last; ++y)
  {
    for (std::int64_t z = y; z <= last; ++z)
    {
      const auto judged = Judge(this->Ranks, y, z);
      if (judged > best)
      {
        best = judged;
        this->StepY = y;
        this->StepZ = z;
      }
    }
  }
}

} // namespace isosurface
