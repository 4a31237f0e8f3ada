// SPDX-License-Identifier: BSD-3-Clause
#include "SpectrumTable.h"

#include "RangedArray.h"

#include "vtkDoubleArray.h"
#include "vtkNew.h"
#include "vtkSmartPointer.h"
#include "vtkTable.h"

#include <algorithm>
#include <cstdint>
#include <limits>

namespace isosurface
{
namespace
{

constexpr const char* IsovalueName = "Isovalue";
constexpr const char* Names[WorkloadSpectrum::NumberOfQuantities] = { "Triangles", "ActiveCells",
  "ActiveBlocks", "Bytes", "Area", "Volume" };
constexpr std::size_t Area = 4;
constexpr std::size_t Volume = 5;

/// The sum of a quantity over spectra, areas and volumes in the units of the world; nothing if one of them does
/// not know it.
void AddQuantity(const std::vector<const WorkloadSpectrum*>& spectra, std::size_t quantity,
  const std::string& suffix, vtkTable* table)
{
  static_assert(Volume + 1 == WorkloadSpectrum::NumberOfQuantities, "Area and Volume are the last");
  std::vector<double> sums(spectra.front()->Bins.Count);
  for (const WorkloadSpectrum* spectrum : spectra)
  {
    const WorkloadSpectrum::Counts& counts = *spectrum->GetQuantities()[quantity];
    if (counts.size() != sums.size())
    {
      return;
    }
    const double unit = quantity == Area ? spectrum->AreaUnit
      : quantity == Volume               ? spectrum->VolumeUnit
                                         : 1;
    std::transform(counts.begin(), counts.end(), sums.begin(), sums.begin(),
      [unit](std::uint64_t count, double sum) { return sum + static_cast<double>(count) * unit; });
  }
  const auto column = vtkSmartPointer<vtkDataArray>::Take(
    vtkDataArray::CreateDataArray(quantity < Area ? VTK_ID_TYPE : VTK_DOUBLE));
  column->SetName((Names[quantity] + suffix).c_str());
  AllocateTuples(column, static_cast<vtkIdType>(sums.size()));
  for (std::size_t bin = 0; bin < sums.size(); ++bin)
  {
    column->SetComponent(static_cast<vtkIdType>(bin), 0, sums[bin]);
  }
  table->AddColumn(column);
}

} // namespace

void AddSpectrumColumns(const std::vector<WorkloadSpectrum>& spectra, vtkTable* table)
{
  if (spectra.empty())
  {
    return;
  }
  const SpectrumBins& bins = spectra.front().Bins;
  vtkNew<vtkDoubleArray> isovalues;
  isovalues->SetName(IsovalueName);
  AllocateTuples(isovalues, bins.Count);
  for (std::uint32_t bin = 0; bin < bins.Count; ++bin)
  {
    isovalues->SetValue(bin, bins.GetEdge(bin));
  }
  table->AddColumn(isovalues);
  std::vector<const WorkloadSpectrum*> all;
  for (const WorkloadSpectrum& spectrum : spectra)
  {
    all.push_back(&spectrum);
  }
  for (std::size_t quantity = 0; quantity < WorkloadSpectrum::NumberOfQuantities; ++quantity)
  {
    AddQuantity(all, quantity, "", table);
  }
}

void AddQuantityColumn(const WorkloadSpectrum& spectrum, std::size_t quantity,
  const std::string& suffix, vtkTable* table)
{
  AddQuantity({ &spectrum }, quantity, suffix, table);
}

void FillSpectrumTuples(vtkTable* table, vtkDoubleArray* tuples)
{
  constexpr int columns = 1 + static_cast<int>(WorkloadSpectrum::NumberOfQuantities);
  tuples->SetNumberOfComponents(columns);
  tuples->SetNumberOfTuples(table->GetNumberOfRows());
  tuples->Fill(std::numeric_limits<double>::quiet_NaN());
  for (int column = 0; column < columns; ++column)
  {
    const char* name = column == 0 ? IsovalueName : Names[column - 1];
    if (auto* values = vtkDataArray::SafeDownCast(table->GetColumnByName(name)))
    {
      tuples->CopyComponent(column, values, 0);
    }
  }
}

} // namespace isosurface
