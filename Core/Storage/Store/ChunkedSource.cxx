// SPDX-License-Identifier: BSD-3-Clause
#include "Storage/Store/ChunkedSource.h"

#include "Ground/Base/FirstFailure.h"
#include "Ground/Base/ParallelFor.h"
#include "Ground/Volume/SampleCopy.h"

#include <algorithm>
#include <cstddef>
#include <utility>

namespace isosurface
{
namespace
{

std::uint64_t CountBytes(const VertexBox& box, ValueType type)
{
  return static_cast<std::uint64_t>(box.GetNumberOfVertices()) * GetValueSize(type);
}

std::uint64_t CountBytes(const VertexBox& box, const std::vector<ValueType>& types)
{
  std::uint64_t bytes = 0;
  for (const ValueType type : types)
  {
    bytes += CountBytes(box, type);
  }
  return bytes;
}

/// Whether the chunks that slices have in common can be kept, with what the cache takes for each.
bool FitsLayer(
  const BoxSource& source, const std::vector<ValueType>& types, std::uint64_t cacheBytes)
{
  VertexBox layer = source.GetBox();
  layer.High[2] = std::min(layer.High[2], layer.Low[2] + (*source.GetChunk())[2]);
  return CountBytes(layer, types) <= cacheBytes / 5 * 4;
}

} // namespace

Status ChunkedSource::Replace(std::unique_ptr<BoxSource>& source, FileSystem& files,
  VolumeOpener opener, const std::string& path, const SourceRecord& record,
  const GridGeometry& grid, const std::vector<ArrayDescription>& arrays,
  const ChunkDecoding& decoding)
{
  const std::vector<ValueType> types = ArrayVariables(arrays).GetStoredTypes();
  if (source->HasCheapRows() || !source->GetChunk() ||
    !FitsLayer(*source, types, decoding.CacheBytes))
  {
    return Status::Ok();
  }
  auto samples = SourceSamples::Open(files, opener, path, record, grid, arrays,
    std::make_shared<BlockCache>(decoding.CacheBytes), decoding.SharedCache);
  ISOSURFACE_RETURN_IF_ERROR(samples.GetStatus());
  source.reset(new ChunkedSource(std::move(*samples), std::move(source), types, decoding));
  return Status::Ok();
}

ChunkedSource::ChunkedSource(std::shared_ptr<SourceSamples> samples,
  std::unique_ptr<BoxSource> source, std::vector<ValueType> types, const ChunkDecoding& decoding)
  : Samples(std::move(samples))
  , Source(std::move(source))
  , Types(std::move(types))
  , Decoding(decoding)
{
}

std::uint64_t ChunkedSource::GetReadBytes(const VertexBox& box) const
{
  return CountBytes(box, this->Types);
}

std::uint64_t ChunkedSource::GetHeldBytes() const
{
  // Each thread has a chunk as it is stored, decoded, and in the order of the cache.
  const VertexBox chunk = { { 0, 0, 0 }, *this->Source->GetChunk() };
  return this->Decoding.CacheBytes +
    3 * static_cast<std::uint64_t>(this->Decoding.Threads) * CountBytes(chunk, this->Types);
}

Result<BoxSamples> ChunkedSource::Read(const VertexBox& box)
{
  auto buffer = this->Pool->Take(this->GetReadBytes(box));
  if (!buffer.IsOk())
  {
    return Status(buffer.GetStatus().GetCode(),
      this->Samples->GetName() + ": cannot read: " + buffer.GetStatus().GetMessage());
  }
  // Threads that need the same chunks decode different ones of them.
  const std::int64_t slices = box.High[2] - box.Low[2];
  const std::int64_t parts = std::min<std::int64_t>(slices, this->Decoding.Threads);
  FirstFailure failure;
  BoxSamples samples;
  std::uint8_t* to = (*buffer)->GetData();
  for (std::size_t component = 0; component < this->Types.size(); ++component)
  {
    const ValueType type = this->Types[component];
    ParallelFor(static_cast<std::size_t>(parts), this->Decoding.Threads,
      [&](std::size_t index, int)
      {
        const auto part = static_cast<std::int64_t>(index);
        VertexBox slab = box;
        slab.Low[2] = box.Low[2] + slices * part / parts;
        slab.High[2] = box.Low[2] + slices * (part + 1) / parts;
        VertexBox before = box;
        before.High[2] = slab.Low[2];
        QueryStatistics statistics;
        failure.Run(
          [&] {
            return this->Samples->Read(component, slab, to + CountBytes(before, type), statistics);
          });
      });
    ISOSURFACE_RETURN_IF_ERROR(failure.Get());
    samples.Arrays.push_back(MakeSampleView(type, box, to));
    to += CountBytes(box, type);
  }
  samples.Owner = std::move(*buffer);
  return samples;
}

} // namespace isosurface
