// SPDX-License-Identifier: BSD-3-Clause
#include "Storage/Store/PackedCounts.h"

#include <cstddef>

namespace isosurface
{

void AppendPackedCounts(const std::vector<std::uint64_t>& counts, std::vector<std::uint8_t>& bytes)
{
  std::uint64_t before = 0;
  for (std::size_t index = 0; index < counts.size();)
  {
    const std::uint64_t difference = counts[index] - before;
    before = counts[index++];
    AppendSignedVarint(bytes, static_cast<std::int64_t>(difference));
    if (difference == 0)
    {
      const std::size_t first = index;
      while (index < counts.size() && counts[index] == before)
      {
        ++index;
      }
      AppendVarint(bytes, index - first);
    }
  }
}

bool ReadPackedCounts(ByteReader& reader, std::vector<std::uint64_t>& counts)
{
  std::uint64_t count = 0;
  for (std::size_t index = 0; index < counts.size();)
  {
    const std::int64_t difference = reader.ReadSignedVarint();
    if (reader.HasFailed())
    {
      return false;
    }
    count += static_cast<std::uint64_t>(difference);
    counts[index++] = count;
    if (difference == 0)
    {
      auto more = reader.ReadVarint();
      if (reader.HasFailed() || more > counts.size() - index)
      {
        return false;
      }
      for (; more > 0; --more)
      {
        counts[index++] = count;
      }
    }
  }
  return true;
}

} // namespace isosurface
