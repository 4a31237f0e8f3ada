// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_Hdf5Description_h
#define isosurface_Hdf5Description_h

#include "Formats/Hdf5/Hdf5File.h"
#include "Ground/Volume/GridGeometry.h"

#include <string>
#include <vector>

namespace isosurface
{

/**
 * What an HDF5 file says of a dataset, in the words of the programs that write such files:
 *
 *     dimension scales          DIMENSION_LABELS, DIMENSION_LIST (h5py, NetCDF-4)
 *     NeXus                     the attributes `signal` and `axes` of the group
 *     EMD                       the datasets dim1, dim2 ... beside it
 *     ilastik                   the attribute `axistags`: letters and resolutions of the axes
 *     ImageJ's HDF5, ilastik    the attribute `element_size_um`: z, y, x
 *     DREAM.3D                  the geometry of the image that the cells are of
 *     ITK                       the datasets Spacing, Origin and Directions beside VoxelData
 *     Imaris                    ImageSizeX ... of the channel, ExtMin0 ... ExtMax2 of the image
 *     BigDataViewer             cells of int16 are of uint16
 *     MATLAB                    the order of its indices
 *
 * Coordinates of an axis with equal steps place the samples, or are the times of the steps. What is
 * not obeyed is told.
 */
struct Hdf5Description
{
  std::string Letters;        ///< of the axes: those given, or the file's, or likely ones
  StoredArray::Numbers Shape; ///< of what the dataset has samples of, if that is less
  bool IsUnsigned = false;    ///< samples of int16 are those of uint16
  GridGeometry Place;         ///< spacing, origin and direction
  std::string Unit;           ///< of lengths; perhaps empty
  std::string SampleUnit;     ///< perhaps empty
  std::vector<double> Times;  ///< perhaps empty
  std::string Notes;          ///< sentences without an end, with semicolons between them

  /// `letters` say what the axes are, if they are not empty, whatever the file says.
  static Hdf5Description Read(const Hdf5File& file, const std::string& path,
    const StoredArray::Numbers& shape, const std::string& letters);

  void AddNote(const std::string& note) { this->Notes += (this->Notes.empty() ? "" : "; ") + note; }
};

/// Where the samples of an image of Imaris lie that has `size` of them on x, y and z. False if the file
/// does not say it.
bool FindPlaceOfImaris(const Hdf5File& file, const Index3& size, Hdf5Description& description);
/// The samples on x, y and z of a channel of Imaris, whose dataset may have more; zeros if its group
/// does not say it.
Index3 FindSizeOfImaris(const Hdf5File& file, const std::string& channel);

} // namespace isosurface

#endif
