// SPDX-License-Identifier: BSD-3-Clause
#include "Storage/Store/SourceSamples.h"

#include "Ground/Base/FirstFailure.h"
#include "Ground/Base/ParallelFor.h"
#include "Ground/Volume/VolumeName.h"
#include "Storage/Record/BlockRecord.h"
#include "Storage/Record/BlockSegment.h"

#include <algorithm>
#include <cstring>
#include <limits>
#include <utility>

namespace isosurface
{
namespace
{

/// BlockCacheKey::Level of chunks, which no level of blocks has.
constexpr std::uint32_t ChunkLevel = std::numeric_limits<std::uint32_t>::max();

} // namespace

Result<std::shared_ptr<SourceSamples>> SourceSamples::Open(FileSystem& files, VolumeOpener opener,
  const std::string& path, const SourceRecord& record, const GridGeometry& grid,
  const std::vector<ArrayDescription>& arrays, std::shared_ptr<BlockCache> cache)
{
  ISOSURFACE_RETURN_IF_ERROR(CheckSource(files, opener, path, record, grid, arrays));
  const std::string name = VolumeName{ record.FindPath(files, path), record.Within }.GetText();
  return OpenNew(files, opener, path, name, record, grid, arrays, std::move(cache));
}

Result<std::shared_ptr<SourceSamples>> SourceSamples::OpenNew(FileSystem& files,
  VolumeOpener opener, const std::string& path, const std::string& name, const SourceRecord& record,
  const GridGeometry& grid, const std::vector<ArrayDescription>& arrays,
  std::shared_ptr<BlockCache> cache)
{
  std::shared_ptr<SourceSamples> samples(
    new SourceSamples(files, opener, path, record, std::move(cache)));
  samples->Name = name;
  samples->Box = { { 0, 0, 0 }, grid.GetDimensions() };
  for (const ArrayDescription& described : arrays)
  {
    Array array;
    array.Name = record.Arrays[samples->Arrays.size()];
    array.Type = described.Type;
    array.FirstComponent = samples->ArrayOf.size();
    array.Components = static_cast<std::size_t>(described.Components);
    ISOSURFACE_ASSIGN_OR_RETURN(auto source, samples->OpenArray(array, &samples->Paths));
    array.Chunk = source->GetChunk().value_or(samples->Box.High);
    for (std::size_t axis = 0; axis < 3; ++axis)
    {
      array.Chunks[axis] = (samples->Box.High[axis] - 1) / array.Chunk[axis] + 1;
    }
    array.HeldBytes = source->GetHeldBytes();
    array.Parent = source->Fork();
    array.Idle.push_back(std::move(source));
    samples->ArrayOf.resize(samples->ArrayOf.size() + array.Components, samples->Arrays.size());
    samples->Arrays.push_back(std::move(array));
  }
  return samples;
}

Status SourceSamples::CheckUnchanged() const
{
  return CheckSourceFiles(this->Files, this->Volume, this->Name, this->Record, this->Paths);
}

Status SourceSamples::MakeChanged(std::int64_t block) const
{
  return Status(StatusCode::Corrupt,
    this->Name + ": was changed since " + this->Volume + " was made of it: block " +
      std::to_string(block) + " has other samples; index it again");
}

Result<std::unique_ptr<BoxSource>> SourceSamples::OpenArray(
  const Array& array, std::vector<std::string>* paths) const
{
  ISOSURFACE_ASSIGN_OR_RETURN(auto volume,
    OpenSource(this->Files, this->Opener, this->Volume, this->Name,
      this->Record.MakeChoice({ array.Name })));
  const bool isThere = volume.Arrays.size() == 1 && volume.Arrays[0].Name == array.Name &&
    volume.Arrays[0].Type == array.Type &&
    static_cast<std::size_t>(volume.Arrays[0].Components) == array.Components &&
    volume.Grid.GetDimensions() == this->Box.High;
  if (!isThere)
  {
    return Status(StatusCode::Corrupt,
      this->Name + ": has no array \"" + array.Name + "\" as " + this->Volume + " knows it");
  }
  if (paths)
  {
    *paths = volume.Files;
  }
  return std::move(volume.Source);
}

Result<std::unique_ptr<BoxSource>> SourceSamples::Take(Array& array)
{
  {
    const std::lock_guard<std::mutex> lock(this->Mutex);
    if (!array.Idle.empty())
    {
      auto source = std::move(array.Idle.back());
      array.Idle.pop_back();
      return source;
    }
  }
  return array.Parent ? array.Parent->Fork() : this->OpenArray(array);
}

void SourceSamples::GiveBack(Array& array, std::unique_ptr<BoxSource> source)
{
  const std::lock_guard<std::mutex> lock(this->Mutex);
  array.Idle.push_back(std::move(source));
}

VertexBox SourceSamples::FindChunkBox(const Array& array, const Index3& chunk) const
{
  VertexBox box;
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    box.Low[axis] = chunk[axis] * array.Chunk[axis];
    box.High[axis] = std::min(box.Low[axis] + array.Chunk[axis], this->Box.High[axis]);
  }
  return box;
}

Result<SourceSamples::Chunk> SourceSamples::DecodeChunk(Array& array, const VertexBox& box)
{
  ISOSURFACE_ASSIGN_OR_RETURN(auto source, this->Take(array));
  ISOSURFACE_ASSIGN_OR_RETURN(const auto samples, source->Read(box));
  if (!samples.Fits(std::vector<ValueType>(array.Components, array.Type), box))
  {
    return Status(StatusCode::Corrupt, this->Name + ": has other samples than it states");
  }
  const std::size_t size = GetValueSize(array.Type);
  auto decoded = std::make_shared<DecodedBlock>();
  decoded->Bytes = Buffer<std::uint8_t>(
    static_cast<std::size_t>(box.GetNumberOfVertices()) * array.Components * size);
  std::uint8_t* to = decoded->Bytes.GetData();
  for (const SampleView& view : samples.Arrays)
  {
    CopyBox(view, box, box, to);
    to += static_cast<std::size_t>(box.GetNumberOfVertices()) * size;
  }
  this->GiveBack(array, std::move(source));
  return Chunk(std::move(decoded));
}

Result<SourceSamples::Chunk> SourceSamples::GetChunk(
  Array& array, const Index3& chunk, QueryStatistics& statistics)
{
  const BlockCacheKey key = this->MakeKey(array, chunk);
  const auto decode = [&]
  {
    auto made = this->DecodeChunk(array, this->FindChunkBox(array, chunk));
    if (made.IsOk() && this->IsShared && this->IsShared())
    {
      bool isThere = false;
      static_cast<void>(this->SharedCache->Get(
        key, [&] { return made; }, isThere));
    }
    return made;
  };
  bool hit = false;
  auto decoded = this->Cache->Get(key, decode, hit);
  if (decoded.IsOk())
  {
    statistics.BlockCacheHits += hit ? 1 : 0;
    statistics.BlocksRead += hit ? 0 : 1;
    statistics.BytesRead += hit ? 0 : (*decoded)->Bytes.GetSize();
  }
  return decoded;
}

BlockCacheKey SourceSamples::MakeKey(const Array& array, const Index3& chunk) const
{
  const std::int64_t number = chunk[0] + array.Chunks[0] * (chunk[1] + array.Chunks[1] * chunk[2]);
  return { this->Dataset, number, static_cast<std::uint32_t>(array.FirstComponent), ChunkLevel };
}

Status SourceSamples::CopyChunk(Array& array, const Index3& chunk, std::size_t component,
  const VertexBox& box, std::uint8_t* to, QueryStatistics& statistics)
{
  ISOSURFACE_ASSIGN_OR_RETURN(const auto decoded, this->GetChunk(array, chunk, statistics));
  const std::size_t size = GetValueSize(array.Type);
  const VertexBox whole = this->FindChunkBox(array, chunk);
  const auto plane = static_cast<std::size_t>(whole.GetNumberOfVertices()) * size;
  const SampleView view = MakeSampleView(
    array.Type, whole, decoded->Bytes.GetData() + (component - array.FirstComponent) * plane);
  CopyBox(view, whole.Intersect(box), box, to);
  return Status::Ok();
}

std::vector<Index3> SourceSamples::FindChunks(const Array& array, const VertexBox& box) const
{
  Index3 first;
  Index3 last;
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    first[axis] = box.Low[axis] / array.Chunk[axis];
    last[axis] = (box.High[axis] - 1) / array.Chunk[axis];
  }
  std::vector<Index3> chunks;
  for (Index3 at = first; at[2] <= last[2]; ++at[2])
  {
    for (at[1] = first[1]; at[1] <= last[1]; ++at[1])
    {
      for (at[0] = first[0]; at[0] <= last[0]; ++at[0])
      {
        chunks.push_back(at);
      }
    }
  }
  return chunks;
}

void SourceSamples::ShareWith(std::shared_ptr<BlockCache> cache, std::function<bool()> isShared)
{
  this->SharedCache = std::move(cache);
  this->IsShared = std::move(isShared);
}

std::int64_t SourceSamples::GetChunkSlices() const
{
  std::int64_t slices = 1;
  for (const Array& array : this->Arrays)
  {
    slices = std::max(slices, array.Chunk[2]);
  }
  return slices;
}

std::uint64_t SourceSamples::GetSlabBytes(const VertexBox& box, std::int64_t slices) const
{
  constexpr std::int64_t ofEntry = 512; // beside the samples
  const Index3 size = box.GetSize();
  std::uint64_t bytes = 0;
  for (const Array& array : this->Arrays)
  {
    std::int64_t chunks = 1;
    std::int64_t samples = 1;
    for (std::size_t axis = 0; axis < 3; ++axis)
    {
      // Slices begin and end amid chunks.
      const std::int64_t chunk = array.Chunk[axis];
      const std::int64_t crossed = (box.High[axis] - 1) / chunk - box.Low[axis] / chunk + 1;
      const std::int64_t count = axis == 2 && slices < size[axis]
        ? std::min(crossed, (slices + chunk - 2) / chunk + 1)
        : crossed;
      chunks *= count;
      samples *= std::min(this->Box.High[axis], count * chunk);
    }
    bytes += static_cast<std::uint64_t>(samples) * array.Components * GetValueSize(array.Type) +
      static_cast<std::uint64_t>(chunks * ofEntry);
  }
  return bytes;
}

std::uint64_t SourceSamples::GetThreadBytes() const
{
  std::uint64_t bytes = 0;
  for (const Array& array : this->Arrays)
  {
    // As it is read, and in the order of the cache.
    const auto chunk = static_cast<std::uint64_t>(array.Chunk[0] * array.Chunk[1] * array.Chunk[2]);
    bytes += array.HeldBytes + 2 * chunk * array.Components * GetValueSize(array.Type);
  }
  return bytes;
}

Status SourceSamples::Decode(std::size_t component, const VertexBox& box, int threads)
{
  Array& array = this->Arrays[this->ArrayOf[component]];
  const std::vector<Index3> chunks = this->FindChunks(array, box);
  FirstFailure failure;
  ParallelFor(chunks.size(), threads,
    [&](std::size_t index, int)
    {
      QueryStatistics statistics;
      failure.Run([&] { return this->GetChunk(array, chunks[index], statistics).GetStatus(); });
    });
  return failure.Get();
}

Status SourceSamples::Read(
  std::size_t component, const VertexBox& box, std::uint8_t* to, QueryStatistics& statistics)
{
  Array& array = this->Arrays[this->ArrayOf[component]];
  std::vector<Index3> chunks = this->FindChunks(array, box);
  // First those that nobody has, nor decodes at the moment: threads that need the same chunks share
  // the work, instead of waiting for each other at each.
  const auto rest = std::stable_partition(chunks.begin(), chunks.end(),
    [&](const Index3& chunk) { return !this->Cache->Contains(this->MakeKey(array, chunk)); });
  std::vector<Index3> waiting(rest, chunks.end());
  for (auto chunk = chunks.begin(); chunk != rest; ++chunk)
  {
    if (this->Cache->Contains(this->MakeKey(array, *chunk)))
    {
      waiting.push_back(*chunk);
      continue;
    }
    ISOSURFACE_RETURN_IF_ERROR(this->CopyChunk(array, *chunk, component, box, to, statistics));
  }
  for (const Index3& chunk : waiting)
  {
    ISOSURFACE_RETURN_IF_ERROR(this->CopyChunk(array, chunk, component, box, to, statistics));
  }
  return Status::Ok();
}

Result<std::shared_ptr<DecodedBlock>> SourceSamples::ReadBlock(std::size_t component,
  const BlockGrid& grid, std::int64_t block, std::size_t front, QueryStatistics& statistics,
  const VertexBox* part)
{
  const VertexBox& known = part ? *part : this->Box;
  const VertexBox box = grid.GetGhostedVertices(block, 0).Intersect(known);
  const ValueType type = this->GetType(component);
  auto read = std::make_shared<DecodedBlock>();
  read->Block = block;
  read->Bytes = Buffer<std::uint8_t>(
    front + static_cast<std::size_t>(box.GetNumberOfVertices()) * GetValueSize(type));
  std::uint8_t* samples = read->Bytes.GetData() + front;
  read->View = MakeSampleView(type, box, samples);
  read->View.Box = grid.GetVertices(block).Intersect(known);
  ISOSURFACE_RETURN_IF_ERROR(this->Read(component, box, samples, statistics));
  return read;
}

Result<std::shared_ptr<const DecodedBlock>> GatherBlock(SourceSamples& source,
  const BlockGrid& grid, const BlockDirectoryEntry& entry, const std::string& path,
  std::size_t component, const std::uint8_t* header, QueryStatistics& statistics)
{
  constexpr std::size_t headerSize = BlockRecord::SegmentHeaderSize;
  const auto makeError = [&](const char* reason)
  {
    return Status(
      StatusCode::Corrupt, path + ": block " + std::to_string(entry.Block) + " has " + reason);
  };
  const std::uint32_t stored = entry.Lengths[component];
  if (stored !=
    BlockSegment(grid, entry.Block, 0).GetNumberOfSamples() *
      GetValueSize(source.GetType(component)))
  {
    return makeError("an impossible length in the directory");
  }
  ISOSURFACE_ASSIGN_OR_RETURN(
    const auto block, source.ReadBlock(component, grid, entry.Block, headerSize, statistics));
  std::uint8_t* const segment = block->Bytes.GetData();
  std::memcpy(segment, header, headerSize);
  if (!CheckSegment(segment, stored, { entry.Block, static_cast<std::uint32_t>(component), 0 })
         .IsOk())
  {
    return source.MakeChanged(entry.Block);
  }
  const auto coding = LoadSegmentCoding(segment);
  if (!coding || coding->Codec != SegmentCodec::None)
  {
    return makeError("an unknown codec");
  }
  return std::shared_ptr<const DecodedBlock>(block);
}

} // namespace isosurface
