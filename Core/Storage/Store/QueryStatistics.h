// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_QueryStatistics_h
#define isosurface_QueryStatistics_h

#include <cstdint>

namespace isosurface
{

/// The cost of queries and reads of a blocked volume. Each thread has its own; Add() joins them.
struct QueryStatistics
{
  std::uint64_t TreePagesRead = 0;      ///< pages of interval trees read from disk
  std::uint64_t TreePageCacheHits = 0;  ///< pages of interval trees found in memory
  std::uint64_t IntervalsReported = 0;  ///< by the trees, before exact filtering
  std::uint64_t ActiveBlocks = 0;       ///< blocks that an isosurface crosses, in this rank's share
  std::uint64_t DirectoryPagesRead = 0; ///< pages of block directories read from disk
  std::uint64_t BlocksRead = 0;         ///< reads of blocks from disk, each of adjacent components
  std::uint64_t BytesRead = 0;          ///< bytes of blocks read from disk
  std::uint64_t BlockCacheHits = 0;     ///< blocks found in the block cache
  double QuerySeconds = 0;              ///< in trees and directories
  double ReadSeconds = 0;               ///< in reading and decoding blocks

  void Add(const QueryStatistics& other)
  {
    this->TreePagesRead += other.TreePagesRead;
    this->TreePageCacheHits += other.TreePageCacheHits;
    this->IntervalsReported += other.IntervalsReported;
    this->ActiveBlocks += other.ActiveBlocks;
    this->DirectoryPagesRead += other.DirectoryPagesRead;
    this->BlocksRead += other.BlocksRead;
    this->BytesRead += other.BytesRead;
    this->BlockCacheHits += other.BlockCacheHits;
    this->QuerySeconds += other.QuerySeconds;
    this->ReadSeconds += other.ReadSeconds;
  }
};

} // namespace isosurface

#endif
