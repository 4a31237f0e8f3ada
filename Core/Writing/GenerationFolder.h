// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_GenerationFolder_h
#define isosurface_GenerationFolder_h

#include "Base/FileSystem.h"
#include "Base/Status.h"
#include "Store/BlockedVolumeHeader.h"

#include <string>

namespace isosurface
{

/**
 * How a blocked volume is replaced, or gets another time step, in one step. Each write fills a
 * folder of its own beside those of earlier ones; only the header says which ones count:
 *
 *     NAME.bvol                           the header; replaced by a rename, last of all
 *     NAME.bvol.partial                   the next header, while it is being written
 *     NAME.bvol.stores/000001/            the generation that the header names, until then
 *     NAME.bvol.stores/000002/            the one being written
 *         spectra
 *         store-00000/  store-00001/  ...
 *
 * Whatever dies on the way leaves the header and its generation as they were, and folders that no
 * header names, which the next write removes first of all, so that a full disk has room again. One
 * rank does all of this. A writer holds the lock of NAME.bvol.stores/ (FileSystem::LockFolder).
 */
class GenerationFolder
{
public:
  /// Removes what killed writers have left: the folders that neither the header on disk nor
  /// `pending` names. Nothing is removed if the header on disk cannot be read.
  static void RemoveUnnamed(
    FileSystem& files, const std::string& path, const BlockedVolumeHeader& pending);

  /// Makes a folder whose number is above all that exist; returns its name. An error if somebody
  /// else makes the same one meanwhile.
  static Result<std::string> Create(FileSystem& files, const std::string& path);

  /// Puts the header in place, once all that it names is on stable storage. On an error before the
  /// rename, the old header is still there; `isVisible` tells whether the new one is.
  static Status Commit(
    FileSystem& files, const std::string& path, const BlockedVolumeHeader& header, bool& isVisible);

  /// Removes the folders with lower numbers than `current` that the header does not name. What
  /// cannot be removed is left for the next write.
  static void RemoveOlder(FileSystem& files, const std::string& path, const std::string& current,
    const BlockedVolumeHeader& header);

  /// Removes the folders of those of the header's time steps that the header on disk does not name.
  /// If that cannot be read, all are left for the next write.
  static void DiscardUnnamed(
    FileSystem& files, const std::string& path, const BlockedVolumeHeader& header);

  /// Removes what an unfinished write has left; `current`: empty before its folder is made.
  static void Discard(FileSystem& files, const std::string& path, const std::string& current);
};

} // namespace isosurface

#endif
