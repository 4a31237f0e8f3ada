// SPDX-License-Identifier: BSD-3-Clause
#include "Redistribution/RawForm.h"

#include "Base/ParallelFor.h"
#include "Contour/SurfaceExtractor.h"
#include "Contour/SurfaceMerge.h"
#include "EdgeIndex/CodedNumbers.h"

#include <algorithm>
#include <atomic>
#include <cstring>
#include <mutex>
#include <utility>
#include <vector>

namespace isosurface
{
namespace
{

// One block of another source, or none.
class SingleBlockSource : public BlockSource
{
public:
  SingleBlockSource(BlockSource* source, std::size_t block)
    : Source(source)
    , Block(block)
  {
  }
  std::size_t GetNumberOfBlocks() const override { return this->Source ? 1 : 0; }
  Index3 GetLatticeCoordinates(std::size_t) const override
  {
    return this->Source->GetLatticeCoordinates(this->Block);
  }
  VertexBox GetVertices(std::size_t) const override
  {
    return this->Source->GetVertices(this->Block);
  }
  ValueType GetValueType() const override
  {
    return this->Source ? this->Source->GetValueType() : ValueType::UInt8;
  }
  Result<BlockSamples> Acquire(std::size_t) override { return this->Source->Acquire(this->Block); }

private:
  BlockSource* Source;
  std::size_t Block;
};

std::size_t GetTupleSize(const AttributeLayout& layout)
{
  return GetValueSize(layout.Type) * static_cast<std::size_t>(layout.NumberOfComponents);
}

template <typename T>
void AppendArray(Message& bytes, const Buffer<T>& array)
{
  const auto* first = reinterpret_cast<const std::uint8_t*>(array.GetData());
  bytes.insert(bytes.end(), first, first + sizeof(T) * array.GetSize());
}

Message Serialize(const Surface& surface, const ContourRequest& request)
{
  Message bytes;
  for (const SurfacePart& part : surface.Parts)
  {
    AppendNumber(bytes, part.NumberOfPoints);
    AppendNumber(bytes, part.NumberOfCells);
  }
  AppendNumber(bytes, surface.Connectivity.GetSize());
  AppendArray(bytes, surface.Points);
  AppendArray(bytes, surface.Normals);
  AppendArray(bytes, surface.GlobalIds);
  for (const SurfaceAttribute& attribute : surface.Attributes)
  {
    AppendArray(bytes, attribute.Bytes);
  }
  if (request.Polygons)
  {
    const auto* ends = reinterpret_cast<const std::uint8_t*>(surface.Offsets.Values32.begin() + 1);
    bytes.insert(bytes.end(), ends, ends + sizeof(std::int32_t) * surface.NumberOfCells);
  }
  AppendArray(bytes, surface.Connectivity.Values32);
  return bytes;
}

// Takes arrays off the end of what NumberReader has read.
class ArrayReader
{
public:
  ArrayReader(const std::uint8_t* bytes, std::size_t size)
    : Next(bytes)
    , Left(size)
  {
  }
  template <typename T>
  bool Read(std::size_t count, Buffer<T>& array, std::size_t first = 0)
  {
    if (count > this->Left / sizeof(T))
    {
      return false;
    }
    array = Buffer<T>(first + count);
    if (count > 0)
    {
      std::memcpy(array.GetData() + first, this->Next, sizeof(T) * count);
    }
    this->Next += sizeof(T) * count;
    this->Left -= sizeof(T) * count;
    return true;
  }
  std::size_t GetLeft() const { return this->Left; }

private:
  const std::uint8_t* Next;
  std::size_t Left;
};

// Reads one block, and checks that its numbers fit each other.
class BlockParser
{
public:
  BlockParser(const BlockDescription& block, const ContourRequest& request)
    : Block(block)
    , Request(request)
  {
  }

  bool Parse(const std::uint8_t* bytes)
  {
    NumberReader numbers(bytes, this->Block.Bytes);
    for (std::size_t isovalue = 0; isovalue < this->Request.Isovalues.size(); ++isovalue)
    {
      SurfacePart part;
      part.Isovalue = this->Request.Isovalues[isovalue];
      part.FirstPoint = this->Parsed.NumberOfPoints;
      part.FirstCell = this->Parsed.NumberOfCells;
      part.NumberOfPoints = numbers.ReadNumber();
      part.NumberOfCells = numbers.ReadNumber();
      if (part.NumberOfPoints != this->Block.Points[isovalue] ||
        part.NumberOfCells > this->Block.Bytes)
      {
        return false;
      }
      this->Parsed.NumberOfPoints += part.NumberOfPoints;
      this->Parsed.NumberOfCells += part.NumberOfCells;
      this->Parsed.Parts.push_back(part);
    }
    const std::size_t corners = numbers.ReadNumber();
    ArrayReader arrays(numbers.GetNext(), numbers.GetLeft());
    return !numbers.HasFailed() && this->ReadPoints(arrays) && this->ReadCells(arrays, corners) &&
      arrays.GetLeft() == 0;
  }

  Surface& GetSurface() { return this->Parsed; }

private:
  bool ReadPoints(ArrayReader& arrays)
  {
    Surface& surface = this->Parsed;
    const std::size_t points = surface.NumberOfPoints;
    if (!arrays.Read(3 * points, surface.Points) ||
      !arrays.Read(this->Request.Normals ? 3 * points : 0, surface.Normals) ||
      !arrays.Read(points, surface.GlobalIds))
    {
      return false;
    }
    for (const AttributeLayout& layout : this->Request.Attributes)
    {
      SurfaceAttribute& attribute = surface.Attributes.emplace_back();
      attribute.Layout = { GetInterpolatedType(layout.Type), layout.NumberOfComponents };
      if (!arrays.Read(GetTupleSize(attribute.Layout) * points, attribute.Bytes))
      {
        return false;
      }
    }
    return true;
  }

  bool ReadCells(ArrayReader& arrays, std::size_t corners)
  {
    Surface& surface = this->Parsed;
    const std::size_t cells = surface.NumberOfCells;
    Buffer<std::int32_t>& ends = surface.Offsets.Values32;
    if (this->Request.Polygons)
    {
      if (!arrays.Read(cells, ends, 1))
      {
        return false;
      }
    }
    else
    {
      ends = Buffer<std::int32_t>(cells + 1);
      for (std::size_t cell = 0; cell < cells; ++cell)
      {
        ends[cell + 1] = static_cast<std::int32_t>(3 * (cell + 1));
      }
    }
    ends[0] = 0;
    if (!arrays.Read(corners, surface.Connectivity.Values32) ||
      static_cast<std::size_t>(ends[cells]) != corners || !std::is_sorted(ends.begin(), ends.end()))
    {
      return false;
    }
    surface.NumberOfTriangles = corners - 2 * cells;
    surface.NumberOfBlocks = 1;
    const auto points = static_cast<std::int64_t>(surface.NumberOfPoints);
    return std::all_of(surface.Connectivity.Values32.begin(), surface.Connectivity.Values32.end(),
      [points](std::int32_t corner) { return corner >= 0 && corner < points; });
  }

  const BlockDescription& Block;
  const ContourRequest& Request;
  Surface Parsed;
};

// Extracts batches of blocks in parallel, and hands them on in their order.
class BatchExtraction
{
public:
  BatchExtraction(
    const GridGeometry& geometry, const ContourRequest& request, BlockSource& source, int threads)
    : Geometry(geometry)
    , Request(request)
    , Source(source)
    , Threads(std::max(1, threads))
  {
  }

  Status Run(const SurfaceForm::Take& take, const Progress& progress)
  {
    const std::size_t count = this->Source.GetNumberOfBlocks();
    const std::size_t batch = BlocksPerThread * static_cast<std::size_t>(this->Threads);
    for (std::size_t first = 0; first < count; first += batch)
    {
      const std::size_t size = std::min(batch, count - first);
      const auto all = static_cast<double>(count);
      ISOSURFACE_RETURN_IF_ERROR(this->ExtractBatch(first, size,
        MakePartOfProgress(
          progress, static_cast<double>(first) / all, static_cast<double>(first + size) / all)));
      for (std::size_t n = 0; n < size; ++n)
      {
        if (this->Blocks[n].CountPoints() > 0)
        {
          ISOSURFACE_RETURN_IF_ERROR(take(std::move(this->Blocks[n]), std::move(this->Bytes[n])));
        }
      }
    }
    return Status::Ok();
  }

private:
  static constexpr std::size_t BlocksPerThread = 16;

  Status ExtractBatch(std::size_t first, std::size_t size, const Progress& progress)
  {
    this->Blocks.assign(size, {});
    this->Bytes.assign(size, {});
    Status failure;
    std::atomic<bool> failed{ false };
    std::mutex mutex;
    const bool finished = ParallelFor(
      size, this->Threads,
      [&](std::size_t n, int)
      {
        if (failed)
        {
          return;
        }
        Status status = this->Extract(first + n, n);
        if (!status.IsOk())
        {
          const std::lock_guard<std::mutex> lock(mutex);
          if (!failed.exchange(true))
          {
            failure = std::move(status);
          }
        }
      },
      progress);
    return failure.IsOk() && !finished
      ? Status(StatusCode::Aborted, "The redistribution was stopped.")
      : failure;
  }

  Status Extract(std::size_t block, std::size_t n)
  {
    SingleBlockSource one(&this->Source, block);
    const Result<Surface> surface = ExtractSurface(this->Geometry, one, this->Request, 1);
    if (!surface.IsOk())
    {
      return surface.GetStatus();
    }
    BlockDescription& description = this->Blocks[n];
    description.Vertices = one.GetVertices(0);
    description.Lattice = one.GetLatticeCoordinates(0);
    for (const SurfacePart& part : surface->Parts)
    {
      description.Points.push_back(part.NumberOfPoints);
    }
    if (surface->NumberOfPoints > 0)
    {
      this->Bytes[n] = Serialize(*surface, this->Request);
      description.Bytes = this->Bytes[n].size();
    }
    return Status::Ok();
  }

  const GridGeometry& Geometry;
  const ContourRequest& Request;
  BlockSource& Source;
  int Threads;
  std::vector<BlockDescription> Blocks;
  std::vector<Message> Bytes;
};

} // namespace

Status RawForm::Pack(
  BlockSource& source, int threads, const Take& take, const Progress& progress) const
{
  return BatchExtraction(this->Geometry, this->Request, source, threads).Run(take, progress);
}

Result<Surface> RawForm::Unpack(ArrivingBlocks& blocks, int threads, const Progress& progress) const
{
  const std::size_t count = blocks.GetBlocks().size();
  std::vector<Surface> surfaces;
  for (std::size_t n = 0; n < count; ++n)
  {
    const std::uint8_t* bytes = blocks.Wait(n);
    if (!bytes || (progress && !progress(static_cast<double>(n) / static_cast<double>(count))))
    {
      return Status(StatusCode::Aborted, "Not all blocks of the isosurface came.");
    }
    BlockParser parser(blocks.GetBlocks()[n], this->Request);
    if (!parser.Parse(bytes))
    {
      return MakeDamagedMessage();
    }
    surfaces.push_back(std::move(parser.GetSurface()));
  }
  if (surfaces.empty())
  {
    SingleBlockSource none(nullptr, 0);
    return ExtractSurface(this->Geometry, none, this->Request, threads);
  }
  return MergeSurfaces(surfaces);
}

} // namespace isosurface
