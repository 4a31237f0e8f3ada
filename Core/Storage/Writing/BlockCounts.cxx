// SPDX-License-Identifier: BSD-3-Clause
#include "Storage/Writing/BlockCounts.h"

#include "Ground/Base/Coding.h"
#include "Ground/Volume/SampleRange.h"
#include "Storage/Record/BlockRecord.h"
#include "Storage/Spectrum/BlockActivity.h"

#include <algorithm>
#include <utility>

namespace isosurface
{
namespace
{

/// The maximum number of bins of a spectrum.
std::uint64_t CountBins(ValueType type)
{
  return GetValueSize(type) == 1 ? 256 : SpectrumBins::MaximumCount;
}

} // namespace

StoreSpectra::StoreSpectra(const MeasuredGrid& grid, ArrayVariables variables, std::uint32_t stores,
  std::size_t rank, std::size_t ranks)
  : Grid(grid)
  , Variables(std::move(variables))
  , Stores(stores)
  , Rank(rank)
  , Ranks(ranks)
{
  for (std::size_t store = rank; store < stores; store += ranks)
  {
    this->Mine.push_back(std::make_unique<Store>());
    for (std::size_t variable = 0; variable < this->Variables.GetCount(); ++variable)
    {
      this->Mine.back()->Sums.emplace_back(this->Variables[variable].Type);
    }
  }
}

void StoreSpectra::Add(std::uint32_t store, std::size_t variable, const EdgeSums& counted)
{
  Store& mine = *this->Mine[store / this->Ranks];
  const std::lock_guard<std::mutex> lock(mine.Mutex);
  mine.Sums[variable].Add(counted);
}

std::vector<std::uint8_t> StoreSpectra::PackSums(std::uint32_t store) const
{
  std::vector<std::uint8_t> packed;
  for (const GrowingSpectrum& sums : this->Mine[store / this->Ranks]->Sums)
  {
    sums.AppendTo(packed);
  }
  return packed;
}

bool StoreSpectra::UnpackSums(std::uint32_t store, const std::vector<std::uint8_t>& packed)
{
  ByteReader reader(packed);
  std::vector<GrowingSpectrum>& sums = this->Mine[store / this->Ranks]->Sums;
  return std::all_of(sums.begin(), sums.end(),
           [&](GrowingSpectrum& ofVariable) { return ofVariable.ReadFrom(reader); }) &&
    reader.GetRemaining() == 0;
}

void StoreSpectra::SetRanges(const std::vector<KeyRange>& ranges)
{
  this->FiniteRanges = ranges;
  this->Totals.clear();
  for (std::size_t variable = 0; variable < ranges.size(); ++variable)
  {
    this->Totals.push_back(this->MakeSpectrum(variable));
  }
}

WorkloadSpectrum StoreSpectra::MakeSpectrum(std::size_t variable) const
{
  WorkloadSpectrum spectrum(
    SpectrumBins::Choose(this->Variables[variable].Type, this->FiniteRanges[variable]));
  spectrum.AreaUnit = BlockMeasure::GetAreaUnit(this->Grid.Geometry);
  spectrum.VolumeUnit = BlockMeasure::GetVolumeUnit(this->Grid.Geometry);
  return spectrum;
}

bool StoreSpectra::FinishStore(std::uint32_t store, const std::vector<BlockDirectoryEntry>& entries,
  const std::vector<std::vector<KeyRange>>& ranges)
{
  Store& mine = *this->Mine[store / this->Ranks];
  for (std::size_t variable = 0; variable < this->Variables.GetCount(); ++variable)
  {
    // A query reads the segments of all levels; for a magnitude those of all components.
    const Variable& counted = this->Variables[variable];
    const std::size_t first =
      counted.IsMagnitude() ? this->Variables.GetFirst(counted.Array) : variable;
    const std::size_t end = first +
      (counted.IsMagnitude()
          ? static_cast<std::size_t>(this->Variables.GetComponents(counted.Array))
          : 1);
    WorkloadSpectrum spectrum = this->MakeSpectrum(variable);
    BlockActivity activity(counted.Type, spectrum.Bins);
    for (const BlockDirectoryEntry& entry : entries)
    {
      const std::size_t levels = entry.Lengths.size() / this->Variables.GetNumberOfStored();
      activity.Add(ranges[variable][static_cast<std::size_t>(entry.Block)],
        entry.FindSegment(end * levels) - entry.FindSegment(first * levels));
    }
    activity.SetActivity(spectrum);
    if (!std::exchange(mine.Sums[variable], GrowingSpectrum(counted.Type))
           .SetSums(spectrum, this->FiniteRanges[variable]))
    {
      return false;
    }
    mine.Packed.push_back(SpectraFile::Pack(spectrum));
    const std::lock_guard<std::mutex> lock(this->TotalsMutex);
    static_cast<void>(this->Totals[variable].Add(spectrum));
  }
  return true;
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
    for (const SpectraFile::Section& packed : store->Packed)
    {
      message.resize(message.size() + sizeof(std::uint64_t));
      StoreLittleEndian<std::uint64_t>(
        message.data() + message.size() - sizeof(std::uint64_t), packed.size());
      message.insert(message.end(), packed.begin(), packed.end());
    }
  }
  return message;
}

std::vector<SpectraFile::Section> StoreSpectra::Unpack(const std::vector<Message>& messages) const
{
  const std::size_t variables = this->Variables.GetCount();
  std::vector<SpectraFile::Section> sections(variables * this->Stores);
  for (std::size_t rank = 0; rank < this->Ranks; ++rank)
  {
    const std::uint8_t* next = messages[rank].data();
    for (std::size_t store = rank; store < this->Stores; store += this->Ranks)
    {
      for (std::size_t variable = 0; variable < variables; ++variable)
      {
        const std::uint8_t* begin = next + sizeof(std::uint64_t);
        next = begin + LoadLittleEndian<std::uint64_t>(next);
        sections[store * variables + variable].assign(begin, next);
      }
    }
  }
  return sections;
}

std::uint64_t StoreSpectra::GetBytes() const
{
  // The sums at each edge, and twice that while the bins grow. A packed spectrum takes about half of
  // the numbers of a spectrum; rank 0 has it as a section and in a message.
  constexpr std::uint64_t sums = sizeof(SurfaceSums);
  constexpr std::uint64_t packed = sizeof(SurfaceSums) / 2;
  std::uint64_t bytes = 0;
  for (std::size_t variable = 0; variable < this->Variables.GetCount(); ++variable)
  {
    const std::uint64_t bins = CountBins(this->Variables[variable].Type);
    bytes += bins * (this->Stores / this->Ranks + 3) * sums;
    bytes += this->Rank == 0 ? bins * std::uint64_t{ this->Stores } * 2 * packed : 0;
  }
  return bytes;
}

std::uint64_t StoreSpectra::GetCounterBytes(std::uint64_t blockSize)
{
  const std::uint64_t side = blockSize + 1;
  const std::uint64_t workload = 8 * side * side * side + 32 * SpectrumBins::MaximumCount;
  const std::uint64_t measure =
    8 * side * side + 2 * sizeof(MeasureSums::Change) * SpectrumBins::MaximumCount;
  const std::uint64_t sums = 3 * sizeof(SurfaceSums) * SpectrumBins::MaximumCount;
  return workload + measure + sums;
}

BlockCounts::BlockCounts(
  const BlockedVolumeHeader& header, std::size_t rank, std::size_t ranks, int threads)
  : Grid(header.GetBlockGrid())
  , Variables(header.GetVariables())
  , Spectra(MeasuredGrid{ header.Grid, header.Lines ? &*header.Lines : nullptr }, Variables,
      header.NumberOfStores, rank, ranks)
  , Ranges(Variables.GetCount(),
      std::vector<KeyRange>(static_cast<std::size_t>(Grid.GetNumberOfBlocks())))
{
  this->Threads.reserve(static_cast<std::size_t>(threads));
  for (int thread = 0; thread < threads; ++thread)
  {
    this->Threads.push_back({ BlockSpectrum(this->Spectra.GetGrid()),
      std::vector<KeyRange>(this->Variables.GetCount()) });
  }
}

void BlockCounts::Add(const PendingBlock& block, const std::vector<SampleView>& views, int thread)
{
  Counters& counters = this->Threads[static_cast<std::size_t>(thread)];
  for (std::size_t variable = 0; variable < this->Variables.GetCount(); ++variable)
  {
    // The record is in the processor's cache, in one piece; the slab's rows are far apart.
    if (const auto view = this->ViewRecord(block, variable))
    {
      this->AddVariable(block, variable, *view, counters);
    }
    else if (variable < views.size())
    {
      this->AddVariable(block, variable, views[variable], counters);
    }
    else
    {
      this->AddVariable(block, variable, this->AssembleVariable(block, variable)->View, counters);
    }
  }
}

void BlockCounts::AddVariable(
  const PendingBlock& block, std::size_t variable, const SampleView& samples, Counters& counters)
{
  const SampleRange range = FindSampleRange(samples, samples.Box);
  this->Ranges[variable][static_cast<std::size_t>(block.Block)] = range.All;
  counters.FiniteRanges[variable].Add(range.Finite);
  this->Spectra.Add(block.Store, variable, counters.Spectrum.Count(samples, range));
}

std::optional<SampleView> BlockCounts::ViewRecord(
  const PendingBlock& block, std::size_t variable) const
{
  const Variable& wanted = this->Variables[variable];
  if (wanted.IsMagnitude() || this->Grid.GetNumberOfLevels() > 1)
  {
    return std::nullopt;
  }
  const std::uint64_t offset = block.Layout.Offsets[variable] + BlockRecord::SegmentHeaderSize;
  if (offset % GetValueSize(wanted.Type) != 0)
  {
    return std::nullopt;
  }
  SampleView view = MakeSampleView(
    wanted.Type, this->Grid.GetGhostedVertices(block.Block, 0), block.Record.GetData() + offset);
  view.Box = this->Grid.GetVertices(block.Block);
  return view;
}

/// The samples of a filled block at full resolution.
std::shared_ptr<DecodedBlock> BlockCounts::AssembleVariable(
  const PendingBlock& block, std::size_t variable) const
{
  const Variable& wanted = this->Variables[variable];
  if (wanted.IsMagnitude())
  {
    DecodedBlocks components;
    for (int component = 0; component < this->Variables.GetComponents(wanted.Array); ++component)
    {
      components.push_back(
        this->AssembleVariable(block, *this->Variables.Find(wanted.Array, component)));
    }
    return MakeMagnitudeBlock(components);
  }
  const auto levels = static_cast<std::size_t>(this->Grid.GetNumberOfLevels());
  std::vector<const std::uint8_t*> segments;
  for (std::size_t index = variable * levels; index < (variable + 1) * levels; ++index)
  {
    segments.push_back(
      block.Record.GetData() + block.Layout.Offsets[index] + BlockRecord::SegmentHeaderSize);
  }
  return AssembleLevel(this->Grid, block.Block, 0, wanted.Type, segments);
}

void BlockCounts::AddFiniteRanges(const std::vector<KeyRange>& ranges)
{
  for (std::size_t variable = 0; variable < ranges.size(); ++variable)
  {
    this->Threads[0].FiniteRanges[variable].Add(ranges[variable]);
  }
}

std::vector<KeyRange> BlockCounts::JoinFiniteRanges() const
{
  std::vector<KeyRange> finite(this->Variables.GetCount());
  for (const Counters& ofThread : this->Threads)
  {
    for (std::size_t variable = 0; variable < finite.size(); ++variable)
    {
      finite[variable].Add(ofThread.FiniteRanges[variable]);
    }
  }
  return finite;
}

} // namespace isosurface
