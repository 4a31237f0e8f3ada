// SPDX-License-Identifier: BSD-3-Clause
// Input: flags (1 byte: 1 seals the checksums, 2 asks for normals), an edge-index stream. It is
// decoded as a whole, and its records one by one, those of the preview as well.
#include "Fixtures/EdgeIndexStreams.h"
#include "FuzzTarget.h"
#include "SealedBytes.h"

using namespace isosurface;

namespace
{

/// The maximum of blocks that are decoded of one input, since each takes time.
constexpr std::size_t MaximumBlocks = 8;
/// The maximum of components of attributes, since each takes memory for all edges of a block.
constexpr int MostComponents = 6;
/// For decoded blocks, the models and the surface.
constexpr std::size_t BlockBytes = std::size_t{ 192 } << 20;

bool IsSmall(const EdgeIndexHeader& header)
{
  int components = 0;
  for (const EdgeIndexAttribute& attribute : header.Attributes)
  {
    components += attribute.NumberOfComponents;
  }
  return components <= MostComponents;
}

// Returns whether the stream has few blocks.
bool DecodeRecords(const EdgeIndexHeader& header, const std::uint8_t* bytes, std::size_t size)
{
  const EdgeIndexHeader preview = header.PreviewLevel > 0 ? header.MakePreview() : header;
  EdgeIndexBlockDecoder blocks(header);
  EdgeIndexBlockDecoder previewBlocks(preview);
  std::size_t used = 0;
  std::size_t number = 0;
  for (std::size_t at = 0; at < size; at += used)
  {
    const auto record = EdgeIndexRecord::Parse(header, bytes + at, size - at, used);
    if (!record.IsOk())
    {
      return true;
    }
    if (++number > MaximumBlocks)
    {
      return false;
    }
    const auto samples =
      record->Block.IsPreview ? previewBlocks.Decode(*record) : blocks.Decode(*record);
    Require(samples.IsOk() || samples.GetStatus().GetCode() == StatusCode::Corrupt,
      "a bad block is Corrupt");
    Require(!samples.IsOk() ||
        samples->Scalars.Box.GetNumberOfVertices() == record->Block.Vertices.GetNumberOfVertices(),
      "a block has the vertices that its record tells");
  }
  return true;
}

} // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size)
{
  if (size < 1)
  {
    return 0;
  }
  const std::uint8_t flags = bytes[0];
  const SealedBytes stream = (flags & 1) != 0 ? SealEdgeIndexFile(bytes + 1, size - 1)
                                              : SealedBytes(bytes + 1, bytes + size);
  const MemoryLimit limit(64 * size + BlockBytes);
  std::size_t used = 0;
  const auto header = EdgeIndexHeader::Parse(stream.data(), stream.size(), used);
  if (!header.IsOk() || !IsSmall(*header) ||
    !DecodeRecords(*header, stream.data() + used, stream.size() - used))
  {
    return 0;
  }
  ContourRequest request;
  request.GlobalIds = true;
  request.Normals = (flags & 2) != 0;
  const auto surface = DecodeSurface(stream.data(), stream.size(), request, 1);
  for (std::size_t n = 0; surface.IsOk() && n < surface->Connectivity.GetSize(); ++n)
  {
    Require(surface->Connectivity[n] >= 0 &&
        surface->Connectivity[n] < static_cast<std::int64_t>(surface->NumberOfPoints),
      "triangles have points that are there");
  }
  return 0;
}
