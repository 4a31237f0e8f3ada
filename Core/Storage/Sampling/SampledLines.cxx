// SPDX-License-Identifier: BSD-3-Clause
#include "Storage/Sampling/SampledLines.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <iterator>

namespace isosurface
{

KeptLines KeepSampledLines(
  const ImageLines& lines, std::int64_t columns, std::int64_t rows, const std::uint8_t* isHidden)
{
  const auto findCell = [](double place, std::int64_t size)
  { return std::clamp<std::int64_t>(static_cast<std::int64_t>(std::floor(place)), 0, size - 2); };
  const auto isSampled = [&](const std::array<std::int64_t, 2>& line)
  {
    const auto& first = lines.Points[static_cast<std::size_t>(line[0])];
    const auto& second = lines.Points[static_cast<std::size_t>(line[1])];
    const double column = (first[0] + second[0]) / 2;
    const double row = (first[1] + second[1]) / 2;
    if (std::isnan(column) || std::isnan(row))
    {
      return false;
    }
    const std::int64_t low = findCell(column, columns) + columns * findCell(row, rows);
    return !isHidden ||
      (isHidden[low] | isHidden[low + 1] | isHidden[low + columns] | isHidden[low + columns + 1]) ==
      0;
  };
  KeptLines kept;
  std::copy_if(lines.Lines.begin(), lines.Lines.end(), std::back_inserter(kept.Lines), isSampled);

  std::vector<std::int64_t> numbers(lines.Points.size(), -1);
  for (const auto& line : kept.Lines)
  {
    for (const std::int64_t point : line)
    {
      numbers[static_cast<std::size_t>(point)] = 0;
    }
  }
  for (std::size_t point = 0; point < numbers.size(); ++point)
  {
    if (numbers[point] == 0)
    {
      numbers[point] = static_cast<std::int64_t>(kept.Points.size());
      kept.Points.push_back(static_cast<std::int64_t>(point));
    }
  }
  for (auto& line : kept.Lines)
  {
    for (std::int64_t& point : line)
    {
      point = numbers[static_cast<std::size_t>(point)];
    }
  }
  return kept;
}

} // namespace isosurface
