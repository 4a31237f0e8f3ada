// SPDX-License-Identifier: BSD-3-Clause
// Input: flags (1 byte: 1 seals the pages, 2 gives a page cache), the ends of a range (uint64
// each), the file of a tree. Its bytes are stabbed, asked for the range, and verified.
#include "FuzzTarget.h"
#include "SealedBytes.h"

#include "Ground/Base/Coding.h"
#include "Storage/Index/ExternalIntervalTree.h"

#include <algorithm>
#include <limits>
#include <string>

using namespace isosurface;

namespace
{

const std::string Path = "/data/tree";
constexpr std::size_t PrefixSize = 17;
/// A page, the nodes of a path, one decoded node, an error's message.
constexpr std::size_t QueryBytes = std::size_t{ 256 } * 1024;

void Ask(const ExternalIntervalTree& tree, ValueKey low, ValueKey high)
{
  std::uint64_t reports = 0;
  bool overlap = true;
  const auto visit = [&](const KeyInterval& interval)
  {
    ++reports;
    overlap = overlap && interval.Minimum <= high && low <= interval.Maximum;
  };
  PageStatistics statistics;
  const Status status = tree.FindOverlapping(low, high, visit, statistics);
  Require(overlap, "what a query reports overlaps its range");
  Require(reports <= tree.GetCount(), "a query reports no more intervals than there are");
  Require(statistics.PageReads + statistics.CacheHits <= 64 + 16 * tree.GetPageCount(),
    "a query reads no more pages than a whole tree has");
  Require(status.IsOk() || status.GetMessage().find(Path) == 0, "an error names the file");
}

} // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size)
{
  if (size < PrefixSize)
  {
    return 0;
  }
  const bool isSealed = (bytes[0] & 1) != 0;
  const std::size_t cacheBytes = (bytes[0] & 2) != 0 ? 64 * 1024 : 0;
  const auto low = LoadLittleEndian<ValueKey>(bytes + 1);
  const auto high = LoadLittleEndian<ValueKey>(bytes + 9);
  MemoryDisk disk;
  PutFile(disk, Path,
    isSealed ? SealPages(bytes + PrefixSize, size - PrefixSize, "INTVTREE")
             : SealedBytes(bytes + PrefixSize, bytes + size));

  // A check of the tree has all intervals of a node, several times.
  const MemoryLimit limit(QueryBytes + cacheBytes + 16 * size);
  const auto tree = ExternalIntervalTree::Open(disk, Path, cacheBytes);
  if (!tree.IsOk())
  {
    Require(tree.GetStatus().GetMessage().find(Path) == 0, "an error names the file");
    return 0;
  }
  Ask(**tree, low, low);
  Ask(**tree, std::min(low, high), std::max(low, high));
  Ask(**tree, 0, std::numeric_limits<ValueKey>::max());
  PageStatistics statistics;
  const Status status = (*tree)->Verify(statistics);
  Require(status.IsOk() || status.GetCode() == StatusCode::Corrupt, "a bad tree is Corrupt");
  return 0;
}
