// SPDX-License-Identifier: BSD-3-Clause
#include "Storage/Record/BlockCompression.h"

#include <algorithm>
#include <array>
#include <cstddef>

namespace isosurface
{
namespace
{

struct CodecTraits
{
  const char* Name;
  int MaximumLevel;
};

constexpr std::array<CodecTraits, 3> Codecs = { { { "none", 0 }, { "lz4", 12 }, { "zstd", 19 } } };

} // namespace

const char* GetCodecName(SegmentCodec codec)
{
  return Codecs[static_cast<std::size_t>(codec)].Name;
}

std::optional<SegmentCodec> FindCodec(const std::string& name)
{
  const auto found = std::find_if(
    Codecs.begin(), Codecs.end(), [&](const CodecTraits& codec) { return codec.Name == name; });
  if (found == Codecs.end())
  {
    return std::nullopt;
  }
  return static_cast<SegmentCodec>(found - Codecs.begin());
}

int BlockCompression::GetEffectiveLevel() const
{
  return this->Codec == SegmentCodec::None ? 0 : std::max(1, this->Level);
}

bool BlockCompression::IsValid() const
{
  const auto index = static_cast<std::size_t>(this->Codec);
  return index < Codecs.size() && this->Level >= 0 &&
    (this->Codec == SegmentCodec::None || this->Level <= Codecs[index].MaximumLevel);
}

} // namespace isosurface
