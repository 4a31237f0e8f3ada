// SPDX-License-Identifier: BSD-3-Clause
#include "Ranks/Redistribution/CompactPartition.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <utility>

namespace isosurface
{
namespace
{

// See MakeCompactPartition. Order is sorted in place, range by range; a range of it is what is cut.
class Bisection
{
public:
  Bisection(const std::vector<WeighedBlock>& blocks, const std::array<double, 3>& spacing)
    : Blocks(blocks)
    , Spacing(spacing)
    , Order(blocks.size())
    , Pieces(blocks.size())
  {
    std::iota(this->Order.begin(), this->Order.end(), std::size_t{ 0 });
  }

  std::vector<std::uint32_t> Run(std::uint32_t pieces)
  {
    this->Divide(0, this->Order.size(), 0, pieces);
    return std::move(this->Pieces);
  }

private:
  // Assigns the blocks [begin, end) of Order to `pieces` pieces from `first` on.
  void Divide(std::size_t begin, std::size_t end, std::uint32_t first, std::uint32_t pieces)
  {
    if (pieces == 1)
    {
      for (std::size_t n = begin; n < end; ++n)
      {
        this->Pieces[this->Order[n]] = first;
      }
      return;
    }
    this->Sort(begin, end);
    const std::uint32_t lower = pieces / 2;
    const std::size_t cut = this->FindCut(begin, end, lower, pieces - lower);
    this->Divide(begin, cut, first, lower);
    this->Divide(cut, end, first + lower, pieces - lower);
  }

  void Sort(std::size_t begin, std::size_t end)
  {
    const std::size_t axis = this->FindLongestAxis(begin, end);
    const auto isBefore = [&](std::size_t a, std::size_t b)
    {
      const Index3& lowA = this->Blocks[a].Vertices.Low;
      const Index3& lowB = this->Blocks[b].Vertices.Low;
      for (std::size_t n = 0; n < 3; ++n)
      {
        const std::size_t next = (axis + n) % 3;
        if (lowA[next] != lowB[next])
        {
          return lowA[next] < lowB[next];
        }
      }
      return false;
    };
    std::sort(this->Order.begin() + static_cast<std::ptrdiff_t>(begin),
      this->Order.begin() + static_cast<std::ptrdiff_t>(end), isBefore);
  }

  std::size_t FindLongestAxis(std::size_t begin, std::size_t end) const
  {
    VertexBox bounds = begin < end ? this->Blocks[this->Order[begin]].Vertices : VertexBox();
    for (std::size_t n = begin; n < end; ++n)
    {
      bounds.Extend(this->Blocks[this->Order[n]].Vertices);
    }
    std::size_t longest = 0;
    double maximum = -1;
    for (std::size_t axis = 0; axis < 3; ++axis)
    {
      const double length =
        static_cast<double>(bounds.GetSize()[axis] - 1) * std::abs(this->Spacing[axis]);
      if (length > maximum)
      {
        maximum = length;
        longest = axis;
      }
    }
    return longest;
  }

  // The cut at which the maximum of the mean works on both sides is minimal. (A cut among n pieces
  // raises the mean by at most 1 / n of a block, hence the bound of 1.3 blocks.)
  std::size_t FindCut(
    std::size_t begin, std::size_t end, std::uint32_t lower, std::uint32_t upper) const
  {
    std::uint64_t before = 0;
    std::uint64_t behind = 0;
    for (std::size_t n = begin; n < end; ++n)
    {
      behind += this->Blocks[this->Order[n]].Workload;
    }
    std::size_t cut = begin;
    double minimum = static_cast<double>(behind) / upper;
    for (std::size_t n = begin; n < end; ++n)
    {
      before += this->Blocks[this->Order[n]].Workload;
      behind -= this->Blocks[this->Order[n]].Workload;
      const double mean =
        std::max(static_cast<double>(before) / lower, static_cast<double>(behind) / upper);
      if (mean < minimum)
      {
        minimum = mean;
        cut = n + 1;
      }
    }
    return cut;
  }

  const std::vector<WeighedBlock>& Blocks;
  const std::array<double, 3>& Spacing;
  std::vector<std::size_t> Order;
  std::vector<std::uint32_t> Pieces;
};

} // namespace

std::vector<std::uint32_t> MakeCompactPartition(const std::vector<WeighedBlock>& blocks,
  std::uint32_t pieces, const std::array<double, 3>& spacing)
{
  return Bisection(blocks, spacing).Run(pieces);
}

} // namespace isosurface
