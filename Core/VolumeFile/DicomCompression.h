// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_DicomCompression_h
#define isosurface_DicomCompression_h

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

// What GDCM is not left alone with: it takes wrong sizes and offsets in compressed images for right.

namespace isosurface
{

/// Columns, rows and components that a stream of JPEG, JPEG-LS or JPEG 2000 names. Nothing if it is
/// none, or JPEG 2000 in a file of its own.
std::optional<std::array<std::uint64_t, 3>> FindCompressedSize(
  const std::uint8_t* bytes, std::size_t size);

/// Decodes an image of DICOM's run lengths: appends `count` little-endian samples of `valueSize` bytes.
/// False if it is damaged or truncated. Source: DICOM PS3.5, G.
bool DecodeRunLengths(const std::vector<std::uint8_t>& code, std::size_t count,
  std::size_t valueSize, std::vector<std::uint8_t>& to);

} // namespace isosurface

#endif
