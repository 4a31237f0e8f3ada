// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_PrintedSpectrum_h
#define isosurface_PrintedSpectrum_h

#include "Storage/Spectrum/WorkloadSpectrum.h"

#include <nlohmann/json.hpp>

#include <cstddef>
#include <string>
#include <vector>

namespace isosurface
{

/// One column of a printed contour spectrum: one value for each isovalue.
struct SpectrumColumn
{
  std::string Name;
  nlohmann::json Values; ///< an array of numbers
};

/// All columns of a spectrum, isovalues first; area and volume in the units of the grid.
std::vector<SpectrumColumn> MakeSpectrumColumns(const WorkloadSpectrum& spectrum);

/// At most `count` bins, evenly distributed from the first to the last whose isosurface has at least
/// a hundredth of the maximum number of triangles; ascending.
std::vector<std::size_t> PickBins(const WorkloadSpectrum& spectrum, std::size_t count);

/// The columns as text, with their names and one line for each isovalue: of all bins, or of the
/// given ones.
std::string FormatSpectrum(const std::vector<SpectrumColumn>& columns);
std::string FormatSpectrum(
  const std::vector<SpectrumColumn>& columns, const std::vector<std::size_t>& bins);

} // namespace isosurface

#endif
