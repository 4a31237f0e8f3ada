// SPDX-License-Identifier: BSD-3-Clause
#include "Coding/EntropyCoding/RangeCoder.h"

namespace isosurface
{

void RangeEncoder::Carry(std::vector<std::uint8_t>& bytes, std::size_t first)
{
  for (std::size_t n = bytes.size(); n > first && ++bytes[--n] == 0;)
  {
  }
}

void RangeEncoder::AppendWord(std::vector<std::uint8_t>& bytes, std::uint32_t word)
{
  const std::uint8_t parts[4] = { static_cast<std::uint8_t>(word >> 24),
    static_cast<std::uint8_t>(word >> 16), static_cast<std::uint8_t>(word >> 8),
    static_cast<std::uint8_t>(word) };
  bytes.insert(bytes.end(), parts, parts + 4);
}

void RangeEncoder::Finish()
{
  for (int size = 1; size <= 8; ++size)
  {
    const std::uint64_t mask = size == 8 ? 0 : ~std::uint64_t(0) >> (8 * size);
    const std::uint64_t up = mask - (this->Low & mask);
    const std::uint64_t step = (this->Low & mask) == 0 ? 0 : up + 1;
    if (step < this->Range)
    {
      this->Advance(step);
      for (int n = 0; n < size; ++n)
      {
        this->Bytes->push_back(static_cast<std::uint8_t>(this->Low >> (56 - 8 * n)));
      }
      return;
    }
  }
}

std::uint32_t RangeDecoder::ReadLastWord()
{
  std::uint32_t word = 0;
  for (int n = 0; n < 4; ++n)
  {
    std::uint8_t byte = 0;
    if (this->Next != this->End)
    {
      byte = *this->Next++;
    }
    else
    {
      this->Missing += this->Missing <= 8 ? 1 : 0;
    }
    word = word << 8 | byte;
  }
  return word;
}

} // namespace isosurface
