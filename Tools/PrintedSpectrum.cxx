// SPDX-License-Identifier: BSD-3-Clause
#include "PrintedSpectrum.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <iterator>
#include <numeric>
#include <utility>

namespace isosurface
{
namespace
{

using PlainJson = nlohmann::json;

PlainJson Scale(const WorkloadSpectrum::Counts& counts, double unit)
{
  PlainJson values = PlainJson::array();
  for (const std::uint64_t count : counts)
  {
    values.push_back(static_cast<double>(count) * unit);
  }
  return values;
}

std::string FormatNumber(const PlainJson& value)
{
  if (!value.is_number_float())
  {
    return value.dump();
  }
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.9g", value.get<double>());
  return text.data();
}

} // namespace

std::vector<SpectrumColumn> MakeSpectrumColumns(const WorkloadSpectrum& spectrum)
{
  PlainJson isovalues = PlainJson::array();
  for (std::size_t bin = 0; bin < spectrum.Bins.Count; ++bin)
  {
    isovalues.push_back(spectrum.Bins.GetEdge(bin));
  }
  const SpectrumColumn quantities[] = { { "triangles", spectrum.Triangles },
    { "activeCells", spectrum.ActiveCells }, { "activeBlocks", spectrum.ActiveBlocks },
    { "bytes", spectrum.Bytes }, { "area", Scale(spectrum.Area, spectrum.AreaUnit) },
    { "volume", Scale(spectrum.Volume, spectrum.VolumeUnit) } };
  std::vector<SpectrumColumn> columns = { { "isovalue", std::move(isovalues) } };
  static_assert(std::size(quantities) == WorkloadSpectrum::NumberOfQuantities);
  std::copy_if(std::begin(quantities), std::end(quantities), std::back_inserter(columns),
    [&](const SpectrumColumn& column) { return column.Values.size() == spectrum.Bins.Count; });
  return columns;
}

std::vector<std::size_t> PickBins(const WorkloadSpectrum& spectrum, std::size_t count)
{
  const WorkloadSpectrum::Counts& triangles = spectrum.Triangles;
  if (triangles.empty() || count == 0)
  {
    return {};
  }
  const std::uint64_t minimum = *std::max_element(triangles.begin(), triangles.end()) / 100;
  const auto isLarge = [minimum](std::uint64_t number) { return number >= minimum; };
  const auto first = static_cast<std::size_t>(
    std::find_if(triangles.begin(), triangles.end(), isLarge) - triangles.begin());
  const auto last = static_cast<std::size_t>(
    triangles.rend() - std::find_if(triangles.rbegin(), triangles.rend(), isLarge) - 1);
  const std::size_t steps = std::min(count, last - first + 1) - 1;
  std::vector<std::size_t> bins = { first };
  for (std::size_t step = 1; step <= steps; ++step)
  {
    bins.push_back(first + (last - first) * step / steps);
  }
  return bins;
}

std::string FormatSpectrum(const std::vector<SpectrumColumn>& columns)
{
  std::vector<std::size_t> bins(columns.empty() ? 0 : columns.front().Values.size());
  std::iota(bins.begin(), bins.end(), std::size_t{ 0 });
  return FormatSpectrum(columns, bins);
}

std::string FormatSpectrum(
  const std::vector<SpectrumColumn>& columns, const std::vector<std::size_t>& bins)
{
  std::vector<std::string> lines(bins.size() + 1);
  for (const SpectrumColumn& column : columns)
  {
    std::vector<std::string> texts = { column.Name };
    for (const std::size_t bin : bins)
    {
      texts.push_back(FormatNumber(column.Values[bin]));
    }
    std::size_t width = 0;
    for (const std::string& text : texts)
    {
      width = std::max(width, text.size());
    }
    for (std::size_t line = 0; line < lines.size(); ++line)
    {
      lines[line] += std::string(width + 2 - texts[line].size(), ' ') + texts[line];
    }
  }
  std::string table;
  for (const std::string& line : lines)
  {
    table += line + "\n";
  }
  return table;
}

} // namespace isosurface
