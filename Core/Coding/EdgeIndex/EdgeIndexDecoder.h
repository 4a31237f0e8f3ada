// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_EdgeIndexDecoder_h
#define isosurface_EdgeIndexDecoder_h

#include "Coding/EdgeIndex/BlockRecordFormat.h"
#include "Coding/EdgeIndex/EdgeIndexHeader.h"
#include "Ground/Base/Progress.h"
#include "Ground/Base/Status.h"
#include "Ground/Volume/BlockSource.h"
#include "Surface/Contour/Surface.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

namespace isosurface
{

struct BlockModel;

/**
 * Decodes the records of one stream, by any number of threads at once, into samples that marching
 * cubes contours to the encoded surface: each has the right side of the isovalue; as far as the mode
 * keeps them, the ends of crossed edges have the right values; in bounded mode the positions of
 * points on their edges are there; and the tuples of the attributes.
 *
 * Memory: a model (at most 2 MB) for each thread that decodes, and the samples.
 */
class EdgeIndexBlockDecoder
{
public:
  /// header: that of the stream, or its MakePreview() for blocks of the preview; must outlive the
  /// decoder.
  explicit EdgeIndexBlockDecoder(const EdgeIndexHeader& header);
  ~EdgeIndexBlockDecoder();
  EdgeIndexBlockDecoder(const EdgeIndexBlockDecoder&) = delete;
  EdgeIndexBlockDecoder& operator=(const EdgeIndexBlockDecoder&) = delete;

  /// Errors: Corrupt.
  Result<BlockSamples> Decode(const EdgeIndexRecord& record);

private:
  std::unique_ptr<BlockModel> TakeModel();

  const EdgeIndexHeader& Header;
  std::mutex Mutex;
  std::vector<std::unique_ptr<BlockModel>> Models; ///< not in use by a thread
};

/// Blocks of one isovalue, given as records. Each is decoded when an extraction acquires it. The
/// header and the bytes of the records must outlive the source.
class EdgeIndexBlockSource : public BlockSource
{
public:
  EdgeIndexBlockSource(const EdgeIndexHeader& header, std::vector<EdgeIndexRecord> records)
    : Header(header)
    , Decoder(header)
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
  ValueType GetValueType() const override { return this->Header.GetDecodedType(); }
  Result<BlockSamples> Acquire(std::size_t block) override
  {
    return this->Decoder.Decode(this->Records[block]);
  }

private:
  const EdgeIndexHeader& Header;
  EdgeIndexBlockDecoder Decoder;
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
Result<Surface> DecodeSurface(const std::uint8_t* bytes, std::size_t size,
  const ContourRequest& request, int threads, const Progress& progress = {});

} // namespace isosurface

#endif
