// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_OmeXml_h
#define isosurface_OmeXml_h

#include "Formats/Tiff/TiffImage.h"
#include "Ground/Base/Status.h"

#include <string>
#include <vector>

namespace isosurface
{

/**
 * The images of OME-XML, which is the description of the first page of an OME-TIFF, or a file of its own.
 * Other files are named, not opened. Entities are not expanded, and no document type is obeyed.
 *
 * Source: "The OME-TIFF format specification" and the OME schema 2016-06 (older ones are alike).
 */
struct OmeXml
{
  std::vector<TiffImage> Images;
  std::string MetadataFile; ///< that has the images, of a file that has none (BinaryOnly)

  static bool IsOme(const std::string& text);
  /// `file` is the name, without a folder, of the file that the text is of. Error: a sentence without a
  /// file; Corrupt, or Unsupported.
  static Result<OmeXml> Parse(const std::string& text, const std::string& file);
};

} // namespace isosurface

#endif
