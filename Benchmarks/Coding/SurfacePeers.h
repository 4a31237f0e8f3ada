// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_Benchmarks_SurfacePeers_h
#define isosurface_Benchmarks_SurfacePeers_h

#include "Surface/Contour/Surface.h"

#include <cstddef>
#include <string>
#include <vector>

namespace isosurface
{

/// What another format makes of a surface, by one thread.
struct PeerOutcome
{
  std::string Name;
  std::size_t Bytes = 0;
  double EncodeSeconds = 0;
  double DecodeSeconds = 0;
};

/**
 * Puts points (three float32) and triangles (three indices of 32 bits) into formats that are in
 * use: .ply (binary) with zstd and xz; .vtp (appended, not encoded as text) with zlib and LZMA,
 * where VTK is there; meshoptimizer's buffers, lossless and with positions of 14 bits, where it is.
 */
std::vector<PeerOutcome> MeasurePeers(const Surface& surface);

} // namespace isosurface

#endif
