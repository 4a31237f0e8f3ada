// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_ReadingOrder_h
#define isosurface_ReadingOrder_h

#include "Ground/Volume/BoxSource.h"

#include <cstdint>
#include <memory>
#include <vector>

namespace isosurface
{

/// The vertices of a box whose coordinates are multiples of a step.
struct Lattice
{
  VertexBox Box;
  Index3 Step{ 1, 1, 1 };

  /// The same vertices by number: their coordinates divided by the step.
  VertexBox GetNumbers() const;
};

/**
 * In which order to read boxes of a source, so that after any part of the order the samples that were
 * read are the finest lattice, or the largest one, for their number.
 */
class ReadingOrder
{
public:
  /// The order that suits the source (ReadSourceSample), for a lattice of about `vertices`. Parts have `atOnce` chunks
  /// or more, as long as there are so many.
  static std::unique_ptr<ReadingOrder> Choose(
    const BoxSource& source, std::int64_t vertices, std::int64_t atOnce = 1);
  virtual ~ReadingOrder() = default;

  /// The boxes of the next part; none if all is read. They have no vertex in common with those of
  /// other parts.
  virtual std::vector<VertexBox> FindNext() = 0;
  /// What can be shown when all parts that FindNext() has returned are read.
  virtual Lattice GetLattice() const = 0;
  /// Every lattice contains only multiples of this step.
  const Index3& GetStep() const { return this->Step; }
  /// That of a lattice of all vertices.
  virtual const Index3& GetWholeStep() const { return this->Step; }
  /// Which part of the source a lattice is that is not all of it.
  virtual const char* GetPart() const { return "middle"; }
  /// Whether boxes are best read row by row, each row of the lattice alone.
  virtual bool IsByRows() const { return false; }

protected:
  explicit ReadingOrder(const Index3& step)
    : Step(step)
  {
  }

  const Index3 Step;
};

} // namespace isosurface

#endif
