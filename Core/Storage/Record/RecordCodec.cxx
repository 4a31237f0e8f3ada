// SPDX-License-Identifier: BSD-3-Clause
#include "Storage/Record/RecordCodec.h"

#include "Storage/Record/SegmentPrediction.h"

#include <lz4.h>
#include <lz4hc.h>
#include <zstd.h>

#include <algorithm>
#include <cstring>
#include <new>
#include <string>

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

/// Memory that a thread reuses for each block.
struct Workspace
{
  SegmentPrediction Prediction;
  std::vector<std::uint8_t> Filtered;
  std::vector<std::uint8_t> Coded;
  std::vector<std::vector<std::uint8_t>> Samples; ///< decoded, per segment

  static Workspace& OfThisThread()
  {
    thread_local Workspace workspace;
    return workspace;
  }
};

std::uint8_t* Grow(std::vector<std::uint8_t>& bytes, std::size_t size)
{
  bytes.resize(std::max(bytes.size(), size));
  return bytes.data();
}

/// One segment to encode or decode.
struct SegmentTask
{
  SegmentTask(const BlockGrid& grid, std::int64_t block, int level, ValueType type)
    : Grid(grid)
    , Block(block)
    , Level(level)
    , Type(type)
    , Segment(grid, block, level)
    , Count(static_cast<std::size_t>(Segment.GetNumberOfSamples()))
    , Size(Count * GetValueSize(type))
  {
  }

  bool IsCoarsest() const { return this->Level == this->Grid.GetNumberOfLevels() - 1; }

  /// The predictions of a predictor, null if it needs none; `coarser`: the samples of the segments
  /// of all coarser levels.
  const void* Predict(SamplePredictor predictor, const std::vector<const std::uint8_t*>& coarser,
    SegmentPrediction& prediction) const
  {
    if (predictor != SamplePredictor::Coarser)
    {
      return nullptr;
    }
    const auto assembled =
      AssembleLevel(this->Grid, this->Block, this->Level + 1, this->Type, coarser);
    return prediction.Compute(this->Segment, assembled->View);
  }

  const BlockGrid& Grid;
  std::int64_t Block;
  int Level;
  ValueType Type;
  BlockSegment Segment;
  std::size_t Count;
  std::size_t Size; ///< in bytes
};

/// The bytes to store for a segment.
struct EncodedSegment
{
  SegmentCoding Coding;
  const std::uint8_t* Bytes;
  std::uint32_t Stored;
};

/// `samples`: those of the segments from the coarsest level to this one.
EncodedSegment EncodeSegment(const BlockCompression& compression, const SegmentTask& task,
  const std::vector<const std::uint8_t*>& samples, Workspace& workspace)
{
  const EncodedSegment uncompressed = { {}, samples.back(), static_cast<std::uint32_t>(task.Size) };
  const std::size_t limit = task.Size - task.Size / 16;
  if (compression.Codec == SegmentCodec::None || limit == task.Size)
  {
    return uncompressed;
  }
  const SamplePredictor predictor =
    ChoosePredictor(compression.Codec, task.Type, task.IsCoarsest());
  std::uint8_t* filtered = Grow(workspace.Filtered, task.Size);
  const void* predictions = task.Predict(predictor, samples, workspace.Prediction);
  ApplyFilter(predictor, task.Type, samples.back(), task.Count, predictions, filtered);
  std::uint8_t* coded = Grow(workspace.Coded, limit);
  const std::size_t stored = CompressBytes(
    compression.Codec, compression.GetEffectiveLevel(), filtered, task.Size, coded, limit);
  return stored == 0
    ? uncompressed
    : EncodedSegment{ { compression.Codec, predictor }, coded, static_cast<std::uint32_t>(stored) };
}

Status MakeError(
  StatusCode code, const SegmentTask& task, std::uint32_t variable, const char* reason)
{
  return Status(code,
    "block " + std::to_string(task.Block) + ", variable " + std::to_string(variable) + ", level " +
      std::to_string(task.Level) + " " + reason);
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

SamplePredictor ChoosePredictor(SegmentCodec codec, ValueType type, bool isCoarsest)
{
  if (codec != SegmentCodec::Zstd)
  {
    return SamplePredictor::None;
  }
  return IsFloatingType(type) || isCoarsest ? SamplePredictor::Previous : SamplePredictor::Coarser;
}

void EncodeRecord(const BlockCompression& compression, const BlockGrid& grid, std::int64_t block,
  const std::vector<ValueType>& types, BlockRecordLayout& layout, Buffer<std::uint8_t>& record)
{
  Workspace& workspace = Workspace::OfThisThread();
  const auto levels = static_cast<std::size_t>(grid.GetNumberOfLevels());
  workspace.Samples.resize(std::max(workspace.Samples.size(), levels));
  std::uint64_t end = 0;
  for (std::size_t variable = 0; variable < types.size(); ++variable)
  {
    std::vector<const std::uint8_t*> samples;
    for (std::size_t index = 0; index < levels; ++index)
    {
      const std::size_t segment = variable * levels + index;
      const SegmentTask task(grid, block, static_cast<int>(levels - 1 - index), types[variable]);
      const std::uint8_t* from =
        record.GetData() + layout.Offsets[segment] + BlockRecord::SegmentHeaderSize;
      // Finer levels may be predicted from these samples, which compressed bytes will overwrite.
      const bool isNeeded = index + 1 < levels &&
        ChoosePredictor(compression.Codec, types[variable], false) == SamplePredictor::Coarser;
      if (isNeeded && task.Size != 0)
      {
        std::uint8_t* copy = Grow(workspace.Samples[index], task.Size);
        std::memcpy(copy, from, task.Size);
        from = copy;
      }
      samples.push_back(from);
      const EncodedSegment encoded = EncodeSegment(compression, task, samples, workspace);
      std::uint8_t* to = record.GetData() + end;
      if (encoded.Stored != 0 && encoded.Bytes != to + BlockRecord::SegmentHeaderSize)
      {
        // Uncompressed samples may move by less than their length.
        std::memmove(to + BlockRecord::SegmentHeaderSize, encoded.Bytes, encoded.Stored);
      }
      SealSegment(to, encoded.Stored, encoded.Coding,
        { block, static_cast<std::uint32_t>(variable), static_cast<std::uint32_t>(task.Level) });
      layout.Offsets[segment] = end;
      layout.Lengths[segment] = encoded.Stored;
      end += BlockRecord::SegmentHeaderSize + encoded.Stored;
    }
  }
  layout.Size = end;
  std::memset(record.GetData() + end, 0, static_cast<std::size_t>(BlockRecord::AlignUp(end) - end));
}

Result<std::shared_ptr<DecodedBlock>> DecodeLevel(const BlockGrid& grid, std::int64_t block,
  std::uint32_t variable, int level, ValueType type,
  const std::vector<const std::uint8_t*>& segments, const std::vector<std::uint32_t>& stored)
{
  Workspace& workspace = Workspace::OfThisThread();
  workspace.Samples.resize(std::max(workspace.Samples.size(), segments.size()));
  std::vector<const std::uint8_t*> samples;
  for (std::size_t index = 0; index < segments.size(); ++index)
  {
    const SegmentTask task(
      grid, block, grid.GetNumberOfLevels() - 1 - static_cast<int>(index), type);
    const std::uint8_t* bytes = segments[index] + BlockRecord::SegmentHeaderSize;
    const auto coding = LoadSegmentCoding(segments[index]);
    if (!coding)
    {
      return MakeError(StatusCode::Unsupported, task, variable,
        "is stored with a codec or predictor that this version does not know");
    }
    if (coding->Codec == SegmentCodec::None)
    {
      if (stored[index] != task.Size)
      {
        return MakeError(
          StatusCode::Corrupt, task, variable, "does not have the length of its samples");
      }
      samples.push_back(bytes);
      continue;
    }
    if (task.IsCoarsest() && coding->Predictor == SamplePredictor::Coarser)
    {
      return MakeError(StatusCode::Corrupt, task, variable,
        "is predicted from a coarser level, but it is the coarsest");
    }
    std::uint8_t* filtered = Grow(workspace.Filtered, task.Size);
    if (!DecompressBytes(coding->Codec, bytes, stored[index], filtered, task.Size))
    {
      return MakeError(StatusCode::Corrupt, task, variable, "cannot be decompressed");
    }
    const void* predictions = task.Predict(coding->Predictor, samples, workspace.Prediction);
    std::uint8_t* decoded = Grow(workspace.Samples[index], task.Size);
    RevertFilter(coding->Predictor, type, filtered, task.Count, predictions, decoded);
    samples.push_back(decoded);
  }
  return AssembleLevel(grid, block, level, type, samples);
}

} // namespace isosurface
