// SPDX-License-Identifier: BSD-3-Clause
#include "Surface/Drawing/SharedDepths.h"

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <iterator>
#include <limits>

namespace isosurface
{
namespace
{

SharedDepths* CurrentDepths = nullptr;

/// Depths are not negative, so their bits have the same order.
std::uint64_t GetNearness(float depth)
{
  std::uint32_t bits = 0;
  std::memcpy(&bits, &depth, sizeof(bits));
  return ~bits;
}

float GetDepth(std::uint64_t nearness)
{
  const auto bits = ~static_cast<std::uint32_t>(nearness);
  float depth = 0;
  std::memcpy(&depth, &bits, sizeof(depth));
  return nearness == 0 ? std::numeric_limits<float>::infinity() : depth;
}

} // namespace

SharedDepths* SharedDepths::GetCurrent()
{
  return CurrentDepths;
}

void SharedDepths::SetCurrent(SharedDepths* depths)
{
  CurrentDepths = depths;
}

void SharedDepths::Begin(int width, int height, const PixelBox& part, const void* last)
{
  this->Width = width;
  this->Height = height;
  this->Part = part;
  this->Last = nullptr; // until there is memory
  this->ReduceAll = nullptr;
  this->Told.assign(static_cast<std::size_t>(DepthPyramid::CountSquares(width)) *
      static_cast<std::size_t>(DepthPyramid::CountSquares(height)),
    0);
  this->Farthest.clear();
  this->Farthest.reserve(this->Told.size()); // no rank runs out of memory while others wait
  this->Last = last;
}

void SharedDepths::Share(const void* mapper, DepthPyramid& drawn)
{
  if (!this->Last || mapper != this->Last || !drawn.HasSize(this->Width, this->Height))
  {
    return;
  }
  this->Sharer = mapper;
  if (this->ReduceAll)
  {
    this->Tell(drawn.GetSquares());
    this->ReduceOnce();
  }
  if (!this->Farthest.empty())
  {
    drawn.BringNearer(this->Farthest);
  }
}

void SharedDepths::End()
{
  if (this->ReduceAll && this->IsWanted())
  {
    this->Sharer = nullptr; // it could, and did not
  }
  this->ReduceOnce();
}

void SharedDepths::Tell(const std::vector<float>& squares)
{
  constexpr int side = DepthPyramid::SquareSide;
  std::size_t square = 0;
  for (int y = 0; y < this->Height; y += side)
  {
    const bool isRowDrawn =
      y >= this->Part.Bottom && std::min(y + side, this->Height) <= this->Part.Top;
    for (int x = 0; x < this->Width; x += side, ++square)
    {
      // Around its part, this rank has an older image.
      if (isRowDrawn && x >= this->Part.Left && std::min(x + side, this->Width) <= this->Part.Right)
      {
        this->Told[square] = GetNearness(squares[square]);
      }
    }
  }
}

void SharedDepths::ReduceOnce()
{
  const ReduceMaximum reduce = std::exchange(this->ReduceAll, nullptr);
  if (reduce && reduce(this->Told))
  {
    std::transform(
      this->Told.begin(), this->Told.end(), std::back_inserter(this->Farthest), GetDepth);
  }
}

} // namespace isosurface
