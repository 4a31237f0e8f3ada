// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_BlockCompression_h
#define isosurface_BlockCompression_h

#include "Record/SegmentFilter.h"

#include <cstdint>
#include <optional>
#include <string>

namespace isosurface
{

/// How the bytes of a segment are coded. The numbers are part of the file format.
enum class SegmentCodec : std::uint8_t
{
  None = 0, ///< as they are
  Lz4 = 1,  ///< one LZ4 block
  Zstd = 2  ///< one Zstandard frame
};

/// "none", "lz4", "zstd", as the file header has it; and back.
const char* GetCodecName(SegmentCodec codec);
std::optional<SegmentCodec> FindCodec(const std::string& name);

/**
 * What a writer is to do with segments. A segment that would not shrink by a sixteenth is stored as
 * it is, whatever is asked for here.
 */
struct BlockCompression
{
  SegmentCodec Codec = SegmentCodec::None;
  /// How hard the codec tries: 1 to 12 for lz4, 1 to 19 for zstd; 0 is the codec's default, 1.
  int Level = 0;
  /// Instead of the filter that ChooseFilter() gives each segment; for measurements.
  std::optional<SegmentFilter> Filter;

  /// 0 where there is nothing to choose; else the level that is meant.
  int GetEffectiveLevel() const;
  /// Whether codec and level are possible together.
  bool IsValid() const;
};

} // namespace isosurface

#endif
