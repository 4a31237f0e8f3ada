// SPDX-License-Identifier: BSD-3-Clause
#include "Storage/Index/IntervalTreeFormat.h"

#include "Ground/Base/Coding.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <string>

namespace isosurface
{

// The client area of page 0 (offsets are within the client area):
//
//     +----+-----------------------------------------------------------+
//     |  0 | tree version (uint32)                                     |
//     |  4 | zeros (uint32)                                            |
//     |  8 | number of intervals, N (uint64)                           |
//     | 16 | minimum of all intervals (uint64)  a query outside this   |
//     | 24 | maximum of all intervals (uint64)  range reads no page    |
//     | 32 | root: subtree reference (12)                              |
//     | 44 | zeros (uint32)                                            |
//     | 48 | identity of what the intervals are of (uint64)            |
//     | 56 | zeros                                                     |
//     +----+-----------------------------------------------------------+
//
// A list reference is 10 bytes, a subtree reference 12:
//
//     +----+--------------------------+      +----+--------------------------+
//     |  0 | page (uint32)            |      |  0 | list reference (10)      |
//     |  4 | first record (uint16)    |      | 10 | height (uint16), 0: leaf |
//     |  6 | number of records (u32)  |      +----+--------------------------+
//     +----+--------------------------+
//
// A page of records, B = (PageSize - 16) / 20 of them. A page may hold (parts of) several lists:
//
//     +----------+-----------------------------------------------------+
//     |        0 | tag "RECS"                                          |
//     |        4 | zeros (uint32)                                      |
//     | 8 + 20 r | record r: Minimum (uint64), Maximum (uint64),       |
//     |          |           payload (uint32)                          |
//     |      ... | unused records are zeros                            |
//     +----------+-----------------------------------------------------+
//
// A page of one node with s slabs (s - 1 boundaries), m multislab lists, w underflow windows:
//
//     +-----------------+----------------------------------------------+
//     |               0 | tag "NODE"                                   |
//     |               4 | height (uint16)                              |
//     |               6 | s (uint16), 2 <= s <= 2 floor(sqrt(B))       |
//     |               8 | m (uint16)                                   |
//     |              10 | w (uint16)                                   |
//     |              12 | zeros (uint32)                               |
//     |              16 | s - 1 boundaries (uint64), ascending         |
//     |         8 + 8 s | s slabs of 50 bytes:                         |
//     |                 |    0 left list (10)                          |
//     |                 |   10 minimum of the left list (uint64)       |
//     |                 |   18 right list (10)                         |
//     |                 |   28 maximum of the right list (uint64)      |
//     |                 |   36 child: subtree reference (12)           |
//     |                 |   48 underflow window (uint16), 65535: none  |
//     |        8 + 58 s | m multislab lists of 14 bytes:               |
//     |                 |    0 first slab (uint16)                     |
//     |                 |    2 last slab (uint16)                      |
//     |                 |    4 list (10)                               |
//     | 8 + 58 s + 14 m | w underflow windows: list (10)               |
//     +-----------------+----------------------------------------------+

namespace
{

constexpr std::uint32_t RecordTag = 0x53434552; // "RECS"
constexpr std::uint32_t NodeTag = 0x45444f4e;   // "NODE"

constexpr std::size_t ListSize = 10;
constexpr std::size_t SubtreeSize = 12;
constexpr std::size_t NodeHeaderSize = 16;
constexpr std::size_t SlabSize = 50;
constexpr std::size_t MultislabSize = 14;

std::size_t GetNodeSize(std::size_t slabs, std::size_t multislabs, std::size_t windows)
{
  return NodeHeaderSize + 8 * (slabs - 1) + SlabSize * slabs + MultislabSize * multislabs +
    ListSize * windows;
}

void StoreList(std::uint8_t* bytes, const IntervalList& list)
{
  StoreLittleEndian(bytes, list.Page);
  StoreLittleEndian(bytes + 4, list.Record);
  StoreLittleEndian(bytes + 6, list.Count);
}

IntervalList LoadList(const std::uint8_t* bytes)
{
  IntervalList list;
  list.Page = LoadLittleEndian<std::uint32_t>(bytes);
  list.Record = LoadLittleEndian<std::uint16_t>(bytes + 4);
  list.Count = LoadLittleEndian<std::uint32_t>(bytes + 6);
  return list;
}

void StoreSubtree(std::uint8_t* bytes, const IntervalSubtree& subtree)
{
  StoreList(bytes, subtree.List);
  StoreLittleEndian(bytes + ListSize, static_cast<std::uint16_t>(subtree.Height));
}

IntervalSubtree LoadSubtree(const std::uint8_t* bytes)
{
  IntervalSubtree subtree;
  subtree.List = LoadList(bytes);
  subtree.Height = LoadLittleEndian<std::uint16_t>(bytes + ListSize);
  return subtree;
}

/// Whether the list lies in pages 1 .. endPage - 1, in a layout that lists have.
bool IsListValid(const IntervalList& list, std::uint64_t endPage, std::uint32_t recordsPerPage)
{
  if (list.Count == 0)
  {
    return true;
  }
  const std::uint64_t pages =
    (std::uint64_t(list.Record) + list.Count + recordsPerPage - 1) / recordsPerPage;
  return list.Page >= 1 && list.Page + pages <= endPage && list.Record < recordsPerPage &&
    (pages == 1 || list.Record == 0);
}

/// Whether the subtree is a leaf, or a node of less than `heightLimit`, before page `endPage`.
bool IsSubtreeValid(const IntervalSubtree& subtree, std::uint64_t endPage,
  std::uint32_t heightLimit, std::uint32_t recordsPerPage)
{
  const IntervalList& list = subtree.List;
  if (subtree.Height == 0)
  {
    return list.Count <= recordsPerPage && IsListValid(list, endPage, recordsPerPage);
  }
  return subtree.Height < heightLimit && list.Count > 0 && list.Record == 0 && list.Page >= 1 &&
    list.Page < endPage;
}

/// Why the references of a node are impossible; null if they are valid.
const char* FindFault(const IntervalTreeNode& node, std::uint32_t page, std::uint32_t capacity)
{
  if (std::adjacent_find(node.Boundaries.begin(), node.Boundaries.end(),
        [](ValueKey a, ValueKey b) { return a >= b; }) != node.Boundaries.end())
  {
    return "slab boundaries do not ascend";
  }
  for (const IntervalTreeSlab& slab : node.Slabs)
  {
    if (!IsListValid(slab.Left, page, capacity) || !IsListValid(slab.Right, page, capacity) ||
      !IsSubtreeValid(slab.Child, page, node.Height, capacity) ||
      (slab.Window != IntervalTreeSlab::NoWindow && slab.Window >= node.Windows.size()))
    {
      return "impossible reference of a slab";
    }
  }
  for (const IntervalTreeMultislab& multislab : node.Multislabs)
  {
    if (multislab.First < 1 || multislab.First > multislab.Last ||
      multislab.Last + std::size_t(2) > node.Slabs.size() ||
      !IsListValid(multislab.List, page, capacity))
    {
      return "impossible multislab";
    }
  }
  for (const IntervalList& window : node.Windows)
  {
    if (!IsListValid(window, page, capacity))
    {
      return "impossible underflow window";
    }
  }
  return nullptr;
}

} // namespace

std::uint32_t IntervalTreeFormat::GetRecordsPerPage(std::size_t payloadSize)
{
  return static_cast<std::uint32_t>((payloadSize - RecordPageHeaderSize) / RecordSize);
}

std::uint32_t IntervalTreeFormat::GetSlabLimit(std::uint32_t recordsPerPage)
{
  return 2 * static_cast<std::uint32_t>(std::sqrt(static_cast<double>(recordsPerPage)));
}

std::size_t IntervalTreeNode::FindSlab(ValueKey key) const
{
  return static_cast<std::size_t>(
    std::lower_bound(this->Boundaries.begin(), this->Boundaries.end(), key) -
    this->Boundaries.begin());
}

std::size_t IntervalTreeNode::GetMultislabLimit(std::size_t payloadSize, std::size_t slabs)
{
  // There is at most one window a slab.
  return (payloadSize - GetNodeSize(slabs, 0, slabs)) / MultislabSize;
}

void IntervalTreeNode::Encode(std::size_t payloadSize, std::uint8_t* payload) const
{
  assert(
    GetNodeSize(this->Slabs.size(), this->Multislabs.size(), this->Windows.size()) <= payloadSize);
  std::fill(payload, payload + payloadSize, std::uint8_t(0));
  StoreLittleEndian(payload, NodeTag);
  StoreLittleEndian(payload + 4, static_cast<std::uint16_t>(this->Height));
  StoreLittleEndian(payload + 6, static_cast<std::uint16_t>(this->Slabs.size()));
  StoreLittleEndian(payload + 8, static_cast<std::uint16_t>(this->Multislabs.size()));
  StoreLittleEndian(payload + 10, static_cast<std::uint16_t>(this->Windows.size()));
  std::uint8_t* bytes = payload + NodeHeaderSize;
  for (const ValueKey boundary : this->Boundaries)
  {
    StoreLittleEndian(bytes, boundary);
    bytes += 8;
  }
  for (const IntervalTreeSlab& slab : this->Slabs)
  {
    StoreList(bytes, slab.Left);
    StoreLittleEndian(bytes + 10, slab.LeftMinimum);
    StoreList(bytes + 18, slab.Right);
    StoreLittleEndian(bytes + 28, slab.RightMaximum);
    StoreSubtree(bytes + 36, slab.Child);
    StoreLittleEndian(bytes + 48, slab.Window);
    bytes += SlabSize;
  }
  for (const IntervalTreeMultislab& multislab : this->Multislabs)
  {
    StoreLittleEndian(bytes, multislab.First);
    StoreLittleEndian(bytes + 2, multislab.Last);
    StoreList(bytes + 4, multislab.List);
    bytes += MultislabSize;
  }
  for (const IntervalList& window : this->Windows)
  {
    StoreList(bytes, window);
    bytes += ListSize;
  }
}

Result<IntervalTreeNode> IntervalTreeNode::Decode(
  const PagedFileReader& file, std::uint32_t page, const std::uint8_t* payload)
{
  const std::uint32_t capacity = IntervalTreeFormat::GetRecordsPerPage(file.GetPayloadSize());
  IntervalTreeNode node;
  node.Height = LoadLittleEndian<std::uint16_t>(payload + 4);
  const std::size_t slabs = LoadLittleEndian<std::uint16_t>(payload + 6);
  const std::size_t multislabs = LoadLittleEndian<std::uint16_t>(payload + 8);
  const std::size_t windows = LoadLittleEndian<std::uint16_t>(payload + 10);
  if (LoadLittleEndian<std::uint32_t>(payload) != NodeTag || node.Height < 1 || slabs < 2 ||
    slabs > IntervalTreeFormat::GetSlabLimit(capacity) ||
    GetNodeSize(slabs, multislabs, windows) > file.GetPayloadSize())
  {
    return file.MakeCorrupt(page, "this is not a node of an interval tree");
  }
  node.Boundaries.resize(slabs - 1);
  node.Slabs.resize(slabs);
  node.Multislabs.resize(multislabs);
  node.Windows.resize(windows);
  const std::uint8_t* bytes = payload + NodeHeaderSize;
  for (ValueKey& boundary : node.Boundaries)
  {
    boundary = LoadLittleEndian<ValueKey>(bytes);
    bytes += 8;
  }
  for (IntervalTreeSlab& slab : node.Slabs)
  {
    slab.Left = LoadList(bytes);
    slab.LeftMinimum = LoadLittleEndian<ValueKey>(bytes + 10);
    slab.Right = LoadList(bytes + 18);
    slab.RightMaximum = LoadLittleEndian<ValueKey>(bytes + 28);
    slab.Child = LoadSubtree(bytes + 36);
    slab.Window = LoadLittleEndian<std::uint16_t>(bytes + 48);
    bytes += SlabSize;
  }
  for (IntervalTreeMultislab& multislab : node.Multislabs)
  {
    multislab.First = LoadLittleEndian<std::uint16_t>(bytes);
    multislab.Last = LoadLittleEndian<std::uint16_t>(bytes + 2);
    multislab.List = LoadList(bytes + 4);
    bytes += MultislabSize;
  }
  for (IntervalList& window : node.Windows)
  {
    window = LoadList(bytes);
    bytes += ListSize;
  }
  if (const char* fault = FindFault(node, page, capacity))
  {
    return file.MakeCorrupt(page, fault);
  }
  return node;
}

PagedFile::ClientArea IntervalTreeHeader::Encode() const
{
  PagedFile::ClientArea bytes = {};
  StoreLittleEndian(&bytes[0], IntervalTreeFormat::Version);
  StoreLittleEndian(&bytes[8], this->Count);
  StoreLittleEndian(&bytes[16], this->Minimum);
  StoreLittleEndian(&bytes[24], this->Maximum);
  static_assert(32 + SubtreeSize <= 48, "the root ends before the identity");
  StoreSubtree(&bytes[32], this->Root);
  StoreLittleEndian(&bytes[48], this->Identity);
  return bytes;
}

Result<IntervalTreeHeader> IntervalTreeHeader::Decode(const PagedFileReader& file)
{
  const PagedFile::ClientArea& bytes = file.GetClientArea();
  const auto version = LoadLittleEndian<std::uint32_t>(&bytes[0]);
  if (version > IntervalTreeFormat::Version)
  {
    return Status(StatusCode::Unsupported,
      file.GetPath() + ": written by a newer version (interval tree format " +
        std::to_string(version) + ", this program reads up to " +
        std::to_string(IntervalTreeFormat::Version) + ")");
  }
  IntervalTreeHeader header;
  header.Count = LoadLittleEndian<std::uint64_t>(&bytes[8]);
  header.Minimum = LoadLittleEndian<ValueKey>(&bytes[16]);
  header.Maximum = LoadLittleEndian<ValueKey>(&bytes[24]);
  header.Root = LoadSubtree(&bytes[32]);
  header.Identity = LoadLittleEndian<std::uint64_t>(&bytes[48]);
  if (version == 0 || header.Count != header.Root.List.Count ||
    !IsSubtreeValid(header.Root, file.GetPageCount(), IntervalTreeFormat::HeightLimit,
      IntervalTreeFormat::GetRecordsPerPage(file.GetPayloadSize())))
  {
    return file.MakeCorrupt(0, "impossible root of the interval tree");
  }
  return header;
}

void IntervalRecordPage::Begin(std::uint8_t* payload)
{
  StoreLittleEndian(payload, RecordTag);
  StoreLittleEndian(payload + 4, std::uint32_t(0));
}

void IntervalRecordPage::Put(
  std::uint8_t* payload, std::uint32_t record, const KeyInterval& interval)
{
  std::uint8_t* bytes = payload + IntervalTreeFormat::RecordPageHeaderSize +
    std::size_t(record) * IntervalTreeFormat::RecordSize;
  StoreLittleEndian(bytes, interval.Minimum);
  StoreLittleEndian(bytes + 8, interval.Maximum);
  StoreLittleEndian(bytes + 16, interval.Payload);
}

bool IntervalRecordPage::IsOne(const std::uint8_t* payload)
{
  return LoadLittleEndian<std::uint32_t>(payload) == RecordTag;
}

KeyInterval IntervalRecordPage::Get(const std::uint8_t* payload, std::uint32_t record)
{
  const std::uint8_t* bytes = payload + IntervalTreeFormat::RecordPageHeaderSize +
    std::size_t(record) * IntervalTreeFormat::RecordSize;
  return { LoadLittleEndian<ValueKey>(bytes), LoadLittleEndian<ValueKey>(bytes + 8),
    LoadLittleEndian<std::uint32_t>(bytes + 16) };
}

} // namespace isosurface
