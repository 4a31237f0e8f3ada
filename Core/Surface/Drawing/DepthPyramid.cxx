// SPDX-License-Identifier: BSD-3-Clause
#include "Surface/Drawing/DepthPyramid.h"

#include <algorithm>
#include <cstddef>
#include <utility>

namespace isosurface
{
namespace
{

/// A box is compared with at most so many squares on an axis.
constexpr int MostSquares = 8;

int DivideUp(int number, int by)
{
  return (number + by - 1) / by;
}

} // namespace

void DepthPyramid::Build(const std::vector<float>& depths, int width, int height)
{
  this->Width = width;
  this->Height = height;
  this->Levels.assign(1, { CountSquares(width), CountSquares(height), {} });
  Level& finest = this->Levels.front();
  finest.Farthest.assign(
    static_cast<std::size_t>(finest.Width) * static_cast<std::size_t>(finest.Height), 0.0F);
  for (int y = 0; y < height; ++y)
  {
    const float* row =
      depths.data() + static_cast<std::size_t>(y) * static_cast<std::size_t>(width);
    float* squares = finest.Farthest.data() +
      static_cast<std::size_t>(y / SquareSide) * static_cast<std::size_t>(finest.Width);
    for (int x = 0; x < width; ++x)
    {
      squares[x / SquareSide] = std::max(squares[x / SquareSide], row[x]);
    }
  }
  this->AddCoarserLevels();
}

void DepthPyramid::BringNearer(const std::vector<float>& squares)
{
  std::vector<float>& finest = this->Levels.front().Farthest;
  std::transform(finest.begin(), finest.end(), squares.begin(), finest.begin(),
    [](float mine, float told) { return std::min(mine, told); });
  this->Levels.resize(1);
  this->AddCoarserLevels();
}

void DepthPyramid::AddCoarserLevels()
{
  while (this->Levels.back().Width > 1 || this->Levels.back().Height > 1)
  {
    this->AddCoarserLevel();
  }
}

void DepthPyramid::AddCoarserLevel()
{
  const Level& fine = this->Levels.back();
  Level coarse{ DivideUp(fine.Width, 2), DivideUp(fine.Height, 2), {} };
  coarse.Farthest.assign(
    static_cast<std::size_t>(coarse.Width) * static_cast<std::size_t>(coarse.Height), 0.0F);
  for (int y = 0; y < fine.Height; ++y)
  {
    const float* row =
      fine.Farthest.data() + static_cast<std::size_t>(y) * static_cast<std::size_t>(fine.Width);
    float* squares = coarse.Farthest.data() +
      static_cast<std::size_t>(y / 2) * static_cast<std::size_t>(coarse.Width);
    for (int x = 0; x < fine.Width; ++x)
    {
      squares[x / 2] = std::max(squares[x / 2], row[x]);
    }
  }
  this->Levels.push_back(std::move(coarse));
}

bool DepthPyramid::IsBehind(const ProjectedBox& box) const
{
  if (this->Levels.empty())
  {
    return false;
  }
  const int left = std::max(box.Pixels.Left, 0);
  const int right = std::min(box.Pixels.Right, this->Width);
  const int bottom = std::max(box.Pixels.Bottom, 0);
  const int top = std::min(box.Pixels.Top, this->Height);
  if (left >= right || bottom >= top)
  {
    return true;
  }
  std::size_t level = 0;
  int side = SquareSide;
  while (
    std::max(right - left, top - bottom) > MostSquares * side && level + 1 < this->Levels.size())
  {
    side *= 2;
    ++level;
  }
  const Level& squares = this->Levels[level];
  for (int y = bottom / side; y <= (top - 1) / side; ++y)
  {
    const float* row = squares.Farthest.data() +
      static_cast<std::size_t>(y) * static_cast<std::size_t>(squares.Width);
    for (int x = left / side; x <= (right - 1) / side; ++x)
    {
      if (!(row[x] < box.Depth))
      {
        return false;
      }
    }
  }
  return true;
}

} // namespace isosurface
