// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_IntervalListWriter_h
#define isosurface_IntervalListWriter_h

#include "Base/Status.h"
#include "Index/IntervalTreeFormat.h"
#include "Index/PagedFile.h"

#include <cstdint>
#include <vector>

namespace isosurface
{

/**
 * Packs lists of intervals into pages, one after the other. A list of at most B intervals begins
 * in the page where the last one ended if the rest of that page holds it, else in a new one; a
 * longer list begins in a new page. So a short list costs one read, a prefix of t intervals of a
 * long one at most 1 + t/B, and two neighbouring pages hold more than B intervals together.
 */
class IntervalListWriter
{
public:
  explicit IntervalListWriter(PagedFileWriter& file);

  std::uint32_t GetRecordsPerPage() const { return this->RecordsPerPage; }

  /// Begins a list of `count` intervals, which are then added. No page may be allocated by others
  /// until they are.
  Result<IntervalList> Begin(std::uint32_t count);
  Status Add(const KeyInterval& interval);
  /// Writes the last page.
  Status Finish();

private:
  Status BeginPage();
  Status EndPage();

  PagedFileWriter& File;
  std::uint32_t RecordsPerPage;
  std::vector<std::uint8_t> Payload;
  std::uint32_t Page = 0; // 0: none yet
  std::uint32_t Record = 0;
};

} // namespace isosurface

#endif
