// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_TiffImages_h
#define isosurface_TiffImages_h

#include "Formats/Tiff/TiffFiles.h"
#include "Formats/Tiff/TiffImage.h"
#include "Ground/Volume/VolumeName.h"
#include "Ground/Volume/VolumeOpener.h"

#include <string>
#include <vector>

namespace isosurface
{

/// The images of a TIFF file, as the description of its first page tells them: OME-XML, which may be in
/// another file, ImageJ or tifffile; or one image of which each page is a slice.
class TiffImages
{
public:
  /// `files` must outlive the images.
  static Result<TiffImages> Read(
    TiffFiles& files, const VolumeName& name, const VolumeChoice& choice);

  const std::vector<TiffImage>& Get() const { return this->Images; }
  /// What names an image behind a colon: its name, if no other has it and it is no number.
  std::string GetName(std::size_t number) const;
  /// The image that the name of the volume chooses, of which the time step is there.
  Result<TiffImage> Choose() const;
  /// What other tags of the first page tell; perhaps empty.
  const std::string& GetNotes() const { return this->Notes; }
  /// A file of OME-XML alone; perhaps empty.
  const std::string& GetMetadata() const { return this->Metadata; }

private:
  TiffImages(TiffFiles& files, const VolumeName& name, const VolumeChoice& choice)
    : Files(files)
    , Name(name)
    , Choice(choice)
  {
  }

  Status FindImages();
  /// What --axes says of the pages: without y and x.
  std::string GetPageAxes() const;
  Status ReadOme(const std::string& text);
  /// The OME-XML of another file: of a TIFF file, or text.
  Result<std::string> ReadMetadata(const std::string& path);
  /// Adds the path and the reason to an error that is a sentence without a file.
  Status AddPath(const Status& status) const
  {
    return this->Files.MakeError(status.GetCode(), status.GetMessage());
  }

  TiffFiles& Files;
  const VolumeName& Name;
  const VolumeChoice& Choice;
  std::vector<TiffImage> Images;
  bool IsShaped = false; ///< whether tifffile says what they are, whose axes may be told otherwise
  std::string Notes;
  std::string Metadata;
};

} // namespace isosurface

#endif
