// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_SpectrumTable_h
#define isosurface_SpectrumTable_h

#include "Partition/WorkloadSpectrum.h"

#include <nlohmann/json.hpp>

#include <cstddef>
#include <string>
#include <vector>

namespace isosurface
{

/// One column of a printed contour spectrum: a value an isovalue.
struct SpectrumColumn
{
  std::string Name;
  nlohmann::json Values; ///< an array of numbers
};

/// All that a spectrum tells, the isovalues first; area and volume in the grid's units.
std::vector<SpectrumColumn> MakeSpectrumColumns(const WorkloadSpectrum& spectrum);

/// At most `count` bins, evenly spread from the first to the last one whose isosurface has at least
/// a hundredth of the triangles of the largest one; ascending.
std::vector<std::size_t> PickBins(const WorkloadSpectrum& spectrum, std::size_t count);

/// The columns beside each other, a line an isovalue, below their names; of all bins, or of those
/// that are given.
std::string FormatSpectrumTable(const std::vector<SpectrumColumn>& columns);
std::string FormatSpectrumTable(
  const std::vector<SpectrumColumn>& columns, const std::vector<std::size_t>& bins);

} // namespace isosurface

#endif
