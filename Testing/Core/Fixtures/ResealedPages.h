// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_ResealedPages_h
#define isosurface_ResealedPages_h

#include "Ground/Base/Checksum.h"
#include "Ground/Base/Coding.h"
#include "Ground/Base/PagedFile.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace isosurface
{

/// Computes the checksum of a page of a paged file of 4096 bytes a page again; returns it.
inline std::uint64_t ResealPage(std::vector<std::uint8_t>& bytes, std::size_t page)
{
  constexpr std::size_t size = PagedFile::DefaultPageSize;
  std::uint8_t* begin = bytes.data() + page * size;
  const std::uint64_t checksum = ComputeChecksum(begin, size - PagedFile::ChecksumSize, page);
  StoreLittleEndian(begin + size - PagedFile::ChecksumSize, checksum);
  return checksum;
}

/// Makes a changed file of 4096 bytes a page consistent in itself: checksums of all complete pages,
/// and their sums, by the groups that page 0 states.
inline void ResealPages(std::vector<std::uint8_t>& bytes)
{
  constexpr std::size_t size = PagedFile::DefaultPageSize;
  const auto group = LoadLittleEndian<std::uint64_t>(bytes.data() + PagedFile::SumsOffset - 8);
  const std::size_t pages = bytes.size() / size;
  std::vector<std::uint64_t> sums(group == 0 ? 0 : PagedFile::GetSumLimit(size));
  for (std::size_t page = 1; page < pages; ++page)
  {
    const std::uint64_t checksum = ResealPage(bytes, page);
    if (group != 0 && (page - 1) / group < sums.size())
    {
      sums[static_cast<std::size_t>((page - 1) / group)] += checksum;
    }
  }
  for (std::size_t index = 0; index < sums.size(); ++index)
  {
    StoreLittleEndian(bytes.data() + PagedFile::SumsOffset + 8 * index, sums[index]);
  }
  ResealPage(bytes, 0);
}

/// Makes a paged file one without sums, as early writers made them.
inline void RemoveSums(std::vector<std::uint8_t>& bytes)
{
  constexpr std::size_t begin = PagedFile::SumsOffset - 8;
  constexpr std::size_t end = PagedFile::DefaultPageSize - PagedFile::ChecksumSize;
  std::fill(bytes.begin() + begin, bytes.begin() + end, std::uint8_t{ 0 });
  ResealPage(bytes, 0);
}

} // namespace isosurface

#endif
