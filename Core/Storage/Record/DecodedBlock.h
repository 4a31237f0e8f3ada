// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_DecodedBlock_h
#define isosurface_DecodedBlock_h

#include "Ground/Base/Buffer.h"
#include "Ground/Volume/SampleView.h"

#include <cstdint>
#include <memory>
#include <vector>

namespace isosurface
{

/// The samples of one variable of one block at one level, x fastest. View.Box is the block's own
/// vertices, View.Available includes the ghost layer; both are in the level's vertex coordinates
/// (BlockGrid). View points into Bytes.
struct DecodedBlock
{
  std::int64_t Block = 0;
  int Level = 0;
  SampleView View;
  Buffer<std::uint8_t> Bytes;
};
using DecodedBlocks = std::vector<std::shared_ptr<const DecodedBlock>>;

} // namespace isosurface

#endif
