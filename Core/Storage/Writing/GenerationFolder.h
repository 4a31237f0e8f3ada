// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_GenerationFolder_h
#define isosurface_GenerationFolder_h

#include "Ground/Base/FileSystem.h"
#include "Ground/Base/Status.h"
#include "Storage/Store/BlockedVolumeHeader.h"

#include <string>

namespace isosurface
{

/**
 * Replaces a blocked volume, or appends a time step, at once. Each write fills a generation, a
 * folder of its own beside those of earlier writes; the header names those that are part of the
 * volume:
 *
 *     NAME.bvol                           the header; replaced by a rename, last of all
 *     NAME.bvol.partial                   the next header, while it is being written
 *     .NAME.bvol.stores/000001/            the generation that the header names, until then
 *     .NAME.bvol.stores/000002/            the one being written
 *         spectra
 *         store-00000/  store-00001/  ...
 *
 *     .NAME.bvol.stores/journal            the checkpoint of the write (WriteJournal), if it keeps one
 *
 * A writer that is killed leaves the header and its generation unchanged, and folders that no
 * header names. The next write goes on with them, or removes them first, to free space. One rank does all of this, and
 * holds the lock of .NAME.bvol.stores/ (FileSystem::LockFolder) meanwhile.
 */
class GenerationFolder
{
public:
  /// Removes the folders that neither the header on disk nor `pending` names, which killed writers
  /// have left, and the journal, unless `isJournaled`. Removes nothing if the header on disk cannot
  /// be read.
  static void RemoveUnnamed(FileSystem& files, const std::string& path,
    const BlockedVolumeHeader& pending, bool isJournaled);

  /// Removes the files of a killed write now, not with the next write. Files that its journal names
  /// stay for the next one. Does nothing while another writer holds the lock.
  static void RemoveUnfinished(FileSystem& files, const std::string& path);

  /// Makes a folder with a number above all existing ones; returns its name. An error if another
  /// process makes the same one meanwhile.
  static Result<std::string> Create(FileSystem& files, const std::string& path);

  /// Puts the header in place, after all that it names is on stable storage. `isVisible` tells
  /// whether the new header is in place; if not, the old one still is.
  static Status Commit(
    FileSystem& files, const std::string& path, const BlockedVolumeHeader& header, bool& isVisible);

  /// Removes the folders with lower numbers than `current` that the header does not name. Folders
  /// that cannot be removed are left to the next write.
  static void RemoveOlder(FileSystem& files, const std::string& path, const std::string& current,
    const BlockedVolumeHeader& header);

  /// Removes the folders of the header's time steps that the header on disk does not name. If that
  /// cannot be read, all are left to the next write.
  static void DiscardUnnamed(
    FileSystem& files, const std::string& path, const BlockedVolumeHeader& header);

  /// Removes the files of an unfinished write; `current` is empty before its folder is made.
  static void Discard(FileSystem& files, const std::string& path, const std::string& current);
};

} // namespace isosurface

#endif
