// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_ZarrVolume_h
#define isosurface_ZarrVolume_h

#include "Formats/Source/FormatFunctions.h"

#include <vector>

namespace isosurface
{

/**
 * A volume in a folder of Zarr 2, Zarr 3 or N5:
 *
 *     folder           an array, the multiscales of OME-Zarr 0.4 or 0.5 in it, or its only array of three
 *                      axes, or the only one with four, or with five
 *     folder:path      the same of a folder within
 *
 * Of multiscales, the first image's finest level is read, with its axes, scale, translation and the
 * names of its channels. Arrays have the axes that dimension_names (or _ARRAY_DIMENSIONS) say with the
 * letters t, c, z, y and x, otherwise those of ArrayAxes::Parse(). N5 counts axes from the fastest one.
 *
 * Sources: "Zarr storage specification version 2"; "Zarr core specification version 3", with the codecs
 * bytes, transpose, gzip, zstd, blosc, crc32c and sharding-indexed; "Next-generation file formats
 * (NGFF)" 0.4 and 0.5; the README of saalfeldlab/n5.
 */
Result<OpenedVolume> OpenZarrVolume(
  FileSystem& files, const VolumeName& name, const VolumeChoice& choice);

/// All arrays in the folder.
Result<std::vector<VolumeListing>> ListZarr(FileSystem& files, const VolumeName& name);

/// Whether a file of this name has metadata of Zarr or N5.
bool IsZarrMetadata(const std::string& name);
/// Hints that the metadata of folders will be read (FileSystem::LookFor): of a version of ZarrNode, or of any (0).
void LookForZarr(FileSystem& files, const std::vector<std::string>& folders, int version = 0);
/// Whether a folder has such a file.
bool IsZarrFolder(FileSystem& files, const std::string& path);

} // namespace isosurface

#endif
