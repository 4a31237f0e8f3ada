// SPDX-License-Identifier: BSD-3-Clause
#include "Volumes/MeasuredVolume.h"

#include "Formats/Plain/RawVolume.h"
#include "Ground/Base/ParallelFor.h"
#include "Ground/Volume/SampleRange.h"
#include "Storage/Spectrum/BlockWorkload.h"
#include "Storage/Store/BlockedVolume.h"
#include "Storage/Writing/BlockProfileScan.h"
#include "Storage/Writing/BlockedVolumeWriter.h"

#include <mutex>
#include <utility>

namespace isosurface
{
namespace
{

/// Measures blocks as they are read. Each thread has its own workload counter.
class BlockMeasurement
{
public:
  BlockMeasurement(BlockedVolume& volume, const SpectrumBins& bins, int threads)
    : Volume(volume)
    , Bins(bins)
    , Profiles(volume.GetBlockGrid(), volume.GetHeader().Arrays[0].Type, 1)
    , Ranges(static_cast<std::size_t>(volume.GetBlockGrid().GetNumberOfBlocks()))
    , Spectra(volume.GetHeader().Arrays[0].Type, bins, Ranges.size())
    , Counters(static_cast<std::size_t>(threads), BlockWorkload(bins))
  {
  }

  Status Measure(const BlockReference& reference, int thread)
  {
    QueryStatistics statistics;
    ISOSURFACE_ASSIGN_OR_RETURN(
      const auto decoded, this->Volume.ReadBlock(reference, 0, 0, 0, statistics));
    const SampleView& view = decoded->View;
    const auto block = static_cast<std::size_t>(reference.Block);
    this->Ranges[block] = FindSampleRange(view, view.Box).All;
    // Each block has its own cubes, so there are no data races.
    this->Profiles.Add(view, this->Profiles.GetOwnVertices(reference.Block));
    WorkloadSpectrum spectrum(this->Bins);
    if (this->Ranges[block].Minimum < this->Ranges[block].Maximum)
    {
      BlockWorkload& counter = this->Counters[static_cast<std::size_t>(thread)];
      counter.Count(view);
      counter.MoveTo(spectrum);
    }
    this->Spectra.Set(block, spectrum, this->Ranges[block], statistics.BytesRead);
    return Status::Ok();
  }

  MeasuredVolume Take()
  {
    return { this->Volume.GetHeader().Arrays[0].Type, std::move(this->Ranges),
      this->Profiles.GetProfiles(), std::move(this->Spectra) };
  }

private:
  BlockedVolume& Volume;
  SpectrumBins Bins;
  BlockProfileScan Profiles;
  std::vector<KeyRange> Ranges;
  BlockSpectra Spectra;
  std::vector<BlockWorkload> Counters;
};

} // namespace

Result<MeasuredVolume> MeasuredVolume::Read(const std::string& path, int threads)
{
  ISOSURFACE_ASSIGN_OR_RETURN(
    auto volume, BlockedVolume::Open(path, GetLocalFileSystem(), std::make_shared<BlockCache>(0)));
  QueryStatistics statistics;
  const auto blocks = volume->ListBlocks(0, statistics);
  const auto spectrum = volume->GetSpectrum(0, 0);
  if (!blocks.IsOk() || !spectrum.IsOk())
  {
    return blocks.IsOk() ? spectrum.GetStatus() : blocks.GetStatus();
  }
  BlockMeasurement measurement(*volume, (*spectrum)->Bins, threads);
  Status status;
  std::mutex mutex;
  ParallelFor(blocks->size(), threads,
    [&](std::size_t index, int thread)
    {
      const Status own = measurement.Measure((*blocks)[index], thread);
      if (!own.IsOk())
      {
        const std::lock_guard<std::mutex> lock(mutex);
        status = own;
      }
    });
  ISOSURFACE_RETURN_IF_ERROR(status);
  return measurement.Take();
}

Status WriteVolume(
  const std::string& from, const std::string& to, int blockSize, std::uint32_t stores, int threads)
{
  ISOSURFACE_ASSIGN_OR_RETURN(const auto raw, RawVolume::ReadHeader(GetLocalFileSystem(), from));
  ISOSURFACE_ASSIGN_OR_RETURN(auto source, raw.Open(GetLocalFileSystem()));
  BlockedVolumeSettings settings;
  settings.BlockSize = blockSize;
  settings.NumberOfStores = stores;
  settings.MemoryLimit = std::uint64_t{ 4 } << 30; // the spectra of thousands of stores
  settings.Distribution = DistributionMethod::Balanced;
  settings.Compression.Codec = SegmentCodec::Lz4;
  settings.Threads = threads;
  SerialCommunicator alone;
  return BlockedVolumeWriter(alone)
    .Write(to, raw.Grid, { { raw.ArrayName, raw.Type } }, *source, settings)
    .GetStatus();
}

} // namespace isosurface
