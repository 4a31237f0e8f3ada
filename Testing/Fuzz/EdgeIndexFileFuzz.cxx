// SPDX-License-Identifier: BSD-3-Clause
// Input: flags (1 byte: 1 seals the checksums, 2 reads the preview, 4 asks for a box), an
// edge-index file. It is opened, verified, and its surface read.
#include "FuzzTarget.h"
#include "SealedBytes.h"

#include "Coding/EdgeIndex/EdgeIndexFile.h"

#include <string>

using namespace isosurface;

namespace
{

const std::string Path = "/data/surface.eix";
/// The maximum of blocks that are decoded of one input, since each takes time.
constexpr std::size_t MaximumBlocks = 8;
/// The maximum of components of attributes, since each takes memory for all edges of a block.
constexpr int MostComponents = 6;
/// For a decoded block of 64-bit samples with its crossings, the models, and the surface of eight
/// blocks.
constexpr std::size_t BlockBytes = std::size_t{ 192 } << 20;

void Read(const EdgeIndexFile& file, bool preview, bool box)
{
  EdgeIndexSelection selection;
  selection.Preview = preview;
  if (box)
  {
    selection.Box = VertexBox{ { 3, 3, 3 }, { 30, 4, 30 } };
  }
  const auto selected = file.Select(selection);
  Require(selected.IsOk() || selected.GetStatus().GetCode() == StatusCode::InvalidArgument,
    "what a file has can be selected");
  ContourRequest request;
  request.GlobalIds = true;
  const auto surface = file.Read(selection, request, 1);
  if (!surface.IsOk())
  {
    Require(surface.GetStatus().GetMessage().find(Path) == 0, "an error names the file");
    return;
  }
  const auto points = static_cast<std::int64_t>(surface->NumberOfPoints);
  for (std::size_t n = 0; n < surface->Connectivity.GetSize(); ++n)
  {
    Require(surface->Connectivity[n] >= 0 && surface->Connectivity[n] < points,
      "triangles have points that are there");
  }
}

} // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size)
{
  if (size < 1)
  {
    return 0;
  }
  const std::uint8_t flags = bytes[0];
  MemoryDisk disk;
  PutFile(disk, Path,
    (flags & 1) != 0 ? SealEdgeIndexFile(bytes + 1, size - 1)
                     : SealedBytes(bytes + 1, bytes + size));
  const MemoryLimit limit(64 * size + BlockBytes);
  const auto file = EdgeIndexFile::Open(disk, Path);
  if (!file.IsOk())
  {
    Require(file.GetStatus().GetMessage().find(Path) == 0, "an error names the file");
    return 0;
  }
  int components = 0;
  for (const EdgeIndexAttribute& attribute : (*file)->GetHeader().Attributes)
  {
    components += attribute.NumberOfComponents;
  }
  if ((*file)->GetEntries().size() > MaximumBlocks || components > MostComponents)
  {
    return 0;
  }
  const Status status = (*file)->Verify(1);
  Require(status.IsOk() || status.GetCode() == StatusCode::Corrupt, "a bad file is Corrupt");
  Read(**file, (flags & 2) != 0, (flags & 4) != 0);
  return 0;
}
