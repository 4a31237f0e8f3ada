// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_DicomSeries_h
#define isosurface_DicomSeries_h

#include "Formats/Dicom/DicomSlice.h"
#include "Formats/Source/FolderFiles.h"
#include "Ground/Volume/VolumeName.h"

#include <map>
#include <string>
#include <vector>

namespace isosurface
{

/// What files have of a series.
struct DicomSeries
{
  std::vector<DicomSlice> Slices;
  Status Fault; ///< of the first of its images that cannot be read
  /// "Thorax 5.0 B30f (CT, 120 slices of 512 x 512)"; the UID if no image can be read. Of series that would
  /// have the same one, their numbers and perhaps the ends of their UIDs stand in it.
  std::string Name;
};

/**
 * All series of a name, by their UID: of the images in a folder, or else of those in its folders, and so
 * on (the same of the folder of a file DICOMDIR); of those in the folder of another file; or of those
 * that fit a pattern. An image that cannot be read is an error of its series; of all if its header does
 * not tell the series, since a slice of any may be missing. NotFound if there are none.
 */
Result<std::map<std::string, DicomSeries>> FindDicomSeries(
  const std::string& path, PassedOver& over);

/// The images of the series that is meant (DicomVolume.h).
Result<std::vector<DicomSlice>> ChooseDicomSeries(const VolumeName& name, PassedOver& over);

} // namespace isosurface

#endif
