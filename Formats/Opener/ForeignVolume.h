// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_ForeignVolume_h
#define isosurface_ForeignVolume_h

#include "Formats/Source/FormatFunctions.h"

#include <string>
#include <vector>

namespace isosurface
{

/// Whether OpenForeignVolume() supports the name (VolumeName.h). Looks at folders and at the first
/// bytes of files.
bool IsForeignVolume(FileSystem& files, const std::string& name);

/**
 * Opens a volume in files of another format; a VolumeOpener for Core. VolumeFormat.cxx lists the
 * formats and how they are recognised; Documentation/dev/sources.md, what is read of each.
 *
 * Unsupported if not IsForeignVolume(), or if the module that reads the format cannot be loaded.
 * InvalidArgument for axes, unless the format takes them, and for a time step that is not there.
 * `files` must outlive the source. HDF5, NetCDF and DICOM are read from the local file system,
 * whatever `files` is. Cost: reading the headers; for a TIFF stack, the directories of all pages.
 */
Result<OpenedVolume> OpenForeignVolume(
  FileSystem& files, const std::string& name, const VolumeChoice& choice = {});

/// What is in a file or a folder of HDF5, NetCDF, Zarr or DICOM. Unsupported for others.
Result<std::vector<VolumeListing>> ListForeignVolumes(FileSystem& files, const std::string& name);

} // namespace isosurface

#endif
