// SPDX-License-Identifier: BSD-3-Clause
#include "SpectrumTable.h"

#include <algorithm>
#include <cstddef>

namespace isosurface
{

std::vector<SpectrumColumn> MakeSpectrumColumns(const WorkloadSpectrum& spectrum)
{
  SpectrumColumn isovalues = { "isovalue", nlohmann::json::array() };
  for (std::size_t bin = 0; bin < spectrum.Bins.Count; ++bin)
  {
    isovalues.Values.push_back(spectrum.Bins.GetEdge(bin));
  }
  return { isovalues, { "triangles", spectrum.Triangles },
    { "activeCells", spectrum.ActiveCells } };
}

std::string FormatSpectrumTable(const std::vector<SpectrumColumn>& columns)
{
  std::vector<std::vector<std::string>> texts;
  std::vector<std::size_t> widths;
  for (const SpectrumColumn& column : columns)
  {
    texts.push_back({ column.Name });
    for (const nlohmann::json& value : column.Values)
    {
      texts.back().push_back(value.dump());
    }
    widths.push_back(0);
    for (const std::string& text : texts.back())
    {
      widths.back() = std::max(widths.back(), text.size());
    }
  }
  std::string table;
  const std::size_t lines = texts.empty() ? 0 : texts.front().size();
  for (std::size_t line = 0; line < lines; ++line)
  {
    for (std::size_t column = 0; column < texts.size(); ++column)
    {
      const std::string& text = texts[column][line];
      table += std::string(widths[column] + 2 - text.size(), ' ') + text;
    }
    table += "\n";
  }
  return table;
}

} // namespace isosurface
