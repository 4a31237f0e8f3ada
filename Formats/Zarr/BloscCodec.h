// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_BloscCodec_h
#define isosurface_BloscCodec_h

#include <cstddef>
#include <cstdint>

namespace isosurface
{

/// Decodes a chunk of blosc, which must have exactly `size` bytes. False if it is damaged.
using BloscDecoder = bool (*)(
  const std::uint8_t* from, std::size_t fromSize, std::uint8_t* to, std::size_t size);

/// What the module BloscCodec has.
extern "C" const BloscDecoder IsosurfaceBloscCodec;

} // namespace isosurface

#endif
