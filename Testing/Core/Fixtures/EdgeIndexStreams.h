// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_EdgeIndexStreams_h
#define isosurface_EdgeIndexStreams_h

#include "Coding/EdgeIndex/EdgeIndexDecoder.h"
#include "Coding/EdgeIndex/EdgeIndexEncoder.h"
#include "Coding/EdgeIndex/IsovalueJoin.h"

#include <memory>
#include <utility>
#include <vector>

namespace isosurface
{

/// The surface of a source as one stream: the header, then the records of EncodeBlocks.
/// Errors: as EncodeBlocks.
inline Result<std::vector<std::uint8_t>> EncodeSurface(
  const EdgeIndexHeader& header, BlockSource& source, int threads, const Progress& progress = {})
{
  std::vector<std::uint8_t> bytes;
  header.Append(bytes);
  const Status status = EncodeBlocks(
    header, source, threads,
    [&bytes](const std::vector<std::uint8_t>& records)
    {
      bytes.insert(bytes.end(), records.begin(), records.end());
      return Status::Ok();
    },
    progress);
  ISOSURFACE_RETURN_IF_ERROR(status);
  return bytes;
}

/// Blocks of one isovalue, given as records. Each is decoded when an extraction acquires it. The
/// header and the bytes of the records must outlive the source.
class EdgeIndexBlockSource : public CodedBlockSource
{
public:
  EdgeIndexBlockSource(const EdgeIndexHeader& header, std::vector<EdgeIndexRecord> records)
    : CodedBlockSource(header)
    , Records(std::move(records))
  {
  }

  std::size_t GetNumberOfBlocks() const override { return this->Records.size(); }
  Index3 GetLatticeCoordinates(std::size_t block) const override
  {
    return this->Records[block].Block.Lattice;
  }
  VertexBox GetVertices(std::size_t block) const override
  {
    return this->Records[block].Block.Vertices;
  }
  Result<BlockSamples> Acquire(std::size_t block) override
  {
    return this->Decoder.Decode(this->Records[block]);
  }

private:
  std::vector<EdgeIndexRecord> Records;
};

/**
 * Decodes a stream into its surface: points, GlobalIds and cells are equal, and in the same order,
 * as those that ExtractSurface makes of the encoded blocks (as far as the mode keeps points). The
 * request's isovalues and attributes are ignored: the surface has all that the header names.
 * Normals must be among the attributes if they are requested, since they cannot be computed from
 * decoded samples.
 *
 * Errors: Corrupt (bytes altered or cut off), Unsupported, InvalidArgument, OutOfMemory, Aborted.
 */
inline Result<Surface> DecodeSurface(const std::uint8_t* bytes, std::size_t size,
  const ContourRequest& request, int threads, const Progress& progress = {})
{
  std::size_t used = 0;
  ISOSURFACE_ASSIGN_OR_RETURN(
    const EdgeIndexHeader header, EdgeIndexHeader::Parse(bytes, size, used));
  std::vector<std::vector<EdgeIndexRecord>> records(header.Isovalues.size());
  for (std::size_t at = used; at < size; at += used)
  {
    ISOSURFACE_ASSIGN_OR_RETURN(
      const EdgeIndexRecord record, EdgeIndexRecord::Parse(header, bytes + at, size - at, used));
    if (!record.Block.IsPreview)
    {
      records[record.Block.Isovalue].push_back(record);
    }
  }
  std::vector<IsovalueSource> sources;
  sources.reserve(records.size());
  for (std::vector<EdgeIndexRecord>& blocks : records)
  {
    sources.push_back(
      { sources.size(), std::make_unique<EdgeIndexBlockSource>(header, std::move(blocks)) });
  }
  return JoinIsovalues(header, sources, request, threads, progress);
}

} // namespace isosurface

#endif
