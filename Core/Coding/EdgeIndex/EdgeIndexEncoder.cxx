// SPDX-License-Identifier: BSD-3-Clause
#include "Coding/EdgeIndex/EdgeIndexEncoder.h"

#include "Coding/BlockCoding/BlockCoding.h"
#include "Coding/BlockCoding/BytePlanes.h"
#include "Coding/EdgeIndex/BlockIslands.h"
#include "Coding/EdgeIndex/BlockRecordFormat.h"
#include "Coding/EdgeIndex/IslandMask.h"
#include "Coding/EdgeIndex/PointAttributes.h"
#include "Coding/EdgeIndex/PreviewBlocks.h"
#include "Coding/EdgeIndex/SampledBlock.h"
#include "Ground/Base/FirstFailure.h"
#include "Ground/Base/ParallelFor.h"
#include "Ground/Base/WithinMemory.h"

#include <algorithm>
#include <optional>
#include <utility>

namespace isosurface
{

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
