// SPDX-License-Identifier: BSD-3-Clause
#include "SpectrumTable.h"

#include "RangedArray.h"

#include "vtkDoubleArray.h"
#include "vtkIdTypeArray.h"
#include "vtkNew.h"
#include "vtkTable.h"

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

double GetUnit(const WorkloadSpectrum& spectrum, std::size_t quantity)
{
  return quantity == Area ? spectrum.AreaUnit : spectrum.VolumeUnit;
}

/// The sum of a quantity over spectra, in its unit; nothing if one of them does not know it.
template <typename Array>
void AddSum(const std::vector<const WorkloadSpectrum*>& spectra, std::size_t quantity,
  const std::string& name, vtkTable* table)
{
  const std::size_t bins = spectra.front()->Bins.Count;
  vtkNew<Array> column;
  column->SetName(name.c_str());
  AllocateTuples(column, static_cast<vtkIdType>(bins));
  column->Fill(0);
  for (const WorkloadSpectrum* spectrum : spectra)
  {
    const WorkloadSpectrum::Counts& counts = *spectrum->GetQuantities()[quantity];
    if (counts.size() != bins)
    {
      return;
    }
    for (std::size_t bin = 0; bin < bins; ++bin)
    {
      using Value = typename Array::ValueType;
      Value value = static_cast<Value>(counts[bin]);
      if (quantity >= Area)
      {
        value = static_cast<Value>(static_cast<double>(value) * GetUnit(*spectrum, quantity));
      }
      const auto row = static_cast<vtkIdType>(bin);
      column->SetValue(row, column->GetValue(row) + value);
    }
  }
  table->AddColumn(column);
}

void AddQuantity(const std::vector<const WorkloadSpectrum*>& spectra, std::size_t quantity,
  const std::string& suffix, vtkTable* table)
{
  static_assert(Volume + 1 == WorkloadSpectrum::NumberOfQuantities, "Area and Volume are the last");
  const std::string name = Names[quantity] + suffix;
  if (quantity < Area)
  {
    AddSum<vtkIdTypeArray>(spectra, quantity, name, table);
  }
  else
  {
    AddSum<vtkDoubleArray>(spectra, quantity, name, table);
  }
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
  all.reserve(spectra.size());
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
