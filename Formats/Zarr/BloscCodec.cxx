// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/Zarr/BloscCodec.h"

#include <blosc.h>

namespace isosurface
{
namespace
{

bool DecodeBlosc(const std::uint8_t* from, std::size_t fromSize, std::uint8_t* to, std::size_t size)
{
  std::size_t decoded = 0;
  return ::blosc_cbuffer_validate(from, fromSize, &decoded) == 0 && decoded == size &&
    ::blosc_decompress_ctx(from, to, size, 1) == static_cast<int>(size);
}

} // namespace

const BloscDecoder IsosurfaceBloscCodec = DecodeBlosc;

} // namespace isosurface
