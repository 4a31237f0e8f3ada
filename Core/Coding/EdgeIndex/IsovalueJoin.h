// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_IsovalueJoin_h
#define isosurface_IsovalueJoin_h

#include "Coding/EdgeIndex/EdgeIndexDecoder.h"
#include "Coding/EdgeIndex/EdgeIndexHeader.h"
#include "Ground/Base/Progress.h"
#include "Ground/Base/Status.h"
#include "Ground/Volume/BlockSource.h"
#include "Surface/Contour/Surface.h"

#include <cstddef>
#include <memory>
#include <vector>

namespace isosurface
{

/// Blocks that are decoded as an extraction acquires them. The header is as EdgeIndexBlockDecoder takes it.
class CodedBlockSource : public BlockSource
{
public:
  explicit CodedBlockSource(const EdgeIndexHeader& header)
    : Header(header)
    , Decoder(header)
  {
  }
  ValueType GetValueType() const override { return this->Header.GetDecodedType(); }
  const EdgeIndexBlockDecoder& GetDecoder() const { return this->Decoder; }

protected:
  const EdgeIndexHeader& Header;
  EdgeIndexBlockDecoder Decoder;
};

/// The decoded blocks of an isovalue.
struct IsovalueSource
{
  std::size_t Isovalue = 0; ///< index of EdgeIndexHeader::Isovalues
  std::unique_ptr<CodedBlockSource> Blocks;
};

/**
 * Extracts the surface of decoded blocks: each isovalue from its own source, joined in the order of
 * the sources as ExtractSurface joins isovalues. The request's isovalues and attributes are ignored:
 * the surface has all attributes of the header, and lacks the islands that blocks leave out. If the request asks for normals, they must be among
 * these (else InvalidArgument), since decoded samples have no gradients.
 *
 * Errors: Corrupt (blocks that do not fit together), InvalidArgument, OutOfMemory, Aborted, what
 * Acquire returns.
 */
Result<Surface> JoinIsovalues(const EdgeIndexHeader& header,
  const std::vector<IsovalueSource>& sources, const ContourRequest& request, int threads,
  const Progress& progress);

} // namespace isosurface

#endif
