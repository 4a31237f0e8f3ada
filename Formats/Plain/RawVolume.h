// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_RawVolume_h
#define isosurface_RawVolume_h

#include "Ground/Volume/VolumeName.h"
#include "Ground/Volume/VolumeOpener.h"

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace isosurface
{

/// Where the samples of a volume are in files: in one file, or in several with the same number of
/// slices each. x fastest, then y, then z; one component.
struct RawVolume
{
  GridGeometry Grid;
  ValueType Type = ValueType::UInt8;
  std::string ArrayName = "scalars";
  std::string SampleUnit; ///< of the samples; empty if it is not known
  std::string LeftOut;    ///< as OpenedVolume::LeftOut
  bool IsBigEndian = false;
  bool IsGzip = false;          ///< each file is a gzip or zlib stream
  bool EndsWithSamples = false; ///< the samples are the last bytes of each file; ignores Offset
  bool IsWhole = false; ///< more bytes behind the samples are an error; otherwise they are told

  // A file consists of Offset bytes, Lines lines of text, Skip bytes, and the samples. If it is
  // compressed, the stream begins after the lines, and contains the Skip bytes.
  std::uint64_t Offset = 0;
  std::uint64_t Lines = 0;
  std::uint64_t Skip = 0;
  std::vector<std::string> Paths;

  /// The bytes of all samples. Nothing if there are none, or more than any file can have.
  std::optional<std::uint64_t> CountBytes() const;
  /// Opens the file, or the first one of a series, and checks its size. `files` must outlive the
  /// source.
  Result<std::unique_ptr<BoxSource>> Open(FileSystem& files) const;
  /// The same, as a volume.
  Result<OpenedVolume> OpenVolume(FileSystem& files) const;
  /// What to tell of bytes behind the samples of the first file, but for `known` that belong there; ""
  /// if there are none, or in a stream.
  std::string DescribeSurplus(FileSystem& files, std::uint64_t known = 0) const;

  /// Reads a header by its extension: .mhd, .mha, .nrrd, .nhdr (below).
  /// Unsupported for others.
  static Result<RawVolume> ReadHeader(FileSystem& files, const std::string& path);

private:
  /// Opens the samples of a file, `bytes` bytes, as a file of their own.
  Result<std::unique_ptr<RandomAccessFile>> OpenPart(
    FileSystem& files, const std::string& path, std::uint64_t bytes) const;
};

/**
 * Reads the header of a MetaImage (.mhd, or .mha with the samples in the same file). Supported: two
 * or three dimensions, and more of one sample each; one channel; binary samples in one file
 * (ElementDataFile = LOCAL or a name) or in a file for each slice or slab (LIST, or a pattern with
 * first, last and step), also compressed (CompressedData). Unknown fields are ignored. Errors,
 * which name the field: Unsupported, Corrupt (contradictory).
 *
 * TransformMatrix begins with the direction of the x axis, which becomes the first column of
 * Direction.
 *
 * Source: the MetaIO documentation of Kitware's wiki (MetaIO/Documentation).
 */
Result<RawVolume> ReadMetaImageHeader(FileSystem& files, const std::string& path);

/**
 * Reads the header of a NRRD file (.nrrd, or .nhdr with the samples in other files). Supported: two
 * or three axes of space, and any axes of one sample; one value a sample; encoding raw or gzip; one
 * file, or a file for each slice or slab (LIST, or a pattern with first, last and step); skipped
 * lines and bytes. Unknown fields are ignored. Errors, which name the field: Unsupported, Corrupt
 * (contradictory).
 *
 * The spacing is the lengths of the space directions. Coordinates are not converted to another
 * space.
 *
 * Source: the definition of the NRRD file format, teem.sourceforge.net/nrrd/format.html.
 */
Result<RawVolume> ReadNrrdHeader(FileSystem& files, const std::string& path);

} // namespace isosurface

#endif
