// SPDX-License-Identifier: BSD-3-Clause
#include "Ranks/Compositing/FixedDepths.h"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <limits>

namespace isosurface
{
namespace
{

constexpr std::uint32_t Farthest = std::numeric_limits<std::uint32_t>::max();
constexpr std::size_t Block = 32;

bool AreFarthest(const float* depths)
{
  std::uint32_t common = Farthest; // without a branch for each pixel
  for (std::size_t index = 0; index < Block; ++index)
  {
    std::uint32_t bits;
    std::memcpy(&bits, depths + index, sizeof(bits));
    common &= bits;
  }
  return common == Farthest;
}

} // namespace

void ConvertFixedDepths(float* depths, std::size_t count)
{
  constexpr double scale = 1.0 / Farthest;
  for (std::size_t begin = 0; begin < count; begin += Block)
  {
    const std::size_t end = std::min(count, begin + Block);
    if (end - begin == Block && AreFarthest(depths + begin))
    {
      std::fill(depths + begin, depths + end, 1.0F);
      continue;
    }
    for (std::size_t index = begin; index < end; ++index)
    {
      std::uint32_t bits;
      std::memcpy(&bits, depths + index, sizeof(bits));
      depths[index] = static_cast<float>(bits * scale);
    }
  }
}

} // namespace isosurface
