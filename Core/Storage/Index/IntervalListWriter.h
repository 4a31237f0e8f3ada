// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_IntervalListWriter_h
#define isosurface_IntervalListWriter_h

#include "Ground/Base/PagedFile.h"
#include "Ground/Base/Status.h"
#include "Storage/Index/IntervalTreeFormat.h"

#include <cstdint>
#include <vector>

namespace isosurface
{

/**
 * Packs lists of intervals into pages, one after the other. A list of at most B intervals follows
 * the previous one if it fits in the rest of the page; otherwise it begins a new page. A longer
 * list always begins a new page. So a short list costs one read, the first t intervals of a long
 * one at most 1 + t/B reads, and two successive pages hold more than B intervals together.
 */
class IntervalListWriter
{
public:
  explicit IntervalListWriter(PagedFileWriter& file);

  std::uint32_t GetRecordsPerPage() const { return this->RecordsPerPage; }

  /// Begins a list of `count` intervals, which the caller then adds. Until then, only this object
  /// may allocate pages.
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
