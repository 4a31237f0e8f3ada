// SPDX-License-Identifier: BSD-3-Clause
#include "Storage/Record/BlockRecord.h"

#include "Ground/Base/Checksum.h"
#include "Ground/Base/Coding.h"
#include "Ground/Volume/Magnitude.h"

#include <string>

namespace isosurface
{
namespace
{

constexpr std::size_t ChecksumSize = 8;

std::uint64_t ComputeSegmentChecksum(
  const std::uint8_t* segment, std::uint32_t stored, const SegmentPlace& place)
{
  std::uint8_t bytes[16];
  StoreLittleEndian(bytes, static_cast<std::uint64_t>(place.Block));
  StoreLittleEndian(bytes + 8, place.Variable);
  StoreLittleEndian(bytes + 12, place.Level);
  return ComputeChecksum(segment + ChecksumSize,
    BlockRecord::SegmentHeaderSize - ChecksumSize + stored, ComputeChecksum(bytes, sizeof(bytes)));
}

} // namespace

void SealSegment(std::uint8_t* segment, std::uint32_t stored, const SegmentCoding& coding,
  const SegmentPlace& place)
{
  StoreLittleEndian(segment + 8, stored);
  segment[12] = static_cast<std::uint8_t>(coding.Codec);
  segment[13] = static_cast<std::uint8_t>(coding.Predictor);
  StoreLittleEndian(segment + 14, std::uint16_t{ 0 });
  StoreLittleEndian(segment, ComputeSegmentChecksum(segment, stored, place));
}

Status CheckSegment(const std::uint8_t* segment, std::uint32_t stored, const SegmentPlace& place)
{
  const auto makeError = [&place](const char* reason)
  {
    return Status(StatusCode::Corrupt,
      "block " + std::to_string(place.Block) + ", variable " + std::to_string(place.Variable) +
        ", level " + std::to_string(place.Level) + reason);
  };
  if (LoadLittleEndian<std::uint64_t>(segment) != ComputeSegmentChecksum(segment, stored, place))
  {
    return makeError(" has a wrong checksum");
  }
  if (LoadLittleEndian<std::uint32_t>(segment + 8) != stored)
  {
    return makeError(" has another length than the directory states");
  }
  return Status::Ok();
}

std::optional<SegmentCoding> LoadSegmentCoding(const std::uint8_t* segment)
{
  const auto codec = static_cast<SegmentCodec>(segment[12]);
  const std::uint8_t predictor = segment[13];
  const bool isKnown = codec == SegmentCodec::None
    ? predictor == 0
    : GetCodecName(codec) != nullptr && IsPredictor(predictor);
  if (!isKnown)
  {
    return std::nullopt;
  }
  return SegmentCoding{ codec, static_cast<SamplePredictor>(predictor) };
}

std::shared_ptr<DecodedBlock> AssembleLevel(const BlockGrid& grid, std::int64_t block, int level,
  ValueType type, const std::vector<const std::uint8_t*>& segments)
{
  const std::size_t size = GetValueSize(type);
  auto decoded = std::make_shared<DecodedBlock>();
  decoded->Block = block;
  decoded->Level = level;
  const VertexBox available = grid.GetGhostedVertices(block, level);
  decoded->Bytes =
    Buffer<std::uint8_t>(static_cast<std::size_t>(available.GetNumberOfVertices()) * size);
  decoded->View = MakeSampleView(type, available, decoded->Bytes.GetData());
  decoded->View.Box = grid.GetVertices(block, level);

  const int coarsest = grid.GetNumberOfLevels() - 1;
  for (int from = coarsest; from >= level; --from)
  {
    // A coarser level's ghost layer lies outside of this one's box; its own vertices lie inside.
    const BlockSegment segment(grid, block, from);
    const int shift = from - level;
    const std::uint8_t* samples = segments[static_cast<std::size_t>(coarsest - from)];
    segment.VisitRows(shift == 0 ? segment.GetBox() : segment.GetOwnBox(),
      [&](const SegmentRow& row)
      {
        const Index3 to = { row.I << shift, row.J << shift, row.K << shift };
        CopySamples(decoded->Bytes.GetData() + available.FindIndex(to) * size, row.Step << shift,
          samples + row.Offset * size, 1, row.Count, size);
      });
  }
  return decoded;
}

std::shared_ptr<DecodedBlock> MakeMagnitudeBlock(const DecodedBlocks& components)
{
  auto block = std::make_shared<DecodedBlock>();
  block->Block = components.front()->Block;
  block->Level = components.front()->Level;
  const VertexBox& box = components.front()->View.Available;
  block->Bytes =
    Buffer<std::uint8_t>(static_cast<std::size_t>(box.GetNumberOfVertices()) * sizeof(double));
  auto* magnitudes = reinterpret_cast<double*>(block->Bytes.GetData());
  std::vector<SampleView> views;
  for (const std::shared_ptr<const DecodedBlock>& component : components)
  {
    views.push_back(component->View);
  }
  ComputeMagnitudes(views, box, magnitudes);
  block->View = MakeMagnitudeView(box, magnitudes);
  block->View.Box = components.front()->View.Box;
  return block;
}

BlockRecordLayout::BlockRecordLayout(
  const BlockGrid& grid, std::int64_t block, const std::vector<ValueType>& types)
{
  for (const ValueType type : types)
  {
    for (int level = grid.GetNumberOfLevels() - 1; level >= 0; --level)
    {
      const std::uint64_t samples = BlockSegment(grid, block, level).GetNumberOfSamples();
      this->Samples += samples;
      this->Offsets.push_back(this->Size);
      this->Lengths.push_back(static_cast<std::uint32_t>(samples * GetValueSize(type)));
      this->Size += BlockRecord::SegmentHeaderSize + this->Lengths.back();
    }
  }
}

} // namespace isosurface
