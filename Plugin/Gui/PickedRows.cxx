// SPDX-License-Identifier: BSD-3-Clause
#include "PickedRows.h"

#include <algorithm>

namespace isosurface
{

std::vector<double> ChooseIsovalues(
  const std::vector<double>& column, std::vector<std::size_t> rows)
{
  std::sort(rows.begin(), rows.end());
  rows.erase(std::unique(rows.begin(), rows.end()), rows.end());
  rows.erase(std::lower_bound(rows.begin(), rows.end(), column.size()), rows.end());
  std::vector<double> isovalues;
  for (std::size_t index = 0; index < rows.size(); ++index)
  {
    const bool continues = index > 0 && rows[index - 1] + 1 == rows[index];
    const bool goesOn = index + 1 < rows.size() && rows[index] + 1 == rows[index + 1];
    if (!continues || !goesOn)
    {
      isovalues.push_back(column[rows[index]]);
    }
  }
  return isovalues;
}

} // namespace isosurface
