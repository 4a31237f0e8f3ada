// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_EdgeIndexDecoder_h
#define isosurface_EdgeIndexDecoder_h

#include "Base/Progress.h"
#include "Base/Status.h"
#include "Contour/Surface.h"
#include "EdgeIndex/BlockRecordFormat.h"
#include "EdgeIndex/EdgeIndexHeader.h"
#include "Volume/BlockSource.h"

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
 * Decodes the records of the blocks of one stream, on any number of threads at once: samples that
 * have the right side of the isovalue at every vertex and, as far as the mode keeps it, the right
 * value at the ends of crossed edges; (Bounded) where on their edges the points lie; and the tuples
 * of the attributes. Marching cubes of them is the encoded surface.
 *
 * header: that of the stream, or its MakePreview() for blocks of the preview; must outlive the
 * decoder. Memory: that of the model, at most 2 MB, for as many threads as decode at a time; and
 * the samples.
 */
class EdgeIndexBlockDecoder
{
public:
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
  std::vector<std::unique_ptr<BlockModel>> Models; ///< those that no thread decodes with now
};

/// The same for a single record.
Result<BlockSamples> DecodeBlock(const EdgeIndexHeader& header, const EdgeIndexRecord& record);

/**
 * The blocks of one isovalue of an edge-index stream, or of any collection of records, as an
 * extraction visits them: each is decoded when its turn comes. The records' bytes must outlive the
 * source.
 */
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
 * Decodes a stream into the surface that it was made of: points, GlobalIds and cells equal, in
 * their order too, what ExtractSurface gives for the blocks that were encoded. Isovalues and
 * Attributes of the request are not used: the surface has all attributes of the header. Normals are
 * there if they are asked for and were encoded; otherwise asking for them is an InvalidArgument:
 * they can be computed of the triangles.
 *
 * Errors: Corrupt (bytes altered or cut off), Unsupported, InvalidArgument, OutOfMemory, Aborted.
 */
Result<Surface> DecodeSurface(const std::uint8_t* bytes, std::size_t size,
  const ContourRequest& request, int threads, const Progress& progress = {});

} // namespace isosurface

#endif
