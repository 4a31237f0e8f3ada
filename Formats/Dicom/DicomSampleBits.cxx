// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/Dicom/DicomSampleBits.h"

#include <cstring>

namespace isosurface
{
namespace
{

template <typename Word>
std::uint32_t LoadWord(const SampleWords& words, std::size_t number)
{
  Word word;
  std::memcpy(&word, words.First + number * sizeof(Word), sizeof(Word));
  return word;
}

/// Calls `use` with a zero of an unsigned type of that size.
template <typename Use>
void DispatchWord(std::size_t size, Use&& use)
{
  size == 1 ? use(std::uint8_t{}) : size == 2 ? use(std::uint16_t{}) : use(std::uint32_t{});
}

} // namespace

void TakeSamples(
  const SampleWords& words, const SampleBits& bits, std::size_t valueSize, std::uint8_t* to)
{
  const std::uint32_t mask = bits.Count < 32 ? (std::uint32_t{ 1 } << bits.Count) - 1 : ~0u;
  const std::uint32_t sign = bits.IsSigned ? std::uint32_t{ 1 } << (bits.Count - 1) : 0;
  DispatchWord(words.Size,
    [&](auto someWord)
    {
      DispatchWord(valueSize,
        [&](auto someValue)
        {
          for (std::size_t number = 0; number < words.Count; ++number)
          {
            std::uint32_t sample = LoadWord<decltype(someWord)>(words, number) >> bits.Low & mask;
            sample |= (sample & sign) != 0 ? ~mask : 0;
            const auto value = static_cast<decltype(someValue)>(sample);
            std::memcpy(to + number * sizeof(value), &value, sizeof(value));
          }
        });
    });
}

bool HasBitsFrom(const SampleWords& words, int bit)
{
  std::uint32_t all = 0;
  DispatchWord(words.Size,
    [&](auto some)
    {
      for (std::size_t number = 0; number < words.Count; ++number)
      {
        all |= LoadWord<decltype(some)>(words, number);
      }
    });
  return bit < 32 && all >> bit != 0;
}

} // namespace isosurface
