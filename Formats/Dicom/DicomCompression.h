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

/// What a compressed image says of itself.
struct CompressedForm
{
  std::array<std::uint64_t, 3> Size{}; ///< columns, rows and components
  int Bits = 0;                        ///< of a sample, 1 to 128
  bool IsSigned = false;               ///< JPEG 2000 alone tells
  bool IsJpeg = false;                 ///< whether it is the first JPEG, not JPEG-LS or JPEG 2000
};

/// What a stream of JPEG, JPEG-LS or JPEG 2000, also one in a JP2 file, names before its first sample.
/// Nothing if it is none, or damaged up to there. Source: ISO/IEC 10918-1, B; 14495-1, C; 15444-1, A
/// and I.
std::optional<CompressedForm> FindCompressedForm(const std::uint8_t* bytes, std::size_t size);

/// Decodes an image of DICOM's run lengths: appends `count` little-endian samples of `valueSize` bytes.
/// False if it is damaged or truncated. Source: DICOM PS3.5, G.
bool DecodeRunLengths(const std::vector<std::uint8_t>& code, std::size_t count,
  std::size_t valueSize, std::vector<std::uint8_t>& to);

} // namespace isosurface

#endif
