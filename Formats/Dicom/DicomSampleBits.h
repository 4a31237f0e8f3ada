// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_DicomSampleBits_h
#define isosurface_DicomSampleBits_h

#include <cstddef>
#include <cstdint>

namespace isosurface
{

/// Which bits of a word are a sample. What is in the others means nothing, or is an overlay.
struct SampleBits
{
  int Low = 0;           ///< the number of the lowest
  int Count = 16;        ///< with Low at most those of the word
  bool IsSigned = false; ///< whether the highest of them is a sign
};

/// Words in the byte order of this machine.
struct SampleWords
{
  const std::uint8_t* First = nullptr;
  std::size_t Size = 2; ///< bytes of each: 1, 2 or 4
  std::size_t Count = 0;
};

/// Makes integers of `valueSize` bytes (1, 2 or 4, no fewer than those of the words) of the samples.
/// `to` may be the words themselves, if they are as large.
/// Source: DICOM PS3.5, 8.1.1.
void TakeSamples(
  const SampleWords& words, const SampleBits& bits, std::size_t valueSize, std::uint8_t* to);

/// Whether some word has a bit of this number or above.
bool HasBitsFrom(const SampleWords& words, int bit);

} // namespace isosurface

#endif
