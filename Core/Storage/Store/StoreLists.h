// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_StoreLists_h
#define isosurface_StoreLists_h

#include "Storage/Store/BlockedVolumeHeader.h"

#include <optional>
#include <string>
#include <vector>

namespace isosurface
{

/// The lists of stores of a header. If there are many stores, they are nearly all of its text, and
/// making a document of them would take most of the time to open a volume.
struct StoreLists
{
  std::string Rest; ///< the text, with [n] in the place of list n
  std::vector<std::vector<StoreDescription>> Lists;
};

/// Cuts the lists out of a header's text. Nothing if it is not written as
/// BlockedVolumeHeader::Format() does it, but for spaces in the lists: then all of it is to be
/// parsed as a document. Cost: 0.1 us a store.
std::optional<StoreLists> CutStoreLists(const std::string& text);

} // namespace isosurface

#endif
