// SPDX-License-Identifier: BSD-3-Clause
#include "Store/PackedCounts.h"

namespace isosurface
{
namespace
{

void AppendNumber(std::uint64_t number, std::vector<std::uint8_t>& bytes)
{
  for (; number >= 128; number >>= 7)
  {
    bytes.push_back(static_cast<std::uint8_t>(number | 128));
  }
  bytes.push_back(static_cast<std::uint8_t>(number));
}

bool TakeNumber(
  const std::uint8_t* bytes, std::size_t size, std::size_t& position, std::uint64_t& number)
{
  number = 0;
  for (int shift = 0; shift < 64 && position < size; shift += 7)
  {
    const std::uint64_t byte = bytes[position++];
    if (shift == 63 && byte > 1)
    {
      return false;
    }
    number |= (byte & 127) << shift;
    if (byte < 128)
    {
      return true;
    }
  }
  return false;
}

} // namespace

void AppendPackedCounts(const std::vector<std::uint64_t>& counts, std::vector<std::uint8_t>& bytes)
{
  std::uint64_t before = 0;
  for (std::size_t index = 0; index < counts.size();)
  {
    const std::uint64_t difference = counts[index] - before;
    before = counts[index++];
    const std::uint64_t sign = difference >> 63 == 0 ? 0 : ~std::uint64_t{ 0 };
    AppendNumber((difference << 1) ^ sign, bytes);
    if (difference == 0)
    {
      const std::size_t first = index;
      while (index < counts.size() && counts[index] == before)
      {
        ++index;
      }
      AppendNumber(index - first, bytes);
    }
  }
}

bool TakePackedCounts(const std::uint8_t* bytes, std::size_t size, std::size_t& position,
  std::vector<std::uint64_t>& counts)
{
  std::uint64_t count = 0;
  for (std::size_t index = 0; index < counts.size();)
  {
    std::uint64_t zigzag;
    if (!TakeNumber(bytes, size, position, zigzag))
    {
      return false;
    }
    count += (zigzag >> 1) ^ (~(zigzag & 1) + 1);
    counts[index++] = count;
    if (zigzag == 0)
    {
      std::uint64_t more;
      if (!TakeNumber(bytes, size, position, more) || more > counts.size() - index)
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
