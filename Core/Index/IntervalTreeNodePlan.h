// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_IntervalTreeNodePlan_h
#define isosurface_IntervalTreeNodePlan_h

#include "Volume/ValueKey.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace isosurface
{

/**
 * Decides, from counts alone, how one node of an external interval tree lays out its intervals:
 * which go into which slab's left and right list, which multislabs have a list of their own, and
 * which share the windows of the underflow list.
 *
 * Boundaries b[1] < ... < b[s - 1] cut the keys into slabs (-inf, b[1]], ..., (b[s - 1], inf).
 * An interval with no boundary in it belongs to the child of its slab. Any other is in the left
 * list of the slab of its Minimum; in the right list of the slab that its Maximum is strictly
 * inside of, if there is one; and, if there are slabs between that it spans wholly, in the list of
 * that multislab.
 *
 * A multislab with less than B/2 intervals would waste its page, and a query its read. Such ones
 * share the underflow list. That is cut into windows of consecutive slabs; a window lists
 * every interval that spans one of its slabs, and a query reads just the window of its slab. A
 * window grows while its list has at most max(B, 2 t) intervals, where t is the least number that
 * span one of its slabs. Hence a query reads at most 1 + 2 t/B pages for t intervals; and since
 * more than half of the intervals of a window that can grow no more end in it or begin in it or in
 * the next slab, where no other window counts them, all windows list at most 5 U records of U
 * intervals. This is Chazelle, "Filtering search: a new approach to query-answering", SIAM
 * J. Comput. 15, 1986, section 2 (window lists), at the place of Arge and Vitter's corner
 * structure. It takes any number of intervals, so that multislabs for whose list the node's page
 * has no room can go there, too.
 */
class IntervalTreeNodePlan
{
public:
  /// Where an interval belongs; slabs First + 1 .. End - 1 are those that it spans wholly.
  struct Placement
  {
    std::uint16_t First = 0; ///< the slab of its Minimum
    std::uint16_t End = 0;   ///< the number of boundaries that are not above its Maximum
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
  /// Of groups, First .. End - 1.
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

  /// After all are counted: fixes multislab lists (at most `multislabLimit`) and windows.
  void Decide(std::uint32_t recordsPerPage, std::size_t multislabLimit);

  std::uint32_t GetChildCount(std::size_t slab) const { return this->Children[slab]; }
  std::uint32_t GetLeftCount(std::size_t slab) const { return this->Left[slab]; }
  std::uint32_t GetRightCount(std::size_t slab) const { return this->Right[slab]; }
  /// The multislabs with lists of their own, then the windows.
  const std::vector<Group>& GetGroups() const { return this->Groups; }
  std::size_t GetMultislabCount() const { return this->MultislabCount; }
  /// The group number of a slab's window, or -1.
  int GetWindow(std::size_t slab) const { return this->WindowOfSlab[slab]; }
  /// The groups whose list an interval that IsMultislab() is part of.
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
  std::vector<std::int32_t> GroupOfSpan;  // as Spans; -1 for those in windows
  std::vector<std::int32_t> WindowOfSlab; // -1 for none
  std::vector<Group> Groups;
  std::size_t MultislabCount = 0;
};

} // namespace isosurface

#endif
