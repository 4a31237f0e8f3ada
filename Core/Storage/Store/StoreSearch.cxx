// SPDX-License-Identifier: BSD-3-Clause
#include "Storage/Store/StoreSearch.h"

#include "Storage/Store/BlockStore.h"
#include "Storage/Store/VolumeLayout.h"

#include <algorithm>
#include <iterator>
#include <numeric>

namespace isosurface
{
namespace
{

using References = std::vector<BlockReference>;

/// The blocks [begin, end) of a list of ordinals. Cost: the directory pages of these.
Result<References> MakeReferences(const BlockStore& store, std::uint32_t number,
  std::uint32_t overview, const std::vector<std::uint32_t>& ordinals, std::uint64_t begin,
  std::uint64_t end, QueryStatistics& statistics)
{
  References references;
  for (std::uint64_t index = begin; index < end; ++index)
  {
    ISOSURFACE_ASSIGN_OR_RETURN(const auto block, store.FindBlock(ordinals[index], statistics));
    references.push_back({ block, number, ordinals[index], overview, 0 });
  }
  return references;
}

} // namespace

Result<References> FindActiveBlocks(BlockStore& store, const VolumeLayout& layout,
  const BlockQuery& query, const StoreSpan& span, int level, QueryStatistics& statistics)
{
  const StoredLevel stored = layout.FindLevel(level);
  ISOSURFACE_ASSIGN_OR_RETURN(
    const auto active, store.FindActive(query.Variable, query.Isovalues, statistics));
  if (query.Selection.IsPlain())
  {
    return MakeReferences(store, span.Store, stored.Overview, active, span.FindBegin(active.size()),
      span.FindEnd(active.size()), statistics);
  }
  std::vector<std::uint32_t> candidates = active;
  if (query.Selection.ClosedSides.AreBeyondInside)
  {
    candidates.resize(static_cast<std::size_t>(store.GetNumberOfBlocks()));
    std::iota(candidates.begin(), candidates.end(), 0U);
  }
  else if (!query.Selection.ClosedSides.IsEmpty())
  {
    ISOSURFACE_ASSIGN_OR_RETURN(
      const auto inside, store.FindInside(query.Variable, query.Isovalues, statistics));
    candidates.clear();
    std::set_union(
      active.begin(), active.end(), inside.begin(), inside.end(), std::back_inserter(candidates));
  }
  ISOSURFACE_ASSIGN_OR_RETURN(auto found,
    MakeReferences(
      store, span.Store, stored.Overview, candidates, 0, candidates.size(), statistics));
  const GridGeometry geometry = layout.GetHeader().Grid.Coarsen(level);
  BlockSelection selection = query.Selection;
  selection.Lines = layout.GetLines(level);
  const auto isLeftOut = [&](const BlockReference& block)
  {
    const bool isActive = std::binary_search(active.begin(), active.end(), block.Ordinal);
    return !selection.Selects(
      geometry, stored.Grid->GetVertices(block.Block, stored.Level), isActive);
  };
  found.erase(std::remove_if(found.begin(), found.end(), isLeftOut), found.end());
  const auto first = found.begin();
  return References(first + static_cast<std::ptrdiff_t>(span.FindBegin(found.size())),
    first + static_cast<std::ptrdiff_t>(span.FindEnd(found.size())));
}

Result<References> ListBlocks(
  BlockStore& store, std::uint32_t number, std::uint32_t overview, QueryStatistics& statistics)
{
  std::vector<std::uint32_t> ordinals(static_cast<std::size_t>(store.GetNumberOfBlocks()));
  std::iota(ordinals.begin(), ordinals.end(), 0U);
  return MakeReferences(store, number, overview, ordinals, 0, ordinals.size(), statistics);
}

} // namespace isosurface
