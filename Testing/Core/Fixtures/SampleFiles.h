// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_Testing_SampleFiles_h
#define isosurface_Testing_SampleFiles_h

#include "Fixtures/MemoryDisk.h"
#include "Fixtures/Require.h"
#include "Fixtures/SampleVolume.h"
#include "Formats/Plain/RawVolume.h"

#include <gtest/gtest.h>
#include <zlib.h>

#include <algorithm>
#include <cstring>
#include <string>
#include <vector>

namespace isosurface
{

using Bytes = std::vector<std::uint8_t>;

inline void WriteFile(MemoryDisk& disk, const std::string& path, const Bytes& bytes)
{
  auto file = Require(disk.CreateForWriting(path));
  ASSERT_TRUE(file->Append(bytes.data(), bytes.size()).IsOk());
}

inline Bytes MakeBytes(const std::string& text)
{
  Bytes bytes(text.size());
  std::copy(text.begin(), text.end(), bytes.begin());
  return bytes;
}

/// Compresses bytes by gzip, or by zlib with 15 window bits.
inline Bytes Deflate(const Bytes& bytes, int windowBits = 15 + 16)
{
  z_stream stream = {};
  EXPECT_EQ(deflateInit2(&stream, 1, Z_DEFLATED, windowBits, 8, Z_DEFAULT_STRATEGY), Z_OK);
  Bytes result(deflateBound(&stream, bytes.size()) + 64);
  stream.next_in = const_cast<Bytef*>(bytes.data());
  stream.avail_in = static_cast<uInt>(bytes.size());
  stream.next_out = result.data();
  stream.avail_out = static_cast<uInt>(result.size());
  EXPECT_EQ(deflate(&stream, Z_FINISH), Z_STREAM_END);
  result.resize(stream.total_out);
  deflateEnd(&stream);
  return result;
}

template <typename T>
Bytes MakeBytes(const SampleVolume<T>& volume, bool isBigEndian = false)
{
  Bytes bytes(volume.Samples.size() * sizeof(T));
  std::memcpy(bytes.data(), volume.Samples.data(), bytes.size());
  for (std::size_t sample = 0; isBigEndian && sample < volume.Samples.size(); ++sample)
  {
    std::reverse(bytes.begin() + static_cast<std::ptrdiff_t>(sample * sizeof(T)),
      bytes.begin() + static_cast<std::ptrdiff_t>((sample + 1) * sizeof(T)));
  }
  return bytes;
}

/// Samples that differ from their neighbours.
template <typename T>
SampleVolume<T> MakeRamp(const Index3& size)
{
  return SampleVolume<T>(
    size, [](auto i, auto j, auto k) { return i * 7 + j * 31 + k * 257 - 50; });
}

/// Checks that a source gives the volume's samples, in boxes of all kinds.
template <typename T>
void ExpectSamples(BoxSource& source, const SampleVolume<T>& volume)
{
  const VertexBox whole = { { 0, 0, 0 }, volume.GetDimensions() };
  ASSERT_TRUE(source.GetBox() == whole);
  const Index3 size = volume.GetDimensions();
  const VertexBox boxes[] = { whole, { { 0, 0, size[2] - 1 }, size },
    { { 0, 0, 0 }, { size[0], size[1], 1 } }, { { 0, 1, 0 }, { size[0], size[1] - 1, size[2] } },
    { { 1, 1, 1 }, { size[0] - 1, size[1], size[2] } },
    { { 0, 0, size[2] / 2 }, { size[0], size[1], size[2] / 2 + 1 } } };
  for (const VertexBox& box : boxes)
  {
    const auto slab = Require(source.Read(box));
    ASSERT_TRUE(slab.Fits({ ValueTypeOf<T>::Value }, box));
    ExpectSamples(slab.Arrays[0], box, volume);
  }
}

} // namespace isosurface

#endif
