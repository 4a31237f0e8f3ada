// SPDX-License-Identifier: BSD-3-Clause
#include "Storage/Record/ByteCodec.h"

#include <lz4.h>
#include <lz4hc.h>
#include <zstd.h>

#include <algorithm>
#include <memory>
#include <new>
#include <vector>

namespace isosurface
{
namespace
{

/// LZ4's thorough encoder works from this level on; below it, all levels are the fast encoder.
constexpr int FirstThoroughLevel = 3;

/// LZ4's interface takes less than 2 GiB; a segment has at most 67^3 samples of 8 bytes.
constexpr std::size_t MaximumSize = LZ4_MAX_INPUT_SIZE;

struct ZstdDeleter
{
  void operator()(ZSTD_CCtx* context) const { ZSTD_freeCCtx(context); }
  void operator()(ZSTD_DCtx* context) const { ZSTD_freeDCtx(context); }
};

template <typename Context>
using ZstdContext = std::unique_ptr<Context, ZstdDeleter>;

/// A context, or std::bad_alloc if the library could not make it.
template <typename Context>
Context* Demand(const ZstdContext<Context>& context)
{
  if (!context)
  {
    throw std::bad_alloc();
  }
  return context.get();
}

std::size_t CompressLz4(
  int level, const std::uint8_t* from, std::size_t size, std::uint8_t* to, std::size_t capacity)
{
  thread_local std::vector<std::uint64_t> state;
  const bool isThorough = level >= FirstThoroughLevel;
  const auto bytes = static_cast<std::size_t>(isThorough ? LZ4_sizeofStateHC() : LZ4_sizeofState());
  state.resize(std::max(state.size(), (bytes + 7) / 8));
  const auto* source = reinterpret_cast<const char*>(from);
  auto* target = reinterpret_cast<char*>(to);
  const int limit = static_cast<int>(std::min(capacity, MaximumSize));
  const int stored = isThorough
    ? LZ4_compress_HC_extStateHC(state.data(), source, target, static_cast<int>(size), limit, level)
    : LZ4_compress_fast_extState(state.data(), source, target, static_cast<int>(size), limit, 1);
  return static_cast<std::size_t>(std::max(0, stored));
}

std::size_t CompressZstd(
  int level, const std::uint8_t* from, std::size_t size, std::uint8_t* to, std::size_t capacity)
{
  thread_local const ZstdContext<ZSTD_CCtx> context(ZSTD_createCCtx());
  const std::size_t stored = ZSTD_compressCCtx(Demand(context), to, capacity, from, size, level);
  return ZSTD_isError(stored) != 0 ? 0 : stored;
}

} // namespace

std::size_t CompressBytes(SegmentCodec codec, int level, const std::uint8_t* from, std::size_t size,
  std::uint8_t* to, std::size_t capacity)
{
  if (size > MaximumSize || capacity == 0)
  {
    return 0;
  }
  switch (codec)
  {
    case SegmentCodec::Lz4:
      return CompressLz4(level, from, size, to, capacity);
    case SegmentCodec::Zstd:
      return CompressZstd(level, from, size, to, capacity);
    case SegmentCodec::None:
      break;
  }
  return 0;
}

bool DecompressBytes(SegmentCodec codec, const std::uint8_t* from, std::size_t stored,
  std::uint8_t* to, std::size_t size)
{
  if (stored > MaximumSize || size > MaximumSize)
  {
    return false;
  }
  switch (codec)
  {
    case SegmentCodec::Lz4:
      return LZ4_decompress_safe(reinterpret_cast<const char*>(from), reinterpret_cast<char*>(to),
               static_cast<int>(stored), static_cast<int>(size)) == static_cast<int>(size);
    case SegmentCodec::Zstd:
    {
      thread_local const ZstdContext<ZSTD_DCtx> context(ZSTD_createDCtx());
      return ZSTD_decompressDCtx(Demand(context), to, size, from, stored) == size;
    }
    case SegmentCodec::None:
      break;
  }
  return false;
}

} // namespace isosurface
