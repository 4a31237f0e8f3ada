// SPDX-License-Identifier: BSD-3-Clause
#include "Coding/EdgeIndex/EdgeIndexEncoder.h"

#include "Coding/BlockCoding/BlockCoding.h"
#include "Coding/BlockCoding/BytePlanes.h"
#include "Coding/EdgeIndex/BlockIslands.h"
#include "Coding/EdgeIndex/BlockRecordFormat.h"
#include "Coding/EdgeIndex/PointAttributes.h"
#include "Coding/EdgeIndex/PreviewBlocks.h"
#include "Coding/EdgeIndex/SampledBlock.h"
#include "Ground/Base/FirstFailure.h"
#include "Ground/Base/ParallelFor.h"
#include "Ground/Base/WithinMemory.h"
#include "Ground/Volume/SampleCopy.h"
#include "Ground/Volume/ValueKey.h"
#include "Surface/Contour/SurfaceExtractor.h"

#include <algorithm>
#include <optional>
#include <utility>

namespace isosurface
{
namespace
{

/// Where the points of a block's surface are among the vertices of the block.
class BlockPlaces
{
public:
  BlockPlaces(const EdgeIndexHeader& header, const VertexBox& box)
    : Size(box.GetSize())
  {
    const GridGeometry grid = GetNumberedGrid(header.Geometry, MakeContourRequest(header));
    this->Dimensions = grid.GetDimensions();
    this->EdgeIds =
      3 * grid.GetNumberOfVertices() * static_cast<std::int64_t>(header.Isovalues.size());
    for (std::size_t axis = 0; axis < 3; ++axis)
    {
      this->Low[axis] = box.Low[axis] + header.Geometry.Extent[2 * axis] - grid.Extent[2 * axis];
    }
  }

  const Index3& GetSize() const { return this->Size; }

  /// Calls body(vertex) for the vertices within one of a point, but along its edge for the ends alone; and for the
  /// ends alone if asked so.
  template <typename Body>
  void VisitAround(std::int64_t id, bool endsAlone, const Body& body) const
  {
    const bool isVertex = id >= this->EdgeIds;
    const std::int64_t vertices = this->Dimensions[0] * this->Dimensions[1] * this->Dimensions[2];
    const std::int64_t vertex = (isVertex ? id : id / 3) % vertices;
    const Index3 place = { vertex % this->Dimensions[0] - this->Low[0],
      vertex / this->Dimensions[0] % this->Dimensions[1] - this->Low[1],
      vertex / (this->Dimensions[0] * this->Dimensions[1]) - this->Low[2] };
    Index3 begin{};
    Index3 end{};
    for (std::size_t axis = 0; axis < 3; ++axis)
    {
      const bool isAlong = !isVertex && axis == static_cast<std::size_t>(id % 3);
      const std::int64_t reach = endsAlone ? 0 : 1;
      const std::int64_t first = place[axis] - (isAlong ? 0 : reach);
      const std::int64_t past = place[axis] + 1 + (isAlong ? 1 : reach);
      begin[axis] = first > 0 ? first : 0;
      end[axis] = past < this->Size[axis] ? past : this->Size[axis];
    }
    for (std::int64_t z = begin[2]; z < end[2]; ++z)
    {
      for (std::int64_t y = begin[1]; y < end[1]; ++y)
      {
        for (std::int64_t x = begin[0]; x < end[0]; ++x)
        {
          body(static_cast<std::size_t>(x + this->Size[0] * (y + this->Size[1] * z)));
        }
      }
    }
  }

private:
  Index3 Size;
  Index3 Dimensions{};
  Index3 Low{};
  std::int64_t EdgeIds = 0; ///< of all isovalues
};

/// Changes the sides of enclosed vertices.
template <typename T>
class SideTurning
{
public:
  /// isFixed: by vertex; those that are not to be turned, nor what is connected to them.
  SideTurning(T threshold, const Index3& size, std::vector<std::uint8_t> isFixed, T* values)
    : Threshold(threshold)
    , Steps{ 1, static_cast<std::size_t>(size[0]), static_cast<std::size_t>(size[0] * size[1]) }
    , IsFixed(std::move(isFixed))
    , Turns(IsFixed.size(), 0)
    , Values(values)
  {
  }

  /// Turns all vertices that are connected to one on its side, if none of them is fixed.
  void Turn(std::size_t first)
  {
    if (this->IsFixed[first] != 0)
    {
      return;
    }
    const bool side = this->IsInside(first);
    T other = this->Values[first];
    bool isFree = true;
    std::vector<std::size_t> connected = { first };
    this->Turns[first] = ++this->Turned;
    for (std::size_t n = 0; n < connected.size() && isFree; ++n)
    {
      for (const std::size_t step : this->Steps)
      {
        // Not beyond the block, since the vertices of its faces are fixed.
        for (const std::size_t neighbor : { connected[n] - step, connected[n] + step })
        {
          if (this->IsInside(neighbor) != side)
          {
            other = this->Values[neighbor];
          }
          else if (this->Turns[neighbor] != this->Turned)
          {
            isFree = isFree && this->IsFixed[neighbor] == 0;
            this->Turns[neighbor] = this->Turned;
            connected.push_back(neighbor);
          }
        }
      }
    }
    for (const std::size_t vertex : connected)
    {
      this->Values[vertex] = isFree ? other : this->Values[vertex];
      this->IsFixed[vertex] = isFree ? 0 : 1;
    }
  }

private:
  bool IsInside(std::size_t vertex) const { return this->Values[vertex] >= this->Threshold; }

  T Threshold;
  std::size_t Steps[3];
  std::vector<std::uint8_t> IsFixed;
  std::vector<std::uint32_t> Turns; ///< in which a vertex was met last
  std::uint32_t Turned = 0;
  T* Values;
};

/// Of each vertex of a block, whether it lies in one of the block's faces.
std::vector<std::uint8_t> FindFaces(const Index3& size)
{
  std::vector<std::uint8_t> areOnFace;
  for (std::int64_t z = 0; z < size[2]; ++z)
  {
    for (std::int64_t y = 0; y < size[1]; ++y)
    {
      for (std::int64_t x = 0; x < size[0]; ++x)
      {
        areOnFace.push_back(
          x == 0 || y == 0 || z == 0 || x + 1 == size[0] || y + 1 == size[1] || z + 1 == size[2]
            ? 1
            : 0);
      }
    }
  }
  return areOnFace;
}

/**
 * The scalars of a block for an encoder with KeptIds, which take fewer bytes: where vertices of one side of the
 * isovalue, or of the other, are enclosed within the block by islands that are left out, and in no cell with an
 * island that is kept, they change sides. So such islands vanish, and others stay as they are.
 *
 * Errors: what ExtractSurface returns.
 */
Result<BlockSamples> MaskIslands(
  const EdgeIndexHeader& header, const BlockSamples& samples, std::size_t isovalue)
{
  ISOSURFACE_ASSIGN_OR_RETURN(
    const Surface surface, ExtractBlockSurface(header, samples, isovalue));
  const VertexBox& box = samples.Scalars.Box;
  const BlockPlaces places(header, box);
  std::vector<std::uint8_t> isFixed = FindFaces(places.GetSize());
  std::vector<std::int64_t> leftOut;
  for (const std::int64_t id : surface.GlobalIds)
  {
    if (!std::binary_search(header.KeptIds->begin(), header.KeptIds->end(), id))
    {
      leftOut.push_back(id);
      continue;
    }
    places.VisitAround(id, false, [&](std::size_t vertex) { isFixed[vertex] = 1; });
  }
  BlockSamples masked;
  const auto bytes = std::make_shared<Buffer<std::uint8_t>>(
    static_cast<std::size_t>(box.GetNumberOfVertices()) * GetValueSize(header.Type));
  CopyBox(samples.Scalars, box, box, bytes->GetData());
  masked.Scalars = MakeSampleView(header.Type, box, bytes->GetData());
  masked.Owner = bytes;
  DispatchValueType(header.Type,
    [&](auto zero)
    {
      using T = decltype(zero);
      if (const auto threshold = FindThreshold<T>(header.Isovalues[isovalue]))
      {
        SideTurning<T> turning(
          *threshold, places.GetSize(), std::move(isFixed), reinterpret_cast<T*>(bytes->GetData()));
        for (const std::int64_t id : leftOut)
        {
          places.VisitAround(id, true, [&](std::size_t vertex) { turning.Turn(vertex); });
        }
      }
    });
  return masked;
}

} // namespace

class EdgeIndexEncoder::Work
{
public:
  explicit Work(const EdgeIndexHeader& header)
    : Header(header)
    , Preview(header.MakePreview())
    , Model(GetFreshModel(header.Settings.Profile))
    , PreviewModel(GetFreshModel(this->Preview.Settings.Profile))
  {
  }

  void EncodeValues(SampledBlock& block, EdgeIndexRecord& record, std::vector<std::uint8_t>& code)
  {
    const double isovalue = this->Header.Isovalues[record.Block.Isovalue];
    std::optional<Quantizer> quantizer;
    if (this->Header.Settings.Mode == EdgeIndexMode::Quantized)
    {
      quantizer.emplace(this->Header.Settings.MakeQuantizer(this->Header.Type, isovalue));
      record.Scale =
        std::clamp(ChooseScale(block.MeasureDistance() / quantizer->GetStep()), -30, 10);
    }
    else
    {
      record.Scale = block.ChooseLosslessScale();
    }
    const ValueDomain domain = quantizer ? quantizer->MakeDomain(record.Scale)
                                         : ValueDomain(this->Header.Type, isovalue, record.Scale);
    block.SetQuantizer(quantizer ? &*quantizer : nullptr);
    block.SetDomain(&domain);
    record.Block.Coding = CodedGeometry::Values;
    record.Block.HasMissing = false;
    BlockContent content;
    content.Domain = &domain;
    this->Run(block, record.Block.IsPreview, content, code);
  }

  void EncodeCrossings(
    SampledBlock& block, EdgeIndexRecord& record, std::vector<std::uint8_t>& code)
  {
    record.Block.Coding = CodedGeometry::Crossings;
    record.Block.HasMissing = block.HasMissingCrossings();
    BlockContent content;
    content.Intervals = block.GetIntervals();
    content.HasMissing = record.Block.HasMissing;
    this->Run(block, record.Block.IsPreview, content, code);
  }

  /// Appends the record of a block that is crossed.
  void Encode(SampledBlock& block, EdgeIndexMode mode, EdgeIndexRecord& record,
    std::vector<std::uint8_t>& bytes)
  {
    std::vector<std::uint8_t> code;
    if (mode != EdgeIndexMode::Bounded)
    {
      this->EncodeValues(block, record, code);
    }
    if (mode == EdgeIndexMode::Bounded || mode == EdgeIndexMode::Smallest)
    {
      EdgeIndexRecord other = record;
      std::vector<std::uint8_t> otherCode;
      this->EncodeCrossings(block, other, otherCode);
      if (mode == EdgeIndexMode::Bounded || otherCode.size() < code.size())
      {
        record = other;
        code = std::move(otherCode);
      }
    }
    record.Code = code.data();
    record.CodeSize = code.size();
    record.Append(bytes);
  }

  /// Appends the record of the block's part of the preview, if there is one.
  Status EncodePreview(
    const SampleView& view, EdgeIndexRecord record, std::vector<std::uint8_t>& bytes)
  {
    const auto vertices = FindPreviewVertices(view.Box, this->Header.PreviewLevel);
    if (!vertices)
    {
      return Status::Ok();
    }
    BlockSamples coarse;
    coarse.Scalars = TakePreviewSamples(view, *vertices, this->Header.PreviewLevel);
    const double isovalue = this->Preview.Isovalues[record.Block.Isovalue];
    SampledBlock block(coarse.Scalars, isovalue, this->Preview.GetIntervals());
    record.Block.Vertices = *vertices;
    record.Block.IsPreview = true;
    return block.IsCrossed()
      ? this->EncodeKept(this->Preview, coarse, block, EdgeIndexMode::Bounded, record, bytes)
      : Status::Ok();
  }

  /// Appends the record of a block, unless all its islands are left out. `header`: of the preview, if the block
  /// is.
  Status EncodeKept(const EdgeIndexHeader& header, const BlockSamples& samples, SampledBlock& block,
    EdgeIndexMode mode, EdgeIndexRecord& record, std::vector<std::uint8_t>& bytes)
  {
    record.Block.NumberOfPoints = block.CountPoints();
    if (!header.KeptIds)
    {
      this->Encode(block, mode, record, bytes);
      return Status::Ok();
    }
    ISOSURFACE_ASSIGN_OR_RETURN(
      const BlockSamples masked, MaskIslands(header, samples, record.Block.Isovalue));
    ISOSURFACE_ASSIGN_OR_RETURN(
      const auto islands, FindBlockIslands(header, masked, record.Block.Isovalue));
    std::uint64_t points = 0;
    for (const BlockIsland& island : islands)
    {
      const bool isKept =
        std::binary_search(header.KeptIds->begin(), header.KeptIds->end(), island.FirstId);
      record.AreKept.push_back(isKept);
      points += isKept ? island.Points : 0;
    }
    record.Block.LacksIslands =
      std::find(record.AreKept.begin(), record.AreKept.end(), false) != record.AreKept.end();
    SampledBlock rest(
      masked.Scalars, header.Isovalues[record.Block.Isovalue], block.GetIntervals());
    rest.SetAttributes(block.GetAttributes());
    record.Block.NumberOfPoints = record.Block.LacksIslands ? points : rest.CountPoints();
    if (points > 0)
    {
      this->Encode(rest, mode, record, bytes);
    }
    return Status::Ok();
  }

  const EdgeIndexHeader Header;
  const EdgeIndexHeader Preview;

private:
  void Run(
    SampledBlock& block, bool isPreview, BlockContent& content, std::vector<std::uint8_t>& code)
  {
    content.Size = block.GetSize();
    content.Attributes = block.GetAttributes();
    BlockModel& model = isPreview ? this->PreviewModel : this->Model;
    model.Reset(content.Domain != nullptr);
    if (model.Profile != EdgeIndexProfile::Working)
    {
      RangeEncoder encoder(code);
      CodeBlock(encoder, model, content, block);
      encoder.Finish();
      return;
    }
    BytePlanes planes;
    planes.Begin(content.Size);
    content.Planes = &planes;
    std::vector<std::uint8_t> attributes;
    RangeEncoder encoder(attributes);
    CodeBlock(encoder, model, content, block);
    planes.Append(code);
    if (!content.Attributes.empty())
    {
      encoder.Finish();
      code.insert(code.end(), attributes.begin(), attributes.end());
    }
  }

  BlockModel Model;
  BlockModel PreviewModel;
};

EdgeIndexEncoder::EdgeIndexEncoder(const EdgeIndexHeader& header)
  : Worker(std::make_unique<Work>(header))
{
}

EdgeIndexEncoder::~EdgeIndexEncoder() = default;

namespace
{

Status CheckBlock(const EdgeIndexHeader& header, const SampleView& view, std::size_t isovalue)
{
  const Index3 size = view.Box.GetSize();
  const Index3 dimensions = header.Geometry.GetDimensions();
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    if (size[axis] < 1 || size[axis] > MaximumCodedVertices || view.Box.Low[axis] < 0 ||
      view.Box.High[axis] > dimensions[axis])
    {
      return { StatusCode::InvalidArgument,
        "A block to encode must lie within the grid and have at most 64 cells a side." };
    }
  }
  if (!view.First || view.Type != header.Type || !(view.Available.Intersect(view.Box) == view.Box))
  {
    return { StatusCode::InvalidArgument,
      "The samples of a block to encode are missing or of another type." };
  }
  if (isovalue >= header.Isovalues.size())
  {
    return { StatusCode::InvalidArgument, "The stream has no such isovalue." };
  }
  return Status::Ok();
}

} // namespace

Status EdgeIndexEncoder::EncodeBlock(const Index3& lattice, const BlockSamples& samples,
  std::size_t isovalue, std::vector<std::uint8_t>& bytes)
{
  const EdgeIndexHeader& header = this->Worker->Header;
  const SampleView& view = samples.Scalars;
  ISOSURFACE_RETURN_IF_ERROR(CheckBlock(header, view, isovalue));
  const Index3 size = view.Box.GetSize();
  if (*std::min_element(size.begin(), size.end()) == 1)
  {
    return Status::Ok(); // no cells, no surface
  }
  SampledBlock block(view, header.Isovalues[isovalue], header.GetIntervals());
  const bool isWithin = !block.IsCrossed() &&
    block.HasInside() != header.ClosedSides.AreBeyondInside &&
    header.ClosedSides.Touch(view.Box, header.Geometry.GetDimensions());
  if (!block.IsCrossed() && !isWithin)
  {
    return Status::Ok();
  }
  EdgeIndexRecord record;
  record.Block.Isovalue = isovalue;
  record.Block.Vertices = view.Box;
  record.Block.Lattice = lattice;
  if (header.PreviewLevel > 0)
  {
    ISOSURFACE_RETURN_IF_ERROR(this->Worker->EncodePreview(view, record, bytes));
  }
  PointAttributes attributes(header, view.Box);
  if (!header.Attributes.empty())
  {
    ISOSURFACE_RETURN_IF_ERROR(attributes.Interpolate(header, samples, isovalue));
    block.SetAttributes(attributes.GetCoded());
  }
  return this->Worker->EncodeKept(header, samples, block, header.Settings.Mode, record, bytes);
}

namespace
{

// Encodes batches of blocks in parallel and passes them on in order.
class BatchEncoding
{
public:
  BatchEncoding(const EdgeIndexHeader& header, BlockSource& source, int threads)
    : Header(header)
    , Source(source)
    , Threads(std::max(1, threads))
    , Encoders(static_cast<std::size_t>(Threads))
  {
  }

  Status Run(
    const std::function<Status(const std::vector<std::uint8_t>&)>& take, const Progress& progress)
  {
    const std::size_t count = this->Source.GetNumberOfBlocks();
    const std::size_t batch = BlocksPerThread * static_cast<std::size_t>(this->Threads);
    std::vector<std::uint8_t> joined;
    for (std::size_t first = 0; first < count; first += batch)
    {
      const std::size_t size = std::min(batch, count - first);
      Progress part;
      if (progress)
      {
        part = [&](double share)
        {
          return progress((static_cast<double>(first) + share * static_cast<double>(size)) /
            static_cast<double>(count));
        };
      }
      ISOSURFACE_RETURN_IF_ERROR(this->EncodeBatch(first, size, part));
      joined.clear();
      for (std::vector<std::uint8_t>& block : this->Blocks)
      {
        joined.insert(joined.end(), block.begin(), block.end());
      }
      ISOSURFACE_RETURN_IF_ERROR(take(joined));
    }
    return Status::Ok();
  }

private:
  static constexpr std::size_t BlocksPerThread = 64;

  Status EncodeBatch(std::size_t first, std::size_t size, const Progress& progress)
  {
    this->Blocks.assign(size, {});
    FirstFailure failure;
    const bool finished = ParallelFor(
      size, this->Threads,
      [&](std::size_t block, int thread)
      {
        failure.Run(
          [&]
          {
            return this->Encode(
              first + block, this->Encoders[static_cast<std::size_t>(thread)], this->Blocks[block]);
          });
      },
      progress);
    ISOSURFACE_RETURN_IF_ERROR(failure.Get());
    return finished ? Status::Ok() : Status(StatusCode::Aborted, "The encoding was aborted.");
  }

  Status Encode(
    std::size_t block, std::unique_ptr<EdgeIndexEncoder>& encoder, std::vector<std::uint8_t>& bytes)
  {
    if (!encoder)
    {
      encoder = std::make_unique<EdgeIndexEncoder>(this->Header);
    }
    ISOSURFACE_ASSIGN_OR_RETURN(const BlockSamples samples, this->Source.Acquire(block));
    for (std::size_t isovalue = 0; isovalue < this->Header.Isovalues.size(); ++isovalue)
    {
      ISOSURFACE_RETURN_IF_ERROR(
        encoder->EncodeBlock(this->Source.GetLatticeCoordinates(block), samples, isovalue, bytes));
    }
    return Status::Ok();
  }

  const EdgeIndexHeader& Header;
  BlockSource& Source;
  int Threads;
  std::vector<std::unique_ptr<EdgeIndexEncoder>> Encoders;
  std::vector<std::vector<std::uint8_t>> Blocks;
};

} // namespace

Status EncodeBlocks(const EdgeIndexHeader& header, BlockSource& source, int threads,
  const std::function<Status(const std::vector<std::uint8_t>& records)>& take,
  const Progress& progress)
{
  ISOSURFACE_RETURN_IF_ERROR(header.Check());
  return RunWithinMemory("", "There is not enough memory to encode the isosurface.",
    [&] { return BatchEncoding(header, source, threads).Run(take, progress); });
}

} // namespace isosurface
