// SPDX-License-Identifier: BSD-3-Clause
#include "Storage/Record/BlockCompression.h"

#include "Ground/Base/EnumeratorNames.h"

#include <algorithm>

namespace isosurface
{
namespace
{

struct CodecTraits
{
  const char* Name;
  int MaximumLevel;
};

/// Without a name if no codec has this number.
CodecTraits GetTraits(SegmentCodec codec)
{
  switch (codec)
  {
    case SegmentCodec::None:
      return { "none", 0 };
    case SegmentCodec::Lz4:
      return { "lz4", 12 };
    case SegmentCodec::Zstd:
      return { "zstd", 19 };
  }
  return { nullptr, 0 };
}

} // namespace

const char* GetCodecName(SegmentCodec codec)
{
  return GetTraits(codec).Name;
}

std::optional<SegmentCodec> FindCodec(const std::string& name)
{
  return FindEnumerator(name, GetCodecName);
}

int BlockCompression::GetEffectiveLevel() const
{
  return this->Codec == SegmentCodec::None ? 0 : std::max(1, this->Level);
}

bool BlockCompression::IsValid() const
{
  const CodecTraits traits = GetTraits(this->Codec);
  return traits.Name && this->Level >= 0 &&
    (this->Codec == SegmentCodec::None || this->Level <= traits.MaximumLevel);
}

} // namespace isosurface
