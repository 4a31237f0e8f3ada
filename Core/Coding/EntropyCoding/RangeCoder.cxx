// SPDX-License-Identifier: BSD-3-Clause
#include "Coding/EntropyCoding/RangeCoder.h"

namespace isosurface
{

void RangeEncoder::Carry()
{
  for (std::size_t n = this->Bytes.size(); n > this->First && ++this->Bytes[--n] == 0;)
  {
  }
}

void RangeEncoder::WriteWord()
{
  const std::uint8_t word[4] = { static_cast<std::uint8_t>(this->Low >> 56),
    static_cast<std::uint8_t>(this->Low >> 48), static_cast<std::uint8_t>(this->Low >> 40),
    static_cast<std::uint8_t>(this->Low >> 32) };
  this->Bytes.insert(this->Bytes.end(), word, word + 4);
  this->Low <<= 32;
  this->Range <<= 32;
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
        this->Bytes.push_back(static_cast<std::uint8_t>(this->Low >> (56 - 8 * n)));
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
