// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_Testing_SealedBytes_h
#define isosurface_Testing_SealedBytes_h

#include "Fixtures/MemoryDisk.h"

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace isosurface
{

/// Bytes that a fuzzer made, with the checksums put right that would stop it at the door. Written
/// after the drawings of the formats, not with Core's writers, which write nothing wrong.
using SealedBytes = std::vector<std::uint8_t>;

/// The input as a paged file: cut to whole pages of the size that it says (or 4096), with the
/// right magic, version, number of pages, kind (8 characters) and checksum of each page.
SealedBytes SealPages(const std::uint8_t* bytes, std::size_t size, const char* kind);

/// Puts the checksum of a segment right; `stored` bytes follow its header of 16.
void SealSegmentBytes(std::uint8_t* segment, std::uint32_t stored, std::int64_t block,
  std::uint32_t array, std::uint32_t level);

/// The text of a JSON document with the value of its last member "checksum" put right, if it has
/// one: the hash of all that stands before that name.
std::string SealJson(std::string text);

/// The input as an edge-index file: the checksums of the header, of its records as far as their
/// sizes go, and of the directory and trailer where a record has the size 0.
SealedBytes SealEdgeIndexFile(const std::uint8_t* bytes, std::size_t size);

/// Puts a file on a disk in memory.
void PutFile(MemoryDisk& disk, const std::string& path, SealedBytes bytes);

} // namespace isosurface

#endif
