// SPDX-License-Identifier: BSD-3-Clause
#include "Storage/Store/ChunkedSource.h"

#include "Ground/Base/FirstFailure.h"
#include "Ground/Base/ParallelFor.h"
#include "Ground/Volume/SampleCopy.h"
#include "Storage/Store/BlockCache.h"

#include <algorithm>
#include <cstddef>
#include <utility>

namespace isosurface
{
namespace
{

/// Each component begins where values of any type may.
std::uint64_t CountBytes(const VertexBox& box, ValueType type)
{
  constexpr std::uint64_t alignment = 64;
  const std::uint64_t bytes =
    static_cast<std::uint64_t>(box.GetNumberOfVertices()) * GetValueSize(type);
  return (bytes + alignment - 1) / alignment * alignment;
}

} // namespace

Status ChunkedSource::Replace(std::unique_ptr<BoxSource>& source, FileSystem& files,
  VolumeOpener opener, const std::string& path, const std::string& name, const SourceRecord& record,
  const GridGeometry& grid, const std::vector<ArrayDescription>& arrays,
  const ChunkDecoding& decoding)
{
  constexpr int fewest = 2;
  if (decoding.Threads < fewest || !source->GetChunk() || !source->DecodesInParallel())
  {
    return Status::Ok();
  }
  const auto cache = std::make_shared<BlockCache>(0);
  auto samples = SourceSamples::OpenNew(files, opener, path, name, record, grid, arrays, cache);
  ISOSURFACE_RETURN_IF_ERROR(samples.GetStatus());
  // Boxes of a round lie in two layers. The cache takes a little more than the chunks in it.
  const std::uint64_t layer = (*samples)->GetLayerBytes();
  const std::uint64_t layers = layer / 4 * 9 + layer % 4;
  const std::uint64_t thread = std::max<std::uint64_t>(1, (*samples)->GetThreadBytes());
  const std::uint64_t left = decoding.MemoryBytes - std::min(decoding.MemoryBytes, layers);
  const auto threads = static_cast<int>(
    std::min<std::uint64_t>(static_cast<std::uint64_t>(decoding.Threads), left / thread));
  if (threads < fewest)
  {
    return Status::Ok();
  }
  cache->SetBudget(layers);
  if (decoding.IsShared)
  {
    (*samples)->ShareWith(BlockCache::GetProcessCache(), decoding.IsShared);
  }
  std::unique_ptr<ChunkedSource> chunked(new ChunkedSource);
  chunked->Samples = std::move(*samples);
  chunked->Source = std::move(source);
  chunked->Types = ArrayVariables(arrays).GetStoredTypes();
  chunked->HeldBytes = layers + static_cast<std::uint64_t>(threads) * thread;
  chunked->Threads = threads;
  source = std::move(chunked);
  return Status::Ok();
}

std::uint64_t ChunkedSource::GetReadBytes(const VertexBox& box) const
{
  std::uint64_t bytes = 0;
  for (const ValueType type : this->Types)
  {
    bytes += CountBytes(box, type);
  }
  return bytes;
}

Result<BoxSamples> ChunkedSource::Read(const VertexBox& box)
{
  auto buffer = this->Pool->Take(this->GetReadBytes(box));
  if (!buffer.IsOk())
  {
    return Status(buffer.GetStatus().GetCode(),
      this->Samples->GetName() + ": cannot read: " + buffer.GetStatus().GetMessage());
  }
  const std::int64_t slices = box.High[2] - box.Low[2];
  const std::int64_t parts = std::min<std::int64_t>(slices, this->Threads);
  BoxSamples samples;
  std::uint8_t* to = (*buffer)->GetData();
  for (std::size_t component = 0; component < this->Types.size(); ++component)
  {
    const ValueType type = this->Types[component];
    ISOSURFACE_RETURN_IF_ERROR(this->Samples->Decode(component, box, this->Threads));
    const auto slice =
      static_cast<std::size_t>(box.GetNumberOfVertices() / slices) * GetValueSize(type);
    FirstFailure failure;
    ParallelFor(static_cast<std::size_t>(parts), this->Threads,
      [&](std::size_t index, int)
      {
        const auto part = static_cast<std::int64_t>(index);
        VertexBox slab = box;
        slab.Low[2] = box.Low[2] + slices * part / parts;
        slab.High[2] = box.Low[2] + slices * (part + 1) / parts;
        const auto before = static_cast<std::size_t>(slab.Low[2] - box.Low[2]);
        QueryStatistics statistics;
        failure.Run(
          [&] { return this->Samples->Read(component, slab, to + before * slice, statistics); });
      });
    ISOSURFACE_RETURN_IF_ERROR(failure.Get());
    samples.Arrays.push_back(MakeSampleView(type, box, to));
    to += CountBytes(box, type);
  }
  samples.Owner = std::move(*buffer);
  return samples;
}

} // namespace isosurface
