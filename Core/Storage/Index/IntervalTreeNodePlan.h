// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_IntervalTreeNodePlan_h
#define isosurface_IntervalTreeNodePlan_h

#include "Ground/Volume/ValueKey.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace isosurface
{

/**
 * Plans the lists of a node of an external interval tree, from counts alone: the left and right
 * list of each slab, the multislabs with a list of their own, and the windows of the underflow
 * list. The slabs and lists are defined in Documentation/formats/interval-tree.md.
 *
 * The underflow list has the intervals of multislabs that have less than B/2 intervals, or for
 * whose list the node's page has no room. It is cut into windows of consecutive slabs. A window
 * lists each underflow interval that spans one of its slabs; a query reads the window of its slab.
 * A window grows while its list has at most max(B, 2 t) intervals, where t is the minimum number of
 * intervals that span one of its slabs. So a query reads at most 1 + 2 t/B pages for t answers, and
 * the windows of U intervals have at most 4 U records (proof: see there, Bounds).
 *
 * Source: B. Chazelle, "Filtering search: a new approach to query-answering", SIAM J. Comput. 15,
 * 1986, section 2 (window lists), instead of Arge and Vitter's corner structure.
 */
class IntervalTreeNodePlan
{
public:
  /// Where an interval belongs. It spans the slabs First + 1 .. End - 1.
  struct Placement
  {
    std::uint16_t First = 0; ///< the slab of its Minimum
    std::uint16_t End = 0;   ///< the number of boundaries <= its Maximum
    bool EndsInside = false; ///< Maximum lies strictly inside slab End
    bool IsInChild() const { return this->First == this->End; }
    bool IsMultislab() const { return this->End >= this->First + 2; }
  };
  /// Consecutive slabs and the number of records in their common list.
  struct Group
  {
    std::uint16_t First;
    std::uint16_t Last;
    std::uint32_t Count;
  };
  /// The groups First .. End - 1.
  struct GroupRange
  {
    std::uint32_t First;
    std::uint32_t End;
  };

  explicit IntervalTreeNodePlan(std::vector<ValueKey> boundaries);

  std::size_t GetSlabCount() const { return this->Boundaries.size() + 1; }
  const std::vector<ValueKey>& GetBoundaries() const { return this->Boundaries; }
  Placement Place(ValueKey minimum, ValueKey maximum) const;
  void Count(const Placement& placement);

  /// After all intervals are counted: chooses the multislab lists (at most `multislabLimit`) and
  /// the windows.
  void Decide(std::uint32_t recordsPerPage, std::size_t multislabLimit);

  std::uint32_t GetChildCount(std::size_t slab) const { return this->Children[slab]; }
  std::uint32_t GetLeftCount(std::size_t slab) const { return this->Left[slab]; }
  std::uint32_t GetRightCount(std::size_t slab) const { return this->Right[slab]; }
  /// The multislabs that have a list, then the windows.
  const std::vector<Group>& GetGroups() const { return this->Groups; }
  std::size_t GetMultislabCount() const { return this->MultislabCount; }
  /// The group of a slab's window; -1 if it has none.
  int GetWindow(std::size_t slab) const { return this->WindowOfSlab[slab]; }
  /// The groups whose lists contain an interval that IsMultislab().
  GroupRange FindGroups(const Placement& placement) const;

private:
  std::uint32_t& At(std::vector<std::uint32_t>& table, std::size_t first, std::size_t last) const;
  void DecideMultislabs(std::uint32_t recordsPerPage, std::size_t multislabLimit);
  void DecideWindows(std::uint32_t recordsPerPage);

  std::vector<ValueKey> Boundaries;
  std::vector<std::uint32_t> Children;
  std::vector<std::uint32_t> Left;
  std::vector<std::uint32_t> Right;
  std::vector<std::uint32_t> Spans;       // by first and last spanned slab
  std::vector<std::int32_t> GroupOfSpan;  // indexed as Spans; -1 for those in windows
  std::vector<std::int32_t> WindowOfSlab; // -1 for none
  std::vector<Group> Groups;
  std::size_t MultislabCount = 0;
};

} // namespace isosurface

#endif
