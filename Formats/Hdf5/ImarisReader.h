// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_ImarisReader_h
#define isosurface_ImarisReader_h

#include "Formats/Hdf5/Hdf5File.h"
#include "Ground/Volume/VolumeOpener.h"

#include <string>

namespace isosurface
{

/// Whether a file is of Imaris 5.5 or later.
bool IsImaris(const Hdf5File& file);
/// Opens a file of Imaris: its channels are arrays, its time points time steps, its resolution levels a
/// pyramid. Datasets are larger than the image, which ImageSizeX, Y and Z of each channel tell.
Result<OpenedVolume> OpenImaris(const Hdf5File& file, const VolumeChoice& choice);

} // namespace isosurface

#endif
