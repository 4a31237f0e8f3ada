// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_SpectrumTable_h
#define isosurface_SpectrumTable_h

#include "Storage/Spectrum/WorkloadSpectrum.h"

#include <cstddef>
#include <string>
#include <vector>

class vtkDoubleArray;
class vtkTable;

namespace isosurface
{

/// Adds the column of isovalues and one column for each known quantity: the sum of the spectra,
/// which have equal bins (their units may differ).
void AddSpectrumColumns(const std::vector<WorkloadSpectrum>& spectra, vtkTable* table);

/// Adds a column for one quantity of a spectrum with the same bins; `suffix` ends its name.
void AddQuantityColumn(const WorkloadSpectrum& spectrum, std::size_t quantity,
  const std::string& suffix, vtkTable* table);

/// Fills an array with the table's rows as tuples: the isovalue, then each quantity, NaN where the
/// table has no column of it. Columns of stores are left out.
void FillSpectrumTuples(vtkTable* table, vtkDoubleArray* tuples);

} // namespace isosurface

#endif
