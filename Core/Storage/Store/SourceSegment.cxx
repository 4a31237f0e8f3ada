// SPDX-License-Identifier: BSD-3-Clause
#include "Storage/Store/SourceSegment.h"

#include "Storage/Record/BlockRecord.h"

#include <cstring>

namespace isosurface
{

Status GatherSegment(SourceSamples& source, const BlockGrid& grid, const BlockDirectoryEntry& entry,
  const std::string& path, std::size_t component, const std::uint8_t* header, std::uint8_t* segment,
  QueryStatistics& statistics)
{
  constexpr std::size_t headerSize = BlockRecord::SegmentHeaderSize;
  const VertexBox box = grid.GetGhostedVertices(entry.Block, 0);
  const std::size_t bytes =
    static_cast<std::size_t>(box.GetNumberOfVertices()) * GetValueSize(source.GetType(component));
  if (entry.Lengths[component] != bytes)
  {
    return Status(StatusCode::Corrupt,
      path + ": block " + std::to_string(entry.Block) +
        " has an impossible length in the directory");
  }
  std::memcpy(segment, header, headerSize);
  ISOSURFACE_RETURN_IF_ERROR(source.Read(component, box, segment + headerSize, statistics));
  const Status status = CheckSegment(
    segment, entry.Lengths[component], { entry.Block, static_cast<std::uint32_t>(component), 0 });
  return status.IsOk() ? status : source.MakeChanged(entry.Block);
}

} // namespace isosurface
