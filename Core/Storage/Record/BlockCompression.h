// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_BlockCompression_h
#define isosurface_BlockCompression_h

#include <cstdint>
#include <optional>
#include <string>

namespace isosurface
{

/// How the bytes of a segment are compressed. The numbers are part of the file format.
enum class SegmentCodec : std::uint8_t
{
  None = 0, ///< not at all
  Lz4 = 1,  ///< one LZ4 block
  Zstd = 2  ///< one Zstandard frame
};

/// "none", "lz4", "zstd", as in the file header. Null: no codec has this number.
const char* GetCodecName(SegmentCodec codec);
/// The codec of a name, or nothing.
std::optional<SegmentCodec> FindCodec(const std::string& name);

/// How a writer compresses segments. A segment that would not shrink by at least a sixteenth is
/// stored uncompressed, with every Codec.
struct BlockCompression
{
  SegmentCodec Codec = SegmentCodec::None;
  /// The codec's own level: 1 to 12 for lz4, 1 to 19 for zstd; 0 is the default, 1.
  int Level = 0;

  /// Level with its default resolved; 0 without a codec.
  int GetEffectiveLevel() const;
  /// Whether the codec has the level.
  bool IsValid() const;
};

} // namespace isosurface

#endif
