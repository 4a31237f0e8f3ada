// SPDX-License-Identifier: BSD-3-Clause
#include "Storage/Writing/StoreSpectra.h"

#include "Ground/Base/Coding.h"
#include "Surface/Spectrum/BlockActivity.h"

#include <utility>

namespace isosurface
{

StoreSpectra::StoreSpectra(const MeasuredGrid& grid, ArrayVariables variables,
  std::vector<SpectrumBins> bins, std::uint32_t stores, std::size_t rank, std::size_t ranks)
  : Grid(grid)
  , Variables(std::move(variables))
  , Bins(std::move(bins))
  , Stores(stores)
  , Rank(rank)
  , Ranks(ranks)
{
  for (std::size_t store = rank; store < stores; store += ranks)
  {
    this->Mine.push_back(std::make_unique<Store>());
    for (const SpectrumBins& ofVariable : this->Bins)
    {
      Sums sums;
      sums.Spectrum.Bins = ofVariable;
      sums.Spectrum.Triangles.resize(ofVariable.Count);
      sums.Spectrum.ActiveCells.resize(ofVariable.Count);
      sums.Measure = MeasureSums(ofVariable);
      this->Mine.back()->Arrays.push_back(std::move(sums));
    }
  }
  for (std::size_t variable = 0; variable < this->Bins.size(); ++variable)
  {
    this->Totals.push_back(this->MakeSpectrum(variable));
  }
}

WorkloadSpectrum StoreSpectra::MakeSpectrum(std::size_t variable) const
{
  WorkloadSpectrum spectrum(this->Bins[variable]);
  spectrum.AreaUnit = BlockMeasure::GetAreaUnit(this->Grid.Geometry);
  spectrum.VolumeUnit = BlockMeasure::GetVolumeUnit(this->Grid.Geometry);
  return spectrum;
}

std::vector<BlockCounters> StoreSpectra::MakeCounters() const
{
  std::vector<BlockCounters> counters;
  for (const SpectrumBins& bins : this->Bins)
  {
    counters.emplace_back(bins, this->Grid);
  }
  return counters;
}

void StoreSpectra::Add(std::uint32_t store, std::size_t variable, BlockCounters& counted)
{
  Store& mine = *this->Mine[store / this->Ranks];
  const std::lock_guard<std::mutex> lock(mine.Mutex);
  counted.Workload.MoveTo(mine.Arrays[variable].Spectrum);
  counted.Measure.MoveTo(mine.Arrays[variable].Measure);
}

void StoreSpectra::FinishStore(std::uint32_t store, const std::vector<BlockDirectoryEntry>& entries,
  const std::vector<std::vector<KeyRange>>& ranges)
{
  Store& mine = *this->Mine[store / this->Ranks];
  for (std::size_t variable = 0; variable < this->Bins.size(); ++variable)
  {
    // A query reads the segments of all levels; for a magnitude those of all components.
    const Variable& counted = this->Variables[variable];
    const std::size_t first =
      counted.IsMagnitude() ? this->Variables.GetFirst(counted.Array) : variable;
    const std::size_t end = first +
      (counted.IsMagnitude()
          ? static_cast<std::size_t>(this->Variables.GetComponents(counted.Array))
          : 1);
    BlockActivity activity(counted.Type, this->Bins[variable]);
    for (const BlockDirectoryEntry& entry : entries)
    {
      const std::size_t levels = entry.Lengths.size() / this->Variables.GetNumberOfStored();
      activity.Add(ranges[variable][static_cast<std::size_t>(entry.Block)],
        entry.FindSegment(end * levels) - entry.FindSegment(first * levels));
    }
    Sums sums = std::exchange(mine.Arrays[variable], {});
    WorkloadSpectrum spectrum = this->MakeSpectrum(variable);
    spectrum.Triangles = std::move(sums.Spectrum.Triangles);
    spectrum.ActiveCells = std::move(sums.Spectrum.ActiveCells);
    activity.SetActivity(spectrum);
    sums.Measure.SetMeasures(spectrum);
    mine.Arrays[variable].Packed = SpectraFile::Pack(spectrum);
    const std::lock_guard<std::mutex> lock(this->TotalsMutex);
    static_cast<void>(this->Totals[variable].Add(spectrum));
  }
}

void StoreSpectra::ReduceTotals(Communicator& communicator, std::vector<WorkloadSpectrum>& totals)
{
  for (WorkloadSpectrum& total : totals)
  {
    for (WorkloadSpectrum::Counts* counts : total.GetQuantities())
    {
      communicator.ReduceSum(*counts);
    }
  }
}

Message StoreSpectra::Pack() const
{
  Message message;
  for (const std::unique_ptr<Store>& store : this->Mine)
  {
    for (const Sums& sums : store->Arrays)
    {
      message.resize(message.size() + sizeof(std::uint64_t));
      StoreLittleEndian<std::uint64_t>(
        message.data() + message.size() - sizeof(std::uint64_t), sums.Packed.size());
      message.insert(message.end(), sums.Packed.begin(), sums.Packed.end());
    }
  }
  return message;
}

std::vector<SpectraFile::Section> StoreSpectra::Unpack(const std::vector<Message>& messages) const
{
  std::vector<SpectraFile::Section> sections(this->Bins.size() * this->Stores);
  for (std::size_t rank = 0; rank < this->Ranks; ++rank)
  {
    const std::uint8_t* next = messages[rank].data();
    for (std::size_t store = rank; store < this->Stores; store += this->Ranks)
    {
      for (std::size_t variable = 0; variable < this->Bins.size(); ++variable)
      {
        const std::uint8_t* begin = next + sizeof(std::uint64_t);
        next = begin + LoadLittleEndian<std::uint64_t>(next);
        sections[store * this->Bins.size() + variable].assign(begin, next);
      }
    }
  }
  return sections;
}

std::uint64_t StoreSpectra::GetBytes() const
{
  // The triangles, cells and changes of measures of a spectrum. A packed one takes about half of
  // that; rank 0 has it as a section and in a message.
  constexpr std::uint64_t sums = 2 * sizeof(std::uint64_t) + sizeof(MeasureSums::Change);
  constexpr std::uint64_t packed = sums / 2;
  std::uint64_t bytes = 0;
  for (const SpectrumBins& ofVariable : this->Bins)
  {
    bytes += ofVariable.Count * (this->Stores / this->Ranks + 1) * sums;
    bytes += this->Rank == 0 ? ofVariable.Count * std::uint64_t{ this->Stores } * 2 * packed : 0;
  }
  return bytes;
}

std::uint64_t StoreSpectra::GetCounterBytes(std::size_t variables, std::uint64_t blockSize)
{
  const std::uint64_t side = blockSize + 1;
  const std::uint64_t workload = 4 * side * side * side + 16 * SpectrumBins::MaximumCount;
  const std::uint64_t measure =
    8 * side * side + sizeof(MeasureSums::Change) * SpectrumBins::MaximumCount;
  return variables * (workload + measure);
}

} // namespace isosurface
