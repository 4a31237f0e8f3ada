// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_SpectrumTable_h
#define isosurface_SpectrumTable_h

#include "Partition/WorkloadSpectrum.h"

#include <cstddef>
#include <string>
#include <vector>

class vtkDoubleArray;
class vtkTable;

namespace isosurface
{

/// Adds the column of isovalues, and one of each quantity that is known: the sum of the spectra,
/// which have equal bins (and units of their own).
void AddSpectrumColumns(const std::vector<WorkloadSpectrum>& spectra, vtkTable* table);

/// Adds one quantity of a spectrum of the table's bins, its column named with a suffix.
void AddQuantityColumn(const WorkloadSpectrum& spectrum, std::size_t quantity,
  const std::string& suffix, vtkTable* table);

/// Fills an array with the table's rows as tuples: the isovalue, then each quantity, NaN where the
/// table has no column of it. Columns of stores are left out.
void FillSpectrumTuples(vtkTable* table, vtkDoubleArray* tuples);

} // namespace isosurface

#endif
