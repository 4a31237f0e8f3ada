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

  /// Reads a header by its extension: .mhd, .mha (MetaImageHeader.h), .nrrd, .nhdr (NrrdHeader.h).
  /// Unsupported for others.
  static Result<RawVolume> ReadHeader(FileSystem& files, const std::string& path);

private:
  /// Opens the samples of a file, `bytes` bytes, as a file of their own.
  Result<std::unique_ptr<RandomAccessFile>> OpenPart(
    FileSystem& files, const std::string& path, std::uint64_t bytes) const;
};

/// Opens a volume whose header RawVolume::ReadHeader() reads.
Result<OpenedVolume> OpenRawVolume(
  FileSystem& files, const VolumeName& name, const VolumeChoice& choice);

} // namespace isosurface

#endif
