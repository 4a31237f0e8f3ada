// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_Hdf5ChunkCoding_h
#define isosurface_Hdf5ChunkCoding_h

#include "Formats/Hdf5/Hdf5Handle.h"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

namespace isosurface
{

/**
 * Decodes chunks of a dataset without the library, and so without its lock: those of plain integers
 * and floats that were shuffled, deflated, both or neither. Others are left to the library.
 */
class Hdf5ChunkCoding
{
public:
  /// Nothing if the dataset has other filters, or samples that need more than a swap of bytes to be
  /// those of the type `native`. The lock is held.
  static std::optional<Hdf5ChunkCoding> Find(const Hdf5Handle& dataset, const Hdf5Handle& plist,
    hid_t native, const StoredArray::Numbers& chunk);

  /// The bytes of a decoded chunk.
  std::size_t GetChunkBytes() const { return this->ChunkBytes; }
  /// Whether a box is a chunk, or what the last one on an axis has of the dataset.
  bool IsChunk(const StoredArray::Numbers& low, const StoredArray::Numbers& size,
    const StoredArray::Numbers& shape) const;
  /// Decodes `stored`, and writes the first `size` samples on each axis to `to`: the last axis
  /// fastest, without gaps. False if the bytes are not those of a chunk.
  bool Decode(
    const std::vector<std::uint8_t>& stored, const StoredArray::Numbers& size, std::uint8_t* to);
  /// Whether `stored` is a code of more or fewer bytes than a chunk has. Of fewer, the library would
  /// read beyond them.
  bool IsOfAnotherSize(const std::vector<std::uint8_t>& stored);

private:
  /// Finds the bytes before the shuffle, which may be those of `stored`, and their number: one more
  /// than a chunk has for any that is larger; nothing if they are no code.
  std::optional<std::size_t> Inflate(
    const std::vector<std::uint8_t>& stored, const std::uint8_t*& bytes);
  void CopyRows(
    const std::uint8_t* samples, const StoredArray::Numbers& size, std::uint8_t* to) const;

  StoredArray::Numbers Chunk;
  std::size_t ValueSize = 1;
  std::size_t ChunkBytes = 0;
  bool IsSwapped = false;
  bool IsShuffled = false;
  bool IsDeflated = false;
  std::vector<std::uint8_t> Inflated;
  std::vector<std::uint8_t> Ordered; ///< after the shuffle was undone
};

} // namespace isosurface

#endif
