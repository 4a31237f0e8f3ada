// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_Hdf5LinkedFiles_h
#define isosurface_Hdf5LinkedFiles_h

#include "Formats/Hdf5/Hdf5Handle.h"
#include "Ground/Base/Status.h"

#include <cstdint>
#include <map>
#include <set>
#include <string>

namespace isosurface
{

/**
 * The other files that an HDF5 file names: external links lead to them, virtual datasets are made of
 * their datasets, and external storage is samples in files without a format. The library opens
 * whatever is there: a FIFO, for which it waits, a device, a file that is none of the data. So each
 * of them is looked at before the library opens it. Every object is opened through this class.
 *
 * Links and virtual datasets lead to regular files, wherever they are, as the library finds them.
 * External storage is regular files in the folder of the HDF5 file or below. The lock is held.
 */
class Hdf5LinkedFiles
{
public:
  Hdf5LinkedFiles();
  Hdf5LinkedFiles(const Hdf5LinkedFiles&) = delete;
  Hdf5LinkedFiles& operator=(const Hdf5LinkedFiles&) = delete;

  /// The properties with which objects are opened that lie behind links: of a link and of a dataset.
  hid_t GetAccess() const { return this->Access.Get(); }
  /// Whether there is such an object. Opens nothing.
  bool FindObject(hid_t at, const std::string& path, H5O_info_t& info);
  Hdf5Handle OpenGroup(hid_t at, const std::string& path);
  Hdf5Handle OpenDataset(hid_t at, const std::string& path);
  /// Why a link was not followed to the last object; empty if it was.
  static const std::string& GetRefusal();

  /// Checks all files that have samples of a dataset. Behind virtual datasets (`depth` > 0) there is
  /// no external storage. Errors name the other file: Unsupported, IoError if it is not regular or
  /// missing, Corrupt if it is truncated.
  Status Check(const Hdf5Handle& dataset, int depth = 0);
  /// The canonical paths of the files that have samples of the datasets that were checked.
  const std::set<std::string>& GetFiles() const { return this->Files; }

private:
  Status CheckExternal(const Hdf5Handle& dataset, const Hdf5Handle& plist, unsigned number,
    std::uint64_t& missingBytes);
  Status CheckVirtual(const Hdf5Handle& dataset, const Hdf5Handle& plist, int depth);
  Result<bool> CheckSource(
    const Hdf5Handle& dataset, const std::string& file, const std::string& object, int depth);
  Result<bool> CheckSourceAt(
    const Hdf5Handle& file, const std::string& place, const std::string& object, int depth);

  Hdf5Handle Access;
  /// Of datasets with external storage, whose names begin in the folder of the file, not in the current
  /// one. While one is open, the library opens it with the same prefix alone.
  Hdf5Handle ExternalAccess;
  std::set<std::string> Files;
  std::map<std::string, int> Checked; ///< files and datasets behind virtual ones: the depth
};

} // namespace isosurface

#endif
