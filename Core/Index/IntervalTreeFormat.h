// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_IntervalTreeFormat_h
#define isosurface_IntervalTreeFormat_h

#include "Base/Status.h"
#include "Index/KeyInterval.h"
#include "Index/PagedFile.h"

#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

namespace isosurface
{

/**
 * The pages of an external interval tree: what they hold, and its bytes. See the drawings in
 * IntervalTreeFormat.cxx. Decoding checks all that the bytes alone can tell, so that whoever walks
 * the tree stays inside the file and comes to an end.
 */
struct IntervalTreeFormat
{
  static constexpr std::uint32_t Version = 1;
  static constexpr PagedFile::Kind Kind = { 'I', 'N', 'T', 'V', 'T', 'R', 'E', 'E' };
  static constexpr std::size_t RecordSize = 20;
  static constexpr std::size_t RecordPageHeaderSize = 8;
  /// No tree comes near it: the fan-out is at least 28 where there is more than one level.
  static constexpr std::uint32_t HeightLimit = 32;

  /// B: the records of one page (204 in pages of 4 KiB, 818 in pages of 16 KiB).
  static std::uint32_t GetRecordsPerPage(std::size_t payloadSize);
  /// The fan-out: twice the square root of B, rounded down before doubling (28 in 4 KiB).
  static std::uint32_t GetSlabLimit(std::uint32_t recordsPerPage);
};

/**
 * Consecutive records, `Count` of them from record `Record` of page `Page` on. A list of at most B
 * records lies within one page; a longer one begins a page and goes on in the pages that follow.
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
  IntervalList List; ///< of a node: its page, record 0, and how many intervals are below
  std::uint32_t Height = 0;
};

/// What a node keeps for the slab (b[i], b[i + 1]] between two of its boundaries.
struct IntervalTreeSlab
{
  static constexpr std::uint16_t NoWindow = 0xffff;

  IntervalList Left;         ///< Minimum in the slab, ascending; all contain its upper boundary
  ValueKey LeftMinimum = 0;  ///< the least Minimum in Left
  IntervalList Right;        ///< Maximum in the slab, descending; all contain its lower boundary
  ValueKey RightMaximum = 0; ///< the greatest Maximum in Right
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

  /// How many multislab lists fit beside the rest.
  static std::size_t GetMultislabLimit(std::size_t payloadSize, std::size_t slabs);
  void Encode(std::size_t payloadSize, std::uint8_t* payload) const;
  /// `page` is the node's own number: all it refers to lies before it, for it is written last.
  static Result<IntervalTreeNode> Decode(
    const PagedFileReader& file, std::uint32_t page, const std::uint8_t* payload);
};

/// What the client area of page 0 tells of the tree.
struct IntervalTreeHeader
{
  std::uint64_t Count = 0; ///< intervals in the tree
  IntervalSubtree Root;
  ValueKey Least = std::numeric_limits<ValueKey>::max(); ///< of all Minimum
  ValueKey Greatest = 0;                                 ///< of all Maximum

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
