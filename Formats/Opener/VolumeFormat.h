// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_VolumeFormat_h
#define isosurface_VolumeFormat_h

#include "Formats/Opener/VolumeName.h"
#include "Ground/Base/FileSystem.h"

#include <cstdint>
#include <string>

namespace isosurface
{

/// The formats of volumes that VolumeFile opens.
enum class VolumeFormat : std::uint8_t
{
  None,
  Header, ///< MetaImage (MetaImageHeader.h), NRRD (NrrdHeader.h): .mhd .mha .nrrd .nhdr
  Tiff,   ///< a slice on each page (TiffFile.h): .tif .tiff, a folder of them, a name with * or ?
  Nifti,  ///< a single file (NiftiVolume.h): .nii .nii.gz
  Mrc,    ///< by "MAP" in its header, .mrc .map .ccp4 .rec .ali .st .mrcs, also .gz (MrcVolume.h)
  Netcdf, ///< by the first bytes of the classic formats, .nc .nc4 .cdf (NetcdfVolume.h)
  Zarr,   ///< a folder with metadata of Zarr or N5 (ZarrVolume.h)
  Dicom,  ///< by "DICM" in a file, or in one of the first files of a folder; .dcm (DicomVolume.h)
  Hdf5    ///< by its first bytes, under any name (Hdf5Volume.h)
};

/// The format of a name: by its extension, or by the first bytes of the file or the names in the
/// folder. Files that do not exist have one if their extension tells.
VolumeFormat FindVolumeFormat(FileSystem& files, const VolumeName& name);

/// Whether a file of the format may have several volumes, which VolumeName::Within tells apart.
bool HasSeveralVolumes(VolumeFormat format);

bool IsTiffName(const std::string& path);
/// Whether the last part of the path has * or ?, which stand for characters.
bool IsNamePattern(const std::string& path);
/// Whether the path is a folder that is not empty.
bool HasFiles(FileSystem& files, const std::string& path);

} // namespace isosurface

#endif
