// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_BlockDescription_h
#define isosurface_BlockDescription_h

#include "Ground/Base/Status.h"
#include "Ground/Volume/BlockGrid.h"

#include <cstdint>
#include <numeric>
#include <vector>

namespace isosurface
{

/// What all ranks know of a block before its records travel.
struct BlockDescription
{
  VertexBox Vertices;
  Index3 Lattice{};                  ///< see BlockSource
  std::vector<std::uint64_t> Points; ///< for each isovalue: crossed edges, including shared faces
  std::uint64_t Bytes = 0;           ///< of its records

  std::uint64_t CountPoints() const
  {
    return std::accumulate(this->Points.begin(), this->Points.end(), std::uint64_t{ 0 });
  }
};

/// The error for messages that differ from what was sent.
inline Status MakeDamagedMessage()
{
  return { StatusCode::Corrupt, "A message of isosurface blocks between ranks arrived damaged." };
}

} // namespace isosurface

#endif
