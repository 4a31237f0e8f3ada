// SPDX-License-Identifier: BSD-3-Clause
#include "Ranks/Sharing/ActiveBlockWork.h"

#include "Ground/Volume/VertexBox.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdlib>

namespace isosurface
{
namespace
{

constexpr std::int64_t MaximumBits = std::int64_t{ 1 } << 28;

/// Thousandths of the mean work, by the number of axes with active neighbours on both sides and, of
/// the others, with one on one side.
constexpr std::array<std::array<std::int64_t, 4>, 4> WorkOfFaces = { {
  { 370, 300, 450, 610 },
  { 530, 710, 1120, 1120 },
  { 1480, 1580, 1580, 1580 },
  { 2050, 2050, 2050, 2050 },
} };
constexpr std::int64_t WorkOfEdge = 15;     ///< for each active neighbour across an edge
constexpr std::int64_t WorkOfCorner = -116; ///< across a corner
constexpr std::int64_t MinimumWork = 20;

/// Which blocks of a box are active, with a layer of others around them.
class ActiveMap
{
public:
  ActiveMap(const Index3& low, const Index3& high)
    : Low(low)
    , Size{ high[0] - low[0] + 3, high[1] - low[1] + 3, high[2] - low[2] + 3 }
  {
  }
  bool Fits() const
  {
    return static_cast<double>(this->Size[0]) * static_cast<double>(this->Size[1]) *
      static_cast<double>(this->Size[2]) <=
      static_cast<double>(MaximumBits);
  }
  void Allocate()
  {
    this->Bits.resize(static_cast<std::size_t>(this->Size[0] * this->Size[1] * this->Size[2]));
  }
  std::size_t Find(const Index3& block) const
  {
    return static_cast<std::size_t>(block[0] - this->Low[0] + 1 +
      this->Size[0] *
        (block[1] - this->Low[1] + 1 + this->Size[1] * (block[2] - this->Low[2] + 1)));
  }
  void Set(const Index3& block) { this->Bits[this->Find(block)] = true; }
  std::int64_t Has(std::size_t place, std::int64_t i, std::int64_t j, std::int64_t k) const
  {
    const auto step = i + this->Size[0] * (j + this->Size[1] * k);
    return this->Bits[static_cast<std::size_t>(static_cast<std::int64_t>(place) + step)] ? 1 : 0;
  }

private:
  Index3 Low;
  Index3 Size;
  std::vector<bool> Bits;
};

/// The work of a block of full size, in thousandths.
std::int64_t PredictWork(const ActiveMap& map, const Index3& block)
{
  const std::size_t place = map.Find(block);
  std::size_t both = 0;
  std::size_t one = 0;
  const std::int64_t sides[3] = { map.Has(place, -1, 0, 0) + map.Has(place, 1, 0, 0),
    map.Has(place, 0, -1, 0) + map.Has(place, 0, 1, 0),
    map.Has(place, 0, 0, -1) + map.Has(place, 0, 0, 1) };
  for (const std::int64_t active : sides)
  {
    both += active == 2 ? 1 : 0;
    one += active == 1 ? 1 : 0;
  }
  std::int64_t work = WorkOfFaces[both][one];
  for (std::int64_t k = -1; k <= 1; ++k)
  {
    for (std::int64_t j = -1; j <= 1; ++j)
    {
      for (std::int64_t i = -1; i <= 1; ++i)
      {
        const std::int64_t axes = std::abs(i) + std::abs(j) + std::abs(k);
        work += axes < 2 ? 0 : map.Has(place, i, j, k) * (axes == 2 ? WorkOfEdge : WorkOfCorner);
      }
    }
  }
  return std::max(work, MinimumWork);
}

/// The cells of a block, in thousandths of one of full size; at least 1.
std::int64_t FindSize(const BlockGrid& grid, std::int64_t block)
{
  std::int64_t size = 1000;
  for (const std::int64_t vertices : grid.GetVertices(block).GetSize())
  {
    size = size * std::max<std::int64_t>(1, vertices - 1) / grid.GetBlockSize();
  }
  return std::max<std::int64_t>(1, size);
}

} // namespace

std::vector<std::int64_t> PredictActiveBlockWork(
  const BlockGrid& grid, const std::vector<std::int64_t>& blocks)
{
  std::vector<std::int64_t> work(blocks.size(), 1);
  if (blocks.empty())
  {
    return work;
  }
  Index3 low = grid.GetBlockCoordinates(blocks.front());
  Index3 high = low;
  for (const std::int64_t block : blocks)
  {
    const Index3 place = grid.GetBlockCoordinates(block);
    for (std::size_t axis = 0; axis < 3; ++axis)
    {
      low[axis] = std::min(low[axis], place[axis]);
      high[axis] = std::max(high[axis], place[axis]);
    }
  }
  ActiveMap map(low, high);
  if (!map.Fits())
  {
    return work;
  }
  map.Allocate();
  for (const std::int64_t block : blocks)
  {
    map.Set(grid.GetBlockCoordinates(block));
  }
  for (std::size_t n = 0; n < blocks.size(); ++n)
  {
    const std::int64_t full = PredictWork(map, grid.GetBlockCoordinates(blocks[n]));
    work[n] = full * FindSize(grid, blocks[n]);
  }
  return work;
}

} // namespace isosurface
