// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_IntervalTreeFormat_h
#define isosurface_IntervalTreeFormat_h

#include "Ground/Base/PagedFile.h"
#include "Ground/Base/Status.h"
#include "Ground/Volume/ValueKey.h"

#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

namespace isosurface
{

/**
 * A closed interval [Minimum, Maximum] of keys with a payload: usually the value range of a block
 * and its number within its store.
 */
struct KeyInterval
{
  ValueKey Minimum = 0;
  ValueKey Maximum = 0;
  std::uint32_t Payload = 0;

  bool Overlaps(ValueKey low, ValueKey high) const
  {
    return this->Minimum <= high && this->Maximum >= low;
  }
};

/**
 * The contents of the pages of an external interval tree and their bytes, drawn in
 * IntervalTreeFormat.cxx. Decode() checks everything that a page shows by itself, so that a query
 * stays inside the file and ends.
 */
struct IntervalTreeFormat
{
  static constexpr std::uint32_t Version = 1;
  static constexpr PagedFile::Kind Kind = { 'I', 'N', 'T', 'V', 'T', 'R', 'E', 'E' };
  static constexpr std::size_t RecordSize = 20;
  static constexpr std::size_t RecordPageHeaderSize = 8;
  /// No tree comes near this height: with more than one level, the fan-out is at least 28.
  static constexpr std::uint32_t HeightLimit = 32;

  /// B: the records of one page (204 in pages of 4 KiB, 818 in pages of 16 KiB).
  static std::uint32_t GetRecordsPerPage(std::size_t payloadSize);
  /// The fan-out: twice the square root of B, rounded down before doubling (28 in 4 KiB).
  static std::uint32_t GetSlabLimit(std::uint32_t recordsPerPage);
};

/**
 * `Count` consecutive records, beginning with record `Record` of page `Page`. A list of at most B
 * records lies within one page; a longer one begins a page and continues in the next ones.
 */
struct IntervalList
{
  std::uint32_t Page = 0;
  std::uint16_t Record = 0;
  std::uint32_t Count = 0;
};

/// A subtree: nothing (Count 0), a leaf (Height 0: one list of at most B), or a node.
struct IntervalSubtree
{
  IntervalList List; ///< for a node: its page, record 0, and the number of intervals below it
  std::uint32_t Height = 0;
};

/// The entry of a node for the slab (b[i], b[i + 1]] between two of its boundaries.
struct IntervalTreeSlab
{
  static constexpr std::uint16_t NoWindow = 0xffff;

  IntervalList Left;         ///< Minimum in the slab, ascending; all contain its upper boundary
  ValueKey LeftMinimum = 0;  ///< the minimum of all Minimum in Left
  IntervalList Right;        ///< Maximum in the slab, descending; all contain its lower boundary
  ValueKey RightMaximum = 0; ///< the maximum of all Maximum in Right
  IntervalSubtree Child;     ///< the intervals strictly between the boundaries
  std::uint16_t Window = NoWindow; ///< the underflow window with intervals that span the slab
};

/// The intervals that span exactly the slabs First .. Last.
struct IntervalTreeMultislab
{
  std::uint16_t First = 0;
  std::uint16_t Last = 0;
  IntervalList List;
};

/// One internal node.
struct IntervalTreeNode
{
  std::uint32_t Height = 1;
  std::vector<ValueKey> Boundaries; ///< strictly ascending, one less than slabs
  std::vector<IntervalTreeSlab> Slabs;
  std::vector<IntervalTreeMultislab> Multislabs;
  std::vector<IntervalList> Windows;

  /// The slab that holds the key.
  std::size_t FindSlab(ValueKey key) const;

  /// The maximum number of multislab lists that fit in the page of a node of `slabs` slabs.
  static std::size_t GetMultislabLimit(std::size_t payloadSize, std::size_t slabs);
  void Encode(std::size_t payloadSize, std::uint8_t* payload) const;
  /// `page` is the node's page: all pages that it refers to must lie before it.
  static Result<IntervalTreeNode> Decode(
    const PagedFileReader& file, std::uint32_t page, const std::uint8_t* payload);
};

/// The client area of page 0.
struct IntervalTreeHeader
{
  std::uint64_t Count = 0;    ///< intervals in the tree
  std::uint64_t Identity = 0; ///< of what the intervals are of, as the tree's writer says
  IntervalSubtree Root;
  ValueKey Minimum = std::numeric_limits<ValueKey>::max(); ///< of all intervals
  ValueKey Maximum = 0;

  PagedFile::ClientArea Encode() const;
  static Result<IntervalTreeHeader> Decode(const PagedFileReader& file);
};

/// The pages of records.
struct IntervalRecordPage
{
  static void Begin(std::uint8_t* payload);
  static void Put(std::uint8_t* payload, std::uint32_t record, const KeyInterval& interval);
  static bool IsOne(const std::uint8_t* payload);
  static KeyInterval Get(const std::uint8_t* payload, std::uint32_t record);
};

} // namespace isosurface

#endif
