// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_SpectrumTable_h
#define isosurface_SpectrumTable_h

#include "Partition/WorkloadSpectrum.h"

#include <nlohmann/json.hpp>

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

/// All that a spectrum tells, the isovalues first. What a spectrum gains is added here, and is then
/// in the text and in the JSON.
std::vector<SpectrumColumn> MakeSpectrumColumns(const WorkloadSpectrum& spectrum);

/// The columns beside each other, a line an isovalue, below their names.
std::string FormatSpectrumTable(const std::vector<SpectrumColumn>& columns);

} // namespace isosurface

#endif
