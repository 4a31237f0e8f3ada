// SPDX-License-Identifier: BSD-3-Clause
#include "Storage/Spectrum/GrowingSpectrum.h"

#include <algorithm>

namespace isosurface
{

SurfaceSums& SurfaceSums::operator+=(const SurfaceSums& other)
{
  this->Triangles += other.Triangles;
  this->Cells += other.Cells;
  this->Area += other.Area;
  this->Volume += other.Volume;
  return *this;
}

SurfaceSums SurfaceSums::operator-(const SurfaceSums& other) const
{
  return { this->Triangles - other.Triangles, this->Cells - other.Cells, this->Area - other.Area,
    this->Volume - other.Volume };
}

const EdgeSums& BlockSpectrum::Count(const SampleView& samples, const SampleRange& range)
{
  this->Sums.Range = range.Finite;
  this->Sums.Bins = SpectrumBins::Choose(samples.Type, range.Finite);
  // One more edge is above all finite samples.
  SpectrumBins bins = this->Sums.Bins;
  ++bins.Count;
  this->Counts.Bins = bins;
  this->Counts.Triangles.assign(bins.Count, 0);
  this->Counts.ActiveCells.assign(bins.Count, 0);
  this->Measure.SetBins(bins);
  if (range.All.Minimum < range.All.Maximum)
  {
    this->Workload.SetBins(bins);
    this->Workload.Count(samples);
    this->Workload.MoveTo(this->Counts);
    this->Measure.Count(samples);
  }
  else
  {
    this->Measure.CountUniform(samples.Type, range.All.Minimum, samples.Box);
  }
  this->SumEdges();
  return this->Sums;
}

void BlockSpectrum::SumEdges()
{
  const SpectrumBins& bins = this->Counts.Bins;
  this->Measures.Changes.assign(bins.Count + std::size_t{ 1 }, {});
  this->Measure.MoveTo(this->Measures);
  this->Sums.Edges.resize(bins.Count);
  MeasureSums::Change sum;
  for (std::size_t bin = 0; bin < bins.Count; ++bin)
  {
    sum += this->Measures.Changes[bin];
    this->Sums.Edges[bin] = { this->Counts.Triangles[bin], this->Counts.ActiveCells[bin], sum.Area,
      sum.Constant - sum.Slope * bin };
  }
  // All finite samples are above the first edge, and none above the last one.
  this->Sums.Below = this->Sums.Edges.front();
  this->Sums.Above = this->Sums.Edges.back();
  this->Sums.Edges.pop_back();
}

void GrowingSpectrum::Add(const EdgeSums& sums)
{
  this->Grow(sums.Range);
  this->AddInBins(sums);
}

void GrowingSpectrum::AddInBins(const EdgeSums& sums)
{
  this->Below += sums.Below;
  if (sums.Range.IsEmpty())
  {
    return;
  }
  // The edges of these bins are multiples of a width, in units of the narrower bins of `sums`. Bins of
  // zeros alone may be wider (SpectrumBins::Choose), but their only edge is 0 in all units.
  constexpr int beyondAll = 62;
  const std::int64_t width = std::int64_t{ 1 }
    << std::clamp(this->Bins.Exponent - sums.Bins.Exponent, 0, beyondAll);
  const std::int64_t first = sums.Bins.First;
  const std::int64_t last = first + (static_cast<std::int64_t>(sums.Bins.Count) - 1);
  // Quotients are rounded up for the first one, down for the last one.
  const std::int64_t firstMultiple = first / width + (first > 0 && first % width != 0 ? 1 : 0);
  const std::int64_t lastMultiple = last / width - (last < 0 && last % width != 0 ? 1 : 0);
  // Counted from the first bin: the edge behind the last one may be beyond 64 bits.
  auto bin = static_cast<std::size_t>(firstMultiple - this->Bins.First);
  const std::size_t end = static_cast<std::size_t>(lastMultiple - this->Bins.First) + 1;
  SurfaceSums before = sums.Below;
  for (; bin < end; ++bin)
  {
    const std::int64_t multiple = this->Bins.First + static_cast<std::int64_t>(bin);
    const SurfaceSums& edge = sums.Edges[static_cast<std::size_t>(multiple * width - first)];
    this->Changes[bin] += edge - before;
    before = edge;
  }
  this->Changes[bin] += sums.Above - before;
}

void GrowingSpectrum::Grow(const KeyRange& range)
{
  KeyRange all = this->Range;
  all.Add(range);
  if (all.Minimum == this->Range.Minimum && all.Maximum == this->Range.Maximum)
  {
    return;
  }
  const SpectrumBins bins = SpectrumBins::Choose(this->Type, all);
  if (bins != this->Bins)
  {
    const EdgeSums sums = this->Resolve();
    this->Bins = bins;
    this->Below = {};
    this->Changes.assign(bins.Count + std::size_t{ 1 }, {});
    this->AddInBins(sums);
  }
  this->Range = all;
}

EdgeSums GrowingSpectrum::Resolve() const
{
  EdgeSums sums{ this->Range, this->Bins, this->Below, {}, this->Below };
  for (std::size_t bin = 0; bin < this->Bins.Count; ++bin)
  {
    sums.Edges.push_back(sums.Above += this->Changes[bin]);
  }
  sums.Above += this->Changes[this->Bins.Count];
  return sums;
}

bool GrowingSpectrum::SetSums(WorkloadSpectrum& spectrum, const KeyRange& range)
{
  if (!range.Contains(this->Range))
  {
    return false;
  }
  this->Grow(range);
  SurfaceSums sum = this->Below;
  for (std::size_t bin = 0; bin < this->Bins.Count; ++bin)
  {
    sum += this->Changes[bin];
    spectrum.Triangles[bin] = sum.Triangles;
    spectrum.ActiveCells[bin] = sum.Cells;
    spectrum.Area[bin] = MeasureSums::Round(sum.Area);
    spectrum.Volume[bin] = MeasureSums::Round(sum.Volume);
  }
  return true;
}

void GrowingSpectrum::AppendTo(std::vector<std::uint8_t>& bytes) const
{
  const auto append = [&](std::uint64_t value) { AppendLittleEndian(bytes, value); };
  const auto appendSums = [&](const SurfaceSums& sums)
  {
    for (const std::uint64_t value : { sums.Triangles, sums.Cells, sums.Area, sums.Volume })
    {
      append(value);
    }
  };
  append(this->Range.Minimum);
  append(this->Range.Maximum);
  appendSums(this->Below);
  append(this->Changes.size());
  for (const SurfaceSums& change : this->Changes)
  {
    appendSums(change);
  }
}

bool GrowingSpectrum::ReadFrom(ByteReader& reader)
{
  const auto read = [&] { return reader.Read<std::uint64_t>(); };
  const auto readSums = [&]
  {
    SurfaceSums sums;
    sums.Triangles = read();
    sums.Cells = read();
    sums.Area = read();
    sums.Volume = read();
    return sums;
  };
  this->Range.Minimum = read();
  this->Range.Maximum = read();
  this->Bins = SpectrumBins::Choose(this->Type, this->Range);
  this->Below = readSums();
  if (read() != this->Bins.Count + std::uint64_t{ 1 })
  {
    return false;
  }
  this->Changes.resize(this->Bins.Count + std::size_t{ 1 });
  std::generate(this->Changes.begin(), this->Changes.end(), readSums);
  return !reader.HasFailed();
}

} // namespace isosurface
