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
  constexpr int fewest = 2; // threads
  const int mostThreads = ChooseReadingThreads(name, decoding.Threads);
  if (mostThreads < fewest || !source->GetChunk() || !source->DecodesInParallel())
  {
    return Status::Ok();
  }
  const auto cache = std::make_shared<BlockCache>(0);
  ISOSURFACE_ASSIGN_OR_RETURN(
    auto samples, SourceSamples::OpenNew(files, opener, path, name, record, grid, arrays, cache));
  const std::uint64_t ofThread = std::max<std::uint64_t>(1, samples->GetThreadBytes());
  const VertexBox& all = source->GetBox();
  const VertexBox& part = decoding.Part.IsEmpty() ? all : decoding.Part;
  const auto countThreads = [&](std::int64_t slices)
  {
    const std::uint64_t kept = samples->GetSlabBytes(part, slices);
    const std::uint64_t left = decoding.MemoryBytes - std::min(decoding.MemoryBytes, kept);
    return static_cast<int>(
      std::min<std::uint64_t>(static_cast<std::uint64_t>(mostThreads), left / ofThread));
  };
  // Several slices have chunks for all threads, also where each is one chunk.
  constexpr std::int64_t enough = 16;
  std::int64_t slices =
    decoding.Part.IsEmpty() ? std::max(enough, samples->GetChunkSlices()) : all.High[2];
  if (countThreads(slices) < fewest)
  {
    slices = samples->GetChunkSlices();
  }
  const int threads = countThreads(slices);
  if (threads < fewest)
  {
    return Status::Ok();
  }
  const std::uint64_t kept = samples->GetSlabBytes(part, slices);
  cache->SetBudget(kept);
  if (decoding.IsShared)
  {
    samples->ShareWith(BlockCache::GetProcessCache(), decoding.IsShared);
  }
  std::unique_ptr<ChunkedSource> chunked(new ChunkedSource);
  chunked->Samples = std::move(samples);
  chunked->Source = std::move(source);
  chunked->Types = ArrayVariables(arrays).GetStoredTypes();
  chunked->HeldBytes = kept + static_cast<std::uint64_t>(threads) * ofThread;
  chunked->Threads = threads;
  chunked->Slices = slices;
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
  std::uint8_t* to = (*buffer)->GetData();
  VertexBox slab = box;
  for (; slab.Low[2] < box.High[2]; slab.Low[2] = slab.High[2])
  {
    slab.High[2] = std::min(box.High[2], (slab.Low[2] / this->Slices + 1) * this->Slices);
    ISOSURFACE_RETURN_IF_ERROR(this->ReadSlab(slab, box, to));
  }
  BoxSamples samples;
  for (const ValueType type : this->Types)
  {
    samples.Arrays.push_back(MakeSampleView(type, box, to));
    to += CountBytes(box, type);
  }
  samples.Owner = std::move(*buffer);
  return samples;
}

Status ChunkedSource::ReadSlab(const VertexBox& slab, const VertexBox& box, std::uint8_t* to)
{
  const std::int64_t slices = slab.High[2] - slab.Low[2];
  const std::int64_t parts = std::min<std::int64_t>(slices, this->Threads);
  const auto ofSlice = static_cast<std::size_t>(slab.GetNumberOfVertices() / slices);
  FirstFailure failure;
  for (std::size_t component = 0; component < this->Types.size(); ++component)
  {
    failure.Run([&] { return this->Samples->Decode(component, slab, this->Threads); });
    const ValueType type = this->Types[component];
    ParallelFor(static_cast<std::size_t>(parts), this->Threads,
      [&](std::size_t index, int)
      {
        const auto number = static_cast<std::int64_t>(index);
        VertexBox part = slab;
        part.Low[2] = slab.Low[2] + slices * number / parts;
        part.High[2] = slab.Low[2] + slices * (number + 1) / parts;
        const auto before = static_cast<std::size_t>(part.Low[2] - box.Low[2]);
        std::uint8_t* place = to + before * ofSlice * GetValueSize(type);
        QueryStatistics statistics;
        failure.Run([&] { return this->Samples->Read(component, part, place, statistics); });
      });
    to += CountBytes(box, type);
  }
  return failure.Get();
}

} // namespace isosurface
