// SPDX-License-Identifier: BSD-3-Clause
#include "Storage/Writing/BlockCounts.h"

#include "Ground/Volume/SampleRange.h"
#include "Storage/Record/BlockRecord.h"

#include <cstdint>

namespace isosurface
{

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
