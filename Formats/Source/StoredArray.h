// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_StoredArray_h
#define isosurface_StoredArray_h

#include "Ground/Base/Status.h"
#include "Ground/Volume/ValueType.h"

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace isosurface
{

/// An array of any number of axes in a file, of which boxes can be read: a dataset of HDF5, a
/// variable of NetCDF, an array of Zarr. Axes are counted from the slowest one.
class StoredArray
{
public:
  using Numbers = std::vector<std::int64_t>;

  virtual ~StoredArray() = default;

  /// The file and the array in it, for messages.
  virtual const std::string& GetName() const = 0;
  /// Samples on each axis.
  virtual const Numbers& GetShape() const = 0;
  /// The type that Read() gives; the file may have another one (floats of 16 bits).
  virtual ValueType GetType() const = 0;
  /// Samples on each axis that are decoded together; empty if any sample can be read alone.
  virtual Numbers GetChunk() const { return {}; }
  /// Whether several open ones of the same file, each of a thread, decode chunks at the same time.
  virtual bool DecodesInParallel() const { return false; }
  /// What decoded chunks may take between reads.
  virtual std::uint64_t GetCacheBytes() const { return 0; }
  /// The maximum memory for reading, besides the samples: decoded chunks, a conversion buffer.
  virtual std::uint64_t GetHeldBytes() const = 0;

  /// Reads the box of `size` samples from `low` on, which must be within the shape: the last axis
  /// fastest, without gaps, in the byte order of the machine. One thread at a time. Errors name the
  /// file, the array and the reason.
  virtual Status Read(const Numbers& low, const Numbers& size, std::uint8_t* to) = 0;
};

/// "64 x 512 x 512".
std::string JoinNumbers(const StoredArray::Numbers& numbers);

/// What an axis of an array stands for. A number is that of the axis, -1 if there is none.
struct ArrayAxes
{
  int X = -1;
  int Y = -1;
  int Z = -1;
  int Time = -1;
  int Channel = -1;

  /// From a letter an axis, the slowest first: x, y and z, and perhaps t and c, each once. An empty
  /// text stands for "zyx", "tzyx" or "tczyx", as `rank` wants. Error: a sentence without a file.
  static Result<ArrayAxes> Parse(const std::string& letters, std::size_t rank);
  /// The letter of an axis of that name: "z" of "Depth"; "?" if the name tells none.
  static char FindLetter(const std::string& name);
  /// The letters of all axes. `known`: the letters that a file tells, "?" for other axes; or empty. Other
  /// axes have the letters that Parse() takes without any; but a last axis of one sample behind three or four
  /// axes, or of up to four samples behind longer axes, has components. `told` gets a sentence about each axis
  /// that is not certain, with the `names` of the axes, if they have some.
  static std::string Guess(const StoredArray::Numbers& shape, const std::string& known,
    const std::string& names, std::string& told);
};

/// What decoded chunks may take so that slabs do not decode a chunk again that they share.
struct ChunkCacheSize
{
  double ChunkBytes = 0;       ///< a decoded chunk
  std::size_t Bytes = 0;       ///< a slab of chunks and one more, or all that is allowed
  std::size_t Slots = 0;       ///< of HDF5's hash table: ten for each chunk, as its guide advises
  std::uint64_t HeldBytes = 0; ///< Bytes, and a chunk beside the cache with its encoded bytes
};

/// The size for boxes that are as wide as the last three axes but the first of them. The chunk has
/// as many axes as the shape.
ChunkCacheSize FindChunkCacheSize(const StoredArray::Numbers& shape,
  const StoredArray::Numbers& chunk, std::size_t valueSize, std::uint64_t cacheBytes);

} // namespace isosurface

#endif
